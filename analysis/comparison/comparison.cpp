#include "analysis/comparison/comparison.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "analysis/comparison/course.h"
#include "analysis/comparison/shape_difference.h"
#include "analysis/motion_curves.h"
#include "config/error.h"
#include "config/text.h"
#include "mesh/geodesics/geodesics.h"
#include "mesh/surface_map_io.h"

namespace kinemesh {
namespace {

constexpr double most_size_ratio = 5.0;
constexpr std::size_t most_doubtful = 5;
constexpr float missing = std::numeric_limits<float>::quiet_NaN();

/// Every vertex to the one with its number.
SurfaceMap by_number(const Topology& topology) {
  SurfaceMap map;
  for (VertexIndex v = 0; v < topology.vertex_count(); ++v) {
    map.points.push_back(topology.faces_of(v).empty() ? SurfacePoint{} : vertex_point(topology, v));
  }
  map.confidence.assign(map.points.size(), 1.0);
  return map;
}

/// Where A's vertices lie on B, however it is found.
void correspond(Comparison& c, const AnimatedMesh& a, const AnimatedMesh& b,
                const ComparisonOptions& options, const RunContext& ctx,
                const std::vector<LandmarkPair>& landmarks, const SurfaceMap* map) {
  if (map != nullptr) {
    check_surface_map(*map, a.topology(), b.topology());
    c.forward = *map;
    c.correspondence = "read from the map that was given";
  } else if (a.topology() == b.topology() && landmarks.empty()) {
    c.forward = c.reverse = by_number(a.topology());
    c.correspondence = "vertex by vertex, as both meshes have the same triangles";
  } else if (!a.vertex_names.empty() && a.vertex_names == b.vertex_names && landmarks.empty()) {
    c.forward = by_number(b.topology());
    c.reverse = by_number(a.topology());
    c.correspondence = "marker by marker, as both have the same markers";
  } else {
    FullMatching m = match_surfaces(a, b, options.matching, ctx, landmarks);
    c.forward = std::move(m.forward);
    c.reverse = std::move(m.reverse);
    c.poor = m.poor;
    if (m.poor) c.warnings.push_back(m.warning);
    c.correspondence =
        "dense matching of the surfaces, by motion (agreement " +
        format_fixed(m.agreement.strain, 2) + "), shape (" + format_fixed(m.agreement.normals, 2) +
        ") and holes (" + format_fixed(m.agreement.loops, 2) + "; 1 is perfect, 0 is chance)" +
        (landmarks.empty()
             ? ""
             : ", through " + count_of(landmarks.size(), "landmark") + " given by hand");
    if (m.unmapped_source > 0) {
      c.warnings.push_back(count_of(m.unmapped_source, "vertex", "vertices") +
                           " of A have no counterpart on B, as they fall into a hole of it");
    }
  }
  if (c.forward.confidence.empty()) c.forward.confidence.assign(c.forward.points.size(), 1.0);
}

/// The least confident places, each far from the others.
void find_doubtful(Comparison& c, const ComparisonOptions& options) {
  std::vector<VertexIndex> order(c.forward.points.size());
  std::iota(order.begin(), order.end(), VertexIndex{0});
  std::ranges::stable_sort(order, {}, [&](VertexIndex v) { return c.forward.confidence[v]; });
  double sum = 0.0, area = 0.0;
  for (std::size_t v = 0; v < order.size(); ++v) {
    sum += c.a.areas[v] * c.forward.confidence[v];
    area += c.a.areas[v];
  }
  c.mean_confidence = area > 0.0 ? sum / area : 0.0;
  for (const VertexIndex v : order) {
    if (c.forward.confidence[v] >= options.doubtful || c.doubtful.size() == most_doubtful) break;
    const bool apart = std::ranges::all_of(c.doubtful, [&](const DoubtfulPlace& d) {
      return (c.a.rest[d.source] - c.a.rest[v]).norm() > 0.15 * c.root_area_mm;
    });
    if (apart) c.doubtful.push_back({v, c.forward.points[v], c.forward.confidence[v]});
  }
}

bool moves(const AnimatedMesh& mesh) { return mesh.frame_count() > 1 && mesh.rate_hz > 0.0; }

std::optional<DeformationResult> deformation(const AnimatedMesh& mesh,
                                             const std::vector<Eigen::Vector3d>& rest,
                                             const DeformationOptions& options,
                                             const RunContext& ctx) {
  if (mesh.frame_count() < 2) return {};
  Mesh pose{mesh.shared_topology(), {}, {}};
  for (const Eigen::Vector3d& p : rest) pose.positions.push_back(p.cast<float>());
  return deformation_of(mesh, options, ctx, &pose);
}

void align(Comparison& c, const AnimatedMesh& a, const std::optional<DeformationResult>& of_a,
           const AnimatedMesh& b, const std::optional<DeformationResult>& of_b,
           const TimeWarpOptions& options, const RunContext& ctx) {
  if (!of_a || !of_b || !moves(a) || !moves(b)) {
    c.warnings.push_back(
        "at least one of both does not move or has no frame rate: shapes are "
        "compared, motions are not");
    return;
  }
  try {
    c.warp = align_in_time(motion_signature(a, *of_a), motion_signature(b, *of_b), options, ctx);
  } catch (const NoResultError& e) {
    c.warnings.push_back(std::string("motions are not compared: ") + e.details().what);
  }
}

/// B's frame at each frame of A; without an alignment its rest.
std::vector<double> frames_of_b(const Comparison& c) {
  std::vector<double> frames(c.a.frame_count, 0.0);
  if (!c.warp) return frames;
  for (std::size_t f = 0; f < frames.size(); ++f) frames[f] = c.warp->b_of_a_s[f] * c.b.rate_hz;
  return frames;
}

/// `turn`: from B's space to A's, with the scale of the alignment.
void compare_motion(Comparison& c, const Topology& topology_b, const Eigen::Matrix3d& turn) {
  const std::vector<double> frames = frames_of_b(c);
  c.b_displacement = comparison::brought_to(c.b.displacement, 3, c.forward, topology_b, frames);
  c.b_strain = comparison::brought_to(c.b.strain, 1, c.forward, topology_b, frames);
  const std::size_t n = c.forward.points.size();
  c.motion_difference = c.strain_difference = {n, std::vector<float>(n * frames.size(), missing)};
  for (std::size_t k = 0; k < n * frames.size(); ++k) {
    Eigen::Map<Eigen::Vector3f> of_b(c.b_displacement.values.data() + 3 * k);
    const Eigen::Map<const Eigen::Vector3f> of_a(c.a.displacement.values.data() + 3 * k);
    of_b = (turn.cast<float>() * of_b).eval();
    c.motion_difference.values[k] = (of_b - of_a).norm();
    c.strain_difference.values[k] = c.b_strain.values[k] - c.a.strain.values[k];
  }
}

double root_area(const Course& course) {
  return std::sqrt(std::accumulate(course.areas.begin(), course.areas.end(), 0.0));
}

void check_sizes(const Comparison& c, const ComparisonOptions& options) {
  const double ratio = root_area(c.b) / root_area(c.a);
  if (options.alignment == ShapeAlignment::similarity ||
      (ratio < most_size_ratio && ratio > 1.0 / most_size_ratio)) {
    return;
  }
  throw NoResultError({.what = "B is " + format_number(std::round(1000.0 * ratio) / 1000.0) +
                               " times as large as A: differences in mm would mean nothing",
                       .remedy = "Check the units of both files, or compare shapes without their "
                                 "size with --alignment similarity"});
}

}  // namespace

void ComparisonOptions::declare(ParameterSet& p) {
  p.group("comparison", "Comparison");
  p.choice("alignment", alignment,
           {{ShapeAlignment::rigid, "rigid", "B is turned and moved onto A"},
            {ShapeAlignment::similarity, "similarity", "and scaled"}},
           "How B's rest pose is brought onto A's before shapes are compared");
  p.number("rest-window", rest_window_s,
           {.unit = "s",
            .min = 0,
            .max = 10,
            .help = "The rest pose is the mean over so long from the first frame"});
  p.number("doubtful", doubtful,
           {.min = 0, .max = 1, .help = "Confidence below which a place is called doubtful"});
  matching.declare(p);
  warp.declare(p);
}

Comparison compare_performances(const AnimatedMesh& a, const AnimatedMesh& b,
                                const ComparisonOptions& options, const RunContext& ctx,
                                const std::vector<LandmarkPair>& landmarks, const SurfaceMap* map) {
  options.validate();
  if (a.frame_count() == 0 || b.frame_count() == 0) {
    throw InputError({.what = "an animation has no frames"});
  }
  Comparison c;
  auto rest_a = comparison::rest_of(a, options.rest_window_s);
  auto rest_b = comparison::rest_of(b, options.rest_window_s);
  const auto of_a = deformation(a, rest_a, options.deformation, ctx.part(0.0, 0.15, "strain of A"));
  const auto of_b = deformation(b, rest_b, options.deformation, ctx.part(0.15, 0.3, "strain of B"));
  c.a = comparison::course_of(a, std::move(rest_a), of_a ? &*of_a : nullptr, options.deformation);
  c.b = comparison::course_of(b, std::move(rest_b), of_b ? &*of_b : nullptr, options.deformation);
  c.root_area_mm = root_area(c.a);
  check_sizes(c, options);
  correspond(c, a, b, options, ctx.part(0.3, 0.8, "correspondence"), landmarks, map);
  align(c, a, of_a, b, of_b, options.warp, ctx.part(0.8, 0.9, "alignment in time"));
  find_doubtful(c, options);
  const comparison::ShapeFit fit =
      comparison::fit_shape(c, b.topology(), options.alignment == ShapeAlignment::similarity);
  c.scale = fit.scale;
  c.shape_mm = comparison::signed_distances(c, a.topology(), b.topology(), fit);
  compare_motion(c, b.topology(), fit.scale * fit.turn);
  c.turn = fit.turn;
  ctx.progress(1.0);
  return c;
}

}  // namespace kinemesh
