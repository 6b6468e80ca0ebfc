// Exact geodesics beside CGAL's Surface_mesh_shortest_path: time, windows, error and peak memory.
// Prints one JSON object a line; tools/verify.d/7_geodesics judges them. Times are CPU times of the
// one thread (best of several for ours), so that other programs disturb them less.
//
//   geodesics_bench compare MESH [SOURCES]       ours and CGAL from the same sources
//   geodesics_bench scaling MESH COUNT…          the mesh smoothed (Loop) and remeshed to COUNT
//                                                vertices; CGAL up to 50,000
//   geodesics_bench all-pairs MESH [THREADS]     every vertex to every vertex, in memory
//   geodesics_bench peak ours|cgal MESH [COUNT]  peak memory of one search
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_shortest_path.h>
#include <CGAL/subdivision_method_3.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "config/error.h"
#include "mesh/formats/mesh_io.h"
#include "mesh/geodesics/all_pairs.h"
#include "mesh/geodesics/geodesics.h"

namespace {

using namespace kinemesh;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;
using ShortestPath =
    CGAL::Surface_mesh_shortest_path<CGAL::Surface_mesh_shortest_path_traits<Kernel, SurfaceMesh>>;
using Json = nlohmann::ordered_json;

struct Input {
  std::shared_ptr<const Topology> topology;
  std::vector<Eigen::Vector3d> positions;
};

Input load(const std::string& path) {
  const Mesh mesh = read_mesh(builtin_mesh_formats(), path);
  Input input{mesh.topology, {}};
  for (const Eigen::Vector3f& p : mesh.positions) input.positions.emplace_back(p.cast<double>());
  return input;
}

SurfaceMesh to_cgal(const Input& input) {
  SurfaceMesh mesh;
  for (const Eigen::Vector3d& p : input.positions) mesh.add_vertex({p.x(), p.y(), p.z()});
  for (const auto& [a, b, c] : input.topology->faces()) {
    mesh.add_face(SurfaceMesh::Vertex_index(a), SurfaceMesh::Vertex_index(b),
                  SurfaceMesh::Vertex_index(c));
  }
  return mesh;
}

Input from_cgal(SurfaceMesh& mesh) {
  mesh.collect_garbage();
  Input input;
  for (const auto v : mesh.vertices()) {
    const auto& p = mesh.point(v);
    input.positions.emplace_back(p.x(), p.y(), p.z());
  }
  std::vector<Triangle> faces;
  for (const auto f : mesh.faces()) {
    Triangle t;
    int corner = 0;
    for (const auto v : mesh.vertices_around_face(mesh.halfedge(f))) t[corner++] = v;
    faces.push_back(t);
  }
  input.topology = Topology::create(input.positions.size(), faces);
  return input;
}

/// The mesh smoothed by Loop subdivision until it has more vertices than asked for, and remeshed
/// to about `count` vertices of equal spacing.
Input remeshed(const Input& input, std::size_t count) {
  SurfaceMesh mesh = to_cgal(input);
  while (mesh.number_of_vertices() < count) {
    CGAL::Subdivision_method_3::Loop_subdivision(mesh, CGAL::parameters::number_of_iterations(1));
  }
  double area = 0.0;
  for (const auto f : mesh.faces()) {
    const auto h = mesh.halfedge(f);
    area += std::sqrt(CGAL::squared_area(mesh.point(mesh.source(h)), mesh.point(mesh.target(h)),
                                         mesh.point(mesh.target(mesh.next(h)))));
  }
  // Equilateral triangles: two faces of area √3/4 l² per vertex.
  const double length = std::sqrt(2.0 * area / (std::sqrt(3.0) * static_cast<double>(count)));
  CGAL::Polygon_mesh_processing::isotropic_remeshing(mesh.faces(), length, mesh,
                                                     CGAL::parameters::number_of_iterations(3));
  return from_cgal(mesh);
}

double cpu_ms() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

/// One search of ours: best time of `repeats` and the windows.
Json ours(const GeodesicSolver& solver, VertexIndex source, int repeats,
          std::vector<double>& distances) {
  const GeodesicField field = solver.solve(source);
  distances.resize(field.distances.size());
  const SurfacePoint point = vertex_point(solver.topology(), source);
  double best = 1e300;
  for (int i = 0; i < repeats; ++i) {
    const double begin = cpu_ms();
    solver.exact_distances(point, std::span<double>(distances));
    best = std::min(best, cpu_ms() - begin);
  }
  const auto windows = static_cast<double>(field.diagnostics.windows);
  return {{"source", source},
          {"ours_ms", best},
          {"windows", field.diagnostics.windows},
          {"ns_per_window", 1e6 * best / windows},
          {"peak_windows", field.diagnostics.peak_windows}};
}

double cgal(const SurfaceMesh& mesh, VertexIndex source, std::vector<double>& distances) {
  const double begin = cpu_ms();
  ShortestPath search(mesh);
  search.add_source_point(SurfaceMesh::Vertex_index(source));
  search.build_sequence_tree();
  const double spent = cpu_ms() - begin;
  distances.clear();
  for (const auto v : mesh.vertices()) {
    distances.push_back(search.shortest_distance_to_source_points(v).first);
  }
  return spent;
}

void compare(Json& row, const Input& input, VertexIndex source, bool with_cgal) {
  const GeodesicSolver solver(input.topology, input.positions);
  std::vector<double> distances, reference;
  row.update(ours(solver, source, input.positions.size() > 60000 ? 3 : 15, distances));
  row["vertices"] = input.positions.size();
  if (!with_cgal) return;
  row["cgal_ms"] = cgal(to_cgal(input), source, reference);
  double error = 0.0, path_error = 0.0;
  const GeodesicField field = solver.solve(source);
  for (VertexIndex v = 0; v < distances.size(); ++v) {
    const bool apart = std::isfinite(distances[v]) != (reference[v] >= 0.0);
    if (apart) error = 1e300;
    if (apart || v == source || !std::isfinite(distances[v])) continue;
    error = std::max(error, std::abs(distances[v] - reference[v]) / reference[v]);
    if (v % 17 != 0) continue;
    const double length = solver.path_to(field, v).length;
    path_error = std::max(path_error, std::abs(length - distances[v]) / distances[v]);
  }
  row["largest_relative_error"] = error;
  row["largest_path_error"] = path_error;
}

int run_compare(const std::string& path, int sources) {
  const Input input = load(path);
  for (int i = 0; i < sources; ++i) {
    Json row{{"mesh", path}};
    const auto source = static_cast<VertexIndex>((7 + i * 2654435761ULL) % input.positions.size());
    compare(row, input, source, true);
    std::cout << row.dump() << std::endl;
  }
  return 0;
}

int run_scaling(const std::string& path, const std::vector<std::string>& counts) {
  const Input coarse = load(path);
  for (const std::string& count : counts) {
    const Input input = remeshed(coarse, std::stoul(count));
    Json row{{"mesh", path}, {"asked", std::stoul(count)}};
    compare(row, input, 7, input.positions.size() <= 60000);
    std::cout << row.dump() << std::endl;
  }
  return 0;
}

int run_all_pairs(const std::string& path, int threads) {
  const Input input = load(path);
  const GeodesicSolver solver(input.topology, input.positions);
  RunContext ctx;
  ctx.set_threads(threads);
  const std::clock_t cpu = std::clock();
  const auto begin = std::chrono::steady_clock::now();
  const DistanceMatrix matrix = distance_matrix(solver, all_vertex_points(*input.topology), ctx);
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
  const Json row{{"mesh", path},
                 {"vertices", input.positions.size()},
                 {"threads", ctx.threads()},
                 {"wall_s", wall.count()},
                 {"cpu_s", static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC},
                 {"asymmetry", (matrix - matrix.transpose()).cwiseAbs().maxCoeff()}};
  std::cout << row.dump() << std::endl;
  return 0;
}

int run_peak(const std::string& who, const std::string& path, std::size_t count) {
  Input input = load(path);
  if (count > 0) input = remeshed(input, count);
  const auto used = [] {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_maxrss) / 1024.0;
  };
  std::vector<double> distances;
  const SurfaceMesh mesh = to_cgal(input);
  const double before = used();
  if (who == "cgal") {
    cgal(mesh, 7, distances);
  } else {
    const GeodesicSolver solver(input.topology, input.positions);
    distances.resize(input.positions.size());
    solver.exact_distances(vertex_point(*input.topology, 7), std::span<double>(distances));
  }
  std::cout << Json{{"mesh", path},
                    {"who", who},
                    {"vertices", input.positions.size()},
                    {"peak_mb", used() - before}}
                   .dump()
            << std::endl;
  return 0;
}

}  // namespace

int main(int argc, char** argv) try {
  const std::vector<std::string> words(argv + 1, argv + argc);
  const std::string mode = words.empty() ? "" : words[0];
  if (mode == "compare" && words.size() >= 2) {
    return run_compare(words[1], words.size() > 2 ? std::stoi(words[2]) : 1);
  }
  if (mode == "scaling" && words.size() >= 3)
    return run_scaling(words[1], {words.begin() + 2, words.end()});
  if (mode == "all-pairs" && words.size() >= 2) {
    return run_all_pairs(words[1], words.size() > 2 ? std::stoi(words[2]) : 2);
  }
  if (mode == "peak" && words.size() >= 3) {
    return run_peak(words[1], words[2], words.size() > 3 ? std::stoul(words[3]) : 0);
  }
  std::cerr << "geodesics_bench compare|scaling|all-pairs|peak …: see the top of its source\n";
  return 2;
} catch (const std::exception& e) {
  std::cerr << "geodesics_bench: " << e.what() << "\n";
  return 1;
}
