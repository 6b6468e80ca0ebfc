#include "capture/c3d/ezc3d_reader.h"

#include <ezc3d/ezc3d_all.h>

#include <algorithm>
#include <cmath>

#include "capture/c3d/parameter_access.h"
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
    take.residuals()[i] = static_cast<float>(p.residual()) * table.to_mm[m];
    uint8_t mask = 0;
    const std::vector<bool>& cameras = p.cameraMask();
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

/// Its 4 × 4 matrix is indexed by row and column; the file holds columns.
void take_rotations(const ezc3d::DataNS::Frame& frame, std::size_t f, RotationData& rotations) {
  float* to = rotations.values.data() + f * rotations.samples_per_frame * rotations.count * 17;
  for (std::size_t s = 0; s < rotations.samples_per_frame; ++s) {
    const auto& subframe = frame.rotations().subframe(s);
    for (std::size_t r = 0; r < rotations.count; ++r) {
      const auto& rotation = subframe.rotation(r);
      for (std::size_t column = 0; column < 4; ++column) {
        for (std::size_t row = 0; row < 4; ++row) {
          *to++ = static_cast<float>(rotation(row, column));
        }
      }
      *to++ = static_cast<float>(rotation.reliability());
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
    const RotationData& r = take.rotations;
    if (r.count != 0 && (frame.rotations().nbSubframes() != r.samples_per_frame ||
                         frame.rotations().subframe(0).nbRotations() != r.count)) {
      refuse(path, "it finds another number of rotations than Kinemesh");
    }
  }
}

C3dParameter parameter_of(const ezc3d::ParametersNS::GroupNS::Parameter& from) {
  C3dParameter p{.name = from.name(), .description = from.description(), .locked = from.isLocked()};
  for (const std::size_t d : from.dimension()) p.dimensions.push_back(static_cast<uint8_t>(d));
  switch (from.type()) {
    case ezc3d::DATA_TYPE::CHAR: {
      p.type = C3dType::text;
      // Its strings have lost their padding.
      const std::vector<std::string>& texts = from.valuesAsString();
      std::size_t width = 0;
      for (const std::string& text : texts) width = std::max(width, text.size());
      for (const std::string& text : texts) {
        p.characters += text;
        p.characters.append(width - text.size(), ' ');
      }
      p.dimensions = {static_cast<uint8_t>(width)};
      if (texts.size() != 1) p.dimensions.push_back(static_cast<uint8_t>(texts.size()));
      break;
    }
    case ezc3d::DATA_TYPE::FLOAT:
      p.type = C3dType::real;
      p.numbers = from.valuesAsDouble();
      break;
    default:
      p.type = from.type() == ezc3d::DATA_TYPE::BYTE ? C3dType::byte : C3dType::integer;
      for (const int v : from.valuesConvertedAsInt()) p.numbers.push_back(v);
  }
  return p;
}

Ezc3dHead head_of(const ezc3d::c3d& file) {
  Ezc3dHead head;
  std::size_t id = 0;
  for (const auto& from : file.parameters().groups()) {
    ++id;
    if (from.isEmpty()) continue;
    // A group that the file does not declare has no name; our reader calls it by its number.
    C3dGroup group{.name = from.name().empty() ? "GROUP" + std::to_string(id) : from.name(),
                   .description = from.description(),
                   .locked = from.isLocked()};
    for (const auto& parameter : from.parameters()) {
      group.parameters.push_back(parameter_of(parameter));
    }
    head.parameters.groups.push_back(std::move(group));
  }
  const ezc3d::Header& header = file.header();
  for (std::size_t e = 0; e < std::min<std::size_t>(header.nbEvents(), 18); ++e) {
    head.header_events.push_back(
        {.label = header.eventsLabel(e), .time_s = static_cast<double>(header.eventsTime(e))});
  }
  head.first_frame = static_cast<int64_t>(header.firstFrame()) + 1;
  head.rate_hz = static_cast<double>(header.frameRate());
  return head;
}

}  // namespace

std::string ezc3d_refusal(const C3dReadResult& result) {
  if (result.layout.processor == Processor::sgi) return "it does not support SGI/MIPS files";
  const auto has = [&](std::string_view code) {
    return std::ranges::any_of(result.findings,
                               [&](const C3dFinding& f) { return f.code == code; });
  };
  if (has_errors(result.findings)) return "it is given healthy files only, and this one has errors";
  // ezc3d takes the whole part of ANALOG:RATE / POINT:RATE for the samples per frame.
  const auto rate = first_number(result.take.parameters, "ANALOG", "RATE");
  const double samples = static_cast<double>(result.layout.analog_samples);
  const double whole = std::floor(rate.value_or(0.0) / result.layout.rate_hz);
  if (result.layout.analog_channels > 0 && (has("C3D501") || whole != samples))
    return "without an ANALOG:RATE that is a multiple of the frame rate it reads garbage";
  if (result.layout.frames > 65'535)
    return "it ignores the fields that hold more than 65535 frames";
  return {};
}

void read_with_ezc3d(const std::filesystem::path& path, const C3dReadOptions& options,
                     C3dReadResult& result, Ezc3dHead& head) {
  if (const std::string why = ezc3d_refusal(result); !why.empty()) refuse(path, why);
  std::vector<C3dFinding> ignored;
  const PointTable table = decode_points_table(result.take.parameters, result.take.marker_count(),
                                               options.unstated.unit, ignored);
  try {
    const ezc3d::c3d file(path.string());
    head = head_of(file);
    check_shape(file, result.take, path);
    for (std::size_t f = 0; f < result.take.frame_count(); ++f) {
      const ezc3d::DataNS::Frame& frame = file.data().frame(f);
      take_points(frame, f, table, options.zero_points, result.take);
      take_analog(frame, f, result.take.analog);
      take_rotations(frame, f, result.take.rotations);
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
