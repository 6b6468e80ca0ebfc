#include "analysis/spherical/spherical_map.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "analysis/spherical/ring_mesh.h"
#include "analysis/spherical/ring_room.h"
#include "analysis/spherical/sphere_descent.h"
#include "config/error.h"
#include "config/text.h"

namespace kinemesh {

namespace {

using spherical::KernelPoint;
using spherical::RingMesh;
using spherical::SphereDescent;

constexpr double crowded = 12.0;  // distortion at which a vertex' surroundings give way
constexpr int relief_rounds = 16;

[[noreturn]] void refuse(const std::string& what, const std::string& remedy) {
  throw NoResultError({.what = what, .remedy = remedy});
}

double area_of(const Topology& topology, std::span<const Eigen::Vector3d> positions) {
  double area = 0.0;
  for (const Triangle& t : topology.faces()) {
    const Eigen::Vector3d& a = positions[t[0]];
    area += (positions[t[1]] - a).cross(positions[t[2]] - a).norm() / 2.0;
  }
  return area;
}

/// Puts the vertices on the sphere, level by level.
class Builder {
 public:
  Builder(const Topology& topology, std::span<const Eigen::Vector3d> positions,
          const SphericalOptions& options, const RunContext& ctx)
      : options_(options),
        ctx_(ctx),
        mesh_(topology),
        points_(topology.vertex_count(), Eigen::Vector3d::Zero()),
        descent_(mesh_, positions, points_, options.sphere_slenderness,
                 1e-4 * std::sqrt(area_of(topology, positions) /
                                  static_cast<double>(topology.face_count()))),
        room_(mesh_, points_) {
    spherical::simplify(mesh_, positions, 4, {}, ctx);
    if (mesh_.alive_count() != 4) throw InternalError("map_to_sphere: no tetrahedron was reached");
  }

  SphericalMap run() {
    place_tetrahedron();
    while (mesh_.removed_count() > 0) {
      const auto level = static_cast<std::size_t>(
          std::ceil(options_.sphere_growth * static_cast<double>(mesh_.alive_count())));
      while (mesh_.removed_count() > 0 && mesh_.alive_count() < level) insert();
      descent_.set_scale(descent_.fitting_scale());
      settle();
      const double share = static_cast<double>(mesh_.alive_count()) /
                           static_cast<double>(mesh_.alive_count() + mesh_.removed_count());
      ctx_.progress(0.1 + 0.6 * share);
    }
    finish();
    return std::move(result_);
  }

  std::vector<Eigen::Vector3d>& points() { return points_; }

 private:
  void place_tetrahedron() {
    const VertexIndex top = mesh_.alive()[0];
    const std::vector<VertexIndex>& ring = mesh_.ring(top);
    points_[top] = Eigen::Vector3d::UnitZ();
    for (std::size_t i = 0; i < 3; ++i) {
      const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / 3.0;
      points_[ring[i]] = {std::sqrt(8.0) / 3.0 * std::cos(angle),
                          std::sqrt(8.0) / 3.0 * std::sin(angle), -1.0 / 3.0};
    }
    descent_.set_scale(descent_.fitting_scale());
  }

  void insert() {
    if (++inserted_ % 256 == 0) ctx_.check_cancelled();
    const VertexIndex v = mesh_.next();
    const std::vector<VertexIndex> ring(mesh_.next_ring().begin(), mesh_.next_ring().end());
    const KernelPoint centre = room_.centre_of(ring);
    if (!room_.moved().empty()) ++result_.withdrawals;
    points_[v] = centre.point;
    if (!(centre.distance > 0.0) || !spherical::star_is_valid(v, ring, points_)) {
      refuse("no map to the sphere without folds is found: vertex " + std::to_string(v) +
                 " has no room among its neighbours",
             "Remesh the surface so that its triangles are less thin");
    }
    mesh_.restore();
    descent_.descend(v);
    for (const VertexIndex r : mesh_.ring(v)) {
      if (mesh_.ring(r).size() <= spherical::hub) descent_.descend(r);
    }
    relieve({v});
  }

  bool strained(VertexIndex v) {
    const SphereDescent::Energy here = descent_.energy_around(v);
    return here.energy > 4.0 * crowding_ * here.area;
  }

  /// Where much surface came back into little room, its surroundings give way, ever wider.
  void relieve(std::vector<VertexIndex> crowd) {
    for (int round = 0; round < relief_rounds; ++round) {
      std::erase_if(crowd, [&](VertexIndex v) { return !strained(v); });
      if (crowd.empty()) return;
      double energy = 0.0, fallen = 0.0;
      for (const VertexIndex v : crowd) energy += descent_.energy_around(v).energy;
      for (const VertexIndex v : room_.surroundings(crowd, 2 + round / 4))
        fallen += descent_.descend(v);
      if (fallen < 0.1 * energy) return;  // as good as it gets without the rest of the surface
    }
  }

