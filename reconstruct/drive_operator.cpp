#include "reconstruct/drive_operator.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "config/error.h"
#include "config/parallel.h"
#include "mesh/geodesics/geodesics.h"
#include "mesh/laplacian.h"
#include "reconstruct/coarse_scan.h"

namespace kinemesh {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using PointSpan = std::span<const Eigen::Vector3d>;

constexpr double reach_in_spacings = 1.6, longest_coarse_edge = 0.22;  // the latter in reaches
constexpr Eigen::Index columns_at_once = 16;

/// markers × vertices: what a marker sees of its face's corners.
Sparse sampling(const Topology& topology, std::span<const SurfacePoint> points) {
  Sparse a(static_cast<Eigen::Index>(points.size()),
           static_cast<Eigen::Index>(topology.vertex_count()));
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t m = 0; m < points.size(); ++m) {
    const Triangle& face = topology.faces()[points[m].face];
    for (std::size_t c = 0; c < 3; ++c) {
      entries.emplace_back(static_cast<int>(m), static_cast<int>(face[c]), points[m].weights[c]);
    }
  }
  a.setFromTriplets(entries.begin(), entries.end());
  return a;
}

/// Covariances of all vertices with the markers: three solves with (K / ℓ² … ) a few columns at a
/// time, so that a scan of half a million triangles needs no more than its result.
class SurfaceField {
 public:
  /// `inverse_square_reach` may be small (the biharmonic limit), but not 0.
  SurfaceField(const SurfaceOperators& surface, double inverse_square_reach)
      : masses_(surface.masses) {
    Sparse q = surface.stiffness;
    for (Eigen::Index v = 0; v < masses_.size(); ++v) {
      q.coeffRef(v, v) += inverse_square_reach * masses_[v];
    }
    solver_.compute(q);
    if (solver_.info() != Eigen::Success) {
      throw NoResultError({.what = "the scan's surface operator cannot be factorised",
                           .remedy = "Remesh the scan: its triangles are too ill-shaped"});
    }
  }
  Eigen::MatrixXd columns(const Sparse& sampling, int order, const RunContext& ctx) const {
    const Sparse loads = sampling.transpose();
    Eigen::MatrixXd result(loads.rows(), loads.cols());
    parallel_chunks(ctx, static_cast<std::size_t>(loads.cols()), columns_at_once,
                    [&](std::size_t begin, std::size_t end) {
                      const auto first = static_cast<Eigen::Index>(begin);
                      const auto count = static_cast<Eigen::Index>(end - begin);
                      Eigen::MatrixXd x = loads.middleCols(first, count);
                      for (int k = 0; k < order; ++k) {
                        if (k > 0) x = masses_.asDiagonal() * x;
                        x = solver_.solve(x).eval();
                      }
                      result.middleCols(first, count) = x;
                    });
    return result;
  }

 private:
  Eigen::VectorXd masses_;
  Eigen::SimplicialLLT<Sparse> solver_;
};

Eigen::MatrixXd symmetric(const Eigen::MatrixXd& m) { return 0.5 * (m + m.transpose()); }

/// columns · covariance⁻¹, with a ridge that only keeps rounding in check.
Eigen::MatrixXf conditioned(const Eigen::MatrixXd& columns, Eigen::MatrixXd covariance,
                            const RunContext& ctx) {
  covariance.diagonal().array() += 1e-9 * covariance.diagonal().mean();
  const Eigen::LDLT<Eigen::MatrixXd> solver(covariance);
  Eigen::MatrixXf result(columns.rows(), columns.cols());
  parallel_chunks(ctx, static_cast<std::size_t>(columns.rows()), 4096,
                  [&](std::size_t begin, std::size_t end) {
                    const auto first = static_cast<Eigen::Index>(begin);
                    const auto count = static_cast<Eigen::Index>(end - begin);
                    const Eigen::MatrixXd block = columns.middleRows(first, count).transpose();
                    result.middleRows(first, count) = solver.solve(block).transpose().cast<float>();
                  });
  return result;
}

