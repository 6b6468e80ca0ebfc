#include "capture/c3d/rotations.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "capture/c3d/header_block.h"
#include "capture/c3d/number_format.h"
#include "capture/c3d/parameter_access.h"
#include "config/text.h"

namespace kinemesh {
namespace {

constexpr std::size_t block_floats = std::size_t{1} << 18;

bool disjoint(uint64_t a_begin, uint64_t a_end, uint64_t b_begin, uint64_t b_end) {
  return a_begin >= a_end || b_begin >= b_end || a_end <= b_begin || b_end <= a_begin;
}

}  // namespace

void find_rotations(const C3dHead& head, C3dLayout& layout) {
  const uint64_t used = first_count(head.parameters, "ROTATION", "USED").value_or(0);
  const uint64_t block = first_count(head.parameters, "ROTATION", "DATA_START").value_or(0);
  // No more than a 32-bit count of blocks, so that nothing below overflows.
  if (used == 0 || used > 65'535 || block == 0 || block > 0xFFFFFFFFU) return;
  const auto ratio = first_count(head.parameters, "ROTATION", "RATIO");
  const double rate = first_number(head.parameters, "ROTATION", "RATE").value_or(layout.rate_hz);
  const double share = std::clamp(std::round(rate / layout.rate_hz), 1.0, 65'535.0);
  layout.rotations = used;
  layout.rotation_samples =
      ratio && *ratio > 0 && *ratio <= 65'535 ? *ratio : static_cast<uint64_t>(share);
  layout.rotations_begin = head.leading + (block - 1) * c3d_block;
}

void settle_rotations(C3dLayout& layout, std::vector<C3dFinding>& findings) {
  if (layout.rotations == 0) return;
  const std::string place = "parameter ROTATION:DATA_START";
  const uint64_t frame = layout.rotations * layout.rotation_samples * rotation_bytes;
  const uint64_t held = layout.rotations_begin < layout.file_bytes
                            ? (layout.file_bytes - layout.rotations_begin) / frame
                            : 0;
  layout.rotation_frames = std::min(layout.frames, held);
  const uint64_t end = layout.rotations_begin + layout.rotation_frames * frame;
  const bool apart =
      disjoint(layout.rotations_begin, end, layout.data_begin, layout.data_end) &&
      layout.rotations_begin >= std::max(layout.parameters_end, layout.leading_bytes + c3d_block);
  const bool most = 2 * layout.rotation_frames >= layout.frames;
  if (layout.frames > 0 && (!apart || !most)) {
    findings.push_back(c3d_finding(
        "C3D319",
        count_of(layout.rotations, "rotation") + " should begin at byte " +
            std::to_string(layout.rotations_begin) +
            (apart ? ", where most of them are cut off" : ", which lies in something else") +
            "; they are left out",
        place));
    layout.rotations = 0;
    return;
  }
  if (layout.rotation_frames < layout.frames) {
    findings.push_back(c3d_finding("C3D319",
                                   "the rotations of " + std::to_string(layout.rotation_frames) +
                                       " of " + count_of(layout.frames, "frame") + " are complete",
                                   "byte " + std::to_string(end)));
  }
  findings.push_back(
      c3d_finding("C3D315", count_of(layout.rotations, "rotation"), "parameter ROTATION:USED"));
}

void read_rotations(const ByteSource& source, const C3dLayout& layout, MarkerSequence& take) {
  if (layout.rotations == 0 || layout.frames == 0) return;
  RotationData& r = take.rotations;
  r.count = layout.rotations;
  r.samples_per_frame = layout.rotation_samples;
  const uint64_t per_frame = r.count * r.samples_per_frame * rotation_floats;
  r.values = Buffer<float>(layout.frames * per_frame);
  const std::size_t want = layout.rotation_frames * per_frame;
  auto* bytes = reinterpret_cast<std::byte*>(r.values.data());
  const std::size_t got = source.read_at(layout.rotations_begin, bytes, want * 4) / 4;
  reals_to_native(bytes, got, layout.processor);
  for (std::size_t i = got / rotation_floats * rotation_floats; i < r.values.size(); ++i) {
    r.values[i] = i % rotation_floats == rotation_floats - 1 ? -1.0F : 0.0F;
  }
}

void write_rotations(const RotationData& rotations, Processor p,
                     const std::function<void(const void*, std::size_t)>& sink) {
  const std::span<const float> all = rotations.values.span();
  std::vector<float> block;
  for (std::size_t first = 0; first < all.size(); first += block_floats) {
    const std::span<const float> part =
        all.subspan(first, std::min(block_floats, all.size() - first));
    block.assign(part.begin(), part.end());
    reals_from_native(reinterpret_cast<std::byte*>(block.data()), block.size(), p);
    sink(block.data(), block.size() * 4);
  }
  const std::vector<std::byte> padding((c3d_block - all.size_bytes() % c3d_block) % c3d_block);
  sink(padding.data(), padding.size());
}

}  // namespace kinemesh
