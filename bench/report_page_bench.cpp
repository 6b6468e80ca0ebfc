// How small an animation gets in a report page, at what error and in what time.
#include <benchmark/benchmark.h>

#include <cmath>
#include <random>
#include <vector>

#include "report/html/components.h"
#include "report/html/mesh_viewer.h"

namespace {

using namespace kinemesh;

// A sheet of `side` × `side` vertices, 150 mm wide: waves of several speeds, head motion, and
// noise of 0.1 mm on every coordinate, which no compression gets rid of.
AnimatedMesh noisy_sheet(VertexIndex side, std::size_t frames, double rate_hz) {
  std::vector<Triangle> faces;
  for (VertexIndex r = 0; r + 1 < side; ++r) {
    for (VertexIndex c = 0; c + 1 < side; ++c) {
      const VertexIndex a = r * side + c;
      faces.push_back({a, a + side, a + 1});
      faces.push_back({a + 1, a + side, a + side + 1});
    }
  }
  const std::size_t vertices = static_cast<std::size_t>(side) * side;
  AnimatedMesh mesh(Topology::create(vertices, faces), frames, rate_hz);
  std::minstd_rand random(1);
  const auto noise = [&random] { return 2e-4F * static_cast<float>(random() % 1001) - 0.1F; };
  for (std::size_t f = 0; f < frames; ++f) {
    const auto t = static_cast<float>(static_cast<double>(f) / rate_hz);
    const float turn = 0.2F * std::sin(0.6F * t);
    for (VertexIndex v = 0; v < vertices; ++v) {
      const float x = 150.0F * (static_cast<float>(v % side) / static_cast<float>(side - 1) - 0.5F);
      const float y = 150.0F * (0.5F - static_cast<float>(v / side) / static_cast<float>(side - 1));
      const float z = 60.0F - 0.006F * (x * x + y * y) + 4.0F * std::sin(3.0F * t + 0.05F * x) +
                      2.0F * std::sin(11.0F * t - 0.09F * y);
      mesh.position(f, v) << x * std::cos(turn) + z * std::sin(turn) + noise(), y + noise(),
          z * std::cos(turn) - x * std::sin(turn) + noise();
    }
  }
  return mesh;
}

void page_of(benchmark::State& state) {
  const auto side = static_cast<VertexIndex>(state.range(0));
  const auto frames = static_cast<std::size_t>(state.range(1));
  const AnimatedMesh mesh = noisy_sheet(side, frames, 120.0);
  RunContext ctx;
  ctx.set_threads(0);
  for (auto _ : state) {
    const MeshViewer viewer(mesh, {}, ctx);
    HtmlPage page("Page");
    page.add_section("Animated mesh").add(viewer);
    state.counters["page_MB"] = static_cast<double>(page.html().size()) / 1e6;
    state.counters["max_error_mm"] = viewer.code().max_error_mm;
    state.counters["rms_error_mm"] = viewer.code().rms_error_mm;
  }
  state.counters["raw_MB"] = static_cast<double>(mesh.positions().size_bytes()) / 1e6;
  state.SetLabel(std::to_string(side * side) + " vertices × " + std::to_string(frames) +
                 " frames with 0.1 mm noise");
}
BENCHMARK(page_of)
    ->Args({13, 3000})
    ->Args({71, 7200})
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

}  // namespace