/// Interpolation by a kernel matrix with polynomial part: rows of [kernel | basis] · inverse.
Eigen::MatrixXf kernel_spread(const Eigen::MatrixXd& among, const Eigen::MatrixXd& basis_among,
                              const Eigen::MatrixXd& to_vertices,
                              const Eigen::MatrixXd& basis_vertices) {
  const Eigen::Index m = among.rows(), b = basis_among.cols();
  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(m + b, m + b);
  system.topLeftCorner(m, m) = among;
  system.topRightCorner(m, b) = basis_among;
  system.bottomLeftCorner(b, m) = basis_among.transpose();
  // Flat or straight sets of markers leave parts of the polynomial undetermined.
  system.bottomRightCorner(b, b).diagonal().setConstant(-1e-9);
  const Eigen::MatrixXd inverse = system.partialPivLu().inverse();
  Eigen::MatrixXf spread(to_vertices.rows(), m);
  for (Eigen::Index first = 0; first < spread.rows(); first += 4096) {
    const Eigen::Index count = std::min<Eigen::Index>(4096, spread.rows() - first);
    Eigen::MatrixXd rows(count, m + b);
    rows << to_vertices.middleRows(first, count), basis_vertices.middleRows(first, count);
    spread.middleRows(first, count) = (rows * inverse.leftCols(m)).cast<float>();
  }
  return spread;
}

Eigen::MatrixXd affine(const std::vector<Eigen::Vector3d>& points) {
  Eigen::MatrixXd basis(static_cast<Eigen::Index>(points.size()), 4);
  for (Eigen::Index i = 0; i < basis.rows(); ++i) {
    basis.row(i) << 1.0, points[static_cast<std::size_t>(i)].transpose();
  }
  return basis;
}

Eigen::MatrixXf euclidean_spread(PointSpan positions, const std::vector<Eigen::Vector3d>& markers) {
  const auto m = static_cast<Eigen::Index>(markers.size());
  Eigen::MatrixXd kernel(static_cast<Eigen::Index>(positions.size()), m);
  Eigen::MatrixXd among(m, m);
  for (Eigen::Index j = 0; j < m; ++j) {
    const Eigen::Vector3d& at = markers[static_cast<std::size_t>(j)];
    for (Eigen::Index i = 0; i < kernel.rows(); ++i) {
      kernel(i, j) = (positions[static_cast<std::size_t>(i)] - at).norm();
    }
    for (Eigen::Index i = 0; i < m; ++i) {
      among(i, j) = (markers[static_cast<std::size_t>(i)] - at).norm();
    }
  }
  // Centred, so that the affine part is well scaled wherever the scan lies.
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const auto& p : markers) middle += p / static_cast<double>(m);
  std::vector<Eigen::Vector3d> own(markers), all(positions.begin(), positions.end());
  for (auto& p : own) p = (p - middle) / 100.0;
  for (auto& p : all) p = (p - middle) / 100.0;
  return kernel_spread(among, affine(own), kernel, affine(all));
}

Eigen::MatrixXf geodesic_spread(const Topology& topology, PointSpan positions,
                                std::span<const SurfacePoint> points, const Sparse& sampling,
                                const RunContext& ctx) {
  const GeodesicSolver solver(std::make_shared<const Topology>(topology), positions);
  const auto vertices = static_cast<Eigen::Index>(positions.size());
  const auto m = static_cast<Eigen::Index>(points.size());
  const double far = 1000.0;  // mm, for what no path reaches
  Eigen::MatrixXd kernel(vertices, m);
  parallel_for(ctx, points.size(), 4, [&](std::size_t j) {
    std::vector<double> distances(positions.size());
    solver.exact_distances(points[j], distances);
    for (Eigen::Index i = 0; i < vertices; ++i) {
      const double d = distances[static_cast<std::size_t>(i)];
      kernel(i, static_cast<Eigen::Index>(j)) = std::isfinite(d) ? d : far;
    }
  });
  const Eigen::MatrixXd among = sampling * kernel;
  return kernel_spread(among, Eigen::MatrixXd::Ones(m, 1), kernel,
                       Eigen::MatrixXd::Ones(vertices, 1));
}

/// Distance of a vertex within a marker's own face bends the kernels: what is missing at the
/// markers is spread once more, until the interpolant is exact there.
void make_exact(Eigen::MatrixXf& spread, const Sparse& sampling) {
  const Eigen::Index m = spread.cols();
  const Eigen::MatrixXd at_markers = sampling * spread.cast<double>();
  const double off = (at_markers - Eigen::MatrixXd::Identity(m, m)).cwiseAbs().maxCoeff();
  if (off < 1e-6) return;
  const Eigen::PartialPivLU<Eigen::MatrixXd> solver(at_markers);
  if (!(solver.rcond() > 1e-8)) return;
  const Eigen::MatrixXd inverse = solver.inverse();
  for (Eigen::Index first = 0; first < spread.rows(); first += 4096) {
    const Eigen::Index count = std::min<Eigen::Index>(4096, spread.rows() - first);
    const Eigen::MatrixXd block = spread.middleRows(first, count).cast<double>();
    spread.middleRows(first, count) = (block * inverse).cast<float>();
  }
}

