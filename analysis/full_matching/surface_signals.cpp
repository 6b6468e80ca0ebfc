#include "analysis/full_matching/surface_signals.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <queue>

#include "analysis/deformation.h"
#include "analysis/diffusion.h"
#include "analysis/surface_balls.h"
#include "config/parallel.h"

namespace kinemesh::full_matching {

namespace {

constexpr double loop_reach = 0.06;  // √area: how far around a loop its nearness tells places apart
constexpr double tangent_reach = 0.012;  // √area: half the chord that is a loop's direction
constexpr double strain_reach = 0.03;    // √area: of the ball in which strain is measured
constexpr double least_strain = 1e-4;    // below it a motion says nothing

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
    options.strain_radius = strain_reach;
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

/// A boundary loop as a curve by its length.
class Loop {
 public:
  Loop(const std::vector<VertexIndex>& vertices, const std::vector<Eigen::Vector3d>& positions) {
    for (const VertexIndex v : vertices) points_.push_back(positions[v]);
    for (std::size_t k = 0; k < points_.size(); ++k) {
      begins_.push_back(length_);
      length_ += (point(k + 1) - points_[k]).norm();
    }
  }
  double length() const { return length_; }

  struct Nearest {
    double distance = std::numeric_limits<double>::infinity(), place = 0.0;
  };
  /// On the two edges at vertex k.
  Nearest nearest(const Eigen::Vector3d& p, std::size_t k) const {
    Nearest best;
    for (const std::size_t from : {(k + points_.size() - 1) % points_.size(), k}) {
      const Eigen::Vector3d edge = point(from + 1) - points_[from];
      const double square = edge.squaredNorm();
      const double t =
          square > 0.0 ? std::clamp((p - points_[from]).dot(edge) / square, 0.0, 1.0) : 0.0;
      const double distance = (points_[from] + t * edge - p).norm();
      if (distance < best.distance) best = {distance, begins_[from] + t * std::sqrt(square)};
    }
    return best;
  }
  /// The chord of the curve over a length that does not depend on the mesh, over that length.
  Eigen::Vector3d direction(double place) const {
    const double half = std::min(tangent_reach, length_ / 8.0);
    return half > 0.0 ? Eigen::Vector3d((at(place + half) - at(place - half)) / (2.0 * half))
                      : Eigen::Vector3d::Zero();
  }

