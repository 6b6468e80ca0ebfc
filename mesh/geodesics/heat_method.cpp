#include "mesh/geodesics/heat_method.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "config/error.h"
#include "mesh/geodesics/intrinsic_delaunay.h"
#include "mesh/geodesics/intrinsic_lengths.h"

namespace kinemesh {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Triplets = std::vector<Eigen::Triplet<double>>;

/// Per vertex, one that stands for all that faces connect with it (union-find).
std::vector<VertexIndex> components_of(std::size_t count, const std::vector<Triangle>& faces) {
  std::vector<VertexIndex> parent(count);
  std::iota(parent.begin(), parent.end(), 0U);
  const auto find = [&](VertexIndex v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const Triangle& f : faces) {
    parent[find(f[1])] = find(f[0]);
    parent[find(f[2])] = find(f[0]);
  }
  for (VertexIndex v = 0; v < count; ++v) parent[v] = find(v);
  return parent;
}

}  // namespace

struct HeatMethod::System {
  System(const Topology& topology, std::span<const Eigen::Vector3d> positions, double time);

  /// Minus the integrated divergence of the unit field against the gradient of the heat.
  Eigen::VectorXd divergence(const Eigen::VectorXd& heat) const;

  std::vector<Triangle> original_faces;
  IntrinsicTriangulation mesh;
  /// Per face, the corners laid out in the plane: corner 0 at the origin, corner 1 at (x1, 0).
  struct Layout {
    double x1, x2, y2;
    std::array<double, 3> cotangents;  // at the corners
  };
  std::vector<Layout> layouts;
  std::vector<VertexIndex> component;  ///< per vertex, the one that stands for its component
  Eigen::SimplicialLDLT<Sparse> diffusion, poisson;
};

HeatMethod::System::System(const Topology& topology, std::span<const Eigen::Vector3d> positions,
                           double time)
    : original_faces(topology.faces()),
      mesh(intrinsic_delaunay(topology, positions)),
      component(components_of(topology.vertex_count(), topology.faces())) {
  const auto count = static_cast<Eigen::Index>(topology.vertex_count());
  Triplets stiffness, mass;
  double length_sum = 0.0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const auto& [l0, l1, l2] = mesh.lengths[f];
    length_sum += l0 + l1 + l2;
    const double area2 = double_area(l0, l1, l2);
    Layout layout{l0, 0.5 * (l0 + (l2 - l1) * (l2 + l1) / l0), area2 / l0, {}};
    for (int c = 0; c < 3; ++c) {
      const double opposite = mesh.lengths[f][(c + 1) % 3];
      const double one = mesh.lengths[f][c], other = mesh.lengths[f][(c + 2) % 3];
      layout.cotangents[c] = (one * one + other * other - opposite * opposite) / (2.0 * area2);
      const auto i = static_cast<int>(mesh.faces[f][(c + 1) % 3]);
      const auto j = static_cast<int>(mesh.faces[f][(c + 2) % 3]);
      const double weight = 0.5 * layout.cotangents[c];
      stiffness.insert(stiffness.end(),
                       {{i, i, weight}, {j, j, weight}, {i, j, -weight}, {j, i, -weight}});
      mass.emplace_back(mesh.faces[f][c], mesh.faces[f][c], area2 / 6.0);
    }
    layouts.push_back(layout);
  }
  const double mean =
      mesh.faces.empty() ? 1.0 : length_sum / (3.0 * static_cast<double>(mesh.faces.size()));
  // One vertex of each component, and every vertex without faces, is held, so that both systems
  // have one solution; distances are shifted to 0 at the sources afterwards.
  for (VertexIndex v = 0; v < topology.vertex_count(); ++v) {
    if (topology.faces_of(v).empty()) mass.emplace_back(v, v, mean * mean);
  }
  Sparse l(count, count), m(count, count);
  l.setFromTriplets(stiffness.begin(), stiffness.end());
  m.setFromTriplets(mass.begin(), mass.end());
  diffusion.compute(Sparse(m + time * mean * mean * l));
  Triplets held;
  for (VertexIndex v = 0; v < topology.vertex_count(); ++v) {
    if (component[v] == v) held.emplace_back(v, v, 1.0);
  }
  Sparse hold(count, count);
  hold.setFromTriplets(held.begin(), held.end());
  poisson.compute(Sparse(l + hold));
  if (diffusion.info() != Eigen::Success || poisson.info() != Eigen::Success) {
    throw NoResultError({.what = "the heat method could not factorise this mesh",
                         .remedy = "Use the exact method"});
  }
}

Eigen::VectorXd HeatMethod::System::divergence(const Eigen::VectorXd& heat) const {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(heat.size());
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const Triangle& face = mesh.faces[f];
    const Layout& at = layouts[f];
    // Differences to corner 0 scaled by their largest keep heat as small as 1e-300 usable.
    double h1 = heat[face[1]] - heat[face[0]], h2 = heat[face[2]] - heat[face[0]];
    const double scale = std::max(std::abs(h1), std::abs(h2));
    if (!(scale > 0.0)) continue;
    h1 /= scale;
    h2 /= scale;
    Eigen::Vector2d field(h1 / at.x1, (h2 - h1 * at.x2 / at.x1) / at.y2);
    field = -field.normalized();
    const std::array<Eigen::Vector2d, 3> edges{Eigen::Vector2d(at.x1, 0.0),
                                               Eigen::Vector2d(at.x2 - at.x1, at.y2),
                                               Eigen::Vector2d(-at.x2, -at.y2)};
    for (int c = 0; c < 3; ++c) {
      const double along_next = edges[c].dot(field),
                   along_previous = -edges[(c + 2) % 3].dot(field);
      result[face[c]] -= 0.5 * (at.cotangents[(c + 2) % 3] * along_next +
                                at.cotangents[(c + 1) % 3] * along_previous);
    }
  }
  return result;
}

HeatMethod::HeatMethod(const Topology& topology, std::span<const Eigen::Vector3d> positions,
                       double time)
    : system_(std::make_unique<const System>(topology, positions, time)) {}
HeatMethod::HeatMethod(HeatMethod&&) noexcept = default;
HeatMethod::~HeatMethod() = default;

std::vector<double> HeatMethod::distances(std::span<const SurfacePoint> sources) const {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const System& s = *system_;
  const Eigen::Index count = s.diffusion.rows();
  Eigen::VectorXd start = Eigen::VectorXd::Zero(count);
  for (const SurfacePoint& source : sources) {
    const Triangle& face = s.original_faces.at(source.face);
    for (int c = 0; c < 3; ++c) start[face[c]] += source.weights[c];
  }
  const Eigen::VectorXd heat = s.diffusion.solve(start);
  const Eigen::VectorXd potential = s.poisson.solve(s.divergence(heat));
  // In each component the weighted mean over its source corners becomes their distance, 0 for a
  // source at a vertex; the least value bounds it from below.
  std::vector<double> least(count, infinity);
  for (const SurfacePoint& source : sources) {
    const Triangle& face = s.original_faces[source.face];
    double value = 0.0;
    for (int c = 0; c < 3; ++c) value += source.weights[c] * potential[face[c]];
    double& shift = least[s.component[face[0]]];
    shift = std::min(shift, value);
  }
  std::vector<double> result(count);
  for (Eigen::Index v = 0; v < count; ++v) {
    const double shift = least[s.component[v]];
    result[v] = shift == infinity ? infinity : std::max(0.0, potential[v] - shift);
  }
  return result;
}

}  // namespace kinemesh
