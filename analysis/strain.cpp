#include "analysis/strain.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "config/multiversion.h"
#include "config/parallel.h"

namespace kinemesh::strain {
namespace {

constexpr std::size_t strain_grain = 128;

/// sums[a * frames + f] += weights[a] * row[f], for a = 0, 1.
KINEMESH_MULTIVERSION void add_scaled(float* sums, const float* row, std::size_t frames, float w0,
                                      float w1) {
  float* second = sums + frames;
  for (std::size_t f = 0; f < frames; ++f) {
    sums[f] += w0 * row[f];
    second[f] += w1 * row[f];
  }
}

/// tensor += products of the columns of one axis of F.
KINEMESH_MULTIVERSION void add_products(float* tensor, const float* columns, std::size_t frames) {
  const float* first = columns;
  const float* second = columns + frames;
  for (std::size_t f = 0; f < frames; ++f) {
    tensor[f] += first[f] * first[f];
    tensor[frames + f] += first[f] * second[f];
    tensor[2 * frames + f] += second[f] * second[f];
  }
}

KINEMESH_MULTIVERSION void face_columns(const float* a, const float* b, const float* c,
                                        const float* inverse, std::size_t frames, float* columns) {
  for (std::size_t f = 0; f < frames; ++f) {
    const float u = b[f] - a[f], v = c[f] - a[f];
    columns[f] = u * inverse[0] + v * inverse[2];
    columns[frames + f] = u * inverse[1] + v * inverse[3];
  }
}

/// Eigenvalues of FᵀF, the larger first.
inline std::pair<float, float> eigenvalues(float c00, float c01, float c11) {
  const float half = 0.5F * (c00 + c11), diff = 0.5F * (c00 - c11);
  const float root = std::sqrt(diff * diff + c01 * c01);
  return {half + root, std::max(half - root, 0.0F)};
}

/// Strain below it is rounding of float positions.
constexpr float rounding = 2e-6F;

inline float half_log(float eigenvalue) { return 0.5F * std::log(std::max(eigenvalue, 1e-12F)); }

/// Smooth weight of a vertex at a distance, so that none enters or leaves a ball at once.
double taper(double distance, double radius) {
  const double t = radius > 0.0 ? distance / radius : 0.0;
  return std::max(0.05, 1.0 - t * t);
}

struct BallFit {
  std::span<const VertexIndex> ball;
  std::vector<double> mass;
  std::vector<Eigen::Vector2d> plane;  // coordinates in the tangent plane around the mean
};

/// Two unit vectors across `normal`.
std::array<Eigen::Vector3d, 2> basis_across(const Eigen::Vector3d& normal) {
  const Eigen::Vector3d axis =
      std::abs(normal.x()) < 0.6 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  const Eigen::Vector3d first = normal.cross(axis).normalized();
  return {first, normal.cross(first)};
}

/// Weights of one ball; false when its vertices lie on a line or a point.
bool fit_ball(const BallFit& fit, std::span<const Eigen::Vector3d> rest, float* weights) {
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (std::size_t j = 0; j < fit.ball.size(); ++j) {
    spread += fit.mass[j] * fit.plane[j] * fit.plane[j].transpose();
  }
  const double trace = spread.trace();
  if (!(trace > 0.0) || !(spread.determinant() > 1e-8 * trace * trace)) return false;
  const Eigen::Matrix2d inverse = spread.inverse();
  Eigen::Matrix<double, 3, 2> at_rest = Eigen::Matrix<double, 3, 2>::Zero();
  for (std::size_t j = 0; j < fit.ball.size(); ++j) {
    at_rest += rest[fit.ball[j]] * (fit.mass[j] * (inverse * fit.plane[j])).transpose();
  }
  // The fit at rest is not exactly the identity on curved surfaces; strain is relative to it.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(at_rest.transpose() * at_rest);
  if (!(solver.eigenvalues()[0] > 1e-6)) return false;
  const Eigen::Matrix2d whiten = inverse * solver.operatorInverseSqrt();
  for (std::size_t j = 0; j < fit.ball.size(); ++j) {
    const Eigen::Vector2d w = fit.mass[j] * (whiten.transpose() * fit.plane[j]);
    weights[2 * j] = static_cast<float>(w.x());
    weights[2 * j + 1] = static_cast<float>(w.y());
  }
  return true;
}

void make_stencil(std::span<const VertexIndex> ball, std::span<const Eigen::Vector3d> rest,
                  const std::vector<double>& areas, const std::vector<Eigen::Vector3d>& normals,
                  float* weights, Eigen::Vector3f* basis) {
  std::fill(weights, weights + 2 * ball.size(), 0.0F);
  basis[0] = basis[1] = Eigen::Vector3f::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero(), mean = Eigen::Vector3d::Zero();
  double radius = 0.0, total = 0.0;
  for (const VertexIndex j : ball) {
    normal += areas[j] * normals[j];
    radius = std::max(radius, (rest[j] - rest[ball[0]]).norm());
  }
  if (!(normal.norm() > 0.0)) normal = normals[ball[0]];
  if (!(normal.norm() > 0.0)) return;
  BallFit fit{ball, {}, {}};
  for (const VertexIndex j : ball) {
    fit.mass.push_back(areas[j] * taper((rest[j] - rest[ball[0]]).norm(), radius));
    mean += fit.mass.back() * rest[j];
    total += fit.mass.back();
  }
  if (!(total > 0.0)) return;
  mean /= total;
  const auto axes = basis_across(normal.normalized());
  for (const VertexIndex j : ball) {
    const Eigen::Vector3d offset = rest[j] - mean;
    fit.plane.emplace_back(axes[0].dot(offset), axes[1].dot(offset));
  }
  if (!fit_ball(fit, rest, weights)) return;
  basis[0] = axes[0].cast<float>();
  basis[1] = axes[1].cast<float>();
}

}  // namespace

Stencils make_stencils(const Topology& topology, std::span<const Eigen::Vector3d> rest,
                       VertexLists lists, const RunContext& ctx) {
  Stencils stencils{std::move(lists), {}, {}};
  stencils.weights.resize(2 * stencils.lists.items.size());
  stencils.basis.resize(2 * topology.vertex_count());
  const auto areas = vertex_areas(topology, rest);
  const auto normals = vertex_normals(topology, rest);
  parallel_for(ctx, topology.vertex_count(), strain_grain, [&](std::size_t v) {
    make_stencil(stencils.lists.of(v), rest, areas, normals,
                 stencils.weights.data() + 2 * stencils.lists.offsets[v],
                 stencils.basis.data() + 2 * v);
  });
  return stencils;
}

void stretch_of_vertex(const Stencils& stencils, const Block& block, std::size_t vertex,
                       float* tensor) {
  const std::size_t frames = block.stride;
  std::fill(tensor, tensor + 3 * frames, 0.0F);
  const auto ball = stencils.lists.of(vertex);
  const float* weights = stencils.weights.data() + 2 * stencils.lists.offsets[vertex];
  if (stencils.basis[2 * vertex].isZero()) {  // no fit: as at rest
    std::fill(tensor, tensor + frames, 1.0F);
    std::fill(tensor + 2 * frames, tensor + 3 * frames, 1.0F);
    return;
  }
  thread_local std::vector<float> columns;
  columns.resize(2 * frames);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::fill(columns.begin(), columns.end(), 0.0F);
    for (std::size_t j = 0; j < ball.size(); ++j) {
      add_scaled(columns.data(), block.row(ball[j], axis), frames, weights[2 * j],
                 weights[2 * j + 1]);
    }
    add_products(tensor, columns.data(), frames);
  }
}

