#include "capture/marker_sequence.h"

#include <algorithm>
#include <limits>

namespace kinemesh {

std::string_view name_of(MarkerKind kind) {
  switch (kind) {
    case MarkerKind::marker: return "marker";
    case MarkerKind::unlabelled: return "unlabelled";
    case MarkerKind::virtual_point: return "virtual";
    case MarkerKind::angle: return "angle";
    case MarkerKind::force: return "force";
    case MarkerKind::moment: return "moment";
    case MarkerKind::power: return "power";
    case MarkerKind::scalar: return "scalar";
  }
  return "marker";
}

MarkerSequence::MarkerSequence(std::size_t frame_count, std::vector<Marker> markers, double rate)
    : rate_hz(rate), frame_count_(frame_count), markers_(std::move(markers)) {
  positions_ = Buffer<float>(3 * sample_count());
  flags_ = Buffer<uint8_t>(sample_count());
  residuals_ = Buffer<float>(sample_count());
  camera_masks_ = Buffer<uint8_t>(sample_count());
}

MarkerSequence MarkerSequence::invalid(std::size_t frame_count, std::vector<Marker> markers,
                                       double rate) {
  MarkerSequence take(frame_count, std::move(markers), rate);
  std::ranges::fill(take.positions_, std::numeric_limits<float>::quiet_NaN());
  std::ranges::fill(take.flags_, uint8_t{0});
  std::ranges::fill(take.residuals_, 0.0F);
  std::ranges::fill(take.camera_masks_, uint8_t{0});
  return take;
}

std::size_t MarkerSequence::find(std::string_view label) const {
  for (std::size_t m = 0; m < markers_.size(); ++m) {
    const Marker& marker = markers_[m];
    if (marker.label == label) return m;
    if (!marker.subject.empty() && marker.subject + ":" + marker.label == label) return m;
  }
  return npos;
}

void MarkerSequence::add_uncertainty() {
  if (uncertainty_.empty()) uncertainty_ = Buffer<float>(sample_count(), 0.0F);
}

MarkerSequence MarkerSequence::select(std::span<const std::size_t> chosen) const {
  std::vector<Marker> kept;
  kept.reserve(chosen.size());
  for (const std::size_t m : chosen) kept.push_back(markers_.at(m));
  MarkerSequence out(frame_count_, std::move(kept), rate_hz);
  if (!uncertainty_.empty()) out.add_uncertainty();
  for (std::size_t f = 0; f < frame_count_; ++f) {
    for (std::size_t k = 0; k < chosen.size(); ++k) {
      const std::size_t from = sample(f, chosen[k]);
      const std::size_t to = out.sample(f, k);
      std::copy_n(positions_.data() + 3 * from, 3, out.positions_.data() + 3 * to);
      out.flags_[to] = flags_[from];
      out.residuals_[to] = residuals_[from];
      out.camera_masks_[to] = camera_masks_[from];
      if (!uncertainty_.empty()) out.uncertainty_[to] = uncertainty_[from];
    }
  }
  out.first_frame = first_frame;
  out.events = events;
  out.origin = origin;
  return out;
}

}  // namespace kinemesh
