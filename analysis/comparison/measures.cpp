#include "analysis/comparison/measures.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/comparison/regions.h"
#include "config/error.h"
#include "config/input_file.h"
#include "mesh/geodesics/geodesics.h"
#include "report/camera.h"

namespace kinemesh {
namespace {

constexpr double least_noise = 0.01;  // mm
constexpr double speed_smoothing_s = 0.02;
constexpr const char* left_corner = "left mouth corner";
constexpr const char* right_corner = "right mouth corner";

/// A place of a mesh: the mean of points on it.
using Place = std::vector<SurfacePoint>;

Eigen::Vector3d where(const Place& place, const AnimatedMesh& mesh, std::size_t frame) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const SurfacePoint& p : place) {
    for (std::size_t k = 0; k < 3; ++k) {
      sum += p.weights[k] * mesh.position(frame, mesh.topology().faces()[p.face][k]).cast<double>();
    }
  }
  return sum / static_cast<double>(place.size());
}

const NamedLoop* loop_of(const Performance& p, const std::string& name) {
  const auto found = std::ranges::find(p.loops, name, &NamedLoop::name);
  return found == p.loops.end() ? nullptr : &*found;
}

/// The corners of the mouth: the vertices of its loop farthest to the left and to the right.
std::vector<VertexIndex> corner_of(const Performance& p, const std::string& name) {
  const NamedLoop* mouth = loop_of(p, "mouth");
  if (mouth == nullptr || (name != left_corner && name != right_corner)) return {};
  const BodyAxes axes = estimate_axes(p.mesh.topology(), p.mesh.frame(0));
  Eigen::Vector3f side = axes.up.cross(axes.front);
  if (name == right_corner) side = -side;
  return {*std::ranges::max_element(
      mouth->vertices, {}, [&](VertexIndex v) { return side.dot(p.mesh.position(0, v)); })};
}

Place place_in(const Performance& p, const std::string& name) {
  std::vector<VertexIndex> vertices = corner_of(p, name);
  if (vertices.empty()) vertices = vertices_named(name, p.mesh);
  return vertex_points(p.mesh.topology(), vertices);
}

/// B's own marker of that name, or where A's place lies on B.
Place place_in_b(const Comparison& c, const Performance& a, const Performance& b,
                 const std::string& name) {
  const bool number = name.find_first_not_of("0123456789") == std::string::npos;
  if (!number) {
    Place own = place_in(b, name);
    if (!own.empty()) return own;
  }
  std::vector<VertexIndex> vertices = corner_of(a, name);
  if (vertices.empty()) vertices = vertices_named(name, a.mesh);
  Place mapped;
  for (const VertexIndex v : vertices) {
    if (c.forward.points[v].valid()) mapped.push_back(c.forward.points[v]);
  }
  return mapped;
}

/// Area of the polygon over its longest chord.
double height_of(const NamedLoop& loop, const AnimatedMesh& mesh, std::size_t frame) {
  Eigen::Vector3d area = Eigen::Vector3d::Zero();
  const Eigen::Vector3d origin = mesh.position(frame, loop.vertices[0]).cast<double>();
  double chord = 0.0;
  for (std::size_t k = 0; k < loop.vertices.size(); ++k) {
    const Eigen::Vector3d p = mesh.position(frame, loop.vertices[k]).cast<double>() - origin;
    const Eigen::Vector3d q =
        mesh.position(frame, loop.vertices[(k + 1) % loop.vertices.size()]).cast<double>() - origin;
    area += 0.5 * p.cross(q);
    for (std::size_t i = 0; i < k; ++i) {
      const Eigen::Vector3d r = mesh.position(frame, loop.vertices[i]).cast<double>() - origin;
      chord = std::max(chord, (p - r).norm());
    }
  }
  return chord > 0.0 ? area.norm() / chord : 0.0;
}

MeasureCourse finished(std::vector<double> mm, double rate_hz, double rest_window_s) {
  MeasureCourse course;
  course.mm = std::move(mm);
  const RestLevel rest = rest_level(course.mm, rate_hz, rest_window_s);
  course.rest_mm = rest.mean;
  course.timing = movement_timing(course.mm, rate_hz, rest.mean, std::max(rest.noise, least_noise));
  const double farthest = *std::ranges::max_element(
      course.mm, {}, [&](double value) { return std::abs(value - rest.mean); });
  course.change_mm = (course.timing ? course.timing->level : farthest) - rest.mean;
  course.peak_speed = peak_speed(course.mm, rate_hz, speed_smoothing_s);
  return course;
}

