#include "reconstruct/carry.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <string>

#include "config/error.h"
#include "config/parallel.h"

namespace kinemesh {
namespace {

using Row = Eigen::RowVector3d;

Row row(const FrameView& frame, VertexIndex v) { return frame.row(v).cast<double>(); }

/// Twice the area times the unit normal of every face.
std::vector<Row> face_normals(const Topology& topology, const FrameView& frame) {
  std::vector<Row> normals;
  normals.reserve(topology.face_count());
  for (const auto& [a, b, c] : topology.faces()) {
    const Row p = row(frame, a);
    normals.push_back((row(frame, b) - p).cross(row(frame, c) - p));
  }
  return normals;
}

/// A face is turned against the faces across its edges.
bool is_turned(const Topology& topology, const std::vector<Row>& normals, FaceIndex f) {
  Row around = Row::Zero();
  for (HalfedgeIndex h = 3 * f; h < 3 * f + 3; ++h) {
    const HalfedgeIndex twin = topology.twin(h);
    if (twin != invalid_index) around += normals[twin / 3].normalized();
  }
  return normals[f].dot(around) < 0;
}

/// Height over longest edge: 0 for a degenerate triangle, .87 for an equilateral one.
double relative_height(const Topology& topology, const FrameView& frame, const Row& normal,
                       FaceIndex f) {
  const auto& [a, b, c] = topology.faces()[f];
  const double longest = std::max({(row(frame, a) - row(frame, b)).squaredNorm(),
                                   (row(frame, b) - row(frame, c)).squaredNorm(),
                                   (row(frame, c) - row(frame, a)).squaredNorm()});
  return longest > 0 ? normal.norm() / longest : 0.0;
}

/// What every frame is compared with.
struct Reference {
  std::vector<uint8_t> turned, degenerate;  ///< per face
  std::vector<double> length;               ///< per edge, mm
};

Reference measure_reference(const Topology& topology, const FrameView& frame, double height) {
  Reference reference;
  const auto normals = face_normals(topology, frame);
  for (FaceIndex f = 0; f < topology.face_count(); ++f) {
    reference.turned.push_back(is_turned(topology, normals, f) ? 1 : 0);
    reference.degenerate.push_back(relative_height(topology, frame, normals[f], f) < height ? 1
                                                                                            : 0);
  }
  for (const Edge& e : topology.edges()) {
    reference.length.push_back((row(frame, e.vertices[0]) - row(frame, e.vertices[1])).norm());
  }
  return reference;
}

FrameQuality measure(const Topology& topology, const Reference& reference, const FrameView& frame,
                     double height) {
  FrameQuality quality;
  const auto normals = face_normals(topology, frame);
  for (FaceIndex f = 0; f < topology.face_count(); ++f) {
    if (reference.turned[f] == 0 && is_turned(topology, normals, f)) ++quality.flipped;
    if (reference.degenerate[f] == 0 && relative_height(topology, frame, normals[f], f) < height) {
      ++quality.degenerate;
    }
  }
  double squares = 0.0;
  std::size_t counted = 0;
  for (std::size_t e = 0; e < topology.edge_count(); ++e) {
    if (reference.length[e] <= 0) continue;
    const auto& [a, b] = topology.edges()[e].vertices;
    const double ratio = (row(frame, a) - row(frame, b)).norm() / reference.length[e];
    quality.stretch_min = counted == 0 ? static_cast<float>(ratio)
                                       : std::min(quality.stretch_min, static_cast<float>(ratio));
    quality.stretch_max = counted == 0 ? static_cast<float>(ratio)
                                       : std::max(quality.stretch_max, static_cast<float>(ratio));
    squares += (ratio - 1) * (ratio - 1);
    ++counted;
  }
  if (counted > 0)
    quality.stretch_rms = static_cast<float>(std::sqrt(squares / static_cast<double>(counted)));
  return quality;
}

void check_sample(const MarkerSequence& take, std::size_t f, std::size_t m) {
  const auto p = take.position(f, m);
  if (take.valid(f, m) && p.allFinite()) return;
  throw InputError({.what = take.valid(f, m) ? "the sample is not finite"
                                             : "the sample is not measured and not filled",
                    .file = take.origin.path,
                    .marker = take.markers()[m].label,
                    .frame = take.first_frame + static_cast<int64_t>(f),
                    .remedy = "Fill the gaps of the take first, or leave this marker out"});
}

CarrySummary summarise(const std::vector<FrameQuality>& quality, std::size_t vertex_count) {
  CarrySummary summary;
  for (std::size_t f = 0; f < quality.size(); ++f) {
    const FrameQuality& q = quality[f];
    summary.frames_with_flips += q.flipped > 0 ? 1 : 0;
    summary.filled_samples += q.filled;
    summary.stretch_min = std::min(summary.stretch_min, q.stretch_min);
    summary.stretch_max = std::max(summary.stretch_max, q.stretch_max);
    if (q.flipped + q.degenerate > summary.worst_count) {
      summary.worst_count = q.flipped + q.degenerate;
      summary.worst_frame = f;
    }
  }
  summary.samples = quality.size() * vertex_count;
  return summary;
}

std::vector<VertexIndex> flip_suspects(const AnimatedMesh& mesh, const Reference& reference,
                                       const std::vector<FrameQuality>& quality) {
  const Topology& topology = mesh.topology();
  std::vector<std::size_t> times(topology.vertex_count(), 0);
  for (std::size_t f = 0; f < quality.size(); ++f) {
    if (quality[f].flipped == 0) continue;
    const auto normals = face_normals(topology, mesh.frame(f));
    for (FaceIndex t = 0; t < topology.face_count(); ++t) {
      if (reference.turned[t] != 0 || !is_turned(topology, normals, t)) continue;
      for (const VertexIndex v : topology.faces()[t]) ++times[v];
    }
  }
  std::vector<VertexIndex> order(times.size());
  std::iota(order.begin(), order.end(), VertexIndex{0});
  std::ranges::stable_sort(order, std::greater{}, [&](VertexIndex v) { return times[v]; });
  std::erase_if(order, [&](VertexIndex v) {
    return times[v] == 0 || 2 * times[v] < *std::ranges::max_element(times);
  });
  order.resize(std::min<std::size_t>(order.size(), 4));
  return order;
}

}  // namespace

void CarryOptions::declare(ParameterSet& p) {
  p.group("quality", "Quality of the mesh in every frame");
  p.number(
      "degenerate-height", degenerate_height,
      {.min = 0.0,
       .max = 0.5,
       .help = "a triangle counts as degenerate when its height is less than this share of its "
               "longest edge"});
}

FrameQuality frame_quality(const Topology& topology, FrameView reference, FrameView frame,
                           const CarryOptions& options) {
  options.validate();
  return measure(topology, measure_reference(topology, reference, options.degenerate_height), frame,
                 options.degenerate_height);
}

CarryResult carry_topology(std::shared_ptr<const Topology> topology, const MarkerSequence& take,
                           std::size_t reference, const CarryOptions& options,
                           const RunContext& ctx) {
  options.validate();
  if (!topology) throw InternalError("carry_topology() needs a topology");
  const std::size_t vertices = take.marker_count();
  if (topology->vertex_count() != vertices) {
    throw InputError({.what = "the topology has " + std::to_string(topology->vertex_count()) +
                              " vertices, but the take has " + std::to_string(vertices) +
                              " markers"});
  }
  if (reference >= take.frame_count())
    throw InternalError("the reference frame lies outside the take");

  CarryResult result;
  AnimatedMesh& mesh = result.animation;
  mesh = AnimatedMesh(std::move(topology), take.frame_count(), take.rate_hz);
  mesh.first_frame = take.first_frame;
  mesh.events = take.events;
  for (const Marker& marker : take.markers()) mesh.vertex_names.push_back(marker.label);
  mesh.add_filled();
  if (!take.uncertainty().empty()) {
    mesh.add_uncertainty();
    std::ranges::copy(take.uncertainty(), mesh.uncertainty().begin());
  }
  std::ranges::copy(take.positions(), mesh.positions().begin());

  const FrameView rest = std::as_const(mesh).frame(reference);
  const Reference base = measure_reference(mesh.topology(), rest, options.degenerate_height);
  result.quality.resize(take.frame_count());
  parallel_for(ctx, take.frame_count(), 64, [&](std::size_t f) {
    uint32_t filled = 0;
    for (std::size_t m = 0; m < vertices; ++m) {
      check_sample(take, f, m);
      const bool estimated = take.filled(f, m);
      mesh.filled()[take.sample(f, m)] = estimated ? 1 : 0;
      filled += estimated ? 1 : 0;
    }
    result.quality[f] =
        measure(mesh.topology(), base, std::as_const(mesh).frame(f), options.degenerate_height);
    result.quality[f].filled = filled;
  });
  result.summary = summarise(result.quality, vertices);
  result.summary.flip_suspects = flip_suspects(mesh, base, result.quality);
  return result;
}

}  // namespace kinemesh