void measure_row(const float* tensor, std::size_t frames, StrainMeasure measure, float floor,
                 float* out) {
  for (std::size_t f = 0; f < frames; ++f) {
    const auto [first, second] = eigenvalues(tensor[f], tensor[frames + f], tensor[2 * frames + f]);
    switch (measure) {
      case StrainMeasure::lambda: out[f] = first; break;
      case StrainMeasure::green: out[f] = 0.5F * (first - 1.0F); break;
      case StrainMeasure::log: out[f] = std::max(half_log(first), 0.0F); break;
      case StrainMeasure::root_log:
        out[f] = std::sqrt(std::max(half_log(first) - rounding, 0.0F) + floor) - std::sqrt(floor);
        break;
      case StrainMeasure::log_norm: out[f] = std::hypot(half_log(first), half_log(second)); break;
    }
  }
}

RestTriangles rest_triangles(const Topology& topology, std::span<const Eigen::Vector3d> rest) {
  RestTriangles triangles;
  triangles.inverse.resize(topology.face_count());
  triangles.valid.resize(topology.face_count());
  for (std::size_t t = 0; t < topology.face_count(); ++t) {
    const Triangle& face = topology.faces()[t];
    const Eigen::Vector3d u = rest[face[1]] - rest[face[0]], v = rest[face[2]] - rest[face[0]];
    const double length = u.norm(), area = u.cross(v).norm();
    const double longest = std::max({length, v.norm(), (v - u).norm()});
    triangles.valid[t] = area > 1e-7 * longest * longest && length > 0.0 ? 1 : 0;
    if (triangles.valid[t] == 0) {
      ++triangles.degenerate;
      continue;
    }
    Eigen::Matrix2d edges;
    edges << length, u.dot(v) / length, 0.0, area / length;
    const Eigen::Matrix2d inverse = edges.inverse();
    triangles.inverse[t] = {static_cast<float>(inverse(0, 0)), static_cast<float>(inverse(0, 1)),
                            static_cast<float>(inverse(1, 0)), static_cast<float>(inverse(1, 1))};
  }
  return triangles;
}

