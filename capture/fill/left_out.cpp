#include "capture/fill/left_out.h"

#include <cmath>

namespace kinemesh::fill {
namespace {

constexpr std::size_t most_stretches = 8;

/// Starts of measured stretches of this length with a measured sample on either side, evenly
/// spread over all there are.
std::vector<std::size_t> stretches(const Trajectories& take, std::size_t marker,
                                   std::size_t length) {
  std::vector<std::size_t> starts;
  std::size_t run = 0;
  for (std::size_t f = 0; f < take.frames(); ++f) {
    run = take.measured(marker, f) ? run + 1 : 0;
    if (run >= length + 2) starts.push_back(f - length);
  }
  if (starts.size() <= most_stretches) return starts;
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < most_stretches; ++k) {
    chosen.push_back(starts[k * (starts.size() - 1) / (most_stretches - 1)]);
  }
  return chosen;
}

/// Variance of a tied random walk at step i of `length`, relative to that of one step.
double walk(std::size_t i, std::size_t length, bool both_ends) {
  const auto done = static_cast<double>(i + 1);
  return both_ends ? done * (1.0 - done / static_cast<double>(length + 1)) : done;
}

/// Root mean square distance of the marker from its mean, per coordinate.
double own_spread(const Trajectories& take, std::size_t marker) {
  double squares = 0.0;
  for (std::size_t f = 0; f < take.frames(); ++f) {
    if (take.measured(marker, f)) {
      squares += (take.at(marker, f) - take.mean(marker)).squaredNorm();
    }
  }
  const auto count = static_cast<double>(take.measured_count(marker));
  return std::sqrt(squares / (3.0 * count));
}

}  // namespace

void set_sd_from_left_out(const Trajectories& take, const GapAt& gap, const Method& method,
                          Estimate& estimate) {
  const std::size_t length = gap.frames.size();
  double squares = 0.0;
  double walked = 0.0;
  for (const std::size_t start : stretches(take, gap.marker, length)) {
    const GapAt left_out{gap.marker, {start, start + length}};
    const std::optional<Estimate> guess = method(left_out);
    if (!guess) continue;
    for (std::size_t i = 0; i < length; ++i) {
      squares += (guess->positions[i] - take.at(gap.marker, start + i)).squaredNorm() / 3.0;
      walked += walk(i, length, true);
    }
  }
  const bool inside = gap.frames.begin > 0 && gap.frames.end < take.frames();
  if (walked == 0.0) {  // nowhere to measure: no better known than the marker's range of motion
    constexpr double unknown_mm = 10.0;
    constexpr std::size_t least = 8;  // samples; fewer show one moment of it, no range
    const bool moving = take.measured_count(gap.marker) >= least;
    estimate.sd.assign(length, moving ? own_spread(take, gap.marker) : unknown_mm);
    return;
  }
  const double step = std::sqrt(squares / walked);
  for (std::size_t i = 0; i < length; ++i) {
    const std::size_t from_end = gap.frames.begin > 0 ? i : length - 1 - i;
    estimate.sd.push_back(step * std::sqrt(walk(from_end, length, inside)));
  }
}

}  // namespace kinemesh::fill
