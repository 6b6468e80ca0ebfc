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
#include <fstream>
#include <sstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>

#include "analysis/full_matching/full_matching.h"
#include "analysis/full_matching/surface_signals.h"
#include "analysis/map_evaluation.h"
#include "analysis/spherical/closed_surface.h"
#include "config/error.h"
#include "tests/support/closest_point.h"
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

double root_area_of(const AnimatedMesh& mesh) {
  const auto p = rest_of(mesh);
  double area = 0;
  for (const Triangle& t : mesh.topology().faces())
    area += (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]).norm() / 2;
  return std::sqrt(area);
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v / static_cast<double>(values.size());
  return sum;
}

/// Geodesic errors of every 16th vertex.
MapEvaluation errors_of(const SurfaceMap& map, const SurfaceMap& truth,
                        const AnimatedMesh& target) {
  return evaluate_map(map, truth_from_map(truth), target.mesh_at(0),
                      {.samples = static_cast<int>(truth.points.size() / 16)});
}

/// Distances of every `step`-th source vertex from its image under forward, then reverse.
std::vector<double> there_and_back(const FullMatching& m, const AnimatedMesh& a,
                                   const AnimatedMesh& b, std::size_t step) {
  const auto positions = rest_of(a);
  const test::ClosestPoint surface(positions, a.topology().faces(), 5);
  std::vector<double> distances;
  for (std::size_t v = 0; v < m.forward.points.size(); v += step) {
    const SurfacePoint& there = m.forward.points[v];
    if (!there.valid()) continue;
    Eigen::Vector3d back = Eigen::Vector3d::Zero();
    bool whole = true;
    for (std::size_t c = 0; c < 3; ++c) {
      const SurfacePoint& corner = m.reverse.points[b.topology().faces()[there.face][c]];
      whole = whole && corner.valid();
      if (whole) back += there.weights[c] * position_of(corner, a.topology(), positions);
    }
    if (whole && std::getenv("PROJECT")) { const auto h = surface.closest(back); const Triangle& t = a.topology().faces()[h.face]; back = h.weights[0] * positions[t[0]] + h.weights[1] * positions[t[1]] + h.weights[2] * positions[t[2]]; }
    if (whole) distances.push_back((back - positions[v]).norm() / root_area_of(a));
  }
  return distances;
}

void dump_signals(const char* folder, uint64_t k, const FullMatching& m, const SurfaceMap& truth, const test::Performance& a, const test::Performance& b) {
  using namespace full_matching;
  const ClosedSurface ca = close_holes(a.mesh.topology(), rest_of(a.mesh)), cb = close_holes(b.mesh.topology(), rest_of(b.mesh));
  const SignalPair pair = compare_signals(a.mesh, ca, b.mesh, cb, 24, {});
  std::ofstream out(std::string(folder) + "/" + std::to_string(k) + ".sig"), faces(std::string(folder) + "/" + std::to_string(k) + ".tri");
  for (const Triangle& t : a.mesh.topology().faces()) faces << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
  const auto at = [&](const SurfacePoint& p, int c) {
    if (!p.valid()) return 0.0F;
    float x = 0; for (std::size_t i = 0; i < 3; ++i) x += static_cast<float>(p.weights[i]) * pair.b.values[b.mesh.topology().faces()[p.face][i]][c];
    return x; };
  for (std::size_t v = 0; v < a.mesh.vertex_count(); ++v) {
    for (int c = 0; c < channels; ++c) out << pair.a.values[v][c] << ' ';
    for (int c = 0; c < channels; ++c) out << at(m.forward.points[v], c) << ' ';
    for (int c = 0; c < channels; ++c) out << at(truth.points[v], c) << ' ';
    for (const SurfacePoint& p : {m.forward.points[v], truth.points[v]}) { Eigen::Vector3d q = Eigen::Vector3d::Zero(); if (p.valid()) q = position_of(p, b.mesh.topology(), pair.b.positions); out << q.transpose() << ' '; }
    out << '\n';
  }
}

