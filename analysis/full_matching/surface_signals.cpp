#include "analysis/full_matching/surface_signals.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "analysis/deformation.h"
#include "analysis/surface_balls.h"
#include "mesh/geodesics/geodesics.h"

namespace kinemesh::full_matching {

namespace {

constexpr double loop_reach = 0.06;  // √area: how far around a loop its nearness tells places apart
constexpr double least_strain = 1e-4;  // below it a motion says nothing

using Curves = Eigen::MatrixXf;  // vertices × instants of one or several measures

/// The animation at `instants` of its duration, the first frame in front as the rest pose.
AnimatedMesh resampled(const AnimatedMesh& mesh, int instants) {
  AnimatedMesh result(mesh.shared_topology(), static_cast<std::size_t>(instants) + 1, 1.0);
  const double last = static_cast<double>(mesh.frame_count() - 1);
  for (int k = 0; k <= instants; ++k) {
    const double time = k == 0 ? 0.0 : last * (k - 0.5) / instants;
    const auto before = static_cast<std::size_t>(time);
    const std::size_t after = std::min(before + 1, mesh.frame_count() - 1);
    const auto t = static_cast<float>(time - static_cast<double>(before));
    result.frame(static_cast<std::size_t>(k)) =
        (1.0F - t) * mesh.frame(before) + t * mesh.frame(after);
  }
  return result;
}

/// Largest stretch and total strain side by side, of mean square 1; empty without motion.
Curves strain_of(const AnimatedMesh& mesh, const std::vector<double>& areas, int instants,
                 const RunContext& ctx) {
  if (mesh.frame_count() < 2) return {};
  const AnimatedMesh few = resampled(mesh, instants);
  Curves curves(static_cast<Eigen::Index>(mesh.vertex_count()), 2 * instants);
  for (const StrainMeasure measure : {StrainMeasure::log, StrainMeasure::log_norm}) {
    DeformationOptions options;
    options.measure = measure;
    const DeformationResult strain = deformation_of(few, options, ctx);
    const Eigen::Index first = measure == StrainMeasure::log ? 0 : instants;
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
      for (int k = 0; k < instants; ++k) {
        curves(static_cast<Eigen::Index>(v), first + k) =
            strain.values.of(v)[static_cast<std::size_t>(k) + 1];
      }
    }
  }
  double square = 0.0;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    square += areas[v] * curves.row(static_cast<Eigen::Index>(v)).squaredNorm();
  }
  if (!(std::sqrt(square) > least_strain)) return {};
  return curves / static_cast<float>(std::sqrt(square));
}

Eigen::MatrixXd second_moments(const Curves& curves, const std::vector<double>& areas) {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(curves.cols(), curves.cols());
  for (Eigen::Index v = 0; v < curves.rows(); ++v) {
    const Eigen::VectorXd row = curves.row(v).cast<double>();
    sum.noalias() += areas[static_cast<std::size_t>(v)] * row * row.transpose();
  }
  return sum;
}

void add_strain(SignalPair& pair, const Curves& a, const Curves& b) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(second_moments(a, pair.a.areas) +
                                                              second_moments(b, pair.b.areas));
  const int kept = static_cast<int>(std::min<Eigen::Index>(channels - first_strain, a.cols()));
  const Eigen::MatrixXf basis = solver.eigenvectors().rightCols(kept).cast<float>();
  const auto project = [&](const Curves& curves, SurfaceSignals& signals) {
    const Eigen::MatrixXf scores = curves * basis;
    for (Eigen::Index v = 0; v < curves.rows(); ++v) {
      signals.values[static_cast<std::size_t>(v)].segment(first_strain, kept) = scores.row(v);
    }
  };
  project(a, pair.a);
  project(b, pair.b);
  pair.has_strain = true;
}

