#include "analysis/match_consensus.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace kinemesh {
namespace {

// Lengths in √area. Chosen on twelve pairs of subjects and motions that are measured nowhere else;
// factors of two in any of them change little.
constexpr double counted_length = 0.1;                // ratios of shorter distances are not asked
constexpr double neighbourhood = 0.3;                 // over which the others' say fades
constexpr double twist_weight = 0.05;                 // of a change of twist beside distances
constexpr double rough_part = 0.1, own_error = 0.02;  // standard deviations of the smooth map's
constexpr double affine_part = 1.0;
constexpr double offset_weight = 0.75;  // the offset's scatter over that of the distances' change
constexpr std::size_t map_neighbours = 32, least_matches = 4;
constexpr std::size_t many_matches = 64;  // of what is beyond, an eighth is taken back at once

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// How much distances and twists change.
class DistanceChanges {
 public:
  DistanceChanges(const FeatureEnergy& energy, const std::vector<FeatureMatch>& matches)
      : energy_(energy), matches_(matches) {
    std::vector<double> ratios;
    for (std::size_t k = 0; k < matches.size(); ++k) {
      for (std::size_t o = 0; o < k; ++o) {
        const auto [a, b] = lengths(k, o);
        if (std::isfinite(a) && std::isfinite(b) && a > counted_length) ratios.push_back(b / a);
      }
    }
    if (!ratios.empty()) scale_ = median(std::move(ratios));
  }

  /// The mean over the others, near ones counting most; the median ratio of all distances counts as
  /// a change of size.
  double of(std::size_t k) const {
    double sum = 0.0, weights = 0.0;
    for (std::size_t o = 0; o < matches_.size(); ++o) {
      const auto [a, b] = lengths(k, o);
      if (o == k || (!std::isfinite(a) && !std::isfinite(b))) continue;
      const bool same_part = std::isfinite(a) && std::isfinite(b);
      const double weight = same_part ? std::exp(-a / neighbourhood) : 1.0;
      const double twist =
          energy_
              .pair(matches_[k].source, matches_[o].source, matches_[k].target, matches_[o].target)
              .orientation;
      sum += weight * (same_part ? std::abs(scale_ * a - b) + twist_weight * twist : 1.0);
      weights += weight;
    }
    return weights > 0.0 ? sum / weights : 0.0;
  }

 private:
  std::pair<double, double> lengths(std::size_t k, std::size_t o) const {
    return energy_.lengths(matches_[k].source, matches_[o].source, matches_[k].target,
                           matches_[o].target);
  }

