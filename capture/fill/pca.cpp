#include "capture/fill/pca.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "capture/fill/companions.h"

namespace kinemesh::fill {
namespace {

constexpr std::size_t most_markers = 60;
constexpr std::size_t most_frames = 2000;
constexpr std::size_t least_frames = 20;

/// Frames outside the gap in which all of `markers` are measured; evenly thinned when too many.
std::vector<std::size_t> complete_frames_of(const Trajectories& take, const GapAt& gap,
                                            const std::vector<std::size_t>& markers) {
  std::vector<std::size_t> all;
  for (std::size_t f = 0; f < take.frames(); ++f) {
    if (f >= gap.frames.begin && f < gap.frames.end) continue;
    if (std::ranges::all_of(markers, [&](std::size_t m) { return take.measured(m, f); })) {
      all.push_back(f);
    }
  }
  if (all.size() <= most_frames) return all;
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < most_frames; ++i) out.push_back(all[i * all.size() / most_frames]);
  return out;
}

/// Frames × 3 markers; markers[0] is the one with the gap. Relative to the mean of the others.
Eigen::MatrixXd relative_positions(const Trajectories& take,
                                   const std::vector<std::size_t>& markers,
                                   const std::vector<std::size_t>& frames, bool with_first,
                                   Eigen::MatrixXd& centres) {
  const auto count = static_cast<Eigen::Index>(markers.size());
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(frames.size()), 3 * count);
  centres.resize(out.rows(), 3);
  for (Eigen::Index r = 0; r < out.rows(); ++r) {
    const std::size_t f = frames[static_cast<std::size_t>(r)];
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (std::size_t k = 1; k < markers.size(); ++k) {
      centre += take.at(markers[k], f) / static_cast<double>(markers.size() - 1);
    }
    centres.row(r) = centre.transpose();
    for (Eigen::Index k = with_first ? 0 : 1; k < count; ++k) {
      out.block<1, 3>(r, 3 * k) =
          (take.at(markers[static_cast<std::size_t>(k)], f) - centre).transpose();
    }
  }
  return out;
}

/// Leading principal axes of centred rows, as columns, strongest first.
Eigen::MatrixXd principal_axes(const Eigen::MatrixXd& rows) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(rows.transpose() * rows);
  const Eigen::VectorXd singular = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt().reverse();
  constexpr double share = 0.99;
  double sum = 0.0;
  Eigen::Index kept = 0;
  while (kept < singular.size() && (kept == 0 || sum < share * singular.sum())) {
    sum += singular[kept++];
  }
  return solver.eigenvectors().rowwise().reverse().leftCols(kept);
}

/// Scale of each column: weight over standard deviation.
Eigen::RowVectorXd column_scales(const Trajectories& take, const std::vector<std::size_t>& markers,
                                 const Eigen::MatrixXd& centred) {
  constexpr double sigma_mm = 200.0;
  Eigen::RowVectorXd scales(centred.cols());
  for (Eigen::Index k = 0; k < scales.size() / 3; ++k) {
    const double d =
        (take.mean(markers[static_cast<std::size_t>(k)]) - take.mean(markers[0])).norm() / sigma_mm;
    for (Eigen::Index c = 3 * k; c < 3 * k + 3; ++c) {
      const double sd =
          std::sqrt(centred.col(c).squaredNorm() / static_cast<double>(centred.rows()));
      scales[c] = sd > 0.0 ? std::exp(-0.5 * d * d) / sd : 0.0;
    }
  }
  return scales;
}

}  // namespace

std::optional<Estimate> fill_pca(const Trajectories& take, const GapAt& gap) {
  std::vector<std::size_t> markers =
      seen_throughout(take, gap, take.nearest(gap.marker), most_markers);
  if (markers.size() < 3) return std::nullopt;
  markers.insert(markers.begin(), gap.marker);
  const std::vector<std::size_t> frames = complete_frames_of(take, gap, markers);
  if (frames.size() < least_frames) return std::nullopt;

  Eigen::MatrixXd centres;
  Eigen::MatrixXd full = relative_positions(take, markers, frames, true, centres);
  const Eigen::RowVectorXd mean = full.colwise().mean();
  full.rowwise() -= mean;
  const Eigen::RowVectorXd scales = column_scales(take, markers, full);
  full.array().rowwise() *= scales.array();
  Eigen::MatrixXd without = full;
  without.leftCols(3).setZero();
  const Eigen::MatrixXd axes = principal_axes(full);
  const Eigen::MatrixXd axes_without = principal_axes(without);
  const Eigen::MatrixXd map =
      axes_without * (axes.transpose() * axes_without).transpose() * axes.transpose();

  // The gap's frames and the one on either side, where the prediction is compared.
  std::vector<std::size_t> wanted;
  const std::size_t first = gap.frames.begin > 0 ? gap.frames.begin - 1 : 0;
  const std::size_t last = std::min(gap.frames.end, take.frames() - 1);
  for (std::size_t f = first; f <= last; ++f) wanted.push_back(f);
  Eigen::MatrixXd seen = relative_positions(take, markers, wanted, false, centres);
  seen.rowwise() -= mean;
  seen.array().rowwise() *= scales.array();
  seen.leftCols(3).setZero();
  Eigen::MatrixXd predicted = seen * map.leftCols(3);
  for (Eigen::Index c = 0; c < 3; ++c) {
    if (scales[c] > 0.0) {
      predicted.col(c) /= scales[c];
    } else {
      predicted.col(c).setZero();
    }
  }
  predicted.rowwise() += mean.head<3>();
  predicted += centres;
  return bridge(take, gap, [&](std::size_t f) -> Eigen::Vector3d {
    return predicted.row(static_cast<Eigen::Index>(f - first)).transpose();
  });
}

}  // namespace kinemesh::fill
