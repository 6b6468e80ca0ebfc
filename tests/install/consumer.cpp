// Builds only if headers, libraries and their dependencies were installed and exported.
#include <capture/c3d/reader.h>
#include <mesh/topology.h>

#include <cstdio>

int main(int argc, char** argv) {
  const kinemesh::Topology tetrahedron(4, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}});
  std::printf("euler %d\n", static_cast<int>(tetrahedron.euler_characteristic()));
  if (argc > 1) {
    const auto result = kinemesh::read_c3d(argv[1]);
    std::printf("markers %zu\n", result.take.marker_count());
  }
  return 0;
}