void add_loops(SurfaceSignals& signals, const ClosedSurface& closed) {
  if (closed.loops.empty()) return;
  const auto longest = std::ranges::max_element(closed.loops, {}, [&](const auto& loop) {
    double length = 0.0;
    for (std::size_t k = 0; k < loop.size(); ++k) {
      length +=
          (signals.positions[loop[k]] - signals.positions[loop[(k + 1) % loop.size()]]).norm();
    }
    return length;
  });
  const GeodesicSolver solver(closed.topology, signals.positions);
  for (int channel = 0; channel < 2; ++channel) {
    std::vector<VertexIndex> sources;
    for (auto loop = closed.loops.begin(); loop != closed.loops.end(); ++loop) {
      if ((loop == longest) == (channel == 0))
        sources.insert(sources.end(), loop->begin(), loop->end());
    }
    if (sources.empty()) continue;
    const GeodesicField field = solver.solve(vertex_points(*closed.topology, sources),
                                             {.method = GeodesicMethod::dijkstra});
    for (std::size_t v = 0; v < signals.values.size(); ++v) {
      const double far = field.distances[v], near = loop_reach / (loop_reach + far);
      const bool inside = closed.filling_vertex(static_cast<VertexIndex>(v));
      signals.values[v][first_loop + channel] = static_cast<float>(inside ? 2.0 - near : near);
    }
  }
}

/// Fillings take their values from around: nothing is compared there, but paths cross them.
void extend_into_fillings(SurfaceSignals& signals, const ClosedSurface& closed) {
  for (int round = 0; round < 30; ++round) {
    for (std::size_t v = closed.surface_vertices; v < signals.values.size(); ++v) {
      Signal sum = Signal::Zero();
      const auto ring = closed.topology->neighbours_of(static_cast<VertexIndex>(v));
      for (const VertexIndex r : ring) sum += signals.values[r];
      sum /= static_cast<float>(ring.size());
      signals.values[v].head<3>() = sum.head<3>();
      signals.values[v].tail<channels - first_strain>() = sum.tail<channels - first_strain>();
    }
  }
}

SurfaceSignals shape_signals(const Topology& topology, const ClosedSurface& closed) {
  SurfaceSignals signals{.positions = closed.positions};
  const std::span<const Eigen::Vector3d> open(closed.positions.data(), closed.surface_vertices);
  signals.areas = vertex_areas(topology, open);
  double area = 0.0;
  for (const double a : signals.areas) area += a;
  signals.root_area_mm = std::sqrt(area);
  for (double& a : signals.areas) a /= area;
  signals.areas.resize(closed.positions.size(), 0.0);
  for (Eigen::Vector3d& p : signals.positions) p /= signals.root_area_mm;
  signals.values.assign(closed.positions.size(), Signal::Zero());
  const std::vector<Eigen::Vector3d> normals = vertex_normals(topology, open);
  for (std::size_t v = 0; v < normals.size(); ++v) {
    signals.values[v].head<3>() = normals[v].cast<float>();
  }
  return signals;
}

}  // namespace

SignalPair compare_signals(const AnimatedMesh& a, const ClosedSurface& closed_a,
                           const AnimatedMesh& b, const ClosedSurface& closed_b, int instants,
                           const RunContext& ctx) {
  SignalPair pair{.a = shape_signals(a.topology(), closed_a),
                  .b = shape_signals(b.topology(), closed_b)};
  pair.has_loops = !closed_a.loops.empty() && !closed_b.loops.empty();
  if (pair.has_loops) {
    add_loops(pair.a, closed_a);
    add_loops(pair.b, closed_b);
  }
  const Curves strain_a = strain_of(a, pair.a.areas, instants, ctx);
  const Curves strain_b = strain_of(b, pair.b.areas, instants, ctx);
  if (strain_a.size() > 0 && strain_b.size() > 0) add_strain(pair, strain_a, strain_b);
  extend_into_fillings(pair.a, closed_a);
  extend_into_fillings(pair.b, closed_b);
  return pair;
}

}  // namespace kinemesh::full_matching
