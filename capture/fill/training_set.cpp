#include "capture/fill/training_set.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "capture/fill/common_frame.h"

namespace kinemesh::fill {
namespace {

constexpr std::size_t margin = 5;  // frames beside the gap that matter most for a smooth join

struct Donor {
  std::size_t marker = 0;
  double weight = 0.0;
};

FrameRange widened(const Trajectories& take, FrameRange range) {
  return {range.begin > margin ? range.begin - margin : 0,
          std::min(take.frames(), range.end + margin)};
}

std::size_t measured_in(const Trajectories& take, std::size_t marker, FrameRange range) {
  std::size_t count = 0;
  for (std::size_t f = range.begin; f < range.end; ++f) count += take.measured(marker, f) ? 1 : 0;
  return count;
}

std::vector<Donor> choose_donors(const Trajectories& take, const GapAt& gap,
                                 const TrainingOptions& options) {
  const std::vector<std::size_t> nearest = take.nearest(gap.marker);
  const auto distance = [&](std::size_t m) {
    return (take.mean(m) - take.mean(gap.marker)).norm();
  };
  double mean_distance = 0.0;
  const std::size_t five = std::min<std::size_t>(5, nearest.size());
  for (std::size_t k = 0; k < five; ++k) {
    mean_distance += distance(nearest[k]) / static_cast<double>(five);
  }
  const double range = std::max(options.donor_range_mm, 1.2 * mean_distance);
  const auto collect = [&](auto&& usable) {
    std::vector<Donor> donors;
    for (const std::size_t m : nearest) {
      if (donors.size() == options.donors) break;
      const double relative = distance(m) / range;
      const double weight = std::exp(-0.5 * relative * relative);
      if (donors.size() >= 4 && weight < 0.01) break;
      if (usable(m)) donors.push_back({m, std::max(weight, 1e-3)});
    }
    return donors;
  };
  const FrameRange wide = widened(take, gap.frames);
  std::vector<Donor> donors =
      collect([&](std::size_t m) { return take.measured_throughout(m, wide); });
  if (donors.size() >= 3) return donors;
  return collect(
      [&](std::size_t m) { return 2 * measured_in(take, m, gap.frames) >= gap.frames.size(); });
}

/// Frames with the marker and all donors measured, outside the gap.
std::vector<std::size_t> complete_rows(const Trajectories& take, std::size_t marker,
                                       const std::vector<Donor>& donors) {
  std::vector<std::size_t> rows;
  for (std::size_t f = 0; f < take.frames(); ++f) {
    if (take.measured(marker, f) &&
        std::ranges::all_of(donors, [&](const Donor& d) { return take.measured(d.marker, f); })) {
      rows.push_back(f);
    }
  }
  return rows;
}

/// Drops donors that are missing often until enough rows are left.
std::vector<std::size_t> rows_and_donors(const Trajectories& take, std::size_t marker,
                                         std::size_t wanted, std::vector<Donor>& donors) {
  const std::size_t available = take.measured_count(marker);
  const std::size_t enough = std::min(wanted, available / 2);
  std::vector<std::size_t> rows = complete_rows(take, marker, donors);
  while (rows.size() < enough && !donors.empty()) {
    const auto cost = [&](const Donor& d) {
      std::size_t missing = 0;
      for (std::size_t f = 0; f < take.frames(); ++f) {
        if (take.measured(marker, f) && !take.measured(d.marker, f)) ++missing;
      }
      return static_cast<double>(missing) / (0.1 + d.weight);
    };
    donors.erase(std::ranges::max_element(donors, {}, cost));
    rows = complete_rows(take, marker, donors);
  }
  return rows;
}

/// All of `from` when they are few; otherwise evenly spread ones.
void spread(const std::vector<std::size_t>& from, std::size_t most,
            std::vector<std::size_t>& into) {
  const std::size_t count = std::min(most, from.size());
  for (std::size_t i = 0; i < count; ++i) {
    into.push_back(from[count == 1 ? 0 : i * (from.size() - 1) / (count - 1)]);
  }
}

/// Dense beside the gap, spread over the take elsewhere.
std::vector<std::size_t> thin_rows(const Trajectories& take, const GapAt& gap,
                                   const std::vector<std::size_t>& complete,
                                   const TrainingOptions& options) {
  if (complete.size() <= options.rows) return complete;
  constexpr std::size_t dense = 12;  // frames beside the gap that are all taken
  // Near rows on one side; a third of the rows at least are left for the rest of the take.
  const std::size_t most_a_side = std::clamp<std::size_t>(options.rows / 3, dense, 40);
  const auto near = static_cast<std::size_t>(
      std::max(static_cast<double>(dense), std::round(options.near_s * take.rate_hz())));
  std::vector<std::size_t> rows;
  std::vector<std::size_t> before;
  std::vector<std::size_t> after;
  std::vector<std::size_t> far;
  for (const std::size_t f : complete) {
    const std::size_t away = f < gap.frames.begin ? gap.frames.begin - f : f - gap.frames.end + 1;
    if (away <= dense) {
      rows.push_back(f);
    } else if (away <= near) {
      (f < gap.frames.begin ? before : after).push_back(f);
    } else {
      far.push_back(f);
    }
  }
  spread(before, most_a_side - dense, rows);
  spread(after, most_a_side - dense, rows);
  spread(far, options.rows - std::min(options.rows, rows.size()), rows);
  std::ranges::sort(rows);
  return rows;
}

/// Weighted displacements, scaled to a root mean square norm of 1 over the rows or, where the
/// donors move more in the gap, over the geometric mean of both: motion that no row knows must not
/// look like much of the same, and what the rows tell of its beginning must count.
Dense make_inputs(const CommonFrame& frame, const std::vector<Donor>& donors, std::size_t rows,
                  std::size_t columns) {
  Dense inputs(3 * donors.size(), columns);
  double outside = 0.0;
  double inside = 0.0;
  for (std::size_t k = 0; k < donors.size(); ++k) {
    for (std::size_t c = 0; c < 3; ++c) {
      double* values = inputs.row(3 * k + c);
      double mean = 0.0;
      for (std::size_t i = 0; i < columns; ++i) {
        values[i] = frame.inside(i, k)[static_cast<Eigen::Index>(c)];
        if (i < rows) mean += values[i] / static_cast<double>(rows);
      }
      for (std::size_t i = 0; i < columns; ++i) {
        values[i] = donors[k].weight * (values[i] - mean);
        (i < rows ? outside : inside) += values[i] * values[i];
      }
    }
  }
  double squares = outside / static_cast<double>(rows);
  if (columns > rows) {
    squares = std::max(squares, std::sqrt(squares * inside / static_cast<double>(columns - rows)));
  }
  const double norm = std::sqrt(squares);
  if (norm <= 0.0) return inputs;
  for (std::size_t r = 0; r < inputs.rows(); ++r) {
    for (std::size_t i = 0; i < columns; ++i) inputs(r, i) /= norm;
  }
  return inputs;
}

}  // namespace

TrainingSet make_training_set(const Trajectories& take, const Trajectories& rough,
                              const Mirror* mirror, const GapAt& gap,
                              const TrainingOptions& options) {
  TrainingSet set;
  std::vector<Donor> donors = choose_donors(take, gap, options);
  const auto complete = rows_and_donors(take, gap.marker, options.rows, donors);
  set.rows = thin_rows(take, gap, complete, options);
  set.donors = donors.size();
  set.gap.resize(gap.frames.size());
  std::iota(set.gap.begin(), set.gap.end(), gap.frames.begin);
  std::vector<std::size_t> frames = set.rows;
  frames.insert(frames.end(), set.gap.begin(), set.gap.end());
  const std::size_t rows = set.rows.size();

  std::vector<std::size_t> markers;
  for (const Donor& d : donors) markers.push_back(d.marker);
  const CommonFrame frame(rough, markers, frames, rows, options.frame_rounds);
  set.inputs = make_inputs(frame, donors, rows, frames.size());
  set.outputs.resize(static_cast<Eigen::Index>(rows), 3);
  for (std::size_t i = 0; i < rows; ++i) {
    set.outputs.row(static_cast<Eigen::Index>(i)) =
        frame.pose(i).undo(take.at(gap.marker, frames[i])).transpose();
  }
  set.guess = spatial_guess({.take = take,
                             .rough = rough,
                             .gap = gap,
                             .donors = markers,
                             .frames = frames,
                             .rows = rows,
                             .frame = frame,
                             .own = set.outputs.colwise().mean().transpose()},
                            mirror, options.guess);
  set.outputs -= set.guess.topRows(static_cast<Eigen::Index>(rows));
  set.mean_output = set.outputs.colwise().mean();
  set.outputs.rowwise() -= set.mean_output;
  for (std::size_t i = rows; i < frames.size(); ++i) set.poses.push_back(frame.pose(i));
  return set;
}

}  // namespace kinemesh::fill
