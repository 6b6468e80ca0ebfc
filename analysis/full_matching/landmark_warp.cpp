#include "analysis/full_matching/landmark_warp.h"

#include <Eigen/Geometry>
#include <numeric>

#include "analysis/spherical/orientation.h"
#include "analysis/spherical/sphere_descent.h"
#include "analysis/spherical/unfold.h"

namespace kinemesh::full_matching {

namespace {

constexpr double kept_area = 0.3;  // of a triangle's area that the last step must leave
constexpr double first_pull = 0.1, last_pull = 1e7, growth = 1.25;  // of the springs
constexpr double near_goal = 1e-3;  // of a goal: there an anchor may be put onto it
constexpr int sweeps = 3;           // with springs of one strength

/// Whether every triangle around v keeps a part of its area when v moves to p.
bool leaves_room(const spherical::RingMesh& mesh, const std::vector<Eigen::Vector3d>& points,
                 VertexIndex v, const Eigen::Vector3d& p) {
  const std::vector<VertexIndex>& ring = mesh.ring(v);
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector3d &b = points[ring[i]], &c = points[ring[(i + 1) % ring.size()]];
    const Eigen::Vector3d normal = b.cross(c - b);
    const double before = (points[v] - b).dot(normal), after = (p - b).dot(normal);
    if (!(after > kept_area * before) || orientation(p, b, c) <= 0) return false;
  }
  return true;
}

/// Puts an anchor on its goal when that is near and leaves room.
bool arrive(const spherical::RingMesh& mesh, std::vector<Eigen::Vector3d>& points,
            const Anchor& anchor) {
  if ((points[anchor.vertex] - anchor.goal).norm() > near_goal ||
      !leaves_room(mesh, points, anchor.vertex, anchor.goal))
    return false;
  points[anchor.vertex] = anchor.goal;
  return true;
}

/// Turns the whole sphere so that the anchors lie near their goals.
void turn_towards(const spherical::RingMesh& mesh, std::vector<Eigen::Vector3d>& points,
                  std::span<const Anchor> anchors) {
  for (const Anchor& a : anchors) {
    if (points[a.vertex] == a.goal) return;  // what has arrived stays
  }
  if (anchors.size() < 3) return;
  std::vector<Eigen::Vector3d> from, to;
  for (const Anchor& a : anchors) {
    from.push_back(points[a.vertex]);
    to.push_back(a.goal);
  }
  const Eigen::Matrix3d turn = spherical::nearest_rotation(from, to);
  for (const VertexIndex v : mesh.alive()) points[v] = (turn * points[v]).normalized();
}

}  // namespace

std::vector<std::size_t> warp_to_anchors(const spherical::RingMesh& mesh,
                                         std::span<const Eigen::Vector3d> rest,
                                         std::vector<Eigen::Vector3d>& points,
                                         std::span<const Anchor> anchors, const RunContext& ctx) {
  turn_towards(mesh, points, anchors);
  spherical::SphereDescent descent(mesh, rest, points, spherical::map_slenderness, 1e-3);
  descent.set_scale(descent.fitting_scale());
  std::vector<uint32_t> anchor_of(points.size(), invalid_index);
  for (std::size_t k = 0; k < anchors.size(); ++k)
    anchor_of[anchors[k].vertex] = static_cast<uint32_t>(k);
  std::vector<std::size_t> away(anchors.size());
  std::iota(away.begin(), away.end(), std::size_t{0});
  for (double pull = first_pull; pull < last_pull && !away.empty(); pull *= growth) {
    ctx.check_cancelled();
    for (int sweep = 0; sweep < sweeps; ++sweep) {
      for (const VertexIndex v : mesh.alive()) {
        if (anchor_of[v] == invalid_index) {
          descent.descend(v);
        } else if (points[v] != anchors[anchor_of[v]].goal) {
          const spherical::SphereDescent::Pull spring{anchors[anchor_of[v]].goal, pull};
          descent.descend(v, &spring);
        }
      }
    }
    std::erase_if(away, [&](std::size_t k) { return arrive(mesh, points, anchors[k]); });
  }
  return away;
}

}  // namespace kinemesh::full_matching
