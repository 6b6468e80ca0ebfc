#include "analysis/comparison/performance.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "capture/rigid_fit.h"
#include "config/error.h"
#include "config/input_file.h"
#include "config/parallel.h"
#include "report/camera.h"

namespace kinemesh {
namespace {

constexpr int reweightings = 8;

bool is_session(const FormatRegistry& formats, const std::filesystem::path& path) {
  if (std::filesystem::is_directory(path)) return false;
  const Format* format = formats.reader_for(path);
  return format == nullptr || !format->keeps.faces;
}

ConvertResult converted(const MarkerSequence& session, const PerformanceOptions& options,
                        Performance& result, const RunContext& ctx) {
  ConvertOptions convert = options.convert;
  convert.stabilise = options.steady;
  try {
    return convert_session(session, convert, {}, ctx);
  } catch (const NoResultError&) {
    if (!convert.stabilise) throw;
  } catch (const UsageError&) {
    if (!convert.stabilise) throw;
  }
  result.notes.push_back(
      "the head is held still by the face itself, as the session has no rigid markers: what moves "
      "as a whole is lost");
  convert.stabilise = false;
  ConvertResult conversion = convert_session(session, convert, {}, ctx);
  hold_still(conversion.animation, ctx);
  return conversion;
}

void convert_into(Performance& result, const PerformanceOptions& options, const RunContext& ctx) {
  result.session = read_session(result.path, options.reading, ctx);
  ConvertResult conversion = converted(result.session, options, result, ctx);
  result.mesh = std::move(conversion.animation);
  for (const Opening& opening : conversion.triangulation.openings)
    result.loops.push_back({std::string(name_of(opening.name)), opening.loop});
  result.notes.insert(result.notes.end(), conversion.warnings.begin(), conversion.warnings.end());
}

Eigen::Vector3d middle_of(const std::vector<VertexIndex>& loop, const AnimatedMesh& mesh) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const VertexIndex v : loop) sum += mesh.position(0, v).cast<double>();
  return sum / static_cast<double>(loop.size());
}

double length_of(const std::vector<VertexIndex>& loop, const AnimatedMesh& mesh) {
  double length = 0.0;
  for (std::size_t k = 0; k < loop.size(); ++k) {
    length += (mesh.position(0, loop[k]) - mesh.position(0, loop[(k + 1) % loop.size()])).norm();
  }
  return length;
}

std::vector<Eigen::Vector3d> frame_of(const AnimatedMesh& mesh, std::size_t f) {
  std::vector<Eigen::Vector3d> points;
  for (VertexIndex v = 0; v < mesh.vertex_count(); ++v)
    points.push_back(mesh.position(f, v).cast<double>());
  return points;
}

}  // namespace

void PerformanceOptions::declare(ParameterSet& p) {
  reading.declare(p);
  p.group("head", "Motion of the head");
  p.flag("steady", steady, "Take the head's motion out, by rigid markers where there are some");
  convert.gaps.declare(p);
  convert.triangulate.declare(p);
}

void PerformanceOptions::validate() const {
  validate_options(*this);
  reading.validate();
}

void hold_still(AnimatedMesh& mesh, const RunContext& ctx) {
  if (mesh.frame_count() < 2 || mesh.vertex_count() < 3) return;
  const std::vector<Eigen::Vector3d> rest = frame_of(mesh, 0);
  parallel_for(ctx, mesh.frame_count(), 4, [&](std::size_t f) {
    const std::vector<Eigen::Vector3d> points = frame_of(mesh, f);
    std::vector<double> weights(points.size(), 1.0), left(points.size());
    RigidFit fit;
    for (int k = 0; k < reweightings; ++k) {
      fit = fit_rigid(points, rest, weights);
      for (std::size_t v = 0; v < points.size(); ++v)
        left[v] = (fit.apply(points[v]) - rest[v]).norm();
      std::vector<double> sorted = left;
      const auto median = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
      std::nth_element(sorted.begin(), median, sorted.end());
      const double scale = std::max(1e-9, *median);
      for (std::size_t v = 0; v < points.size(); ++v) {
        const double r = left[v] / scale;
        weights[v] = 1.0 / ((1.0 + r * r) * (1.0 + r * r));
      }
    }
    for (VertexIndex v = 0; v < points.size(); ++v)
      mesh.position(f, v) = fit.apply(points[v]).cast<float>();
  });
}

std::vector<NamedLoop> name_loops(const AnimatedMesh& mesh) {
  auto loops = mesh.topology().boundary_loops();
  if (loops.empty()) return {};
  std::ranges::stable_sort(loops, std::greater{},
                           [&](const auto& loop) { return length_of(loop, mesh); });
  loops.erase(loops.begin());
  std::vector<NamedLoop> named;
  for (std::size_t k = 0; k < loops.size(); ++k)
    named.push_back({"opening " + std::to_string(k + 1), loops[k]});
  if (named.size() != 3) return named;
  const BodyAxes axes = estimate_axes(mesh.topology(), mesh.frame(0));
  const Eigen::Vector3d up = axes.up.cast<double>();
  const Eigen::Vector3d left = up.cross(axes.front.cast<double>());
  std::ranges::stable_sort(named, {},
                           [&](const NamedLoop& l) { return up.dot(middle_of(l.vertices, mesh)); });
  named[0].name = "mouth";
  const bool second_left =
      left.dot(middle_of(named[1].vertices, mesh)) > left.dot(middle_of(named[2].vertices, mesh));
  named[1].name = second_left ? "left eye" : "right eye";
  named[2].name = second_left ? "right eye" : "left eye";
  return named;
}

Performance read_performance(const FormatRegistry& formats, const std::filesystem::path& path,
                             const PerformanceOptions& options, const RunContext& ctx) {
  Performance result;
  result.path = path.string();
  if (!std::filesystem::is_directory(path)) result.sha256 = sha256_of_file(path);
  if (is_session(formats, path)) {
    convert_into(result, options, ctx);
    return result;
  }
  result.mesh =
      read_animation(formats, path, options.reading.c3d.unstated, ctx.part(0.0, 0.7, "reading"));
  if (options.steady) hold_still(result.mesh, ctx.part(0.7, 1.0, "holding the head still"));
  result.loops = name_loops(result.mesh);
  return result;
}

}  // namespace kinemesh
