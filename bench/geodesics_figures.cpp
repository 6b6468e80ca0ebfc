// What exact distances must satisfy on any mesh, also where no other program gives a reference:
// everything that Dijkstra reaches is reached, no further than along edges, in both directions
// alike, never further than a neighbour and the edge, and by a path as long as the distance.
// Prints one JSON object a line, for tools/verify.d/7_geodesics.
//
//   geodesics_figures check MESH… SOURCES   from so many vertices of each mesh
//   geodesics_figures flat                  rectangles with thin cells, where the truth is known
//   geodesics_figures slivers               shapes of genus 0 to 2, boundaries, with slivers
#include <algorithm>
#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "mesh/formats/mesh_io.h"
#include "mesh/geodesics/geodesics.h"
#include "mesh/geodesics/intrinsic_lengths.h"
#include "tests/support/test_shapes.h"

namespace kinemesh {
namespace {

struct Figures {
  std::size_t distances = 0, unreached = 0, paths = 0, paths_off = 0;
  double over_dijkstra = 0.0, asymmetry = 0.0, over_edge = 0.0, path_error = 0.0;
  double from_truth = 0.0;  ///< flat meshes

  void print(const std::string& name, std::size_t sources) const {
    std::cout << nlohmann::ordered_json{{"mesh", name},
                                        {"sources", sources},
                                        {"distances", distances},
                                        {"unreached", unreached},
                                        {"over_dijkstra", over_dijkstra},
                                        {"asymmetry", asymmetry},
                                        {"over_edge", over_edge},
                                        {"paths", paths},
                                        {"path_error", path_error},
                                        {"paths_off", paths_off},
                                        {"from_truth", from_truth}}
                     .dump()
              << std::endl;
  }
};

/// How much `value` is above `bound`, relative to `scale`.
double above(double value, double bound, double scale) {
  return scale > 0.0 ? std::max(0.0, value - bound) / scale : 0.0;
}

void check_field(const GeodesicSolver& solver, const GeodesicField& field,
                 const IntrinsicLengths& edges, Figures& figures) {
  GeodesicOptions along_edges;
  along_edges.method = GeodesicMethod::dijkstra;
  const GeodesicField upper = solver.solve(field.sources, along_edges);
  const std::vector<double>& d = field.distances;
  for (VertexIndex v = 0; v < d.size(); ++v) {
    if (!std::isfinite(upper.distances[v])) continue;
    ++figures.distances;
    if (!std::isfinite(d[v])) {
      ++figures.unreached;
      continue;
    }
    figures.over_dijkstra =
        std::max(figures.over_dijkstra, above(d[v], upper.distances[v], upper.distances[v]));
    if (v % 7 != 0 || !(d[v] > 0.0)) continue;
    const double off =
        std::abs(solver.path_to(field, v).length - d[v]) / std::max(d[v], edges.mean_length);
    figures.path_error = std::max(figures.path_error, off);
    figures.paths_off += off > 1e-9 ? 1 : 0;
    ++figures.paths;
  }
  const Topology& topology = solver.topology();
  for (HalfedgeIndex h = 0; h < edges.lengths.size(); ++h) {
    const double a = d[topology.from(h)], b = d[topology.to(h)];
    if (!std::isfinite(a) || !std::isfinite(b)) continue;
    figures.over_edge =
        std::max(figures.over_edge, above(std::abs(a - b), edges.lengths[h], std::max(a, b)));
  }
}

std::vector<VertexIndex> spread_sources(const Topology& topology, std::size_t count) {
  std::vector<VertexIndex> sources;
  for (uint64_t k = 0; sources.size() < std::min<std::size_t>(count, topology.vertex_count());
       ++k) {
    const auto v = static_cast<VertexIndex>(k * 2654435761ULL % topology.vertex_count());
    if (!topology.faces_of(v).empty() && std::ranges::find(sources, v) == sources.end()) {
      sources.push_back(v);
    }
  }
  return sources;
}

Figures check(const std::shared_ptr<const Topology>& topology,
              const std::vector<Eigen::Vector3d>& positions, std::size_t source_count,
              bool flat = false) {
  const GeodesicSolver solver(topology, positions);
  const IntrinsicLengths edges = intrinsic_lengths(*topology, positions);
  const std::vector<VertexIndex> sources = spread_sources(*topology, source_count);
  Figures figures;
  std::vector<GeodesicField> fields;
  for (const VertexIndex source : sources) {
    fields.push_back(solver.solve(source));
    check_field(solver, fields.back(), edges, figures);
    for (std::size_t other = 0; other + 1 < fields.size(); ++other) {
      const double there = fields[other].distances[source],
                   back = fields.back().distances[sources[other]];
      if (!std::isfinite(there) && !std::isfinite(back)) continue;
      figures.asymmetry = std::max(figures.asymmetry, std::abs(there - back) / there);
    }
    for (VertexIndex v = 0; flat && v < positions.size(); ++v) {
      const double truth = (positions[v] - positions[source]).norm();
      if (v == source) continue;
      figures.from_truth =
          std::max(figures.from_truth, std::abs(fields.back().distances[v] - truth) / truth);
    }
  }
  return figures;
}

void check_file(const std::string& path, std::size_t sources) {
  const Mesh mesh = read_mesh(builtin_mesh_formats(), path);
  std::vector<Eigen::Vector3d> positions;
  for (const Eigen::Vector3f& p : mesh.positions) positions.push_back(p.cast<double>());
  check(mesh.topology, positions, sources).print(path, sources);
}

void check_flat() {
  for (const double aspect : {1.0, 0.1, 1e-2, 1e-3, 3.447124558091775e-4, 1e-4, 1e-5, 1e-6, 1e-7,
                              1e-8, 1e-9, 1e-10, 1e-11}) {
    for (const uint64_t seed : {1, 2, 3}) {
      std::vector<double> x, y;
      for (int k = 0; k < 25; ++k) {
        x.push_back(k);
        y.push_back(static_cast<float>(k * aspect));
      }
      const test::Surface s = test::rectangle(x, y, seed);
      check(s.topology, s.positions, 12, true)
          .print("25 x 25, cells 1 x " + nlohmann::json(aspect).dump(), 12);
    }
  }
}

void check_slivers() {
  using test::bumpy, test::sphere, test::torus, test::double_ring, test::plane_with_hole;
  const std::pair<const char*, test::Surface> shapes[] = {
      {"sphere", bumpy(sphere(3, 10.0), 0.5, 6.0)},
      {"torus", bumpy(torus(30, 14, 10.0, 4.0, 0.3, 3), 0.5, 6.0)},
      {"double ring (genus 2)", double_ring()},
      {"plane with a hole", plane_with_hole(14, 4, 9)}};
  for (const auto& [name, shape] : shapes) {
    for (const double height : {1e-2, 1e-4, 1e-6, 1e-8, 1e-10}) {
      const test::Surface s = test::with_slivers(shape, height, 5);
      check(s.topology, s.positions, 10)
          .print(std::string(name) + ", slivers of height " + nlohmann::json(height).dump(), 10);
    }
  }
}

int run(const std::vector<std::string>& words) {
  if (words.size() >= 3 && words[0] == "check") {
    for (std::size_t k = 1; k + 1 < words.size(); ++k) {
      check_file(words[k], std::stoul(words.back()));
    }
    return 0;
  }
  if (words.size() == 1 && (words[0] == "flat" || words[0] == "slivers")) {
    words[0] == "flat" ? check_flat() : check_slivers();
    return 0;
  }
  std::cerr << "geodesics_figures check|flat|slivers …: see the top of its source\n";
  return 2;
}

}  // namespace
}  // namespace kinemesh

int main(int argc, char** argv) try {
  return kinemesh::run({argv + 1, argv + argc});
} catch (const std::exception& e) {
  std::cerr << "geodesics_figures: " << e.what() << "\n";
  return 1;
}
