// Time, memory and bytes moved of deformation, scale space and detection, one JSON object a line:
//   anim_dog_bench MESH [thesis|best] [THREADS] [REPEATS]
//   anim_dog_bench generate VERTICES FRAMES SMOOTHINGS TIME_SMOOTHINGS [THREADS]
// Beside it the bandwidth of the cache and of memory, measured in the same run with as many
// threads.
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include "analysis/anim_dog.h"
#include "bench/grid.h"
#include "config/multiversion.h"
#include "config/parallel.h"
#include "mesh/formats/mesh_io.h"

using namespace kinemesh;

namespace {

struct Spent {
  double wall = 1e300, cpu = 1e300;
};

template <class Work>
Spent best_of(int repeats, Work work) {
  Spent best;
  for (int i = 0; i < repeats; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    const std::clock_t cpu = std::clock();
    work();
    best.cpu = std::min(best.cpu, static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC);
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
    best.wall = std::min(best.wall, wall.count());
  }
  return best;
}

KINEMESH_MULTIVERSION void triad(float* a, const float* b, const float* c, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) a[i] = b[i] + 0.5F * c[i];
}

/// GB per second of CPU time and thread, for arrays of `floats` each.
double bandwidth(std::size_t floats, std::size_t rounds) {
  std::vector<float> a(floats, 1.0F), b(floats, 2.0F), c(floats, 3.0F);
  const Spent spent = best_of(3, [&] {
    for (std::size_t r = 0; r < rounds; ++r) triad(a.data(), b.data(), c.data(), floats);
  });
  return 12.0 * static_cast<double>(floats * rounds) / spent.cpu / 1e9;
}

/// A sheet with travelling waves: about as many vertices as asked for.
AnimatedMesh generated(std::size_t vertices, std::size_t frames) {
  const auto side = static_cast<uint32_t>(std::lround(std::sqrt(static_cast<double>(vertices))));
  AnimatedMesh mesh(Topology::create(std::size_t{side} * side, grid_faces(side)), frames, 60);
  for (std::size_t f = 0; f < frames; ++f) {
    for (uint32_t v = 0; v < mesh.vertex_count(); ++v) {
      const auto x = static_cast<float>(v % side), y = static_cast<float>(v / side);
      const float t = static_cast<float>(f) / 60.0F;
      mesh.position(f, v) =
          Eigen::Vector3f(x, y,
                          3.0F * std::sin(0.11F * x + 2.0F * t) * std::sin(0.07F * y - 3.0F * t) *
                              std::sin(0.6F * t));
    }
  }
  return mesh;
}

void report(const AnimatedMesh& mesh, const DeformationOptions& deformation,
            const DetectOptions& detect, int threads, int repeats) {
  RunContext ctx;
  ctx.set_threads(threads);
  DetectResult result;
  DeformationResult d;
  const Spent first = best_of(repeats, [&] { d = deformation_of(mesh, deformation, ctx); });
  const Spent second = best_of(repeats, [&] { result = detect_features(mesh, d, detect, ctx); });
  // Per sample: smoothing and D read four values and write two; the minima read three and write
  // two; the test reads six. Per spatial pass and sample: eight reads (ring of six) and a write.
  const double samples = static_cast<double>(result.samples);
  const double bytes = samples * 17 * 4 + result.spatial_passes * 9 * 4 *
                                              static_cast<double>(mesh.vertex_count()) *
                                              static_cast<double>(mesh.frame_count());
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const double cache = bandwidth(16384, 20000), memory = bandwidth(16U << 20U, 4);
  std::printf(
      "{\"vertices\": %zu, \"frames\": %zu, \"samples\": %.0f, \"threads\": %d, "
      "\"deformation_cpu_s\": %.3f, \"detection_cpu_s\": %.3f, \"cpu_s\": %.3f, \"wall_s\": %.3f, "
      "\"gigabytes\": %.1f, \"cache_gb_s\": %.1f, \"memory_gb_s\": %.1f, \"bandwidth_ratio\": "
      "%.2f, "
      "\"features\": %zu, \"extrema\": %zu, \"tiles\": %zu, \"level_mb\": %.1f, \"peak_mb\": "
      "%.0f}\n",
      mesh.vertex_count(), mesh.frame_count(), samples, threads, first.cpu, second.cpu,
      first.cpu + second.cpu, first.wall + second.wall, bytes / 1e9, cache, memory,
      bytes / 1e9 / second.cpu / cache, result.set.features.size(), result.extrema, result.tiles,
      static_cast<double>(result.level_bytes) / 1e6, static_cast<double>(usage.ru_maxrss) / 1e3);
}

}  // namespace

int main(int argc, char** argv) {
  const auto word = [&](int i, const char* otherwise) {
    return std::string(argc > i ? argv[i] : otherwise);
  };
  DeformationOptions deformation;
  DetectOptions detect;
  if (word(1, "") == "generate") {
    set_thesis_preset(deformation, detect);
    detect.smoothings = std::stoi(word(4, "100"));
    detect.time_smoothings = std::stoi(word(5, "150"));
    const AnimatedMesh mesh = generated(std::stoul(word(2, "50000")), std::stoul(word(3, "500")));
    report(mesh, deformation, detect, std::stoi(word(6, "2")), 1);
    return 0;
  }
  if (word(2, "thesis") == "thesis") {
    set_thesis_preset(deformation, detect);
    detect.smoothings = 77;
    detect.time_smoothings = 54;
  }
  const AnimatedMesh mesh = read_animation(builtin_mesh_formats(), word(1, ""));
  report(mesh, deformation, detect, std::stoi(word(3, "2")), std::stoi(word(4, "3")));
  return 0;
}