  /// Coarse levels cost little and decide much: they are swept until they rest.
  void settle() {
    const int most = options_.sphere_sweeps + static_cast<int>(20000 / mesh_.alive_count());
    for (int k = 0; k < most; ++k) {
      if (sweep() < 1e-3 * total().energy / 3.0) break;
    }
    const SphereDescent::Energy all = total();
    crowding_ = std::max(crowded, 3.0 * all.energy / all.area / 4.0);
  }

  /// Each triangle counts three times.
  SphereDescent::Energy total() {
    SphereDescent::Energy sum{0.0, 0.0};
    for (const VertexIndex v : mesh_.alive()) {
      const SphereDescent::Energy here = descent_.energy_around(v);
      sum.energy += here.energy;
      sum.area += here.area;
    }
    return sum;
  }

  double sweep() {
    double fallen = 0.0;
    std::size_t done = 0;
    for (const VertexIndex v : mesh_.alive()) {
      if (++done % 1024 == 0) ctx_.check_cancelled();
      fallen += descent_.descend(v);
    }
    return fallen;
  }

  void finish() {
    // The finest triangles are hardly smaller than their pieces of the sphere.
    descent_.set_scale(descent_.fitting_scale());
    for (int k = 0; k < options_.sphere_final_sweeps; ++k) {
      const double fallen = sweep();
      ++result_.sweeps;
      ctx_.progress(0.7 + 0.3 * (k + 1) / options_.sphere_final_sweeps);
      if (fallen < 4e-4 * std::numbers::pi) break;
    }
    const SphereDescent::Energy all = total();
    result_.distortion = all.energy / all.area / 4.0;
    result_.points = std::move(points_);
  }

  const SphericalOptions& options_;
  const RunContext& ctx_;
  RingMesh mesh_;
  std::vector<Eigen::Vector3d> points_;
  SphereDescent descent_;
  SphericalMap result_;
  std::size_t inserted_ = 0;
  double crowding_ = crowded;
  spherical::RingRoom room_;
};

void require_finite(const Topology& topology, std::span<const Eigen::Vector3d> positions) {
  if (positions.size() != topology.vertex_count()) {
    throw InternalError("map_to_sphere: one position per vertex is needed");
  }
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (positions[v].allFinite()) continue;
    throw InputError({.what = "the position of vertex " + std::to_string(v) + " is not finite"});
  }
  const double area = area_of(topology, positions);
  if (!(area > 0.0) || !std::isfinite(area)) {
    refuse("the surface has no area", "Give a mesh whose vertices are not all on one line");
  }
}

}  // namespace

void SphericalOptions::declare(ParameterSet& p) {
  p.group("sphere", "Map to the sphere");
  p.number("sphere-growth", sphere_growth,
           {.min = 1.05, .max = 4.0, .help = "Vertices of a level over those of the level before"});
  p.number("sphere-sweeps", sphere_sweeps,
           {.min = 0, .max = 100, .help = "How often each vertex is moved at each level"});
  p.number("sphere-final-sweeps", sphere_final_sweeps,
           {.min = 0, .max = 1000, .help = "How often at most at the finest level"});
  p.number("sphere-slenderness", sphere_slenderness,
           {.min = 1e-4,
            .max = 0.5,
            .help = "Triangles that are thinner (height over longest edge) count as this thick"});
}

void require_closed_genus_zero(const Topology& topology) {
  if (topology.face_count() == 0) refuse("the mesh has no faces", "Give a mesh with faces");
  if (topology.isolated_vertex_count() > 0) {
    refuse(count_of(topology.isolated_vertex_count(), "vertex belongs", "vertices belong") +
               " to no face",
           "Remove vertices without faces");
  }
  if (topology.component_count() != 1) {
    refuse("the mesh has " + std::to_string(topology.component_count()) + " separate pieces",
           "Keep the largest piece, or join them");
  }
  if (!topology.is_manifold()) {
    refuse(
        "the mesh is not manifold: an edge has more than two faces, two faces of opposite "
        "orientation, or several fans meet in a vertex",
        "Mend the mesh first");
  }
  if (!topology.boundary_loops().empty()) {
    refuse("the surface has " + count_of(topology.boundary_loops().size(), "hole", "holes"),
           "Close them first");
  }
  const int64_t genus = (2 - topology.euler_characteristic()) / 2;
  if (genus != 0) {
    refuse("the surface has " +
               count_of(static_cast<std::size_t>(genus), "handle (genus ", "handles (genus ") +
               std::to_string(genus) + "): it cannot be mapped one-to-one to a sphere",
           "Cut the handles and close the cuts");
  }
}

SphericalMap map_to_sphere(const Topology& topology, std::span<const Eigen::Vector3d> positions,
                           const SphericalOptions& options, const RunContext& ctx) {
  options.validate();
  require_closed_genus_zero(topology);
  require_finite(topology, positions);
  Builder builder(topology, positions, options, ctx);
  SphericalMap map = builder.run();
  map.check = check_sphere(topology, map.points);
  if (!map.check.valid()) {
    refuse("no map to the sphere without folds is found: " +
               count_of(map.check.folded, "triangle", "triangles") + " of " +
               std::to_string(topology.face_count()) + " would be folded",
           "Remesh the surface so that its triangles are less thin");
  }
  return map;
}

}  // namespace kinemesh
