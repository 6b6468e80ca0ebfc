#include "tests/support/ict_performer.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/closest_point.h"
#include "tests/support/random.h"
#include "tests/support/remesh.h"
#include "tests/support/synthetic_body.h"
#include "tests/support/true_surface.h"

namespace kinemesh::test {

namespace {

double rise(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return x * x * x * (10 + x * (6 * x - 15));
}

SurfacePoint surface_point(const ClosestPoint::Hit& hit) {
  return {hit.face, {hit.weights[0], hit.weights[1], hit.weights[2]}};
}

/// Families of expressions that go together; one of each is drawn for a motion.
const std::vector<std::vector<std::vector<std::string>>>& families() {
  static const std::vector<std::vector<std::vector<std::string>>> all{
      {{"mouthSmile_L", "mouthSmile_R"},
       {"mouthFrown_L", "mouthFrown_R"},
       {"mouthSmile_L"},
       {"mouthStretch_L", "mouthStretch_R"},
       {"mouthDimple_R"}},
      {{"jawOpen"}, {"jawLeft"}, {"jawForward"}, {"jawOpen", "jawRight"}},
      {{"browInnerUp_L", "browInnerUp_R", "browOuterUp_L", "browOuterUp_R"},
       {"browDown_L", "browDown_R"},
       {"browOuterUp_L"},
       {"browInnerUp_L", "browInnerUp_R"}},
      {{"mouthPucker"},
       {"mouthFunnel"},
       {"mouthLeft"},
       {"mouthUpperUp_L", "mouthUpperUp_R"},
       {"mouthLowerDown_L", "mouthLowerDown_R"}},
      {{"cheekPuff_L", "cheekPuff_R"},
       {"noseSneer_L", "noseSneer_R"},
       {"cheekRaiser_L", "cheekRaiser_R"},
       {"cheekPuff_R"}},
      {{"eyeBlink_L", "eyeBlink_R"}, {"eyeWide_L", "eyeWide_R"}, {"eyeSquint_L", "eyeSquint_R"}}};
  return all;
}

/// The shape on which another connectivity is made: lips apart, so that they are told apart.
std::vector<Eigen::Vector3d> parted(const IctActor& actor) {
  const IctModel& model = actor.model();
  std::vector<Eigen::Vector3d> positions = actor.rest();
  const auto& open = model.expressions[model.expression("jawOpen")];
  for (std::size_t v = 0; v < positions.size(); ++v) positions[v] += 0.3 * open[v].cast<double>();
  return positions;
}

struct Connectivity {
  std::shared_ptr<const Topology> topology;
  std::vector<SurfacePoint> on_model;
};

Connectivity own_connectivity(const IctModel& model) {
  Connectivity c{model.topology, {}};
  for (VertexIndex v = 0; v < model.neutral.size(); ++v) {
    const auto faces = model.topology->faces_of(v);
    if (faces.empty()) {
      c.on_model.push_back({});
      continue;
    }
    SurfacePoint p{faces.front(), {0, 0, 0}};
    const Triangle& face = model.topology->faces()[p.face];
    p.weights.at(static_cast<std::size_t>(std::find(face.begin(), face.end(), v) - face.begin())) =
        1;
    c.on_model.push_back(p);
  }
  return c;
}

Connectivity other_connectivity(const IctActor& actor, std::size_t vertices) {
  const auto& faces = actor.model().topology->faces();
  const std::vector<Eigen::Vector3d> shape = parted(actor);
  const Remeshed mesh = remesh(shape, faces, vertices);
  const ClosestPoint surface(shape, faces, 5);
  Connectivity c{Topology::create(mesh.positions.size(), mesh.faces), {}};
  for (const Eigen::Vector3d& p : mesh.positions) {
    c.on_model.push_back(surface_point(surface.closest(p)));
  }
  return c;
}

/// Per vertex of a performance, its place on the neutral face with parted lips.
std::vector<Eigen::Vector3d> canonical(const IctModel& model, const Performance& performance) {
  const std::vector<Eigen::Vector3d> shape = parted(IctActor(model, {.seed = 0}, {}));
  std::vector<Eigen::Vector3d> places;
  for (const SurfacePoint& p : performance.on_model) {
    places.push_back(p.valid() ? position_of(p, *model.topology, shape) : Eigen::Vector3d::Zero());
  }
  return places;
}

}  // namespace

IctMotion make_ict_motion(const IctModel& model, uint64_t seed, double duration_s) {
  Random random(seed * 86028121 + 17);
  IctMotion motion{{}, duration_s};
  std::vector<std::size_t> order{0, 1, 2, 3, 4, 5};
  random.shuffle(order);
  order.resize(5);
  for (std::size_t k = 0; k < order.size(); ++k) {
    const auto& family = families()[order[k]];
    const auto& group = family[random.below(family.size())];
    // The groups follow each other and overlap.
    const double centre =
        duration_s * (0.14 + 0.72 * (static_cast<double>(k) + random.uniform(-0.3, 0.3)) / 4);
    const double half = duration_s * random.uniform(0.09, 0.14);
    const double hold = duration_s * random.uniform(0.0, 0.03);
    const double strength = random.uniform(0.6, 1.0);
    for (const std::string& name : group) {
      motion.pulses.push_back({model.expression(name), strength, centre - half - hold,
                               centre - hold, centre + hold, centre + half + hold});
    }
  }
  return motion;
}

IctActor::IctActor(const IctModel& model, const IctSubject& subject, const IctMotion& motion,
                   const IctVariation& variation)
    : model_(model), motion_(motion), rest_(model.neutral) {
  if (subject.seed == 0) return;
  Random random(subject.seed * 49979687 + 23);
  for (const auto& identity : model.identities) {
    const double weight = subject.spread * random.normal();
    for (std::size_t v = 0; v < rest_.size(); ++v) rest_[v] += weight * identity[v].cast<double>();
  }
  const Eigen::Vector3d axis = random.normal3().normalized();
  const double angle = random.uniform(0.5, 1) * variation.turn_degrees * std::numbers::pi / 180;
  turn_ = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
  delay_ = random.uniform(0, variation.delay_s);
  for (IctPulse& p : motion_.pulses) p.strength *= 1 + random.uniform(-1, 1) * variation.scale;
}

std::vector<double> IctActor::strengths(double time_s) const {
  std::vector<double> strengths;
  const double t = time_s - delay_;
  for (const IctPulse& p : motion_.pulses) {
    const double up = p.peak_s > p.onset_s ? rise((t - p.onset_s) / (p.peak_s - p.onset_s)) : 1;
    const double down =
        p.end_s > p.release_s ? rise((t - p.release_s) / (p.end_s - p.release_s)) : 0;
    strengths.push_back(p.strength * (up - down));
  }
  return strengths;
}

std::vector<Eigen::Vector3d> IctActor::at(double time_s) const {
  const std::vector<double> weights = strengths(time_s);
  std::vector<Eigen::Vector3d> moved(rest_.size(), Eigen::Vector3d::Zero());
  for (std::size_t k = 0; k < weights.size(); ++k) {
    if (weights[k] == 0) continue;
    const auto& delta = model_.expressions[motion_.pulses[k].expression];
    for (std::size_t v = 0; v < moved.size(); ++v) moved[v] += weights[k] * delta[v].cast<double>();
  }
  for (std::size_t v = 0; v < moved.size(); ++v) moved[v] = rest_[v] + turn_ * moved[v];
  return moved;
}

Performance perform(const IctActor& actor, const PerformOptions& options) {
  Connectivity c = options.remesh_vertices == 0
                       ? own_connectivity(actor.model())
                       : other_connectivity(actor, options.remesh_vertices);
  const auto frames = static_cast<std::size_t>(std::lround(actor.duration_s() * options.rate_hz));
  Performance result{AnimatedMesh(c.topology, frames, options.rate_hz), std::move(c.on_model), {}};
  Random random(options.seed * 15487469 + 31);
  result.head_pose.assign(frames, Eigen::Isometry3d::Identity());
  if (options.head_degrees != 0 || options.head_mm != 0) {
    const TakeOptions wander{.rate_hz = options.rate_hz,
                             .head_degrees = options.head_degrees,
                             .head_mm = options.head_mm};
    result.head_pose = wandering_head(frames, wander, Random(random.bits()));
  }
  for (std::size_t f = 0; f < frames; ++f) {
    const auto shape = actor.at(static_cast<double>(f) / options.rate_hz);
    for (VertexIndex v = 0; v < result.on_model.size(); ++v) {
      const SurfacePoint& place = result.on_model[v];
      Eigen::Vector3d p =
          place.valid() ? position_of(place, *actor.model().topology, shape) : shape[v];
      if (options.noise_mm > 0) p += options.noise_mm * random.normal3();
      result.mesh.position(f, v) = (result.head_pose[f] * p).cast<float>();
    }
  }
  return result;
}

Performance perform(const IctModel& model, const IctSubject& subject, const IctMotion& motion,
                    const PerformOptions& options) {
  return perform(IctActor(model, subject, motion, options.variation), options);
}

SurfaceMap true_map(const IctModel& model, const Performance& source, const Performance& target) {
  SurfaceMap map;
  const bool same = target.mesh.shared_topology() == model.topology;
  if (same) {
    map.points = source.on_model;
    return map;
  }
  const ClosestPoint surface(canonical(model, target), target.mesh.topology().faces(), 5);
  const std::vector<Eigen::Vector3d> places = canonical(model, source);
  for (std::size_t v = 0; v < places.size(); ++v) {
    map.points.push_back(source.on_model[v].valid() ? surface_point(surface.closest(places[v]))
                                                    : SurfacePoint{});
  }
  return map;
}

std::vector<SurfacePoint> place_ict_markers(const IctModel& model, double least_mm, uint64_t seed) {
  const auto& p = model.neutral;
  const auto landmark = [&](std::size_t k) { return p[model.landmarks.at(k)]; };
  const double chin = landmark(8).y(), brow = landmark(19).y(), depth = landmark(1).z() + 28;
  const double half_width = 0.64 * std::abs(landmark(0).x());
  std::vector<Triangle> faces;
  std::vector<FaceIndex> origin;
  for (FaceIndex f = 0; f < model.topology->face_count(); ++f) {
    const Triangle& t = model.topology->faces()[f];
    const Eigen::Vector3d centre = (p[t[0]] + p[t[1]] + p[t[2]]) / 3;
    const Eigen::Vector3d normal = (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]).normalized();
    const bool in_face = centre.y() > chin - 1 && centre.y() < brow + 6 && centre.z() > depth &&
                         std::abs(centre.x()) < half_width;
    if (!in_face || normal.z() < 0.1) continue;
    faces.push_back(t);
    origin.push_back(f);
  }
  TrueSurface face{Topology::create(p.size(), faces), p, {}, {}};
  std::vector<Eigen::Vector3d> edges;  // of lips and lids
  for (const auto& loop : model.topology->boundary_loops()) {
    for (const VertexIndex v : loop) edges.push_back(p[v]);
  }
  std::vector<SurfacePoint> points;
  for (SurfacePoint point : scatter_markers(face, least_mm, seed)) {
    const Eigen::Vector3d q = position_of(point, *face.topology, p);
    const bool near_edge = std::any_of(
        edges.begin(), edges.end(), [&](const Eigen::Vector3d& e) { return (e - q).norm() < 3; });
    point.face = origin[point.face];
    if (!near_edge) points.push_back(point);
  }
  return points;
}

