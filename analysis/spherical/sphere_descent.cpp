#include "analysis/spherical/sphere_descent.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <limits>

namespace kinemesh::spherical {

Eigen::Vector2d newton_direction(const Eigen::Vector2d& gradient, const Eigen::Matrix2d& hessian) {
  const double half_trace = (hessian(0, 0) + hessian(1, 1)) / 2.0;
  const double half_gap = (hessian(0, 0) - hessian(1, 1)) / 2.0, off = hessian(0, 1);
  const double radius = std::sqrt(half_gap * half_gap + off * off);
  const double largest = std::max(std::abs(half_trace + radius), std::abs(half_trace - radius));
  if (!(largest > 0.0)) return Eigen::Vector2d::Zero();
  const double floor = 1e-3 * largest;
  const double high = std::max(std::abs(half_trace + radius), floor);
  const double low = std::max(std::abs(half_trace - radius), floor);
  if (!(radius > 0.0)) return -gradient / high;
  // The eigenvector of the larger eigenvalue; the other is at right angles to it.
  const double angle = std::atan2(off, half_gap) / 2.0;
  const Eigen::Vector2d first(std::cos(angle), std::sin(angle)), second(-first.y(), first.x());
  return -first * (first.dot(gradient) / high) - second * (second.dot(gradient) / low);
}

Eigen::Matrix<double, 3, 2> tangent_basis(const Eigen::Vector3d& p) {
  const Eigen::Vector3d axis =
      std::abs(p.x()) < 0.6 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  Eigen::Matrix<double, 3, 2> basis;
  basis.col(0) = p.cross(axis).normalized();
  basis.col(1) = p.cross(basis.col(0));
  return basis;
}

SphereDescent::SphereDescent(const RingMesh& mesh, std::span<const Eigen::Vector3d> rest,
                             std::vector<Eigen::Vector3d>& points, double slenderness,
                             double shortest)
    : mesh_(mesh), rest_(rest), points_(points), slenderness_(slenderness), shortest_(shortest) {}

void SphereDescent::set_scale(double scale) { scale_square_ = scale * scale; }

double SphereDescent::fitting_scale() const {
  double rest_area = 0.0, area = 0.0;
  for (const VertexIndex v : mesh_.alive()) {
    const std::vector<VertexIndex>& ring = mesh_.ring(v);
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const VertexIndex b = ring[i], c = ring[(i + 1) % ring.size()];
      if (b < v || c < v) continue;
      rest_area += rest_triangle(rest_[v], rest_[b], rest_[c], slenderness_, shortest_).area;
      area += (points_[v] - points_[b]).dot(points_[b].cross(points_[c] - points_[b])) / 2.0;
    }
  }
  return std::sqrt(area / rest_area);
}

void SphereDescent::gather(VertexIndex v) {
  const std::vector<VertexIndex>& ring = mesh_.ring(v);
  corners_.resize(ring.size());
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const VertexIndex b = ring[i], c = ring[i + 1 == ring.size() ? 0 : i + 1];
    const RestTriangle rest = rest_triangle(rest_[v], rest_[b], rest_[c], slenderness_, shortest_);
    Corner& corner = corners_[i];
    corner.b = points_[b];
    corner.c = points_[c];
    const Eigen::Vector3d side = corner.c - corner.b;
    corner.normal = corner.b.cross(side);
    corner.cot_b = rest.cotangents[1];
    corner.cot_c = rest.cotangents[2];
    corner.base = rest.cotangents[0] * side.squaredNorm() / 2.0;
    const double doubled = 2.0 * rest.area * scale_square_;
    corner.area = doubled * doubled;
    corner.least_square = 1e-20 * corner.normal.squaredNorm();
  }
}

