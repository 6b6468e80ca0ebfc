#include "capture/c3d/writer.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "capture/c3d/frame_encode.h"
#include "capture/c3d/header_block.h"
#include "capture/c3d/number_format.h"
#include "capture/c3d/point_table.h"
#include "capture/c3d/rotations.h"
#include "capture/c3d/write_plan.h"
#include "config/error.h"
#include "config/output_file.h"
#include "config/text.h"

namespace kinemesh {
namespace {

constexpr std::size_t block_bytes = std::size_t{1} << 20;

using Sink = std::function<void(const void*, std::size_t)>;

EncodeTally write_frames(const MarkerSequence& take, const C3dWritePlan& plan, const Sink& sink,
                         const RunContext& ctx) {
  EncodeTally tally;
  const FrameEncoder encoder(take, plan);
  const std::size_t frame_bytes = encoder.frame_bytes();
  if (frame_bytes == 0) return tally;
  const std::size_t per_block = std::max<std::size_t>(1, block_bytes / frame_bytes);
  std::vector<std::byte> block(per_block * frame_bytes);
  for (std::size_t first = 0; first < take.frame_count(); first += per_block) {
    ctx.check_cancelled();
    ctx.progress(static_cast<double>(first) / static_cast<double>(take.frame_count()));
    const std::size_t count = std::min(per_block, take.frame_count() - first);
    for (std::size_t f = 0; f < count; ++f)
      encoder.encode(first + f, block.data() + f * frame_bytes, tally);
    sink(block.data(), count * frame_bytes);
  }
  // The format counts in blocks: fill the last one.
  const std::size_t rest = take.frame_count() * frame_bytes % c3d_block;
  const std::vector<std::byte> padding(rest == 0 ? 0 : c3d_block - rest);
  sink(padding.data(), padding.size());
  return tally;
}

void note_tally(const EncodeTally& tally, const C3dWritePlan& plan, std::vector<C3dLoss>& losses) {
  const auto note = [&](std::size_t count, const std::string& what) {
    if (count > 0) losses.push_back({.message = count_of(count, "sample") + " " + what});
  };
  note(tally.clipped_coordinates,
       "with coordinates beyond the range of 16-bit integers, which are clipped");
  note(tally.clipped_residuals, "with residuals over 255 steps of POINT:SCALE, which are clipped");
  note(tally.rounded_residuals, "whose residuals are rounded to steps of " +
                                    format_number(std::abs(plan.scale)) + " (POINT:SCALE)");
  note(tally.lost_cameras, "seen by an eighth camera, which the format cannot name");
  note(tally.ambiguous_zeros, "at exactly (0, 0, 0), which some software takes for gaps");
}

void note_what_c3d_lacks(const MarkerSequence& take, const C3dWriteOptions& options,
                         const C3dWritePlan& plan, std::vector<C3dLoss>& losses) {
  if (!take.uncertainty().empty())
    losses.push_back({.message = "the uncertainty of filled samples has no place in the format"});
  if (plan.unlabelled > 0) {
    losses.push_back({.message = "points without identity become " +
                                 count_of(plan.unlabelled, "column") + " called *" +
                                 std::to_string(take.marker_count() + 1) + " and so on"});
  }
  if (!take.rotations.values.empty() && options.unit != "origin" &&
      options.unit != take.origin.unit) {
    losses.push_back({.message = "the translations of rotations stay in " + take.origin.unit,
                      .place = "parameter group ROTATION"});
  }
  if (take.events.size() > 18 && take.parameters.group("EVENT") == nullptr) {
    losses.push_back({.message = "software that knows only header events sees the first 18 of " +
                                 std::to_string(take.events.size())});
  }
}

void check_shape(const MarkerSequence& take) {
  const std::size_t values =
      take.frame_count() * take.analog.samples_per_frame * take.analog.channels.size();
  if (take.analog.values.size() != values) {
    throw UsageError(
        {.what = "the analog data have " + std::to_string(take.analog.values.size()) +
                 " values, not frames × samples × channels = " + std::to_string(values)});
  }
  const RotationData& r = take.rotations;
  if (r.values.size() != take.frame_count() * r.samples_per_frame * r.count * rotation_floats) {
    throw UsageError({.what = "the rotations do not match the frames"});
  }
  const auto& offsets = take.unlabelled.offsets;
  if (!offsets.empty() && (offsets.size() != take.frame_count() + 1 ||
                           offsets.back() > take.unlabelled.positions.size())) {
    throw UsageError({.what = "the points without identity do not match the frames"});
  }
}

/// Plans, checks what is lost, and writes to `sink`, in this order.
std::vector<C3dLoss> encode(const MarkerSequence& take, const C3dWriteOptions& options,
                            const Sink& sink, const RunContext& ctx) {
  check_shape(take);
  const C3dWritePlan plan = plan_c3d(take, options);
  std::vector<C3dLoss> losses = plan.losses;
  note_what_c3d_lacks(take, options, plan, losses);
  const std::string header = encode_header(plan.header, plan.processor);
  sink(header.data(), header.size());
  sink(plan.section.data(), plan.section.size());
  note_tally(write_frames(take, plan, sink, ctx), plan, losses);
  if (!take.rotations.values.empty()) write_rotations(take.rotations, plan.processor, sink);
  return losses;
}

}  // namespace

void C3dWriteOptions::declare(ParameterSet& p) {
  p.group("c3d", "Writing C3D files");
  p.text("processor", processor,
         {.metavar = "NAME",
          .help = "Number format: intel, dec, sgi, or origin for that of the file read"});
  p.text("storage", storage,
         {.metavar = "KIND", .help = "int or float, or origin for that of the file read"});
  p.text("output-unit", unit,
         {.metavar = "UNIT",
          .help = "Length unit of the file: mm, cm, m, or origin for that of the file read"});
  p.number("scale", scale,
           {.min = 0.0,
            .max = 1e6,
            .help = "Size of one step of integer positions and of residuals in the written unit; 0 "
                    "chooses"});
}

void C3dWriteOptions::validate() const {
  validate_options(*this);
  const auto check = [](const char* name, const std::string& value,
                        std::initializer_list<const char*> words) {
    if (std::ranges::find(words, value) != words.end()) return;
    std::vector<std::string> allowed(words.begin(), words.end());
    throw UsageError({.what = std::string(name) + " is \"" + value + "\"; allowed are " +
                              join(allowed, ", ", " and ")});
  };
  check("processor", processor, {"intel", "dec", "sgi", "origin"});
  check("storage", storage, {"int", "float", "origin"});
  if (unit != "origin" && !millimetres_in(unit))
    throw UsageError({.what = "output-unit is \"" + unit + "\"; allowed are mm, cm, m and origin"});
}

std::vector<C3dLoss> c3d_losses(const MarkerSequence& take, const C3dWriteOptions& options) {
  return encode(take, options, [](const void*, std::size_t) {}, {});
}

C3dWriteResult write_c3d(const MarkerSequence& take, const std::filesystem::path& path,
                         const C3dWriteOptions& options, const RunContext& ctx) {
  for (const C3dLoss& loss : c3d_losses(take, options)) {
    ctx.warn(path.string() + ": " + (loss.place.empty() ? "" : loss.place + ": ") + loss.message);
  }
  OutputFile file(path);
  C3dWriteResult result;
  result.losses = encode(
      take, options, [&](const void* data, std::size_t bytes) { file.write(data, bytes); }, ctx);
  result.bytes = file.position();
  file.commit();
  ctx.progress(1.0);
  return result;
}

std::string encode_c3d(const MarkerSequence& take, const C3dWriteOptions& options,
                       std::vector<C3dLoss>* losses) {
  std::string bytes;
  std::vector<C3dLoss> found = encode(take, options,
                                      [&](const void* data, std::size_t count) {
                                        bytes.append(static_cast<const char*>(data), count);
                                      },
                                      {});
  if (losses != nullptr) *losses = std::move(found);
  return bytes;
}

}  // namespace kinemesh
