#include "mesh/surface_map_io.h"

#include <gtest/gtest.h>

#include "config/error.h"
#include "config/input_file.h"
#include "config/output_file.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_shapes.h"

namespace kinemesh::surface_map_io_test {
namespace {

SurfaceMap example(bool confident) {
  SurfaceMap map{"Anna smile", "Ben, smile", {}, {}};
  map.points = {{3, {0.1, 0.2, 0.7}}, {}, {0, {1.0 / 3, 1.0 / 3, 1.0 - 2.0 / 3}}};
  if (confident) map.confidence = {0.25, 0.0, 1.0};
  return map;
}

TEST(SurfaceMapIo, EveryFormatKeepsEveryNumber) {
  const test::TemporaryFolder folder;
  for (const char* name : {"m.csv", "m.json", "m.npz"}) {
    for (const bool confident : {false, true}) {
      const SurfaceMap map = example(confident);
      write_surface_map(folder.path() / name, map);
      const SurfaceMap again = read_surface_map(folder.path() / name);
      EXPECT_EQ(again.source_name, map.source_name);
      EXPECT_EQ(again.target_name, map.target_name);
      EXPECT_EQ(again.confidence, map.confidence);
      ASSERT_EQ(again.points.size(), map.points.size());
      for (std::size_t v = 0; v < map.points.size(); ++v) {
        EXPECT_EQ(again.points[v].face, map.points[v].face);
        EXPECT_EQ(again.points[v].weights, map.points[v].weights) << name;
      }
    }
  }
}

TEST(SurfaceMapIo, CsvIsAsDocumented) {
  const test::TemporaryFolder folder;
  write_surface_map(folder.path() / "m.csv", example(true));
  EXPECT_TRUE(read_file(folder.path() / "m.csv")
                  .starts_with("# kinemesh surface map, source -> target\n# source: Anna smile\n"
                               "# target: Ben, smile\nvertex,face,b0,b1,b2,confidence\n"
                               "0,3,0.1,0.2,0.7,0.25\n1,-1,0,0,0,0\n"));
}

TEST(SurfaceMapIo, PointsWithoutAPlaceNeedNoConfidence) {
  const test::TemporaryFolder folder;
  write_file(folder.path() / "m.csv",
             "vertex,face,b0,b1,b2,confidence\n0,-1,0,0,0,\n1,1,0.5,0.5,0,0.5\n2,-1,0,0,0,\n");
  write_file(folder.path() / "m.json",
             "{\"format\": \"kinemesh surface map\", \"points\": [[-1, 0, 0, 0], [1, 0.5, 0.5, 0],"
             " [-1, 0, 0, 0]], \"confidence\": [null, 0.5, null]}");
  for (const char* name : {"m.csv", "m.json"}) {
    const SurfaceMap map = read_surface_map(folder.path() / name);
    EXPECT_EQ(map.confidence, (std::vector<double>{0.0, 0.5, 0.0})) << name;
    EXPECT_FALSE(map.points[2].valid());
  }
}

TEST(SurfaceMapIo, MalformedFilesAreRefusedByLine) {
  const test::TemporaryFolder folder;
  const std::string head = "# source: a\nvertex,face,b0,b1,b2,confidence\n0,1,0.5,0.5,0,\n";
  const auto refused = [&](const std::string& text, const std::string& place) {
    write_file(folder.path() / "bad.csv", text);
    try {
      read_surface_map(folder.path() / "bad.csv");
      ADD_FAILURE() << text;
    } catch (const InputError& e) {
      EXPECT_EQ(e.details().place, place) << text;
    }
  };
  refused(head + "2,1,0.5,0.5,0,\n", "line 4");    // vertex 1 is missing
  refused(head + "1,1,0.5,0.4,0,\n", "line 4");    // sum
  refused(head + "1,1,1.5,-0.5,0,\n", "line 4");   // negative
  refused(head + "1,1.5,0.5,0.5,0,\n", "line 4");  // no face
  refused(head + "1,-2,0.5,0.5,0,\n", "line 4");
  refused(head + "1,1,0.5,nan,0,\n", "line 4");
  refused(head + "1,1,0.5,0.5,0,0.5\n", "line 4");  // confidence for one only
  refused(head + "1,1,0.5\n", "line 4");
  refused(head + "1,x,0.5,0.5,0,\n", "line 4");
  refused("0,1,0.5,0.5,0,\n", "line 1");
  refused("", "");
  for (const char* text :
       {"", "{", "[]", "{\"format\": \"x\"}", "{\"format\": \"kinemesh surface map\"}",
        "{\"format\": \"kinemesh surface map\", \"points\": [[1, 2]]}"}) {
    write_file(folder.path() / "bad.json", text);
    EXPECT_THROW(read_surface_map(folder.path() / "bad.json"), InputError) << text;
  }
  EXPECT_THROW(read_surface_map(folder.path() / "missing.csv"), InputError);
  EXPECT_THROW(read_surface_map(folder.path() / "map.txt"), UsageError);
  EXPECT_THROW(write_surface_map(folder.path() / "map.txt", example(false)), UsageError);
}

TEST(SurfaceMapIo, MapsAreCheckedAgainstTheirMeshes) {
  const test::Surface cube = test::cube(1, 1.0);
  SurfaceMap map;
  map.points.assign(cube.positions.size(), {11, {1, 0, 0}});
  EXPECT_NO_THROW(check_surface_map(map, *cube.topology, *cube.topology));
  map.points[4].face = 12;
  EXPECT_THROW(check_surface_map(map, *cube.topology, *cube.topology), InputError);
  map.points.pop_back();
  EXPECT_THROW(check_surface_map(map, *cube.topology, *cube.topology), InputError);
}

}  // namespace
}  // namespace kinemesh::surface_map_io_test
