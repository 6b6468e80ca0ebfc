// kinemesh evaluate map as a user runs it.
#include <nlohmann/json.hpp>

#include "config/output_file.h"
#include "mesh/formats/mesh_io.h"
#include "mesh/geodesics/geodesics.h"
#include "mesh/landmarks.h"
#include "mesh/surface_map_io.h"
#include "tests/support/command_test.h"
#include "tests/support/data.h"
#include "tests/support/test_shapes.h"

namespace kinemesh::evaluate_map_test {
namespace {

class EvaluateMapCommand : public test::CommandTest {
 protected:
  EvaluateMapCommand() : CommandTest(std::string(KINEMESH_PROGRAM) + " evaluate map") {}
};

/// Vertex k of the list's lines to vertex k of the other's: a map that is exact there.
SurfaceMap map_of(const std::vector<VertexIndex>& from, const std::vector<VertexIndex>& to,
                  std::size_t vertices, const Topology& target) {
  SurfaceMap map;
  map.points.resize(vertices);
  for (std::size_t k = 0; k < from.size(); ++k) map.points[from[k]] = vertex_point(target, to[k]);
  return map;
}

TEST_F(EvaluateMapCommand, ReadsBenchmarkListsAndDrawsSeveralMapsInOnePlot) {
  KINEMESH_NEED_DATA("tosca_cat/cat0.off");
  const auto cat0 = test::data_folder() / "tosca_cat/cat0.off";
  const std::string folder = cat0.parent_path().string() + "/";
  const Mesh a = read_mesh(builtin_mesh_formats(), cat0);
  const Mesh b = read_mesh(builtin_mesh_formats(), folder + "cat1.off");
  const auto list_a = read_vertex_list(folder + "cat0.vts", a.positions.size());
  const auto direct = read_vertex_list(folder + "cat1.vts", b.positions.size());
  const auto mirrored = read_vertex_list(folder + "cat1.sym.vts", b.positions.size());
  write_surface_map(place("direct.csv"), map_of(list_a, direct, a.positions.size(), *b.topology));
  write_surface_map(place("mirror.csv"), map_of(list_a, mirrored, a.positions.size(), *b.topology));
  ASSERT_EQ(run(place("direct.csv") + " " + place("mirror.csv") + " --truth " + folder +
                "cat0.vts " + folder + "cat1.vts --mirrored " + folder +
                "cat1.sym.vts --samples 50 --json --target " + folder + "cat1.off --curve " +
                place("c.svg") + " --curve " + place("c.png") + " --curve " + place("c.csv")),
            0)
      << errors_;
  const nlohmann::json json = nlohmann::json::parse(output_);
  ASSERT_EQ(json.size(), 2U);
  // Several lines of a list may name one vertex; then the map knows the last only.
  EXPECT_LT(json[0]["errors"]["median"], 1e-9);
  EXPECT_LT(json[0]["errors"]["mean"], 0.02);
  EXPECT_GT(json[1]["errors"]["mean"], 0.1);
  EXPECT_LT(json[1]["against_mirrored"]["mean"], 0.02);
  EXPECT_GT(json[0]["errors"]["area_under_curve"], 0.9);
  EXPECT_NE(read_file(place("c.svg")).find("direct.csv"), std::string::npos);
  EXPECT_EQ(read_file(place("c.png")).substr(1, 3), "PNG");
  EXPECT_EQ(read_file(place("c.csv")).substr(0, 21), "error_over_root_area,");
}

TEST_F(EvaluateMapCommand, ComparesWithATrueMapAndWithPairs) {
  const test::Surface cube = test::cube(4, 10);
  AnimatedMesh mesh(cube.topology, 1, 0);
  for (VertexIndex v = 0; v < mesh.vertex_count(); ++v)
    mesh.position(0, v) = cube.positions[v].cast<float>();
  write_animation(builtin_mesh_formats(), mesh, place("cube.ply"));
  SurfaceMap map;
  map.target_name = place("cube.ply");
  for (VertexIndex v = 0; v < mesh.vertex_count(); ++v)
    map.points.push_back(vertex_point(*cube.topology, v));
  write_surface_map(place("m.csv"), map);
  ASSERT_EQ(run(place("m.csv") + " --truth " + place("m.csv") + " --json"), 0) << errors_;
  EXPECT_LT(nlohmann::json::parse(output_)[0]["errors"]["worst"], 1e-9);
  write_file(place("pairs.txt"), "0 0\n7 7 corner\n");
  ASSERT_EQ(run(place("m.csv") + " --truth " + place("pairs.txt") + " --source " +
                place("cube.ply") + " --json"),
            0)
      << errors_;
  EXPECT_EQ(nlohmann::json::parse(output_)[0]["errors"]["places"], 2);
  EXPECT_EQ(run(place("m.csv") + " --truth " + place("pairs.txt")), 2);
  EXPECT_EQ(run(place("m.csv") + " --truth " + place("none.csv")), 3);
  EXPECT_EQ(run(place("m.csv") + " --truth " + place("m.csv") + " --curve " + place("c.gif")), 2);
}

}  // namespace
}  // namespace kinemesh::evaluate_map_test