IctTake record_ict(const IctActor& actor, const std::vector<SurfacePoint>& points,
                   const TakeOptions& given) {
  TakeOptions options = given;
  options.duration_s = actor.duration_s();
  const auto frames = static_cast<std::size_t>(std::lround(options.duration_s * options.rate_hz));
  Random seeds(options.seed * 6700417 + 11);
  IctTake take{{}, {}, points, wandering_head(frames, options, Random(seeds.bits())), {}, {}};
  std::vector<Marker> markers;
  for (std::size_t m = 0; m < points.size(); ++m) {
    Marker marker;
    const std::string number = std::to_string(m + 1);
    marker.label = "M" + std::string(number.size() < 3 ? 3 - number.size() : 0, '0') + number;
    marker.subject = options.subject;
    markers.push_back(std::move(marker));
  }
  const auto true_markers = [&](std::size_t f) {
    const auto shape = actor.at(static_cast<double>(f) / options.rate_hz);
    std::vector<Eigen::Vector3d> places;
    for (const SurfacePoint& p : points) {
      places.emplace_back(take.head_pose[f] * position_of(p, *actor.model().topology, shape));
    }
    return places;
  };
  Recording recording = record(markers, points.size(), true_markers, options, seeds);
  take.measured = std::move(recording.measured);
  take.truth = std::move(recording.truth);
  take.gaps = std::move(recording.gaps);
  take.swap = recording.swap;
  return take;
}

}  // namespace kinemesh::test
