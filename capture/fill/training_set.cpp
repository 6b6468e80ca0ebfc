#include "capture/fill/training_set.h"

#include <algorithm>
#include <cmath>
#include <numeric>

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

/// Positions of donors in rows and gap frames, and the rigid frame that moves with them.
class CommonFrame {
 public:
  CommonFrame(const Trajectories& rough, const std::vector<Donor>& donors,
              const std::vector<std::size_t>& frames, std::size_t row_count, int rounds)
      : poses_(frames.size()), count_(donors.size()) {
    positions_.reserve(frames.size() * count_);
    for (const std::size_t f : frames) {
      for (const Donor& d : donors) positions_.emplace_back(rough.at(d.marker, f));
    }
    if (count_ < 4 || row_count == 0) return;
    std::vector<Eigen::Vector3d> shape(at(row_count / 2).begin(), at(row_count / 2).end());
    std::vector<double> weights(count_, 1.0);
    for (int round = 0; round <= rounds; ++round) {
      for (std::size_t i = 0; i < frames.size(); ++i) poses_[i] = fit_rigid(shape, at(i), weights);
      if (round < rounds) average(row_count, shape, weights);
    }
  }

  std::span<const Eigen::Vector3d> at(std::size_t i) const {
    return {positions_.data() + i * count_, count_};
  }
  const RigidFit& pose(std::size_t i) const { return poses_[i]; }

 private:
  /// Mean shape over the rows; donors that move more count less.
  void average(std::size_t row_count, std::vector<Eigen::Vector3d>& shape,
               std::vector<double>& weights) const {
    std::vector<double> variance(count_, 0.0);
    for (std::size_t k = 0; k < count_; ++k) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (std::size_t i = 0; i < row_count; ++i) sum += poses_[i].undo(at(i)[k]);
      shape[k] = sum / static_cast<double>(row_count);
      for (std::size_t i = 0; i < row_count; ++i) {
        variance[k] += (poses_[i].undo(at(i)[k]) - shape[k]).squaredNorm();
      }
    }
    std::vector<double> sorted = variance;
    std::ranges::sort(sorted);
    const double median = sorted[count_ / 2];
    if (median <= 0.0) return;
    for (std::size_t k = 0; k < count_; ++k) weights[k] = median / (variance[k] + median);
  }

  std::vector<RigidFit> poses_;
  std::vector<Eigen::Vector3d> positions_;
  std::size_t count_;
};

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
        values[i] = frame.pose(i).undo(frame.at(i)[k])[static_cast<Eigen::Index>(c)];
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

/// How much each of the first donors tells about a place that moves like what is around it:
/// ordinary kriging (Matheron 1963) of a displacement field with a Matérn 3/2 covariance over the
/// distance. The weights add up to 1.
Eigen::VectorXd kriging_weights(const std::vector<Eigen::Vector3d>& at, const Eigen::Vector3d& own,
                                const TrainingOptions& options) {
  const auto n = static_cast<Eigen::Index>(at.size());
  double range = 0.0;
  for (const Eigen::Vector3d& p : at) {
    range += options.guess_range * (p - own).norm() / static_cast<double>(n);
  }
  if (!(range > 0.0)) return Eigen::VectorXd::Zero(n);
  const auto alike = [&](const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
    const double r = std::sqrt(3.0) * (p - q).norm() / range;
    return (1.0 + r) * std::exp(-r);
  };
  Eigen::MatrixXd a = Eigen::MatrixXd::Ones(n + 1, n + 1);
  Eigen::VectorXd b = Eigen::VectorXd::Ones(n + 1);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Vector3d& p = at[static_cast<std::size_t>(k)];
    for (Eigen::Index j = 0; j < n; ++j) a(k, j) = alike(p, at[static_cast<std::size_t>(j)]);
    a(k, k) += options.guess_nugget;
    b[k] = alike(p, own);
  }
  a(n, n) = 0.0;
  return a.fullPivLu().solve(b).head(n);
}

/// What the nearest donors' displacements say where the marker is, before anything is learnt.
Eigen::MatrixXd spatial_guess(const CommonFrame& frame, const Eigen::Vector3d& own,
                              std::size_t donors, std::size_t rows, std::size_t columns,
                              const TrainingOptions& options) {
  Eigen::MatrixXd guess = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(columns), 3);
  const std::size_t n = std::min(donors, options.guess_donors);
  constexpr std::size_t least = 3;  // fewer say little of the surface between them
  if (n < least || rows == 0) return guess;
  std::vector<Eigen::Vector3d> at(n, Eigen::Vector3d::Zero());
  for (std::size_t i = 0; i < rows; ++i) {
    for (std::size_t k = 0; k < n; ++k) {
      at[k] += frame.pose(i).undo(frame.at(i)[k]) / static_cast<double>(rows);
    }
  }
  const Eigen::VectorXd weights = kriging_weights(at, own, options);
  for (std::size_t i = 0; i < columns; ++i) {
    for (std::size_t k = 0; k < n; ++k) {
      guess.row(static_cast<Eigen::Index>(i)) +=
          weights[static_cast<Eigen::Index>(k)] *
          (frame.pose(i).undo(frame.at(i)[k]) - at[k]).transpose();
    }
  }
  return guess;
}

}  // namespace

TrainingSet make_training_set(const Trajectories& take, const Trajectories& rough, const GapAt& gap,
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

  const CommonFrame frame(rough, donors, frames, rows, options.frame_rounds);
  set.inputs = make_inputs(frame, donors, rows, frames.size());
  set.outputs.resize(static_cast<Eigen::Index>(rows), 3);
  for (std::size_t i = 0; i < rows; ++i) {
    set.outputs.row(static_cast<Eigen::Index>(i)) =
        frame.pose(i).undo(take.at(gap.marker, frames[i])).transpose();
  }
  set.guess = spatial_guess(frame, set.outputs.colwise().mean().transpose(), donors.size(), rows,
                            frames.size(), options);
  set.outputs -= set.guess.topRows(static_cast<Eigen::Index>(rows));
  set.mean_output = set.outputs.colwise().mean();
  set.outputs.rowwise() -= set.mean_output;
  for (std::size_t i = rows; i < frames.size(); ++i) set.poses.push_back(frame.pose(i));
  return set;
}

}  // namespace kinemesh::fill