MeasureCourse course_of(const MeasureSpec& spec, const Performance& p,
                        const std::vector<Place>& places, const NamedLoop* loop,
                        double rest_window_s) {
  std::vector<double> mm(p.mesh.frame_count());
  Eigen::Vector3d rest = Eigen::Vector3d::Zero();
  if (spec.kind == MeasureKind::excursion) {
    const auto n = std::clamp<std::size_t>(
        static_cast<std::size_t>(std::lround(rest_window_s * std::max(0.0, p.mesh.rate_hz))), 1,
        mm.size());
    for (std::size_t f = 0; f < n; ++f)
      rest += where(places[0], p.mesh, f) / static_cast<double>(n);
  }
  for (std::size_t f = 0; f < mm.size(); ++f) {
    switch (spec.kind) {
      case MeasureKind::distance:
        mm[f] = (where(places[0], p.mesh, f) - where(places[1], p.mesh, f)).norm();
        break;
      case MeasureKind::excursion: mm[f] = (where(places[0], p.mesh, f) - rest).norm(); break;
      case MeasureKind::opening: mm[f] = height_of(*loop, p.mesh, f); break;
    }
  }
  return finished(std::move(mm), p.mesh.rate_hz, rest_window_s);
}

[[noreturn]] void refuse_place(const MeasureSpec& spec, const std::string& place,
                               const char* which) {
  throw InputError({.what = "measure '" + spec.name + "': " + which + " has no '" + place + "'",
                    .remedy = "Name markers (wildcards allowed), vertices by number from 0, or an "
                              "opening such as mouth"});
}

MeasureKind kind_of(const std::string& word, const std::string& name,
                    const std::filesystem::path& path) {
  if (word == "distance") return MeasureKind::distance;
  if (word == "excursion") return MeasureKind::excursion;
  if (word == "opening") return MeasureKind::opening;
  throw InputError({.what = "'" + word + "' is no kind of measure",
                    .file = path.string(),
                    .place = "measure " + name,
                    .remedy = "Use distance, excursion or opening"});
}

}  // namespace

std::vector<MeasureSpec> read_measures(const std::filesystem::path& path) try {
  std::vector<MeasureSpec> specs;
  const nlohmann::json json = nlohmann::json::parse(read_file(path));
  for (const auto& [name, what] : json.items()) {
    for (const auto& [kind, places] : what.items()) {
      MeasureSpec spec{name, kind_of(kind, name, path), {}};
      for (const nlohmann::json& place : places)
        spec.places.push_back(place.is_string() ? place.get<std::string>() : place.dump());
      if (spec.places.size() != (spec.kind == MeasureKind::distance ? 2U : 1U)) {
        throw InputError({.what = "a distance has two places, everything else one",
                          .file = path.string(),
                          .place = "measure " + name});
      }
      specs.push_back(std::move(spec));
    }
  }
  return specs;
} catch (const nlohmann::json::exception& e) {
  throw InputError({.what = std::string("the measures are no valid JSON: ") + e.what(),
                    .file = path.string(),
                    .remedy = "Write {\"mouth width\": {\"distance\": [\"LMOU01\", \"RMOU01\"]}}"});
}

std::vector<MeasureSpec> default_measures(const Performance& a, const Performance& b) {
  std::vector<MeasureSpec> specs;
  for (const NamedLoop& loop : a.loops) {
    if (loop_of(b, loop.name) == nullptr) continue;
    const bool numbered = loop.name.starts_with("opening");
    specs.push_back(
        {numbered ? loop.name : loop.name + " opening", MeasureKind::opening, {loop.name}});
    if (loop.name != "mouth") continue;
    specs.push_back({"mouth width", MeasureKind::distance, {left_corner, right_corner}});
    specs.push_back({"left mouth corner excursion", MeasureKind::excursion, {left_corner}});
    specs.push_back({"right mouth corner excursion", MeasureKind::excursion, {right_corner}});
  }
  return specs;
}

std::vector<MeasureResult> take_measures(const Comparison& c, const Performance& a,
                                         const Performance& b,
                                         const std::vector<MeasureSpec>& specs,
                                         double rest_window_s) {
  std::vector<MeasureResult> results;
  for (const MeasureSpec& spec : specs) {
    std::vector<Place> in_a, in_b;
    const NamedLoop *loop_a = nullptr, *loop_b = nullptr;
    if (spec.kind == MeasureKind::opening) {
      loop_a = loop_of(a, spec.places[0]);
      loop_b = loop_of(b, spec.places[0]);
      if (loop_a == nullptr) refuse_place(spec, spec.places[0], "A");
      if (loop_b == nullptr) refuse_place(spec, spec.places[0], "B");
    } else {
      for (const std::string& name : spec.places) {
        in_a.push_back(place_in(a, name));
        in_b.push_back(place_in_b(c, a, b, name));
        if (in_a.back().empty()) refuse_place(spec, name, "A");
        if (in_b.back().empty()) refuse_place(spec, name, "B");
      }
    }
    results.push_back({spec, course_of(spec, a, in_a, loop_a, rest_window_s),
                       course_of(spec, b, in_b, loop_b, rest_window_s)});
  }
  return results;
}

}  // namespace kinemesh
