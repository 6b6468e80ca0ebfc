#include "analysis/spherical/closed_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "analysis/spherical/spherical_map.h"
#include "analysis/surface_balls.h"

namespace kinemesh {

namespace {

/// A ring of vertices and where each lies along the hole's rim, in [0, 1), ascending.
struct Ring {
  std::vector<VertexIndex> vertices;
  std::vector<double> places;
};

class Filler {
 public:
  Filler(std::vector<Triangle>& faces, std::vector<Eigen::Vector3d>& positions,
         const std::vector<VertexIndex>& loop, const std::vector<Eigen::Vector3d>& normals)
      : faces_(faces), positions_(positions) {
    outer_.vertices.assign(loop.rbegin(), loop.rend());  // the filling lies on the other side
    double length = 0.0;
    for (std::size_t k = 0; k < loop.size(); ++k) {
      outer_.places.push_back(length);
      length += (at(outer_, k + 1) - at(outer_, k)).norm();
      centre_ += at(outer_, k) / static_cast<double>(loop.size());
    }
    for (std::size_t k = 0; k < loop.size(); ++k) {
      outer_.places[k] = length > 0.0 ? outer_.places[k] / length
                                      : static_cast<double>(k) / static_cast<double>(loop.size());
    }
    // A hole that is closed to a slit, such as a mouth, would get a filling without area: it
    // becomes a pouch behind the surface instead.
    Eigen::Vector3d area = Eigen::Vector3d::Zero(), outward = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < loop.size(); ++k) {
      area += (at(outer_, k) - centre_).cross(at(outer_, k + 1) - centre_) / 2.0;
      outward += normals[outer_.vertices[k]];
    }
    if (!(length > 0.0) || !(outward.norm() > 0.0)) return;
    const double roundness = 4.0 * std::numbers::pi * area.norm() / (length * length);
    pouch_ = -outward.normalized() * (0.15 * length * std::max(0.0, 1.0 - roundness));
  }

  void fill() {
    constexpr double growth = 1.25;  // of the edges, from ring to ring
    const double turn = 2.0 * std::numbers::pi;
    double edge = turn / static_cast<double>(outer_.vertices.size()), radius = 1.0;
    Ring ring = outer_;
    while (true) {
      radius -= 0.87 * edge;
      edge *= growth;
      const auto count = static_cast<std::size_t>(std::max(0.0, std::round(turn * radius / edge)));
      if (count < 5 || count >= ring.vertices.size()) break;
      Ring inner = make_ring(radius, count);
      zip(ring, inner);
      ring = std::move(inner);
    }
    const auto middle = static_cast<VertexIndex>(positions_.size());
    positions_.push_back(at_radius(0.0, centre_));
    for (std::size_t k = 0; k < ring.vertices.size(); ++k) {
      faces_.push_back({ring.vertices[k], ring.vertices[(k + 1) % ring.vertices.size()], middle});
    }
  }

 private:
  const Eigen::Vector3d& at(const Ring& ring, std::size_t k) const {
    return positions_[ring.vertices[k % ring.vertices.size()]];
  }

  Eigen::Vector3d on_rim(double place) const {
    const auto next = std::ranges::upper_bound(outer_.places, place);
    const auto k = static_cast<std::size_t>(next - outer_.places.begin()) - 1;
    const double begin = outer_.places[k],
                 end = k + 1 < outer_.places.size() ? outer_.places[k + 1] : 1.0;
    const double t = end > begin ? (place - begin) / (end - begin) : 0.0;
    return (1.0 - t) * at(outer_, k) + t * at(outer_, k + 1);
  }

  Eigen::Vector3d at_radius(double radius, const Eigen::Vector3d& rim) const {
    return centre_ + radius * (rim - centre_) + (1.0 - radius * radius) * pouch_;
  }

  Ring make_ring(double radius, std::size_t count) {
    Ring ring;
    for (std::size_t k = 0; k < count; ++k) {
      const double place = (static_cast<double>(k) + 0.5) / static_cast<double>(count);
      ring.places.push_back(place);
      ring.vertices.push_back(static_cast<VertexIndex>(positions_.size()));
      positions_.push_back(at_radius(radius, on_rim(place)));
    }
    return ring;
  }

  /// Triangles between two rings, each edge with the vertex across that is reached first.
  void zip(const Ring& outer, const Ring& inner) {
    const std::size_t n = outer.vertices.size(), m = inner.vertices.size();
    const auto outer_place = [&](std::size_t i) {
      return i < n ? outer.places[i] : outer.places[i - n] + 1.0;
    };
    const auto inner_place = [&](std::size_t j) {
      return j < m ? inner.places[j] : inner.places[j - m] + 1.0;
    };
    for (std::size_t i = 0, j = 0; i < n || j < m;) {
      const VertexIndex a = outer.vertices[i % n], b = inner.vertices[j % m];
      if (j == m || (i < n && outer_place(i + 1) <= inner_place(j + 1))) {
        faces_.push_back({a, outer.vertices[(i + 1) % n], b});
        ++i;
      } else {
        faces_.push_back({a, inner.vertices[(j + 1) % m], b});
        ++j;
      }
    }
  }

  std::vector<Triangle>& faces_;
  std::vector<Eigen::Vector3d>& positions_;
  Ring outer_;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero(), pouch_ = centre_;
};

}  // namespace

ClosedSurface close_holes(const Topology& topology, std::span<const Eigen::Vector3d> positions) {
  ClosedSurface closed{.positions = {positions.begin(), positions.end()},
                       .surface_vertices = topology.vertex_count(),
                       .surface_faces = topology.face_count()};
  std::vector<Triangle> faces = topology.faces();
  if (topology.is_manifold()) closed.loops = topology.boundary_loops();
  const std::vector<Eigen::Vector3d> normals = vertex_normals(topology, positions);
  for (const std::vector<VertexIndex>& loop : closed.loops) {
    Filler(faces, closed.positions, loop, normals).fill();
  }
  closed.topology = Topology::create(closed.positions.size(), std::move(faces));
  require_closed_genus_zero(*closed.topology);
  return closed;
}

}  // namespace kinemesh
