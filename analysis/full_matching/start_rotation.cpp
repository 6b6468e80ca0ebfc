#include "analysis/full_matching/start_rotation.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace kinemesh::full_matching {

namespace {

constexpr std::size_t few_places = 200,
                      many_places = 800;  // places compared: all rotations, the best
constexpr std::size_t refined = 10;       // rotations that are refined

class Scorer {
 public:
  Scorer(const SurfaceSignals& source, std::span<const Eigen::Vector3d> sphere,
         const Target& target, std::span<const Anchor> anchors, const RotationWeights& weights,
         uint64_t seed)
      : source_(source), sphere_(sphere), target_(target), anchors_(anchors), weights_(weights) {
    std::mt19937_64 random(seed);
    std::discrete_distribution<std::size_t> by_area(source.areas.begin(), source.areas.end());
    for (std::size_t k = 0; k < many_places; ++k) sample_.push_back(by_area(random));
  }

  double operator()(const Eigen::Matrix3d& rotation, std::size_t count) {
    from_.resize(3, static_cast<Eigen::Index>(count));
    to_.resize(3, static_cast<Eigen::Index>(count));
    signals_.resize(count);
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t v = sample_[k];
      const SurfacePoint place = target_.locator.locate(rotation * sphere_[v]);
      const Triangle& face = target_.closed.topology->faces()[place.face];
      Eigen::Vector3d position = Eigen::Vector3d::Zero();
      signals_[k].setZero();
      for (std::size_t c = 0; c < 3; ++c) {
        position += place.weights[c] * target_.signals.positions[face[c]];
        signals_[k] += static_cast<float>(place.weights[c]) * target_.signals.values[face[c]];
      }
      from_.col(static_cast<Eigen::Index>(k)) = source_.positions[v];
      to_.col(static_cast<Eigen::Index>(k)) = position;
    }
    return disagreement() + weights_.landmarks * away(rotation);
  }

 private:
  /// Mean squared distance of the landmarks from their goals.
  double away(const Eigen::Matrix3d& rotation) const {
    double sum = 0.0;
    for (const Anchor& a : anchors_) sum += (rotation * sphere_[a.vertex] - a.goal).squaredNorm();
    return anchors_.empty() ? 0.0 : sum / static_cast<double>(anchors_.size());
  }

  double disagreement() {
    from_.colwise() -= Eigen::Vector3d(from_.rowwise().mean());
    to_.colwise() -= Eigen::Vector3d(to_.rowwise().mean());
    const Eigen::Matrix3d covariance = to_ * from_.transpose();
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                                Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Vector3d signs(1, 1, 1);
    if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) signs.z() = -1;
    const Eigen::Matrix3d turn = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
    const double fitted = svd.singularValues().dot(signs);
    const double shape =
        1.0 - fitted * fitted / (from_.squaredNorm() * to_.squaredNorm());  // share not explained
    double strain = 0.0, loops = 0.0, normals = 0.0;
    for (std::size_t k = 0; k < signals_.size(); ++k) {
      const Signal& own = source_.values[sample_[k]];
      const Signal difference = own - signals_[k];
      normals += (turn.cast<float>() * own.head<3>() - signals_[k].head<3>()).squaredNorm();
      loops += difference.segment<2>(first_loop).squaredNorm();
      strain += std::min(4.0F, difference.tail<channels - first_strain>().squaredNorm());
    }
    const auto n = static_cast<double>(signals_.size());
    return weights_.shape * shape + weights_.strain * strain / n + weights_.normals * normals / n +
           weights_.loops * loops / n;
  }

  const SurfaceSignals& source_;
  std::span<const Eigen::Vector3d> sphere_;
  const Target& target_;
  std::span<const Anchor> anchors_;
  RotationWeights weights_;
  std::vector<std::size_t> sample_;
  Eigen::Matrix3Xd from_, to_;
  std::vector<Signal> signals_;
};

/// Spread evenly over all rotations (Alexa 2022: super-Fibonacci spirals).
Eigen::Matrix3d spread_rotation(int index, int count) {
  const double s = index + 0.5, t = s / count, d = 2.0 * std::numbers::pi * s;
  const double r = std::sqrt(t), q = std::sqrt(1.0 - t);
  const double alpha = d / std::numbers::sqrt2, beta = d / 1.533751168755204288118041;
  return Eigen::Quaterniond(q * std::cos(beta), r * std::sin(alpha), r * std::cos(alpha),
                            q * std::sin(beta))
      .toRotationMatrix();
}

}  // namespace

Eigen::Matrix3d start_rotation(const SurfaceSignals& source,
                               std::span<const Eigen::Vector3d> sphere, const Target& target,
                               std::span<const Anchor> anchors, int count,
                               const RotationWeights& weights, const RunContext& ctx) {
  Scorer score(source, sphere, target, anchors, weights, ctx.seed() + 1);
  struct Tried {
    double value;
    Eigen::Matrix3d rotation;
  };
  std::vector<Tried> tried;
  for (int k = 0; k < count; ++k) {
    if (k % 64 == 0) ctx.check_cancelled();
    const Eigen::Matrix3d rotation = spread_rotation(k, count);
    tried.push_back({score(rotation, few_places), rotation});
  }
  std::ranges::stable_sort(tried, {}, &Tried::value);
  tried.resize(std::min(tried.size(), refined));
  std::mt19937_64 random(ctx.seed() + 2);
  std::normal_distribution<double> normal;
  for (Tried& start : tried) {
    start.value = score(start.rotation, many_places);
    for (double size = 0.2; size > 0.01; size *= 0.93) {
      const Eigen::Vector3d turn(normal(random), normal(random), normal(random));
      const double angle = size * turn.norm();
      const Eigen::Matrix3d rotation =
          Eigen::AngleAxisd(angle, turn.normalized()).toRotationMatrix() * start.rotation;
      const double value = score(rotation, many_places);
      if (value < start.value) start = {value, rotation};
    }
  }
  return std::ranges::min_element(tried, {}, &Tried::value)->rotation;
}

}  // namespace kinemesh::full_matching
