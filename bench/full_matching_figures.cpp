// How well dense maps between animations with known truth are found. One JSON object per line.
//
//   full_matching_figures ict [PAIRS] [FIRST]       model faces doing the same motion, the second
//                                                   remeshed to about 5,000 vertices
//   full_matching_figures noisy [PAIRS] [FIRST]     the second turned, scaled, its motion turned
//   and
//                                                   scaled for the subject, 0.3 mm noise
//   full_matching_figures sphere FILE…              time and distortion of maps to the sphere
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>

#include "analysis/full_matching/full_matching.h"
#include "analysis/map_evaluation.h"
#include "analysis/spherical/closed_surface.h"
#include "config/error.h"
#include "mesh/formats/mesh_io.h"
#include "tests/support/ict_performer.h"

namespace {

using namespace kinemesh;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::vector<Eigen::Vector3d> rest_of(const AnimatedMesh& mesh) {
  std::vector<Eigen::Vector3d> positions;
  for (VertexIndex v = 0; v < mesh.vertex_count(); ++v)
    positions.push_back(mesh.position(0, v).cast<double>());
  return positions;
}

/// Geodesic errors of every 16th vertex.
MapEvaluation errors_of(const SurfaceMap& map, const SurfaceMap& truth,
                        const AnimatedMesh& target) {
  return evaluate_map(map, truth_from_map(truth), target.mesh_at(0),
                      {.samples = static_cast<int>(truth.points.size() / 16)});
}

FullMatchingOptions options_from_environment() {
  FullMatchingOptions options;
  ParameterSet set;
  options.declare(set);
  for (Parameter& p : set.parameters()) {
    if (const char* value = std::getenv(p.name().c_str())) p.set({value});
  }
  return options;
}

void face_pair(const std::string& kind, uint64_t k) {
  const test::IctModel& model = test::ict_model();
  const test::IctMotion motion = test::make_ict_motion(model, 100 + k);
  test::PerformOptions perform_a{.rate_hz = 30}, perform_b{.rate_hz = 30, .remesh_vertices = 5000};
  if (kind == "noisy") {
    perform_b.variation = {.turn_degrees = 20, .scale = 0.3};
    perform_a.noise_mm = perform_b.noise_mm = 0.3;
    perform_b.head_degrees = 8;
  }
  const auto a = test::perform(model, {.seed = 2 * k + 1}, motion, perform_a);
  auto b = test::perform(model, {.seed = 2 * k + 2}, motion, perform_b);
  const SurfaceMap truth = test::true_map(model, a, b);
  if (kind == "noisy") {
    const Eigen::Matrix3f turn =
        Eigen::AngleAxisf(2.0F, Eigen::Vector3f(1, -2, 1).normalized()).toRotationMatrix() * 1.7F;
    for (std::size_t f = 0; f < b.mesh.frame_count(); ++f)
      b.mesh.frame(f) = (b.mesh.frame(f) * turn.transpose()).eval();
  }
  const auto start = std::chrono::steady_clock::now();
  const std::clock_t cpu = std::clock();
  const FullMatching m = match_surfaces(a.mesh, b.mesh, options_from_environment());
  const double cpu_s = static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
  const double time = seconds_since(start);
  const MapEvaluation e = errors_of(m.forward, truth, b.mesh);
  const MapEvaluation r = errors_of(m.reverse, test::true_map(model, b, a), a.mesh);
  // What linear triangles alone cost: the true maps, sampled at the vertices alike.
  const ThereAndBack floor =
      there_and_back(truth, test::true_map(model, b, a), m.overlay->source(), m.overlay->target());
  std::cout << nlohmann::json{{"case", kind},
                              {"pair", k},
                              {"mean", e.errors.mean},
                              {"p95", e.errors.p95},
                              {"worst", e.errors.worst},
                              {"reverse_mean", r.errors.mean},
                              {"confidence_ratio", e.confidence_ratio},
                              {"back_mean", m.exactly.mean},
                              {"back_worst", m.exactly.worst},
                              {"vertices_back_mean", m.by_vertices.mean},
                              {"vertices_back_worst", m.by_vertices.worst},
                              {"truth_back_mean", floor.mean},
                              {"truth_back_worst", floor.worst},
                              {"unmapped", m.unmapped_source},
                              {"snapped", m.snapped_source},
                              {"distortion", m.mean_distortion},
                              {"sphere_distortion", m.sphere_distortion_source},
                              {"strain", m.agreement.strain},
                              {"normals", m.agreement.normals},
                              {"loops", m.agreement.loops},
                              {"poor", m.poor},
                              {"seconds", time},
                              {"cpu_s", cpu_s}}
                   .dump()
            << std::endl;
}

void sphere(const std::string& file) {
  const AnimatedMesh mesh = read_animation(builtin_mesh_formats(), file);
  const ClosedSurface closed = close_holes(mesh.topology(), rest_of(mesh));
  const std::clock_t cpu = std::clock();
  const auto start = std::chrono::steady_clock::now();
  const SphericalMap map = map_to_sphere(*closed.topology, closed.positions);
  std::cout << nlohmann::json{{"case", "sphere"},
                              {"file", file},
                              {"vertices", map.points.size()},
                              {"holes", closed.loops.size()},
                              {"distortion", map.distortion},
                              {"smallest_determinant", map.check.smallest_determinant},
                              {"seconds", seconds_since(start)},
                              {"cpu_s", static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC}}
                   .dump()
            << std::endl;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const std::string kind = argc > 1 ? argv[1] : "ict";
    if (kind == "sphere") {
      for (int k = 2; k < argc; ++k) sphere(argv[k]);
      return 0;
    }
    const int pairs = argc > 2 ? std::atoi(argv[2]) : 20, first = argc > 3 ? std::atoi(argv[3]) : 0;
    for (int k = first; k < first + pairs; ++k) face_pair(kind, static_cast<uint64_t>(k));
  } catch (const Error& e) {
    std::cerr << e.what() << '\n';
    return static_cast<int>(e.exit_code());
  }
  return 0;
}
