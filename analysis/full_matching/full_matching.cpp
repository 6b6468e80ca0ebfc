#include "analysis/full_matching/full_matching.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "analysis/full_matching/anchors.h"
#include "analysis/full_matching/composed_map.h"
#include "analysis/full_matching/looseness.h"
#include "analysis/full_matching/start_rotation.h"
#include "config/error.h"
#include "config/text.h"
#include "mesh/geodesics/geodesics.h"

namespace kinemesh {

namespace {

using full_matching::Anchor;
using full_matching::channels;
using full_matching::compare_signals;
using full_matching::ComposedMap;
using full_matching::first_loop;
using full_matching::first_strain;
using full_matching::first_tangent;
using full_matching::Signal;
using full_matching::SignalPair;
using full_matching::start_rotation;
using full_matching::SurfaceSignals;
using full_matching::Target;

constexpr std::size_t coarse_vertices = 500,
                      with_landmarks = 150;  // of the coarsest mesh, at least
constexpr double growth = 1.4;               // of the vertices from level to level
// A sweep moves each vertex as its neighbours then lie: what is wrong on the whole surface takes
// many to be mended, and they must not end early.
constexpr int coarse_sweeps = 200, level_sweeps = 12, final_sweeps = 8;
constexpr double settled = 1e-5;        // of the energy: a sweep that lowers it by less is the last
constexpr double coarse_blur = 1.0;     // of signals while the mesh is coarse, in its edges
constexpr double tangent_weight = 2.0;  // of the direction along loops
constexpr int landmark_refinements = 4;
constexpr double poor_agreement = 0.35;
constexpr double loose = 0.02;      // √area: drift at which confidence is halved
constexpr double slight = 0.4;      // of the differences of signals in the doubt
constexpr double most_lost = 0.15;  // of a surface, in holes of the other

ClosedSurface closed_at_rest(const AnimatedMesh& mesh) {
  if (mesh.frame_count() == 0) throw InputError({.what = "the animation has no frames"});
  std::vector<Eigen::Vector3d> positions;
  for (VertexIndex v = 0; v < mesh.vertex_count(); ++v) {
    positions.push_back(mesh.position(0, v).cast<double>());
  }
  return close_holes(mesh.topology(), positions);
}

/// Errors say which surface they are about.
template <class Make>
auto telling(const char* which, Make&& make) {
  try {
    return make();
  } catch (const NoResultError& e) {
    ErrorDetails details = e.details();
    details.what = std::string("the ") + which + ": " + details.what;
    throw NoResultError(details);
  }
}

struct Moments {
  Signal mean = Signal::Zero(), variance = Signal::Zero();
};
Moments moments_of(const SurfaceSignals& signals) {
  Moments m;
  Signal squares = Signal::Zero();
  for (std::size_t v = 0; v < signals.values.size(); ++v) {
    const auto area = static_cast<float>(signals.areas[v]);
    m.mean += area * signals.values[v];
    squares += area * signals.values[v].cwiseAbs2();
  }
  m.variance = squares - m.mean.cwiseAbs2();
  return m;
}

/// Mean squared difference between places taken at random.
Signal chance_of(const SignalPair& pair) {
  const Moments a = moments_of(pair.a), b = moments_of(pair.b);
  return a.variance + b.variance + (a.mean - b.mean).cwiseAbs2();
}

SignalAgreement agreement_of(const ComposedMap& map, const SignalPair& pair) {
  Signal sum = Signal::Zero();
  double area = 0.0;
  for (const VertexIndex v : map.alive()) {
    sum += static_cast<float>(pair.a.areas[v]) * map.difference(v).cwiseAbs2();
    area += pair.a.areas[v];
  }
  sum /= static_cast<float>(area);
  const Signal chance = chance_of(pair);
  const auto part = [](float difference, float by_chance) {
    return by_chance > 0.0F ? std::clamp(1.0 - difference / by_chance, 0.0, 1.0) : 0.0;
  };
  constexpr int strains = channels - first_strain;
  return {.strain =
              pair.has_strain ? part(sum.tail<strains>().sum(), chance.tail<strains>().sum()) : 0.0,
          .normals = part(sum.head<3>().sum(), chance.head<3>().sum()),
          .loops = pair.has_loops
                       ? part(sum.segment<2>(first_loop).sum(), chance.segment<2>(first_loop).sum())
                       : 0.0};
}

/// What agrees hardly better than chance counts little. Loops are narrow, so that at the start
/// they may miss each other though they belong together: their weight stays.
Signal weights_of(const FullMatchingOptions& options, const SignalAgreement& agreement) {
  Signal weights;
  const auto trust = [](double a) { return a * a; };
  weights.head<3>().setConstant(
      static_cast<float>(options.normal_weight * trust(agreement.normals)));
  weights.segment<2>(first_loop).setConstant(static_cast<float>(options.loop_weight));
  weights.segment<3>(first_tangent).setConstant(static_cast<float>(tangent_weight));
  weights.tail<channels - first_strain>().setConstant(
      static_cast<float>(options.strain_weight * trust(agreement.strain)));
  return weights;
}

void sweep(ComposedMap& map, int most, double smoothness, const RunContext& ctx) {
  map.fit_deformation(smoothness);
  const double little = settled * map.energy();
  for (int k = 0; k < most; ++k) {
    ctx.check_cancelled();
    if (map.sweep() < little) break;
    if (k % 8 != 7) continue;
    map.fit_rotation();
    map.fit_deformation(smoothness);
  }
}

/// From the coarse map to the finished one.
void descend(ComposedMap& map, const SignalPair& pair, const FullMatchingOptions& options,
             const RunContext& ctx) {
  map.set_detail(coarse_blur);
  map.fit_rotation();
  map.set_weights(weights_of(options, {1.0, 1.0, 1.0}), options.keep_shape);
  sweep(map, coarse_sweeps, 0.0, ctx);
  sweep(map, coarse_sweeps / 2, options.smooth_weight, ctx);
  while (!map.complete()) {
    map.fit_rotation();
    map.set_weights(weights_of(options, agreement_of(map, pair)), options.keep_shape);
    map.refine(static_cast<std::size_t>(growth * static_cast<double>(map.vertex_count())));
    map.set_detail(coarse_blur);
    sweep(map, level_sweeps, options.smooth_weight, ctx);
  }
  map.fit_rotation();
  map.set_weights(weights_of(options, agreement_of(map, pair)), options.keep_shape);
  sweep(map, final_sweeps, options.smooth_weight, ctx);
}

/// Brings a coarse map to the landmarks; those that find no way get more vertices around them.
/// Returns those that cannot be met.
std::vector<std::size_t> meet(ComposedMap& map, std::span<const Anchor> anchors,
                              const RunContext& ctx) {
  std::vector<std::size_t> away = map.meet(anchors, ctx);
  for (int k = 0; k < landmark_refinements && !away.empty() && !map.complete(); ++k) {
    map.refine(static_cast<std::size_t>(growth * static_cast<double>(map.vertex_count())));
    away = map.meet(anchors, ctx);
  }
  return away;
}

/// A laid over B by a rotation of its sphere, then brought to the landmarks while it is coarse,
/// then refined. How coarse decides whether all landmarks find their way: several levels are tried.
std::unique_ptr<ComposedMap> lay_over(const ClosedSurface& a, const SignalPair& pair,
                                      const std::vector<Eigen::Vector3d>& start, const Target& rest,
                                      std::span<const Anchor> anchors,
                                      std::span<const LandmarkPair> landmarks,
                                      const FullMatchingOptions& options, const RunContext& ctx) {
  std::vector<uint8_t> keep(anchors.empty() ? 0 : start.size(), 0);
  for (const Anchor& anchor : anchors) keep[anchor.vertex] = 1;
  std::vector<std::size_t> fewest_away;
  std::size_t last = 0;
  for (const std::size_t times : {4, 8, 16, 2, 32}) {
    const std::size_t count =
        anchors.empty() ? coarse_vertices : std::max(with_landmarks, times * anchors.size());
    if (count == last) continue;
    last = count;
    try {
      auto map = std::make_unique<ComposedMap>(a, pair.a, start, rest);
      map->coarsen(count, keep, ctx);
      const std::vector<std::size_t> away = meet(*map, anchors, ctx);
      if (away.empty()) {
        descend(*map, pair, options, ctx);
        return map;
      }
      if (fewest_away.empty() || away.size() < fewest_away.size()) fewest_away = away;
    } catch (const NoResultError&) {
      if (anchors.empty()) throw;
    }
  }
  full_matching::refuse_landmarks(landmarks, fewest_away);
}

/// The nearest point on the boundary loops, and its distance.
struct RimPoint {
  SurfacePoint point;
  double distance = std::numeric_limits<double>::infinity();
};
RimPoint nearest_on_rims(const Eigen::Vector3d& p, const ClosedSurface& closed,
                         const std::vector<Eigen::Vector3d>& positions) {
  RimPoint best;
  for (const Edge& edge : closed.topology->edges()) {
    const HalfedgeIndex inside = closed.filling_face(edge.left / 3) ? edge.right : edge.left;
    if (closed.filling_face(edge.left / 3) == closed.filling_face(edge.right / 3)) continue;
    const Eigen::Vector3d &a = positions[closed.topology->from(inside)],
                          &b = positions[closed.topology->to(inside)];
    const double t = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
    const double distance = (a + t * (b - a) - p).norm();
    if (distance >= best.distance) continue;
    best.distance = distance;
    best.point = {.face = inside / 3};
    best.point.weights[inside % 3] = 1.0 - t;
    best.point.weights[(inside + 1) % 3] = t;
  }
  return best;
}

struct Leaving {
  std::size_t unmapped = 0, snapped = 0;
};

/// Images in fillings go to the loop when it is near, and are marked as unmapped otherwise.
Leaving leave_fillings(SurfaceMap& map, const ClosedSurface& closed,
                       const std::vector<Eigen::Vector3d>& positions, double reach) {
  Leaving leaving;
  for (std::size_t v = 0; v < map.points.size(); ++v) {
    SurfacePoint& point = map.points[v];
    if (!closed.filling_face(point.face)) continue;
    const RimPoint rim =
        nearest_on_rims(position_of(point, *closed.topology, positions), closed, positions);
    const bool near = rim.distance <= reach;
    map.confidence[v] *= near ? 0.5 : 0.0;
    point = near ? rim.point : SurfacePoint{};
    ++(near ? leaving.snapped : leaving.unmapped);
  }
  return leaving;
}

/// How doubtful the place of each vertex of A is: what differs there, and how much is stretched.
std::vector<double> doubts_of(ComposedMap& map, const SignalPair& pair,
                              const ClosedSurface& closed) {
  const Signal chance = chance_of(pair);
  const float normals = chance.head<3>().sum(),
              strains = chance.tail<channels - first_strain>().sum();
  std::vector<double> doubts(closed.positions.size(), 0.0);
  for (VertexIndex v = 0; v < closed.surface_vertices; ++v) {
    const Signal square = map.difference(v).cwiseAbs2();
    double doubt = square.head<3>().sum() / normals;
    if (pair.has_strain) doubt += 0.5 * square.tail<channels - first_strain>().sum() / strains;
    doubt += 0.5 * std::min(4.0, map.distortion_at(v) - 1.0);
    doubts[v] = std::max(0.0, doubt);
  }
  return full_matching::smoothed(std::move(doubts), *closed.topology, 4);
}

double overall_trust(const SignalAgreement& agreement, const SignalPair& pair) {
  const double best = std::max({pair.has_strain ? agreement.strain : 0.0, agreement.normals,
                                pair.has_loops ? agreement.loops * 0.8 : 0.0});
  return best;
}

/// The larger share of either surface that falls into holes of the other.
double lost_share(const FullMatching& result) {
  const auto share = [](std::size_t part, std::size_t all) {
    return static_cast<double>(part) / static_cast<double>(std::max<std::size_t>(1, all));
  };
  return std::max(share(result.unmapped_source, result.forward.points.size()),
                  share(result.unmapped_target, result.reverse.points.size()));
}

void judge(FullMatching& result, const SignalPair& pair) {
  const double trust = overall_trust(result.agreement, pair), lost = lost_share(result);
  result.poor = trust < poor_agreement || result.mean_distortion > 6.0 || lost > most_lost;
  if (!result.poor) return;
  if (lost > most_lost) {
    result.warning = "the map is poor: " + format_fixed(100.0 * lost, 0) +
                     " % of one surface falls into holes of the other, as if they showed different "
                     "parts of a body; cut both to the same part";
    return;
  }
  result.warning =
      "the map is poor: places that it joins hardly have more in common than places taken at "
      "random (strain " +
      format_fixed(result.agreement.strain, 2) + ", normals " +
      format_fixed(result.agreement.normals, 2) + ", loops " +
      format_fixed(result.agreement.loops, 2) + " of 1; distortion " +
      format_fixed(result.mean_distortion, 2) +
      ", 1 being none); give landmarks, or check that both show the same part of a body";
  if (!pair.has_strain) result.warning += "; there is no motion to compare";
}

/// B's vertices on A.
SurfaceMap reverse_of(const SurfaceOverlay& overlay, const std::vector<double>& confidence) {
  const Topology& to = *overlay.source().topology;
  SurfaceMap reverse;
  for (VertexIndex v = 0; v < overlay.target().surface_vertices; ++v) {
    const SurfacePoint point =
        overlay.to_closed_source(vertex_point(*overlay.target().topology, v));
    double sure = 0.0;
    for (std::size_t c = 0; c < 3; ++c)
      sure += point.weights[c] * confidence[to.faces()[point.face][c]];
    reverse.points.push_back(point);
    reverse.confidence.push_back(std::clamp(sure, 0.0, 1.0));
  }
  return reverse;
}

/// Of A's vertices. Moves the map.
std::vector<double> confidence_of(ComposedMap& map, const SignalPair& pair, const ClosedSurface& a,
                                  const FullMatchingOptions& options,
                                  const SignalAgreement& agreement, const RunContext& ctx) {
  const double trust = overall_trust(agreement, pair);
  std::vector<double> confidence = doubts_of(map, pair, a);
  const std::vector<double> looseness =
      full_matching::looseness_of(map, a, weights_of(options, agreement), options.keep_shape, ctx);
  for (std::size_t v = 0; v < confidence.size(); ++v) {
    const double doubt = looseness[v] / loose + slight * confidence[v];
    confidence[v] = std::clamp(trust / (1.0 + doubt), 0.0, 1.0);
  }
  return confidence;
}

void collect(FullMatching& result, ComposedMap& map, const SignalPair& pair,
             const FullMatchingOptions& options, const RunContext& ctx) {
  const ClosedSurface &a = result.overlay->source(), &b = result.overlay->target();
  result.agreement = agreement_of(map, pair);
  for (VertexIndex v = 0; v < a.surface_vertices; ++v) {
    result.forward.points.push_back(map.image(v));
    result.distortion.push_back(map.distortion_at(v));
    result.mean_distortion += pair.a.areas[v] * result.distortion.back();
  }
  const std::vector<double> confidence =
      confidence_of(map, pair, a, options, result.agreement, ctx);
  result.forward.confidence.assign(
      confidence.begin(), confidence.begin() + static_cast<std::ptrdiff_t>(a.surface_vertices));
  result.reverse = reverse_of(*result.overlay, confidence);
  result.exactly = there_and_back(*result.overlay);
  const Leaving forward = leave_fillings(result.forward, b, pair.b.positions, options.snap);
  const Leaving reverse = leave_fillings(result.reverse, a, pair.a.positions, options.snap);
  result.unmapped_source = forward.unmapped;
  result.snapped_source = forward.snapped;
  result.unmapped_target = reverse.unmapped;
  result.snapped_target = reverse.snapped;
  result.by_vertices = there_and_back(result.forward, result.reverse, a, b);
  judge(result, pair);
}

}  // namespace

void FullMatchingOptions::declare(ParameterSet& p) {
  p.group("matching", "Dense matching");
  p.number("keep-shape", keep_shape,
           {.min = 1e-3, .max = 1e3, .help = "How much the map resists stretching"});
  p.number("strain-weight", strain_weight,
           {.min = 0, .max = 1e3, .help = "How much equal strain over time counts"});
  p.number("normal-weight", normal_weight,
           {.min = 0, .max = 1e3, .help = "How much equal normals count"});
  p.number("loop-weight", loop_weight,
           {.min = 0, .max = 1e3, .help = "How much equal nearness of holes and rim counts"});
  p.number("smooth-weight", smooth_weight,
           {.min = 0,
            .max = 1e4,
            .help = "How much a smooth deformation of space that nearly fits counts"});
  p.number("strain-instants", strain_instants,
           {.min = 2, .max = 200, .help = "Instants at which the motions are compared"});
  p.number("snap", snap,
           {.unit = "√area",
            .min = 0,
            .max = 1,
            .help = "Vertices that fall into a hole of the other surface go to its edge when it "
                    "is this near, and are unmapped otherwise"});
  p.number("rotations", rotations,
           {.min = 1, .max = 100000, .help = "Rotations of the sphere that are tried"});
  sphere.declare(p);
}

FullMatching match_surfaces(const AnimatedMesh& source, const AnimatedMesh& target,
                            const FullMatchingOptions& options, const RunContext& ctx,
                            std::span<const LandmarkPair> landmarks) {
  options.validate();
  const ClosedSurface a = telling("source", [&] { return closed_at_rest(source); });
  const ClosedSurface b = telling("target", [&] { return closed_at_rest(target); });
  const SphericalMap sphere_a = telling("source", [&] {
    return map_to_sphere(*a.topology, a.positions, options.sphere, ctx.part(0.0, 0.2, "source"));
  });
  const SphericalMap sphere_b = telling("target", [&] {
    return map_to_sphere(*b.topology, b.positions, options.sphere, ctx.part(0.2, 0.4, "target"));
  });
  const std::vector<Anchor> anchors = full_matching::anchors_of(landmarks, a, b, sphere_b.points);
  const SignalPair pair =
      compare_signals(source, a, target, b, options.strain_instants, ctx.part(0.4, 0.6, "signals"));
  const SphereLocator locator(*b.topology, sphere_b.points);
  const Target rest{b, sphere_b.points, pair.b, locator};
  const Eigen::Matrix3d rotation =
      start_rotation(pair.a, sphere_a.points, rest, anchors, options.rotations, {},
                     ctx.part(0.6, 0.7, "rotation"));
  std::vector<Eigen::Vector3d> start;
  for (const Eigen::Vector3d& p : sphere_a.points) start.push_back((rotation * p).normalized());
  const auto map =
      lay_over(a, pair, start, rest, anchors, landmarks, options, ctx.part(0.7, 1.0, "descent"));
  FullMatching result;
  result.check = check_sphere(*a.topology, map->sphere());
  if (!result.check.valid()) {
    throw NoResultError({.what = "the map would fold",
                         .remedy = "Remesh the surfaces so that their triangles are less thin"});
  }
  result.sphere_distortion_source = sphere_a.distortion;
  result.sphere_distortion_target = sphere_b.distortion;
  result.overlay = std::make_shared<SurfaceOverlay>(a, map->sphere(), b, sphere_b.points);
  collect(result, *map, pair, options, ctx);
  for (const Anchor& anchor : anchors) result.forward.confidence[anchor.vertex] = 1.0;
  return result;
}

}  // namespace kinemesh
