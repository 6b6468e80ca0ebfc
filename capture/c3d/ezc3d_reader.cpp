#include "capture/c3d/ezc3d_reader.h"

#include <ezc3d/ezc3d_all.h>

#include <algorithm>
#include <cmath>

#include "capture/c3d/point_table.h"
#include "config/error.h"

namespace kinemesh {
namespace {

[[noreturn]] void refuse(const std::filesystem::path& path, const std::string& why) {
  throw InputError({.what = "ezc3d " EZC3D_VERSION " cannot read it: " + why,
                    .file = path.string(),
                    .remedy = "Leave out --reader ezc3d"});
}

void take_points(const ezc3d::DataNS::Frame& frame, std::size_t f, const PointTable& table,
                 ZeroPolicy zero_points, MarkerSequence& take) {
  const auto& points = frame.points().points();
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    const ezc3d::DataNS::Points3dNS::Point& p = points[m];
    const std::size_t i = take.sample(f, m);
    const Eigen::Vector3f raw(static_cast<float>(p.x()), static_cast<float>(p.y()),
                              static_cast<float>(p.z()));
    take.position(f, m) = raw * table.to_mm[m];
    const bool zero =
        raw.isZero(0.0F) && zero_points == ZeroPolicy::gap && table.zero_is_value[m] == 0;
    take.flags()[i] = p.residual() >= 0.0 && raw.allFinite() && !zero ? SampleFlag::valid : 0;
    take.residuals()[i] = 0.0F;
    take.camera_masks()[i] = 0;
  }
}

/// Residuals and camera masks as ezc3d gives them.
void take_residuals(const ezc3d::DataNS::Frame& frame, std::size_t f, const PointTable& table,
                    MarkerSequence& take) {
  const auto& points = frame.points().points();
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    const std::size_t i = take.sample(f, m);
    take.residuals()[i] = static_cast<float>(points[m].residual()) * table.to_mm[m];
    uint8_t mask = 0;
    const std::vector<bool>& cameras = points[m].cameraMask();
    for (std::size_t c = 0; c < std::min<std::size_t>(cameras.size(), 7); ++c) {
      if (cameras[c]) mask |= static_cast<uint8_t>(1U << c);
    }
    take.camera_masks()[i] = mask;
  }
}

void take_analog(const ezc3d::DataNS::Frame& frame, std::size_t f, AnalogData& analog) {
  const std::size_t channels = analog.channels.size();
  for (std::size_t s = 0; s < analog.samples_per_frame; ++s) {
    const auto& subframe = frame.analogs().subframe(s);
    for (std::size_t c = 0; c < channels; ++c) {
      analog.values[(f * analog.samples_per_frame + s) * channels + c] =
          static_cast<float>(subframe.channel(c).data());
    }
  }
}

void check_shape(const ezc3d::c3d& file, const MarkerSequence& take,
                 const std::filesystem::path& path) {
  const std::size_t frames = file.data().nbFrames();
  if (frames != take.frame_count()) {
    refuse(path, "it finds " + std::to_string(frames) + " frames, Kinemesh " +
                     std::to_string(take.frame_count()));
  }
  for (std::size_t f = 0; f < frames; ++f) {
    const auto& frame = file.data().frame(f);
    const bool analog = take.analog.channels.empty() ||
                        (frame.analogs().nbSubframes() == take.analog.samples_per_frame &&
                         frame.analogs().subframe(0).nbChannels() == take.analog.channels.size());
    if (frame.points().nbPoints() != take.marker_count() || !analog) {
      refuse(path, "it finds another number of points or analog channels than Kinemesh");
    }
  }
}

}  // namespace

std::string ezc3d_refusal(const C3dReadResult& result) {
  if (result.layout.processor == Processor::sgi) return "it does not support SGI/MIPS files";
  const auto has = [&](std::string_view code) {
    return std::ranges::any_of(result.findings,
                               [&](const C3dFinding& f) { return f.code == code; });
  };
  if (has_errors(result.findings)) return "it is given healthy files only, and this one has errors";
  if (has("C3D501") || has("C3D502"))
    return "without an ANALOG:RATE that is a multiple of the frame rate it reads garbage";
  if (result.layout.frames > 65'535)
    return "it ignores the fields that hold more than 65535 frames";
  return {};
}

void reread_with_ezc3d(const std::filesystem::path& path, const C3dReadOptions& options,
                       C3dReadResult& result, bool as_it_says) {
  if (const std::string why = ezc3d_refusal(result); !why.empty()) refuse(path, why);
  std::vector<C3dFinding> ignored;
  const PointTable table = decode_points_table(result.take.parameters, result.take.marker_count(),
                                               options.missing_unit, ignored);
  try {
    const ezc3d::c3d file(path.string());
    check_shape(file, result.take, path);
    for (std::size_t f = 0; f < result.take.frame_count(); ++f) {
      const ezc3d::DataNS::Frame& frame = file.data().frame(f);
      take_points(frame, f, table, options.zero_points, result.take);
      if (as_it_says) take_residuals(frame, f, table, result.take);
      take_analog(frame, f, result.take.analog);
    }
  } catch (const Error&) {
    throw;
  } catch (const std::exception& e) {
    refuse(path, e.what());
  }
}

std::size_t load_with_ezc3d(const std::filesystem::path& path) {
  return ezc3d::c3d(path.string()).data().nbFrames();
}

}  // namespace kinemesh