 private:
  const Eigen::Vector3d& point(std::size_t k) const { return points_[k % points_.size()]; }
  Eigen::Vector3d at(double place) const {
    place -= std::floor(place / length_) * length_;
    const auto next = std::ranges::upper_bound(begins_, place);
    const auto k =
        static_cast<std::size_t>(std::max<std::ptrdiff_t>(1, next - begins_.begin())) - 1;
    const double edge = (point(k + 1) - points_[k]).norm();
    const double t = edge > 0.0 ? (place - begins_[k]) / edge : 0.0;
    return points_[k] + std::min(t, 1.0) * (point(k + 1) - points_[k]);
  }
  std::vector<Eigen::Vector3d> points_;
  std::vector<double> begins_;
  double length_ = 0.0;
};

/// The loop and its vertex that each vertex is nearest to along the edges.
struct LoopVertex {
  uint32_t loop = invalid_index, vertex = 0;
};
std::vector<LoopVertex> nearest_loops(const Topology& topology,
                                      const std::vector<Eigen::Vector3d>& positions,
                                      const std::vector<std::vector<VertexIndex>>& loops,
                                      const std::vector<uint8_t>& asked) {
  std::vector<LoopVertex> nearest(positions.size());
  std::vector<double> distances(positions.size(), std::numeric_limits<double>::infinity());
  using Entry = std::pair<double, VertexIndex>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (uint32_t l = 0; l < loops.size(); ++l) {
    if (asked[l] == 0) continue;
    for (uint32_t k = 0; k < loops[l].size(); ++k) {
      nearest[loops[l][k]] = {l, k};
      distances[loops[l][k]] = 0.0;
      queue.emplace(0.0, loops[l][k]);
    }
  }
  while (!queue.empty()) {
    const auto [distance, v] = queue.top();
    queue.pop();
    if (distance > distances[v]) continue;
    for (const VertexIndex w : topology.neighbours_of(v)) {
      const double further = distance + (positions[w] - positions[v]).norm();
      if (!(further < distances[w])) continue;
      distances[w] = further;
      nearest[w] = nearest[v];
      queue.emplace(further, w);
    }
  }
  return nearest;
}

/// Distances to the loops are straight: along the edges they would depend on the mesh.
void add_loops(SurfaceSignals& signals, const ClosedSurface& closed) {
  if (closed.loops.empty()) return;
  std::vector<Loop> loops;
  for (const auto& loop : closed.loops) loops.emplace_back(loop, signals.positions);
  const auto longest =
      static_cast<std::size_t>(std::ranges::max_element(loops, {}, &Loop::length) - loops.begin());
  for (int channel = 0; channel < 2; ++channel) {
    std::vector<uint8_t> asked(loops.size());
    for (std::size_t l = 0; l < loops.size(); ++l) asked[l] = (l == longest) == (channel == 0);
    const auto nearest = nearest_loops(*closed.topology, signals.positions, closed.loops, asked);
    for (std::size_t v = 0; v < signals.values.size(); ++v) {
      if (nearest[v].loop == invalid_index) continue;
      const Loop& loop = loops[nearest[v].loop];
      const Loop::Nearest there = loop.nearest(signals.positions[v], nearest[v].vertex);
      const double near = loop_reach / (loop_reach + there.distance);
      const bool inside = closed.filling_vertex(static_cast<VertexIndex>(v));
      signals.values[v][first_loop + channel] = static_cast<float>(inside ? 2.0 - near : near);
      signals.values[v].segment<3>(first_tangent) +=
          (near * loop.direction(there.place)).cast<float>();
    }
  }
}

/// Fillings take their values from around: nothing is compared there, but paths cross them.
void extend_into_fillings(std::vector<Signal>& values, const ClosedSurface& closed) {
  for (int round = 0; round < 30; ++round) {
    for (std::size_t v = closed.surface_vertices; v < values.size(); ++v) {
      Signal sum = Signal::Zero();
      const auto ring = closed.topology->neighbours_of(static_cast<VertexIndex>(v));
      for (const VertexIndex r : ring) sum += values[r];
      sum /= static_cast<float>(ring.size());
      values[v].head<3>() = sum.head<3>();
      values[v].tail<channels - first_strain>() = sum.tail<channels - first_strain>();
    }
  }
}

/// All but the nearness of loops, which is smooth and sharp only where it ends; heat does not cross
/// the gap between lips.
void blur(SurfaceSignals& signals, const Topology& topology, const ClosedSurface& closed) {
  const std::size_t n = closed.surface_vertices;
  std::vector<uint32_t> rows(n);
  std::iota(rows.begin(), rows.end(), 0U);
  diffusion::Operator heat(topology, std::span(signals.positions).first(n), rows);
  std::vector<float> scratch(n * channels);
  for (std::size_t k = 0; k < blurs.size(); ++k) {
    std::vector<Signal>& values = signals.blurred[k] = signals.values;
    const auto factor = heat.factor(blurs[k] * blurs[k] / 4.0);
    for (int step = 0; step < 2; ++step)
      factor->step(values.data()->data(), scratch.data(), channels);
    for (std::size_t v = 0; v < n; ++v)
      values[v].segment<5>(first_loop) = signals.values[v].segment<5>(first_loop);
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

const std::vector<Signal>& SurfaceSignals::seen_by(double edge) const {
  for (std::size_t k = 0; k < blurs.size(); ++k) {
    if (blurs[k] <= edge / 2.0) return blurred[k];
  }
  return values;
}

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
  parallel_for(ctx, 2, 1, [&](std::size_t k) {
    SurfaceSignals& signals = k == 0 ? pair.a : pair.b;
    const ClosedSurface& closed = k == 0 ? closed_a : closed_b;
    blur(signals, k == 0 ? a.topology() : b.topology(), closed);
    extend_into_fillings(signals.values, closed);
    for (std::vector<Signal>& values : signals.blurred) extend_into_fillings(values, closed);
  });
  return pair;
}

}  // namespace kinemesh::full_matching
