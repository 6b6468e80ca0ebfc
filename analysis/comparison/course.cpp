#include "analysis/comparison/course.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mesh/surface_measures.h"

namespace kinemesh {

Eigen::Vector3d Course::displacement_at(std::size_t frame, std::size_t vertex) const {
  const float* at = displacement.values.data() + 3 * (frame * rest.size() + vertex);
  return Eigen::Vector3f(at[0], at[1], at[2]).cast<double>();
}

namespace comparison {
namespace {

/// The largest stretch in percent behind a value of StrainMeasure::root_log.
float stretch_percent(float value, double floor) {
  const double root = static_cast<double>(value) + std::sqrt(floor);
  return static_cast<float>(100.0 * (std::exp(std::max(0.0, root * root - floor)) - 1.0));
}

}  // namespace

std::vector<Eigen::Vector3d> rest_of(const AnimatedMesh& mesh, double seconds) {
  const auto frames = std::clamp<std::size_t>(
      static_cast<std::size_t>(std::lround(seconds * std::max(0.0, mesh.rate_hz))), 1,
      mesh.frame_count());
  std::vector<Eigen::Vector3d> rest(mesh.vertex_count(), Eigen::Vector3d::Zero());
  for (std::size_t f = 0; f < frames; ++f) {
    for (VertexIndex v = 0; v < rest.size(); ++v)
      rest[v] += mesh.position(f, v).cast<double>() / static_cast<double>(frames);
  }
  return rest;
}

Course course_of(const AnimatedMesh& mesh, std::vector<Eigen::Vector3d> rest,
                 const DeformationResult* deformation, const DeformationOptions& options) {
  const std::size_t n = mesh.vertex_count();
  Course course;
  course.areas = vertex_areas(mesh.topology(), rest);
  course.rest = std::move(rest);
  course.rate_hz = mesh.rate_hz;
  course.frame_count = mesh.frame_count();
  course.displacement = {3 * n, std::vector<float>(3 * n * mesh.frame_count())};
  course.strain = {n, std::vector<float>(n * mesh.frame_count(), 0.0F)};
  for (std::size_t f = 0; f < mesh.frame_count(); ++f) {
    for (VertexIndex v = 0; v < n; ++v) {
      const Eigen::Vector3f moved =
          (mesh.position(f, v).cast<double>() - course.rest[v]).cast<float>();
      std::copy_n(moved.data(), 3, course.displacement.values.data() + 3 * (f * n + v));
      if (deformation != nullptr) {
        course.strain.values[f * n + v] =
            stretch_percent(deformation->values.of(v)[f], options.root_floor);
      }
    }
  }
  return course;
}

Field brought_to(const Field& of_b, std::size_t channels, const SurfaceMap& forward,
                 const Topology& topology_b, const std::vector<double>& frames) {
  const std::size_t n = forward.points.size(), row = of_b.vertex_count;
  const std::size_t last = of_b.values.size() / row - 1;
  Field field{channels * n, std::vector<float>(channels * n * frames.size())};
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const double frame = std::clamp(frames[f], 0.0, static_cast<double>(last));
    const auto before = static_cast<std::size_t>(frame);
    const std::size_t after = std::min(before + 1, last);
    const double t = frame - static_cast<double>(before);
    for (std::size_t v = 0; v < n; ++v) {
      const SurfacePoint& point = forward.points[v];
      for (std::size_t c = 0; c < channels; ++c) {
        double sum = point.valid() ? 0.0 : std::numeric_limits<double>::quiet_NaN();
        for (std::size_t k = 0; point.valid() && k < 3; ++k) {
          const std::size_t at = channels * topology_b.faces()[point.face][k] + c;
          sum += point.weights[k] *
                 ((1.0 - t) * of_b.values[before * row + at] + t * of_b.values[after * row + at]);
        }
        field.values[channels * (f * n + v) + c] = static_cast<float>(sum);
      }
    }
  }
  return field;
}

}  // namespace comparison
}  // namespace kinemesh
