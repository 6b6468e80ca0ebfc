#include "mesh/mesh_info.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "config/parallel.h"

namespace kinemesh {
namespace {

constexpr double degrees = 180.0 / 3.14159265358979323846;

/// Cosine of the smallest angle of a triangle (the one opposite its shortest side); 1 when two
/// corners coincide.
double cosine_of_smallest(double aa, double bb, double cc) {
  if (aa > bb) std::swap(aa, bb);
  if (aa > cc) std::swap(aa, cc);
  if (!(aa > 0)) return 1.0;
  return std::clamp((bb + cc - aa) / (2.0 * std::sqrt(bb * cc)), -1.0, 1.0);
}

Eigen::Vector3d corner(const AnimatedMesh& mesh, std::size_t frame, VertexIndex v) {
  return mesh.position(frame, v).cast<double>();
}

std::vector<WorstTriangle> worst_triangles(const AnimatedMesh& mesh, std::size_t count,
                                           const RunContext& ctx) {
  const auto& faces = mesh.topology().faces();
  std::vector<double> largest(faces.size(), -2.0);  // cosine of the smallest angle, by face
  std::vector<std::size_t> frame_of(faces.size(), 0);
  parallel_chunks(ctx, faces.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = 0; f < mesh.frame_count(); ++f) {
      for (std::size_t t = begin; t < end; ++t) {
        const Eigen::Vector3d a = corner(mesh, f, faces[t][0]), b = corner(mesh, f, faces[t][1]),
                              c = corner(mesh, f, faces[t][2]);
        const double cosine =
            cosine_of_smallest((b - c).squaredNorm(), (c - a).squaredNorm(), (a - b).squaredNorm());
        if (cosine <= largest[t]) continue;
        largest[t] = cosine;
        frame_of[t] = f;
      }
    }
  });
  std::vector<std::size_t> order(faces.size());
  for (std::size_t t = 0; t < order.size(); ++t) order[t] = t;
  count = std::min(count, order.size());
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end(),
                    [&largest](std::size_t a, std::size_t b) {
                      return largest[a] != largest[b] ? largest[a] > largest[b] : a < b;
                    });
  std::vector<WorstTriangle> worst;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t t = order[i], f = frame_of[t];
    const TriangleShape shape = shape_of(corner(mesh, f, faces[t][0]), corner(mesh, f, faces[t][1]),
                                         corner(mesh, f, faces[t][2]));
    worst.push_back({static_cast<FaceIndex>(t), f, shape.smallest_angle_deg, shape.aspect});
  }
  return worst;
}

void add_extent(const AnimatedMesh& mesh, MeshInfo& info) {
  info.low.setConstant(std::numeric_limits<float>::infinity());
  info.high = -info.low;
  for (std::size_t f = 0; f < mesh.frame_count(); ++f) {
    info.low = info.low.cwiseMin(mesh.frame(f).colwise().minCoeff().transpose());
    info.high = info.high.cwiseMax(mesh.frame(f).colwise().maxCoeff().transpose());
  }
  if (mesh.frame_count() == 0) return;
  double sum = 0;
  for (const Edge& e : mesh.topology().edges()) {
    sum += (corner(mesh, 0, e.vertices[0]) - corner(mesh, 0, e.vertices[1])).norm();
  }
  const std::size_t edges = mesh.topology().edge_count();
  info.mean_edge_mm = edges > 0 ? sum / static_cast<double>(edges) : 0.0;
}

void add_topology(const Topology& topology, MeshInfo& info) {
  info.components = topology.component_count();
  info.isolated_vertices = topology.isolated_vertex_count();
  info.euler_characteristic = topology.euler_characteristic();
  info.manifold = topology.is_manifold();
  for (const auto& loop : topology.boundary_loops()) info.boundaries.push_back(loop.size());
  std::sort(info.boundaries.rbegin(), info.boundaries.rend());
  if (info.manifold && topology.face_count() > 0) {
    // χ = 2 C − 2 g − B, summed over the components.
    info.genus = (2 * static_cast<int64_t>(info.components) -
                  static_cast<int64_t>(info.boundaries.size()) - info.euler_characteristic) /
                 2;
  }
}

}  // namespace

TriangleShape shape_of(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                       const Eigen::Vector3d& c) {
  const double la = (b - c).norm(), lb = (c - a).norm(), lc = (a - b).norm();
  const double area = 0.5 * (b - a).cross(c - a).norm();
  TriangleShape shape;
  const double shortest = std::min({la, lb, lc});
  if (shortest > 0) {
    // By the sine and the cosine, so that thin triangles keep their digits.
    const double product = la * lb * lc / shortest;
    const double cosine = cosine_of_smallest(la * la, lb * lb, lc * lc);
    shape.smallest_angle_deg = std::atan2(2 * area / product, cosine) * degrees;
  }
  const double half = 0.5 * (la + lb + lc);
  shape.aspect =
      area > 0 ? la * lb * lc * half / (8 * area * area) : std::numeric_limits<double>::infinity();
  return shape;
}

MeshInfo mesh_info_of(const AnimatedMesh& mesh, std::size_t worst_count, const RunContext& ctx) {
  MeshInfo info;
  info.vertices = mesh.vertex_count();
  info.faces = mesh.topology().face_count();
  info.edges = mesh.topology().edge_count();
  info.frames = mesh.frame_count();
  info.rate_hz = mesh.rate_hz;
  info.duration_s = mesh.duration_s();
  info.first_frame = mesh.first_frame;
  add_extent(mesh, info);
  add_topology(mesh.topology(), info);
  info.worst = worst_triangles(mesh, worst_count, ctx);
  info.samples = mesh.frame_count() * mesh.vertex_count();
  info.filled_samples = static_cast<std::size_t>(
      std::ranges::count_if(mesh.filled(), [](uint8_t f) { return f != 0; }));
  info.named_vertices = static_cast<std::size_t>(std::ranges::count_if(
      mesh.vertex_names, [](const std::string& name) { return !name.empty(); }));
  info.events = mesh.events.size();
  return info;
}

}  // namespace kinemesh