/// The mesh that is solved on, the scan itself or a coarser one, and the markers on it.
struct SolveMesh {
  std::shared_ptr<const Topology> coarse;  // of the coarse one
  std::vector<Eigen::Vector3d> coarse_positions;
  Sparse carry;  // from the coarse one to the scan
  Sparse sample;
  std::vector<SurfacePoint> points;
};

SolveMesh coarse_mesh(const Topology& topology, PointSpan positions,
                      std::span<const SurfacePoint> points, std::size_t most_faces,
                      double longest_edge_mm, const RunContext& ctx) {
  CoarseScan coarse = coarsen_scan(topology, positions, most_faces, longest_edge_mm, ctx);
  SolveMesh mesh;
  mesh.carry = coarse.carry();
  mesh.sample = sampling(topology, points) * mesh.carry;
  for (const SurfacePoint& p : points) {
    const auto corner =
        static_cast<std::size_t>(std::ranges::max_element(p.weights) - p.weights.begin());
    mesh.points.push_back(coarse.places[topology.faces()[p.face].at(corner)]);
    if (mesh.points.back().valid()) continue;
    throw InternalError("a marker's vertex lies on no face of the coarse scan");
  }
  mesh.coarse = std::move(coarse.topology);
  mesh.coarse_positions = std::move(coarse.positions);
  return mesh;
}

/// Values at the scan's vertices from those at the coarse ones, without copies in double.
Eigen::MatrixXf carried(const Sparse& carry, const Eigen::MatrixXf& coarse) {
  const Eigen::SparseMatrix<float, Eigen::RowMajor> to_scan = carry.cast<float>();
  return to_scan * coarse;
}

/// Covariance and spread on the mesh that is solved on; `sample` sees the markers there.
void solve(DriveOperator& result, const Topology& topology, PointSpan positions,
           std::span<const SurfacePoint> points, const Sparse& sample,
           const std::vector<Eigen::Vector3d>& markers, DriveMethod method, const RunContext& ctx) {
  const SurfaceOperators surface = surface_operators(topology, positions);
  const SurfaceField field(surface, 1.0 / (result.reach_mm * result.reach_mm));
  Eigen::MatrixXd columns = field.columns(sample, 3, ctx);
  ctx.check_cancelled();
  result.solved_faces = topology.face_count();
  result.covariance = symmetric(sample * columns);
  const double scale = result.covariance.diagonal().mean();
  result.covariance /= scale;
  columns /= scale;
  switch (method) {
    case DriveMethod::surface: result.spread = conditioned(columns, result.covariance, ctx); break;
    case DriveMethod::biharmonic: {
      const SurfaceField wide(surface, 1e-5);  // a reach beyond any face: no fading
      columns = wide.columns(sample, 2, ctx);
      result.spread = conditioned(columns, symmetric(sample * columns), ctx);
      break;
    }
    case DriveMethod::geodesic:
      result.spread = geodesic_spread(topology, positions, points, sample, ctx);
      break;
    case DriveMethod::euclidean: result.spread = euclidean_spread(positions, markers); break;
  }
  // The plain kernels are left as the literature has them off the vertices but at the markers.
  make_exact(result.spread, sample);
}

}  // namespace

double nearest_spacing(std::span<const Eigen::Vector3d> points) {
  if (points.size() < 2) return 0.0;
  double sum = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < points.size(); ++j) {
      if (j != i) nearest = std::min(nearest, (points[i] - points[j]).norm());
    }
    sum += nearest;
  }
  return sum / static_cast<double>(points.size());
}

DriveOperator make_drive_operator(const Topology& topology, PointSpan positions,
                                  std::span<const SurfacePoint> points, DriveMethod method,
                                  double reach_mm, std::size_t most_faces, const RunContext& ctx) {
  const auto start = std::chrono::steady_clock::now();
  std::vector<Eigen::Vector3d> markers;
  for (const SurfacePoint& p : points) markers.push_back(position_of(p, topology, positions));
  DriveOperator result;
  result.reach_mm = reach_mm > 0.0 ? reach_mm : reach_in_spacings * nearest_spacing(markers);
  if (!(result.reach_mm > 0.0)) result.reach_mm = 15.0;
  if (most_faces == 0 || topology.face_count() <= most_faces) {
    solve(result, topology, positions, points, sampling(topology, points), markers, method,
          ctx.part(0.0, 0.8, "spreading"));
  } else {
    const SolveMesh mesh =
        coarse_mesh(topology, positions, points, most_faces, longest_coarse_edge * result.reach_mm,
                    ctx.part(0.0, 0.2, "decimating"));
    solve(result, *mesh.coarse, mesh.coarse_positions, mesh.points, mesh.sample, markers, method,
          ctx.part(0.2, 0.8, "spreading"));
    result.spread = carried(mesh.carry, result.spread);
  }
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace kinemesh
