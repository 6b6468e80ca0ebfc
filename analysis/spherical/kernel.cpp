#include "analysis/spherical/kernel.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <limits>

namespace kinemesh::spherical {

namespace {

/// A half space through the origin, kept with a point of its great circle so that distances of
/// what is near come out with a small relative error.
struct Side {
  Eigen::Vector3d normal, anchor;
  double of(const Eigen::Vector3d& p) const { return (p - anchor).dot(normal); }
};
using Basis = std::array<std::size_t, 3>;

class LargestCircle {
 public:
  explicit LargestCircle(std::vector<Side> sides) : sides_(std::move(sides)) {}

  /// Exchanges one of three sides for the most violated one until none is (a dual simplex).
  KernelPoint solve() {
    Basis basis{0, sides_.size() / 3, 2 * sides_.size() / 3};
    Eigen::Vector3d point = best_of(std::array<std::size_t, 3>(basis));
    for (std::size_t step = 0; step < 4 * sides_.size(); ++step) {
      const std::size_t worst = worst_at(point);
      double least = std::numeric_limits<double>::infinity();
      for (const std::size_t k : basis) least = std::min(least, sides_[k].of(point));
      if (sides_[worst].of(point) >= least - 1e-15) break;
      point = exchange(basis, worst);
    }
    return {point, sides_[worst_at(point)].of(point)};
  }

 private:
  std::size_t worst_at(const Eigen::Vector3d& p) const {
    std::size_t worst = 0;
    for (std::size_t k = 1; k < sides_.size(); ++k) {
      if (sides_[k].of(p) < sides_[worst].of(p)) worst = k;
    }
    return worst;
  }

  double least_of(std::span<const std::size_t> set, const Eigen::Vector3d& p) const {
    double least = std::numeric_limits<double>::infinity();
    for (const std::size_t k : set) least = std::min(least, sides_[k].of(p));
    return least;
  }

  /// The farthest inside the sides of `set`: equally far from three, from two, or from one.
  Eigen::Vector3d best_of(std::span<const std::size_t> set) const {
    Eigen::Vector3d best = sides_[set[0]].normal;
    double most = least_of(set, best);
    const auto offer = [&](const Eigen::Vector3d& direction) {
      const double length = direction.norm();
      if (!(length > 0.0)) return;
      for (const double sign : {1.0, -1.0}) {
        const Eigen::Vector3d p = direction * (sign / length);
        const double value = least_of(set, p);
        if (value > most) {
          most = value;
          best = p;
        }
      }
    };
    for (std::size_t i = 0; i < set.size(); ++i) {
      offer(sides_[set[i]].normal);
      for (std::size_t j = i + 1; j < set.size(); ++j) {
        const Eigen::Vector3d &a = sides_[set[i]].normal, &b = sides_[set[j]].normal;
        offer(a + b);
        for (std::size_t k = j + 1; k < set.size(); ++k) {
          offer((a - b).cross(sides_[set[k]].normal - b));
        }
      }
    }
    return best;
  }

  Eigen::Vector3d exchange(Basis& basis, std::size_t entering) const {
    const std::array<std::size_t, 4> all{basis[0], basis[1], basis[2], entering};
    Eigen::Vector3d point = best_of(all);
    // The side it is farthest from does not bind; the entering one stays.
    std::size_t leaving = 0;
    for (std::size_t k = 1; k < 3; ++k) {
      if (sides_[basis[k]].of(point) > sides_[basis[leaving]].of(point)) leaving = k;
    }
    basis[leaving] = entering;
    return point;
  }

  std::vector<Side> sides_;
};

}  // namespace

KernelPoint kernel_centre(std::span<const VertexIndex> ring,
                          std::span<const Eigen::Vector3d> points) {
  std::vector<Side> sides;
  sides.reserve(ring.size());
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector3d &a = points[ring[i]], &b = points[ring[(i + 1) % ring.size()]];
    const Eigen::Vector3d normal = a.cross(b - a);
    const double length = normal.norm();
    if (length > 0.0) sides.push_back({normal / length, a});
  }
  if (sides.size() < 3) return {};
  KernelPoint centre = LargestCircle(std::move(sides)).solve();
  double radius = 0.0;
  for (const VertexIndex r : ring) radius += (points[r] - centre.point).norm();
  centre.roominess = centre.distance * static_cast<double>(ring.size()) / radius;
  return centre;
}

}  // namespace kinemesh::spherical
