// An animated mesh: one immutable triangulation, and a position of every vertex in every frame.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "config/buffer.h"
#include "mesh/event.h"
#include "mesh/mesh.h"
#include "mesh/topology.h"

namespace kinemesh {

/// vertices × 3, row-major, a view of one frame in mm.
using FrameView = Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>>;
using MutableFrameView = Eigen::Map<Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>>;

/// Where a result came from: enough to make it again.
struct Provenance {
  struct Input {
    std::string path;
    std::string sha256;  ///< lower-case hex, 64 characters
  };
  std::string program;  ///< "kinemesh 0.1.0 (commit)"
  std::string command;  ///< the command line that makes it again
  std::string options;  ///< effective options as TOML
  std::vector<Input> inputs;
  std::string source;  ///< what was recorded: subject, take; free text
};

class AnimatedMesh {
 public:
  AnimatedMesh() = default;
  /// Positions uninitialised. Throws InternalError when topology is null.
  AnimatedMesh(std::shared_ptr<const Topology> topology, std::size_t frame_count, double rate_hz);
  /// Takes over `positions`, frames × vertices × 3 in mm. Throws InternalError when its size
  /// differs.
  AnimatedMesh(std::shared_ptr<const Topology> topology, std::size_t frame_count, double rate_hz,
               Buffer<float> positions);

  const Topology& topology() const { return *topology_; }
  const std::shared_ptr<const Topology>& shared_topology() const { return topology_; }
  std::size_t frame_count() const { return frame_count_; }
  std::size_t vertex_count() const { return topology_ ? topology_->vertex_count() : 0; }

  /// frames × vertices × 3, contiguous, mm.
  std::span<float> positions() { return positions_.span(); }
  std::span<const float> positions() const { return positions_.span(); }
  MutableFrameView frame(std::size_t f);
  FrameView frame(std::size_t f) const;
  Eigen::Map<Eigen::Vector3f> position(std::size_t f, VertexIndex v) {
    return Eigen::Map<Eigen::Vector3f>(positions_.data() + 3 * sample(f, v));
  }
  Eigen::Map<const Eigen::Vector3f> position(std::size_t f, VertexIndex v) const {
    return Eigen::Map<const Eigen::Vector3f>(positions_.data() + 3 * sample(f, v));
  }

  /// frames × vertices, 1 where the sample was estimated rather than measured; empty when the
  /// source does not say.
  std::span<uint8_t> filled() { return filled_.span(); }
  std::span<const uint8_t> filled() const { return filled_.span(); }
  /// frames × vertices, standard deviation in mm of an estimated sample (0 for a measured one);
  /// empty when not known.
  std::span<float> uncertainty() { return uncertainty_.span(); }
  std::span<const float> uncertainty() const { return uncertainty_.span(); }
  /// Allocates the array, set to 0.
  void add_filled();
  void add_uncertainty();

  double duration_s() const;
  /// Time in seconds of frame f since the first frame of this mesh.
  double time_s(std::size_t f) const { return rate_hz > 0 ? static_cast<double>(f) / rate_hz : 0; }
  /// One frame as a static mesh.
  Mesh mesh_at(std::size_t f) const;

  double rate_hz = 0.0;     ///< frames per second; 0 when unknown (a static mesh)
  int64_t first_frame = 1;  ///< number of frame 0 in the original take, 1-based
  std::vector<Event> events;
  std::vector<std::string> vertex_names;  ///< empty, or one per vertex (marker labels)
  Provenance provenance;

 private:
  std::size_t sample(std::size_t f, VertexIndex v) const { return f * vertex_count() + v; }

  std::shared_ptr<const Topology> topology_;
  std::size_t frame_count_ = 0;
  Buffer<float> positions_;
  Buffer<uint8_t> filled_;
  Buffer<float> uncertainty_;
};

}  // namespace kinemesh
