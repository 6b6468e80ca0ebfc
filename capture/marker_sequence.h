// Marker trajectories of one take, as recorded and as cleaned: the type that every capture stage
// reads and writes. Millimetres and seconds; frames × markers × 3, contiguous.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "capture/c3d/parameters.h"
#include "config/buffer.h"
#include "mesh/event.h"

namespace kinemesh {

/// What a trajectory is. Only `marker` is a point of the body by default.
enum class MarkerKind : uint8_t {
  marker,
  unlabelled,
  virtual_point,
  angle,
  force,
  moment,
  power,
  scalar
};

/// "marker", "unlabelled", "virtual", "angle", …: the words of the JSON output.
std::string_view name_of(MarkerKind kind);

struct Marker {
  std::string label;    ///< without the subject's prefix
  std::string subject;  ///< empty when the file does not say
  MarkerKind kind = MarkerKind::marker;
  std::string description;
  std::string unit = "mm";  ///< of the decoded values: "mm" for points, otherwise as in the file
  friend bool operator==(const Marker&, const Marker&) = default;
};

/// Bits of a sample's flags.
struct SampleFlag {
  static constexpr uint8_t valid = 1;   ///< the position may be used
  static constexpr uint8_t filled = 2;  ///< valid, but estimated by Kinemesh rather than measured
};

/// Points without identity; their number may differ from frame to frame. Frame f owns the rows
/// [offsets[f], offsets[f + 1]).
struct UnlabelledPoints {
  std::vector<uint64_t> offsets;           ///< empty, or frames + 1
  std::vector<Eigen::Vector3f> positions;  ///< mm
  std::vector<float> residuals;            ///< mm
  std::vector<uint8_t> camera_masks;
};

/// Analog channels sampled at `rate_hz`, kept for writing back.
struct AnalogData {
  struct Channel {
    std::string label, unit, description;
    friend bool operator==(const Channel&, const Channel&) = default;
  };
  std::vector<Channel> channels;
  double rate_hz = 0.0;
  std::size_t samples_per_frame = 0;
  Buffer<float> values;  ///< (frames × samples_per_frame) × channels, in each channel's unit
};

/// Rotations of segments (C3D group ROTATION), kept for writing back. Each is 17 numbers: a 4 × 4
/// matrix, column by column, and its reliability, -1 where it was not measured. Translations are
/// in the file's length unit.
struct RotationData {
  std::size_t count = 0;  ///< rotations a sample
  std::size_t samples_per_frame = 0;
  Buffer<float> values;  ///< (frames × samples_per_frame) × count × 17
};

/// Numeric formats and byte orders of C3D files.
enum class Processor : uint8_t { intel, dec, sgi };
enum class Storage : uint8_t { integer, real };

/// How the take was stored, so that it can be written back the same way.
struct Origin {
  std::string path;                ///< file it was read from; empty for generated data
  std::string unit = "mm";         ///< length unit of the file
  std::string x_screen, y_screen;  ///< axes of origin as in POINT:X_SCREEN and Y_SCREEN ("+X")
  std::string manufacturer;        ///< company, software and version, as far as given
  Processor processor = Processor::intel;
  Storage storage = Storage::real;
  double scale = -1.0;  ///< POINT:SCALE of the file in its own unit
};

class MarkerSequence {
 public:
  MarkerSequence() = default;
  /// Arrays uninitialised; every sample must be written by the caller.
  MarkerSequence(std::size_t frame_count, std::vector<Marker> markers, double rate_hz);
  /// As above, with every sample invalid at NaN, residual 0, no camera.
  static MarkerSequence invalid(std::size_t frame_count, std::vector<Marker> markers,
                                double rate_hz);

  std::size_t frame_count() const { return frame_count_; }
  std::size_t marker_count() const { return markers_.size(); }
  std::size_t sample_count() const { return frame_count_ * markers_.size(); }
  /// Row of a sample in the per-sample arrays.
  std::size_t sample(std::size_t frame, std::size_t marker) const {
    return frame * markers_.size() + marker;
  }

  const std::vector<Marker>& markers() const { return markers_; }
  std::vector<Marker>& markers() { return markers_; }  ///< labels may change, their number not
  /// First marker with this label ("label" or "subject:label"), or npos.
  std::size_t find(std::string_view label) const;
  static constexpr std::size_t npos = static_cast<std::size_t>(-1);

  /// frames × markers × 3, mm. Where a sample is invalid the value is what the file held: it may
  /// be anything, NaN included, and must not be used.
  std::span<float> positions() { return positions_.span(); }
  std::span<const float> positions() const { return positions_.span(); }
  /// frames × markers, SampleFlag bits.
  std::span<uint8_t> flags() { return flags_.span(); }
  std::span<const uint8_t> flags() const { return flags_.span(); }
  /// frames × markers, mm; 0 means interpolated or edited by the recording software.
  std::span<float> residuals() { return residuals_.span(); }
  std::span<const float> residuals() const { return residuals_.span(); }
  /// frames × markers, bit i set when camera i saw the point.
  std::span<uint8_t> camera_masks() { return camera_masks_.span(); }
  std::span<const uint8_t> camera_masks() const { return camera_masks_.span(); }
  /// frames × markers, standard deviation in mm of filled samples; empty when nothing is filled.
  std::span<float> uncertainty() { return uncertainty_.span(); }
  std::span<const float> uncertainty() const { return uncertainty_.span(); }
  void add_uncertainty();  ///< allocates it, set to 0; does nothing when it is there

  bool valid(std::size_t frame, std::size_t marker) const {
    return (flags_[sample(frame, marker)] & SampleFlag::valid) != 0;
  }
  bool filled(std::size_t frame, std::size_t marker) const {
    return (flags_[sample(frame, marker)] & SampleFlag::filled) != 0;
  }
  Eigen::Map<Eigen::Vector3f> position(std::size_t frame, std::size_t marker) {
    return Eigen::Map<Eigen::Vector3f>(positions_.data() + 3 * sample(frame, marker));
  }
  Eigen::Map<const Eigen::Vector3f> position(std::size_t frame, std::size_t marker) const {
    return Eigen::Map<const Eigen::Vector3f>(positions_.data() + 3 * sample(frame, marker));
  }

  /// The chosen markers (indices into markers(), any order) of all frames, with events, rate and
  /// origin; analog data, rotations, unlabelled points and parameters stay behind.
  MarkerSequence select(std::span<const std::size_t> chosen) const;

  double rate_hz = 0.0;
  int64_t first_frame = 1;  ///< 1-based number of frame 0 in the original take
  std::vector<Event> events;
  UnlabelledPoints unlabelled;
  AnalogData analog;
  RotationData rotations;
  Origin origin;
  C3dParameters parameters;  ///< every parameter of the file, kept for writing back

 private:
  std::size_t frame_count_ = 0;
  std::vector<Marker> markers_;
  Buffer<float> positions_;
  Buffer<uint8_t> flags_;
  Buffer<float> residuals_;
  Buffer<uint8_t> camera_masks_;
  Buffer<float> uncertainty_;
};

}  // namespace kinemesh
