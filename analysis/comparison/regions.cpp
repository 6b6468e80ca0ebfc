#include "analysis/comparison/regions.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "analysis/comparison/course.h"
#include "config/error.h"
#include "config/input_file.h"
#include "config/text.h"
#include "report/camera.h"

namespace kinemesh {
namespace {

constexpr double least_noise = 0.01;        // mm: less is rounding
constexpr double least_part_moving = 0.15;  // of the largest displacement: a vertex takes part
constexpr double clearly = 20.0;            // times its noise, along its displacement
constexpr std::size_t fewest_vertices = 5;

SurfaceRegion whole_of(const AnimatedMesh& mesh) {
  SurfaceRegion whole{"whole surface", std::vector<VertexIndex>(mesh.vertex_count())};
  std::iota(whole.vertices.begin(), whole.vertices.end(), VertexIndex{0});
  return whole;
}

/// Displacements (3 a vertex) of a region over time.
struct Movement {
  const Field& displacement;  // frames × 3 V
  const Field& strain;
  const std::vector<double>& areas;
  const std::vector<VertexIndex>& vertices;
  std::size_t frames() const { return displacement.values.size() / displacement.vertex_count; }
  Eigen::Map<const Eigen::Vector3f> at(std::size_t f, VertexIndex v) const {
    return Eigen::Map<const Eigen::Vector3f>(displacement.values.data() +
                                             f * displacement.vertex_count + std::size_t{3} * v);
  }
};

double mean_square(const Movement& m, std::size_t f) {
  double sum = 0.0, area = 0.0;
  for (const VertexIndex v : m.vertices) {
    const Eigen::Vector3f u = m.at(f, v);
    if (!u.allFinite()) continue;
    sum += m.areas[v] * u.squaredNorm();
    area += m.areas[v];
  }
  return area > 0.0 ? sum / area : 0.0;
}

/// The frames near the region's strongest pose, ascending.
std::vector<std::size_t> strongest_frames(const Movement& m) {
  std::vector<double> squares(m.frames());
  for (std::size_t f = 0; f < squares.size(); ++f) squares[f] = mean_square(m, f);
  const double enough = 0.81 * *std::ranges::max_element(squares);
  std::vector<std::size_t> frames;
  for (std::size_t f = 0; f < squares.size(); ++f) {
    if (squares[f] >= enough) frames.push_back(f);
  }
  return frames;
}

/// The mean displacement over those frames, 3 a vertex of the region.
std::vector<double> strongest_pose(const Movement& m) {
  const std::vector<std::size_t> frames = strongest_frames(m);
  std::vector<double> pose(3 * m.vertices.size(), 0.0);
  for (const std::size_t f : frames) {
    for (std::size_t k = 0; k < m.vertices.size(); ++k) {
      for (int axis = 0; axis < 3; ++axis)
        pose[3 * k + static_cast<std::size_t>(axis)] += m.at(f, m.vertices[k])[axis];
    }
  }
  for (double& p : pose) p /= static_cast<double>(frames.size());
  return pose;
}

std::vector<double> amount_of(const Movement& m) {
  const std::vector<double> pose = strongest_pose(m);
  double norm = 0.0, area = 0.0;
  for (std::size_t k = 0; k < m.vertices.size(); ++k) {
    const Eigen::Map<const Eigen::Vector3d> p(pose.data() + 3 * k);
    if (!p.allFinite()) continue;
    norm += m.areas[m.vertices[k]] * p.squaredNorm();
    area += m.areas[m.vertices[k]];
  }
  std::vector<double> amount(m.frames(), 0.0);
  if (!(norm > 0.0)) return amount;
  for (std::size_t f = 0; f < amount.size(); ++f) {
    for (std::size_t k = 0; k < m.vertices.size(); ++k) {
      const Eigen::Map<const Eigen::Vector3d> p(pose.data() + 3 * k);
      if (!p.allFinite()) continue;
      amount[f] += m.areas[m.vertices[k]] * p.dot(m.at(f, m.vertices[k]).cast<double>());
    }
    amount[f] /= std::sqrt(norm * area);
  }
  return amount;
}

double largest_strain(const Movement& m) {
  double largest = 0.0;
  for (std::size_t f = 0; f < m.frames(); ++f) {
    double sum = 0.0, area = 0.0;
    for (const VertexIndex v : m.vertices) {
      const float strain = m.strain.at(f, v);
      if (!std::isfinite(strain)) continue;
      sum += m.areas[v] * strain;
      area += m.areas[v];
    }
    if (area > 0.0) largest = std::max(largest, sum / area);
  }
  return largest;
}

/// A vertex' timing, and how much of the region it stands for.
struct Timed {
  double seconds, area;
};
/// The instant by which `share` of the area is through.
double quantile(std::vector<Timed> instants, double share) {
  std::ranges::stable_sort(instants, {}, &Timed::seconds);
  double all = 0.0, sum = 0.0;
  for (const Timed& t : instants) all += t.area;
  for (const Timed& t : instants) {
    sum += t.area;
    if (sum >= share * all) return t.seconds;
  }
  return instants.back().seconds;
}

/// The displacement of each vertex along its own in the strongest pose, over that, and the size.
struct VertexCourse {
  std::vector<double> along;
  double size = 0.0, noise = 0.0;  // mm
};
VertexCourse vertex_course(const Movement& m, VertexIndex v, const Eigen::Vector3d& pose,
                           double rate_hz, double rest_window_s) {
  VertexCourse course;
  course.size = pose.norm();
  for (std::size_t f = 0; f < m.frames(); ++f)
    course.along.push_back(pose.dot(m.at(f, v).cast<double>()) / pose.squaredNorm());
  course.noise = course.size * rest_level(course.along, rate_hz, rest_window_s).noise;
  return course;
}

/// From the timing of each vertex that moves clearly: a region begins when a fifth of them has
/// begun, is there when half of them is, and is over when four fifths are. What begins later in one
/// place so does not delay what began before in another.
std::optional<MovementTiming> region_timing(const Movement& m, double rate_hz,
                                            double rest_window_s) {
  const std::vector<double> pose = strongest_pose(m);
  const std::vector<std::size_t> frames = strongest_frames(m);
  const std::size_t at = frames[frames.size() / 2];
  double largest = 0.0;
  for (std::size_t k = 0; k < m.vertices.size(); ++k) {
    const double size = Eigen::Map<const Eigen::Vector3d>(pose.data() + 3 * k).norm();
    if (std::isfinite(size)) largest = std::max(largest, size);
  }
  std::vector<Timed> onsets, peaks, offsets;
  std::size_t returning = 0;
  for (std::size_t k = 0; k < m.vertices.size(); ++k) {
    const Eigen::Map<const Eigen::Vector3d> own(pose.data() + 3 * k);
    if (!own.allFinite() || !(own.norm() > least_part_moving * largest)) continue;
    const VertexCourse course = vertex_course(m, m.vertices[k], own, rate_hz, rest_window_s);
    if (course.size < clearly * std::max(course.noise, least_noise)) continue;
    const auto timing = timing_around(course.along, rate_hz, at);
    if (!timing) continue;
    const double area = m.areas[m.vertices[k]];
    onsets.push_back({timing->onset_s, area});
    peaks.push_back({timing->peak_s, area});
    offsets.push_back({timing->offset_s, area});
    returning += timing->comes_back ? 1U : 0U;
  }
  if (onsets.size() < fewest_vertices) return {};
  return MovementTiming{quantile(onsets, 0.2), quantile(peaks, 0.5), quantile(offsets, 0.8),
                        2 * returning > onsets.size(), largest};
}

RegionCourse course_of(const Movement& m, double rate_hz, double rest_window_s) {
  RegionCourse course;
  course.amount_mm = amount_of(m);
  const RestLevel rest = rest_level(course.amount_mm, rate_hz, rest_window_s);
  const double noise = std::max(rest.noise, least_noise);
  course.timing = movement_timing(course.amount_mm, rate_hz, rest.mean, noise);
  if (course.timing) {
    if (const auto finer = region_timing(m, rate_hz, rest_window_s)) course.timing = finer;
  }
  course.largest_mm = *std::ranges::max_element(course.amount_mm);
  course.largest_strain = largest_strain(m);
  return course;
}

void sum_up_differences(RegionResult& r, const Comparison& c) {
  double area = 0.0, mean = 0.0, square = 0.0;
  for (const VertexIndex v : r.region.vertices) {
    const double d = c.shape_mm[v];
    if (!std::isfinite(d)) continue;
    area += c.a.areas[v];
    mean += c.a.areas[v] * d;
    square += c.a.areas[v] * d * d;
  }
  r.area_share = area / (c.root_area_mm * c.root_area_mm);
  if (!(area > 0.0)) return;
  r.shape_mean_mm = mean / area;
  r.shape_rms_mm = std::sqrt(square / area);
  double all = 0.0;
  for (std::size_t f = 0; f < c.a.frame_count; ++f) {
    double sum = 0.0;
    for (const VertexIndex v : r.region.vertices) {
      const double d = c.motion_difference.at(f, v);
      if (std::isfinite(d)) sum += c.a.areas[v] * d * d / area;
    }
    all += sum / static_cast<double>(c.a.frame_count);
    r.motion_largest_mm = std::max(r.motion_largest_mm, std::sqrt(sum));
  }
  r.motion_rms_mm = std::sqrt(all);
}

}  // namespace

RestLevel rest_level(const std::vector<double>& curve, double rate_hz, double seconds) {
  const auto n = std::clamp<std::size_t>(
      static_cast<std::size_t>(std::lround(seconds * std::max(0.0, rate_hz))), 1, curve.size());
  RestLevel level;
  for (std::size_t f = 0; f < n; ++f) level.mean += curve[f] / static_cast<double>(n);
  for (std::size_t f = 0; f < n; ++f)
    level.noise += (curve[f] - level.mean) * (curve[f] - level.mean) / static_cast<double>(n);
  level.noise = std::sqrt(level.noise);
  return level;
}

std::vector<SurfaceRegion> default_regions(const AnimatedMesh& mesh) {
  const BodyAxes axes = estimate_axes(mesh.topology(), mesh.frame(0));
  const Eigen::Vector3f up = axes.up, left = up.cross(axes.front);
  std::vector<float> heights, sides;
  for (VertexIndex v = 0; v < mesh.vertex_count(); ++v) {
    heights.push_back(up.dot(mesh.position(0, v)));
    sides.push_back(left.dot(mesh.position(0, v)));
  }
  const auto [low, high] = std::ranges::minmax(heights);
  const auto [right_end, left_end] = std::ranges::minmax(sides);
  std::vector<SurfaceRegion> regions{whole_of(mesh)};
  for (const char* third : {"upper", "middle", "lower"}) {
    for (const char* side : {"left", "right"})
      regions.push_back({std::string(third) + " " + side, {}});
  }
  for (VertexIndex v = 0; v < mesh.vertex_count(); ++v) {
    const float part = high > low ? (high - heights[v]) / (high - low) : 0.0F;
    const auto third = std::min<std::size_t>(2, static_cast<std::size_t>(3.0F * part));
    const bool on_left = sides[v] > 0.5F * (left_end + right_end);
    regions[1 + 2 * third + (on_left ? 0 : 1)].vertices.push_back(v);
  }
  std::erase_if(regions, [](const SurfaceRegion& r) { return r.vertices.empty(); });
  return regions;
}

std::vector<VertexIndex> vertices_named(const std::string& name, const AnimatedMesh& mesh) {
  std::vector<VertexIndex> found;
  for (VertexIndex v = 0; v < mesh.vertex_names.size(); ++v) {
    if (matches_wildcard(name, mesh.vertex_names[v])) found.push_back(v);
  }
  if (!found.empty()) return found;
  VertexIndex number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  if (error == std::errc() && end == name.data() + name.size() && number < mesh.vertex_count()) {
    found.push_back(number);
  }
  return found;
}

std::vector<SurfaceRegion> read_regions(const std::filesystem::path& path,
                                        const AnimatedMesh& mesh) try {
  const nlohmann::json json = nlohmann::json::parse(read_file(path));
  std::vector<SurfaceRegion> regions{whole_of(mesh)};
  for (const auto& [name, entries] : json.items()) {
    SurfaceRegion region{name, {}};
    for (const nlohmann::json& entry : entries) {
      const std::string text = entry.is_string() ? entry.get<std::string>() : entry.dump();
      const std::vector<VertexIndex> found = vertices_named(text, mesh);
      if (found.empty()) {
        throw InputError({.what = "'" + text + "' is neither a vertex nor a marker of A",
                          .file = path.string(),
                          .place = "region " + name});
      }
      region.vertices.insert(region.vertices.end(), found.begin(), found.end());
    }
    std::ranges::sort(region.vertices);
    // Not std::ranges::unique, which clang does not take from this library.
    region.vertices.erase(std::unique(region.vertices.begin(), region.vertices.end()),
                          region.vertices.end());
    if (!region.vertices.empty()) regions.push_back(std::move(region));
  }
  return regions;
} catch (const nlohmann::json::exception& e) {
  throw InputError({.what = std::string("the regions are no valid JSON: ") + e.what(),
                    .file = path.string(),
                    .remedy = "Write {\"name\": [vertices or marker names], …}"});
}

std::vector<RegionResult> compare_regions(const Comparison& c, const Topology& topology_b,
                                          std::vector<SurfaceRegion> regions,
                                          double rest_window_s) {
  std::vector<double> frames(c.b.frame_count);
  std::iota(frames.begin(), frames.end(), 0.0);
  const Field moved = comparison::brought_to(c.b.displacement, 3, c.forward, topology_b, frames);
  const Field strain = comparison::brought_to(c.b.strain, 1, c.forward, topology_b, frames);
  std::vector<RegionResult> results;
  for (SurfaceRegion& region : regions) {
    RegionResult r;
    r.region = std::move(region);
    r.a = course_of({c.a.displacement, c.a.strain, c.a.areas, r.region.vertices}, c.a.rate_hz,
                    rest_window_s);
    r.b = course_of({moved, strain, c.a.areas, r.region.vertices}, c.b.rate_hz, rest_window_s);
    sum_up_differences(r, c);
    results.push_back(std::move(r));
  }
  return results;
}

}  // namespace kinemesh