double SphereDescent::energy_at(const Eigen::Vector3d& p, const Pull* pull) const {
  double energy = pull != nullptr ? pull->weight * (p - pull->goal).squaredNorm() : 0.0;
  for (const Corner& k : corners_) {
    const Eigen::Vector3d from_b = p - k.b;
    const double determinant = from_b.dot(k.normal), length = from_b.squaredNorm();
    const double square = determinant * determinant;
    if (!(determinant > 0.0) || square <= k.least_square * length) {
      return std::numeric_limits<double>::infinity();
    }
    // l² opposite to c is |p − b|², opposite to b |p − c|².
    const double stretch = k.base + (k.cot_c * length + k.cot_b * (p - k.c).squaredNorm()) / 2.0;
    energy += stretch * (1.0 + k.area / square);
  }
  return energy;
}

void SphereDescent::differentiate(const Eigen::Vector3d& p, Eigen::Vector3d& gradient,
                                  Eigen::Matrix3d& hessian) const {
  gradient.setZero();
  hessian.setZero();
  for (const Corner& k : corners_) {
    const Eigen::Vector3d from_b = p - k.b, from_c = p - k.c;
    const double determinant = from_b.dot(k.normal);
    const double stretch =
        k.base + (k.cot_c * from_b.squaredNorm() + k.cot_b * from_c.squaredNorm()) / 2.0;
    const double ratio = k.area / (determinant * determinant);
    const Eigen::Vector3d slope = k.cot_c * from_b + k.cot_b * from_c;
    const double first = -2.0 * ratio / determinant;
    gradient += slope * (1.0 + ratio) + k.normal * (stretch * first);
    const Eigen::Matrix3d mixed = slope * k.normal.transpose();
    hessian += (mixed + mixed.transpose()) * first;
    hessian +=
        k.normal * k.normal.transpose() * (6.0 * stretch * ratio / (determinant * determinant));
    hessian.diagonal().array() += (k.cot_b + k.cot_c) * (1.0 + ratio);
  }
}

double SphereDescent::descend(VertexIndex v, const Pull* pull) {
  gather(v);
  const Eigen::Vector3d start = points_[v];
  const double before = energy_at(start, pull);
  if (!std::isfinite(before)) return 0.0;
  Eigen::Vector3d gradient;
  Eigen::Matrix3d hessian;
  differentiate(start, gradient, hessian);
  if (pull != nullptr) {
    gradient += 2.0 * pull->weight * (start - pull->goal);
    hessian.diagonal().array() += 2.0 * pull->weight;
  }
  const Eigen::Matrix<double, 3, 2> basis = tangent_basis(start);
  const Eigen::Vector2d slope = basis.transpose() * gradient;
  Eigen::Matrix2d curvature = basis.transpose() * hessian * basis;
  curvature.diagonal().array() -= start.dot(gradient);  // the sphere bends away
  const Eigen::Vector2d direction = newton_direction(slope, curvature);
  const double promised = -slope.dot(direction);
  if (!(promised > 1e-9 * before)) return 0.0;
  double step = std::min(1.0, 0.5 / direction.norm());
  for (int attempt = 0; attempt < 12; ++attempt, step *= 0.5) {
    const Eigen::Vector3d p = (start + basis * (direction * step)).normalized();
    double after = energy_at(p, pull);
    if (after <= before - 1e-4 * step * promised) {
      points_[v] = p;
      // Far from the optimum the energy is like 1 / area²: Newton's steps are too short there.
      while (attempt == 0 && step < 16.0 && after < 0.7 * before) {
        step *= 2.0;
        const Eigen::Vector3d further = (start + basis * (direction * step)).normalized();
        const double value = energy_at(further, pull);
        if (!(value < after)) break;
        after = value;
        points_[v] = further;
      }
      return before - after;
    }
  }
  return 0.0;
}

SphereDescent::Energy SphereDescent::energy_around(VertexIndex v) {
  gather(v);
  double area = 0.0;
  for (const Corner& k : corners_) area += std::sqrt(k.area) / 2.0;
  return {energy_at(points_[v]), area};
}

}  // namespace kinemesh::spherical