void stretch_of_face(const RestTriangles& rest, const Topology& topology, const Block& block,
                     std::size_t face, float* tensor) {
  const std::size_t frames = block.stride;
  const Triangle& corners = topology.faces()[face];
  std::fill(tensor, tensor + 3 * frames, 0.0F);
  thread_local std::vector<float> columns;
  columns.resize(2 * frames);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    face_columns(block.row(corners[0], axis), block.row(corners[1], axis),
                 block.row(corners[2], axis), rest.inverse[face].data(), frames, columns.data());
    add_products(tensor, columns.data(), frames);
  }
}

namespace {

/// Dihedral angle × length and area of the edges, edges × stride floats each; 0 at the boundary.
void bend_of_edges(const Topology& topology, const Block& block, std::vector<float>& bend,
                   std::vector<float>& area, const RunContext& ctx) {
  const std::size_t frames = block.stride;
  bend.assign(topology.edge_count() * frames, 0.0F);
  area.assign(topology.edge_count() * frames, 0.0F);
  parallel_for(ctx, topology.edge_count(), strain_grain, [&](std::size_t e) {
    const Edge& edge = topology.edges()[e];
    if (edge.boundary()) return;
    const VertexIndex opposite[2] = {topology.from(Topology::previous(edge.left)),
                                     topology.from(Topology::previous(edge.right))};
    const auto at = [&](VertexIndex v, std::size_t f) {
      return Eigen::Vector3f(block.row(v, 0)[f], block.row(v, 1)[f], block.row(v, 2)[f]);
    };
    for (std::size_t f = 0; f < frames; ++f) {
      const Eigen::Vector3f from = at(edge.vertices[0], f), along = at(edge.vertices[1], f) - from;
      const Eigen::Vector3f left = along.cross(at(opposite[0], f) - from);
      const Eigen::Vector3f right = (at(opposite[1], f) - from).cross(along);
      const float length = along.norm();
      area[e * frames + f] = (left.norm() + right.norm()) / 6.0F;
      if (!(length > 0.0F) || left.isZero() || right.isZero()) continue;
      const float sine = left.cross(right).dot(along) / length, cosine = left.dot(right);
      bend[e * frames + f] = length * std::atan2(sine, cosine);
    }
  });
}

}  // namespace

void bend_at_vertices(const Topology& topology, const Block& block, std::vector<float>& bend,
                      std::vector<float>& area, const RunContext& ctx) {
  const std::size_t frames = block.stride;
  std::vector<float> edge_bend, edge_area;
  bend_of_edges(topology, block, edge_bend, edge_area, ctx);
  bend.assign(topology.vertex_count() * frames, 0.0F);
  area.assign(topology.vertex_count() * frames, 0.0F);
  for (std::size_t e = 0; e < topology.edge_count(); ++e) {
    for (const VertexIndex v : topology.edges()[e].vertices) {
      for (std::size_t f = 0; f < frames; ++f) {
        bend[v * frames + f] += 0.5F * edge_bend[e * frames + f];
        area[v * frames + f] += 0.5F * edge_area[e * frames + f];
      }
    }
  }
}

}  // namespace kinemesh::strain
