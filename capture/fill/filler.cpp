#include "capture/fill/filler.h"

#include <cmath>

#include "capture/fill/companions.h"
#include "capture/fill/left_out.h"
#include "capture/fill/pca.h"
#include "capture/fill/scarce.h"
#include "capture/fill/spline.h"
#include "capture/marker_name.h"

namespace kinemesh::fill {
namespace {

/// With many gaps each may cost less: a long session is to be cleaned in a second or so.
bool is_fast(const Trajectories& take, const GapFillOptions& options) {
  if (options.effort != FillEffort::automatic) return options.effort == FillEffort::fast;
  constexpr std::size_t many = 100;
  std::size_t gaps = 0;
  for (std::size_t m = 0; m < take.markers() && gaps <= many; ++m) {
    if (take.measured_count(m) < take.frames()) gaps += take.gaps(m).size();
  }
  return gaps > many;
}

}  // namespace

Filler::Filler(const std::vector<Marker>& markers, const Trajectories& trajectories,
               const GapFillOptions& options)
    : take_(trajectories), method_(options.method), fill_rest_(options.fill_rest) {
  max_gap_ =
      static_cast<std::size_t>(std::floor(options.max_gap_s * trajectories.rate_hz() + 1e-6));
  if (!options.donor.empty()) donor_ = marker_meant(markers, options.donor, "--donor names");
  for (const std::string& label : options.companions) {
    companions_.push_back(marker_meant(markers, label, "--companion names"));
  }
  if (fill_rest_ || method_ == FillMethod::automatic) {
    automatic_.emplace(trajectories, AutomaticOptions{.fast = is_fast(trajectories, options)});
  } else {
    rough_.emplace(fill_roughly(trajectories));
  }
}

std::optional<Estimate> Filler::by_method(const GapAt& gap) const {
  const auto spline = [&](int degree) -> std::optional<Estimate> {
    if (gap.frames.size() > max_gap_) return std::nullopt;
    return fill_spline(take_, gap, degree);
  };
  switch (method_) {
    case FillMethod::linear: return spline(1);
    case FillMethod::cubic: return spline(3);
    case FillMethod::quintic: return spline(5);
    case FillMethod::pattern: {
      if (donor_) return fill_pattern(take_, gap, *donor_);
      const auto near = seen_throughout(take_, gap, take_.nearest(gap.marker), 1);
      return near.empty() ? std::nullopt : fill_pattern(take_, gap, near.front());
    }
    case FillMethod::rigid: {
      if (!companions_.empty()) return fill_rigid(take_, gap, companions_);
      constexpr std::size_t companions = 6;
      return fill_rigid(take_, gap,
                        seen_throughout(take_, gap, take_.nearest(gap.marker), companions));
    }
    case FillMethod::pca: return fill_pca(take_, gap);
    case FillMethod::automatic:
    case FillMethod::hold: break;
  }
  return std::nullopt;
}

Filled Filler::fill(const GapAt& gap) const {
  Filled out{by_method(gap), method_};
  if (out.estimate) {
    set_sd_from_left_out(
        take_, gap, [this](const GapAt& at) { return by_method(at); }, *out.estimate);
  } else if (automatic_) {
    out = {automatic_->fill(gap), FillMethod::automatic};
  }
  if (out.estimate && is_scarce(take_, gap.marker)) {
    raise_sd_of_scarce(take_, automatic_ ? automatic_->rough() : *rough_, gap, *out.estimate);
  }
  return out;
}

std::optional<Estimate> Filler::estimate(const GapAt& gap) const {
  auto out = by_method(gap);
  return out || !automatic_ ? out : automatic_->fill(gap);
}

}  // namespace kinemesh::fill
