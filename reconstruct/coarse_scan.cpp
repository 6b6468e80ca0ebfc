#include "reconstruct/coarse_scan.h"

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Edge_collapse_visitor_base.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Edge_length_cost.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>

#include "config/error.h"
#include "config/parallel.h"
#include "mesh/closest_point.h"

namespace kinemesh {
namespace {

namespace simplification = CGAL::Surface_mesh_simplification;

using CollapsePoint = CGAL::Simple_cartesian<double>::Point_3;
using CollapseMesh = CGAL::Surface_mesh<CollapsePoint>;
using CollapseVertex = CollapseMesh::Vertex_index;

CollapseVertex vertex_at(std::size_t i) {
  return CollapseVertex(static_cast<CollapseMesh::size_type>(i));
}

/// The middle of an edge; a vertex on a boundary stays there, and no edge across from boundary to
/// boundary goes.
struct KeepBoundaries {
  using TM = CollapseMesh;

  template <class Profile>
  boost::optional<CollapsePoint> operator()(const Profile& profile) const {
    const CollapseMesh& mesh = profile.surface_mesh();
    const bool first = mesh.is_border(profile.v0(), true);
    const bool second = mesh.is_border(profile.v1(), true);
    const bool along = mesh.is_border(mesh.edge(profile.v0_v1()));
    if (first && second && !along) return boost::none;
    if (first && !second) return profile.p0();
    if (second && !first) return profile.p1();
    return CGAL::midpoint(profile.p0(), profile.p1());
  }
};

struct StopAt {
  std::size_t edges;
  double squared_length;

  template <class Profile>
  bool operator()(double cost, const Profile& /*profile*/, std::size_t /*before*/,
                  std::size_t now) const {
    return now <= edges || cost > squared_length;
  }
};

/// Keeps what each vertex was collapsed into.
struct Follow : simplification::Edge_collapse_visitor_base<CollapseMesh> {
  std::vector<VertexIndex>* into = nullptr;

  void OnCollapsed(const Profile& profile, const vertex_descriptor& kept) {
    for (const CollapseVertex v : {profile.v0(), profile.v1()}) {
      if (v != kept) (*into)[v] = static_cast<VertexIndex>(kept);
    }
  }
};

VertexIndex root_of(std::vector<VertexIndex>& into, VertexIndex v) {
  while (into[v] != v) {
    into[v] = into[into[v]];
    v = into[v];
  }
  return v;
}

/// The closest point to `p` among the faces around `near` and its neighbours.
SurfacePoint closest_around(const CoarseScan& coarse, VertexIndex near, const Eigen::Vector3d& p) {
  SurfacePoint best;
  double least = std::numeric_limits<double>::infinity();
  const auto look_around = [&](VertexIndex v) {
    for (const FaceIndex f : coarse.topology->faces_of(v)) {
      const Triangle& t = coarse.topology->faces()[f];
      const Eigen::Vector3d w = closest_weights(p, coarse.positions[t[0]], coarse.positions[t[1]],
                                                coarse.positions[t[2]]);
      const SurfacePoint point{f, {w[0], w[1], w[2]}};
      const double off = (position_of(point, *coarse.topology, coarse.positions) - p).squaredNorm();
      if (off >= least) continue;
      least = off;
      best = point;
    }
  };
  look_around(near);
  for (const VertexIndex n : coarse.topology->neighbours_of(near)) look_around(n);
  return best;
}

CollapseMesh collapse_mesh(const Topology& topology, std::span<const Eigen::Vector3d> positions) {
  CollapseMesh mesh;
  for (std::size_t v = 0; v < positions.size(); ++v) {
    const Eigen::Vector3d& p = positions[v];
    if (!p.allFinite()) {
      throw InputError({.what = "vertex " + std::to_string(v) + " of the scan is not finite",
                        .remedy = "Repair the scan"});
    }
    mesh.add_vertex({p.x(), p.y(), p.z()});
  }
  for (const Triangle& t : topology.faces()) {
    mesh.add_face(vertex_at(t[0]), vertex_at(t[1]), vertex_at(t[2]));
  }
  return mesh;
}

/// Coarse vertices and faces; returns the coarse index of each vertex that is left.
std::vector<VertexIndex> take_over(const CollapseMesh& mesh, CoarseScan& coarse) {
  std::vector<VertexIndex> index(mesh.num_vertices(), invalid_index);
  for (const CollapseVertex v : mesh.vertices()) {
    if (mesh.is_isolated(v)) continue;
    index[v] = static_cast<VertexIndex>(coarse.positions.size());
    const CollapsePoint& p = mesh.point(v);
    coarse.positions.emplace_back(p.x(), p.y(), p.z());
  }
  std::vector<Triangle> faces;
  for (const auto f : mesh.faces()) {
    Triangle t{};
    std::size_t c = 0;
    for (const CollapseVertex v : mesh.vertices_around_face(mesh.halfedge(f))) t.at(c++) = index[v];
    faces.push_back(t);
  }
  coarse.topology = Topology::create(coarse.positions.size(), std::move(faces));
  return index;
}

}  // namespace

Eigen::SparseMatrix<double> CoarseScan::carry() const {
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t v = 0; v < places.size(); ++v) {
    if (!places[v].valid()) continue;
    const Triangle& t = topology->faces()[places[v].face];
    for (std::size_t c = 0; c < 3; ++c) {
      entries.emplace_back(static_cast<int>(v), static_cast<int>(t.at(c)), places[v].weights.at(c));
    }
  }
  Eigen::SparseMatrix<double> result(static_cast<Eigen::Index>(places.size()),
                                     static_cast<Eigen::Index>(positions.size()));
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

CoarseScan coarsen_scan(const Topology& topology, std::span<const Eigen::Vector3d> positions,
                        std::size_t faces, double longest_edge_mm, const RunContext& ctx) {
  CollapseMesh mesh = collapse_mesh(topology, positions);
  std::vector<VertexIndex> into(positions.size());
  std::iota(into.begin(), into.end(), VertexIndex{0});
  Follow follow;
  follow.into = &into;
  ctx.check_cancelled();
  simplification::edge_collapse(
      mesh, StopAt{faces * 3 / 2, longest_edge_mm * longest_edge_mm},
      CGAL::parameters::get_cost(simplification::Edge_length_cost<CollapseMesh>())
          .get_placement(KeepBoundaries())
          .visitor(follow));
  ctx.check_cancelled();
  CoarseScan coarse;
  const std::vector<VertexIndex> index = take_over(mesh, coarse);
  for (VertexIndex v = 0; v < into.size(); ++v) into[v] = root_of(into, v);
  const ClosestPointSearch anywhere(coarse.positions, coarse.topology->faces());
  coarse.places.resize(positions.size());
  parallel_for(ctx, positions.size(), 4096, [&](std::size_t v) {
    if (topology.faces_of(static_cast<VertexIndex>(v)).empty()) return;
    const VertexIndex near = index[into[v]];
    coarse.places[v] = near == invalid_index ? anywhere.closest(positions[v]).point
                                             : closest_around(coarse, near, positions[v]);
  });
  return coarse;
}

}  // namespace kinemesh