  const FeatureEnergy& energy_;
  const std::vector<FeatureMatch>& matches_;
  double scale_ = 1.0;
};

/// Rest places of the matches on both sides in √area, the source's moved onto the target's.
struct Aligned {
  Eigen::Matrix3Xd source, target, normals;
};

Aligned align_matches(const FeatureEnergy& energy, const std::vector<FeatureMatch>& matches) {
  const auto count = static_cast<Eigen::Index>(matches.size());
  Aligned result{Eigen::Matrix3Xd(3, count), Eigen::Matrix3Xd(3, count),
                 Eigen::Matrix3Xd(3, count)};
  for (Eigen::Index k = 0; k < count; ++k) {
    const FeatureMatch& m = matches[static_cast<std::size_t>(k)];
    const FeaturePlaces::Place& q = energy.target().places[m.target];
    result.source.col(k) = energy.source().places[m.source].position / energy.source().root_area_mm;
    result.target.col(k) = q.position / energy.target().root_area_mm;
    result.normals.col(k) = q.normal;
  }
  const Eigen::Matrix4d similarity = Eigen::umeyama(result.source, result.target);
  if (similarity.allFinite()) {
    const Eigen::Matrix3Xd turned = similarity.topLeftCorner<3, 3>() * result.source;
    result.source = turned.colwise() + Eigen::Vector3d(similarity.topRightCorner<3, 1>());
  }
  return result;
}

/// The nearest others on the source, the nearest first.
std::vector<Eigen::Index> nearest_others(const Aligned& at, Eigen::Index k) {
  std::vector<Eigen::Index> order;
  for (Eigen::Index o = 0; o < at.source.cols(); ++o) {
    if (o != k) order.push_back(o);
  }
  std::ranges::stable_sort(order, {}, [&](Eigen::Index o) {
    return (at.source.col(o) - at.source.col(k)).squaredNorm();
  });
  order.resize(std::min(order.size(), map_neighbours));
  return order;
}

struct Offset {
  double length = 0.0;    ///< along the surface
  double expected = 1.0;  ///< standard deviation that the map allows
};

/// How far match k is from where the map through the others puts it.
Offset offset_of(const Aligned& at, Eigen::Index k) {
  const std::vector<Eigen::Index> others = nearest_others(at, k);
  const auto count = static_cast<Eigen::Index>(others.size());
  const auto rough = [](double distance) {
    return rough_part * rough_part * std::exp(-distance / neighbourhood);
  };
  const double affine = affine_part * affine_part;
  Eigen::MatrixXd covariance(count, count);
  Eigen::VectorXd towards(count);
  Eigen::MatrixX3d moved(count, 3);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Vector3d x = at.source.col(others[i]) - at.source.col(k);
    moved.row(i) = (at.target.col(others[i]) - at.source.col(others[i])).transpose();
    towards[i] = affine + rough(x.norm());
    for (Eigen::Index j = 0; j <= i; ++j) {
      const Eigen::Vector3d y = at.source.col(others[j]) - at.source.col(k);
      covariance(i, j) = covariance(j, i) = affine * (1.0 + x.dot(y)) + rough((x - y).norm());
    }
    covariance(i, i) += own_error * own_error;
  }
  const Eigen::VectorXd weights = covariance.llt().solve(towards);
  const double variance = affine + rough(0.0) + own_error * own_error - weights.dot(towards);
  Eigen::Vector3d error = at.target.col(k) - at.source.col(k) - moved.transpose() * weights;
  error -= error.dot(at.normals.col(k)) * at.normals.col(k);
  return {error.norm(), std::sqrt(std::max(variance, own_error * own_error))};
}

}  // namespace

void fill_misfits(const FeatureEnergy& energy, std::vector<FeatureMatch>& matches) {
  const DistanceChanges changes(energy, matches);
  for (std::size_t k = 0; k < matches.size(); ++k) {
    matches[k].distance_change = matches[k].misfit = changes.of(k);
    matches[k].offset = 0.0;
  }
  if (matches.size() < least_matches) return;  // too few for a map
  const Aligned at = align_matches(energy, matches);
  std::vector<double> surprise;
  for (std::size_t k = 0; k < matches.size(); ++k) {
    const Offset offset = offset_of(at, static_cast<Eigen::Index>(k));
    matches[k].offset = offset.length;
    surprise.push_back(offset.length / offset.expected);
  }
  const double scatter = std::max(1.0, 1.4826 * median(std::move(surprise)));
  for (FeatureMatch& m : matches) {
    m.offset /= scatter;
    m.misfit = 0.5 * (m.distance_change + offset_weight * m.offset);
  }
}

void take_back_misfits(const FeatureEnergy& energy, double limit,
                       std::vector<FeatureMatch>& matches, std::vector<FeatureMatch>& rejected) {
  while (limit > 0.0 && matches.size() >= least_matches) {
    fill_misfits(energy, matches);
    const std::size_t beyond = matches.size() - std::min(matches.size(), many_matches);
    for (std::size_t left = 1 + beyond / 8; left > 0; --left) {
      const auto worst = std::ranges::max_element(matches, {}, &FeatureMatch::misfit);
      if (worst->misfit <= limit) return;
      rejected.push_back(*worst);
      matches.erase(worst);
    }
  }
}

}  // namespace kinemesh
