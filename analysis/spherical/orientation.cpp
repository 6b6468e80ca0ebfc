#include "analysis/spherical/orientation.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace kinemesh {

namespace {

/// A sum of doubles that do not overlap, smallest first: exact (Shewchuk 1997, figure 6).
class Expansion {
 public:
  void add(double value) {
    double carry = value;
    std::size_t kept = 0;
    for (std::size_t k = 0; k < size_; ++k) {
      const double sum = carry + parts_[k], virtual_part = sum - carry;
      const double rest = (carry - (sum - virtual_part)) + (parts_[k] - virtual_part);
      if (rest != 0.0) parts_[kept++] = rest;
      carry = sum;
    }
    if (carry != 0.0) parts_[kept++] = carry;
    size_ = kept;
  }
  void add_product(double a, double b, double c) {
    const double high = b * c, low = std::fma(b, c, -high);
    for (const double part : {high, low}) {
      const double top = a * part;
      add(std::fma(a, part, -top));
      add(top);
    }
  }
  int sign() const { return size_ == 0 ? 0 : parts_[size_ - 1] > 0 ? 1 : -1; }

 private:
  std::array<double, 32> parts_{};  // 6 products of 4 parts each
  std::size_t size_ = 0;
};

int exact_orientation(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                      const Eigen::Vector3d& c) {
  Expansion sum;
  sum.add_product(a.x(), b.y(), c.z());
  sum.add_product(-a.x(), b.z(), c.y());
  sum.add_product(a.y(), b.z(), c.x());
  sum.add_product(-a.y(), b.x(), c.z());
  sum.add_product(a.z(), b.x(), c.y());
  sum.add_product(-a.z(), b.y(), c.x());
  return sum.sign();
}

}  // namespace

int orientation(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const double determinant = a.dot(b.cross(c));
  const Eigen::Vector3d x = a.cwiseAbs(), y = b.cwiseAbs(), z = c.cwiseAbs();
  const double permanent = x.x() * (y.y() * z.z() + y.z() * z.y()) +
                           x.y() * (y.z() * z.x() + y.x() * z.z()) +
                           x.z() * (y.x() * z.y() + y.y() * z.x());
  const double bound = 8.0 * std::numeric_limits<double>::epsilon() * permanent;
  if (determinant > bound) return 1;
  if (determinant < -bound) return -1;
  return exact_orientation(a, b, c);
}

double solid_angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const double determinant = (a - b).dot(b.cross(c - b));
  return 2.0 * std::atan2(determinant, 1.0 + a.dot(b) + b.dot(c) + c.dot(a));
}

bool SphereCheck::valid() const {
  return folded == 0 && std::abs(solid_angle - 4.0 * std::numbers::pi) < 1e-6;
}

SphereCheck check_sphere(const Topology& topology, std::span<const Eigen::Vector3d> points) {
  SphereCheck check;
  check.smallest_determinant = std::numeric_limits<double>::infinity();
  for (FaceIndex f = 0; f < topology.face_count(); ++f) {
    const auto& [i, j, k] = topology.faces()[f];
    const Eigen::Vector3d &a = points[i], &b = points[j], &c = points[k];
    const double determinant = (a - b).dot(b.cross(c - b));
    check.smallest_determinant = std::min(check.smallest_determinant, determinant);
    check.solid_angle += solid_angle(a, b, c);
    if (orientation(a, b, c) > 0) continue;
    if (check.folded++ == 0) check.first_folded = f;
  }
  return check;
}

}  // namespace kinemesh