/// dump: per vertex of a
void dump(const char* folder, uint64_t k, const FullMatching& m, const SurfaceMap& truth, const test::Performance& a, const test::Performance& b) {
  std::ofstream out(std::string(folder) + "/" + std::to_string(k) + ".csv");
  const auto pa = rest_of(a.mesh), pb = rest_of(b.mesh);
  const double ra = root_area_of(a.mesh), rb = root_area_of(b.mesh);
  for (std::size_t v = 0; v < pa.size(); ++v) {
    double error = -1, back = -1;
    if (m.forward.points[v].valid() && truth.points[v].valid()) error = (position_of(m.forward.points[v], b.mesh.topology(), pb) - position_of(truth.points[v], b.mesh.topology(), pb)).norm() / rb;
    if (m.forward.points[v].valid()) {
      Eigen::Vector3d q = Eigen::Vector3d::Zero(); bool whole = true;
      for (std::size_t c = 0; c < 3; ++c) {
        const SurfacePoint& corner = m.reverse.points[b.mesh.topology().faces()[m.forward.points[v].face][c]];
        whole = whole && corner.valid();
        if (whole) q += m.forward.points[v].weights[c] * position_of(corner, a.mesh.topology(), pa);
      }
      if (whole) back = (q - pa[v]).norm() / ra;
    }
    out << pa[v].x() << ' ' << pa[v].y() << ' ' << pa[v].z() << ' ' << error << ' ' << back << ' ' << m.forward.confidence[v] << ' ' << m.distortion[v];
    out << '\n';
  }
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
  if (const char* folder = std::getenv("DUMP")) { dump(folder, k, m, truth, a, b); if (std::getenv("SIGNALS")) dump_signals(folder, k, m, truth, a, b); 
    double sum = 0; std::vector<double> all; const auto pb = rest_of(b.mesh); const double rb = root_area_of(b.mesh);
    for (std::size_t v = 0; v < truth.points.size(); ++v) if (m.forward.points[v].valid() && truth.points[v].valid()) { all.push_back((position_of(m.forward.points[v], b.mesh.topology(), pb) - position_of(truth.points[v], b.mesh.topology(), pb)).norm() / rb); sum += all.back(); }
    if (const char* variants = std::getenv("VARIANTS")) {
      std::stringstream list(variants); std::string one;
      while (std::getline(list, one, ';')) {
        FullMatchingOptions options = options_from_environment(); ParameterSet set; options.declare(set);
        for (Parameter& p : set.parameters()) if (one.substr(0, one.find('=')) == p.name()) p.set({one.substr(one.find('=') + 1)});
        const FullMatching w = match_surfaces(a.mesh, b.mesh, options);
        std::ofstream out(std::string(folder) + "/" + std::to_string(k) + "." + one);
        double part = 0; int n = 0;
        for (std::size_t v = 0; v < truth.points.size(); ++v) { Eigen::Vector3d q = Eigen::Vector3d::Zero(); if (w.forward.points[v].valid()) { q = position_of(w.forward.points[v], b.mesh.topology(), pb) / rb; if (truth.points[v].valid()) { part += (q - position_of(truth.points[v], b.mesh.topology(), pb) / rb).norm(); ++n; } } out << q.transpose() << '\n'; }
        std::cout << one << " mean " << part / n << " distortion " << w.mean_distortion << std::endl;
      }
    }
    std::ranges::sort(all); std::cout << kind << " " << k << " mean " << sum / static_cast<double>(all.size()) << " p95 " << all[all.size() * 95 / 100] << " worst " << all.back() << " cpu " << cpu_s << " strain " << m.agreement.strain << " normals " << m.agreement.normals << std::endl; return; }
  FullMatching floor; floor.forward = truth; floor.reverse = test::true_map(model, b, a);
  const std::vector<double> fb = there_and_back(floor, a.mesh, b.mesh, 1);
  const std::vector<double> ba = there_and_back(FullMatching{.forward = m.reverse, .reverse = m.forward}, b.mesh, a.mesh, 1);
  std::cout << "floor " << mean(fb) << " " << *std::ranges::max_element(fb) << "  target there and back " << mean(ba) << " " << *std::ranges::max_element(ba) << std::endl;
  const MapEvaluation e = errors_of(m.forward, truth, b.mesh);
  const MapEvaluation r = errors_of(m.reverse, test::true_map(model, b, a), a.mesh);
  const std::vector<double> back = there_and_back(m, a.mesh, b.mesh, 1);
  std::cout << nlohmann::json{{"case", kind},
                              {"pair", k},
                              {"mean", e.errors.mean},
                              {"p95", e.errors.p95},
                              {"worst", e.errors.worst},
                              {"reverse_mean", r.errors.mean},
                              {"confidence_ratio", e.confidence_ratio},
                              {"back_mean", mean(back)},
                              {"back_worst", *std::ranges::max_element(back)},
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
