// Reading of mesh files beside fread of the same file into a fresh buffer, cache warm. Decoding
// alone, and the whole way to an AnimatedMesh (adjacency built). Bytes per second of the file.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>

#include "bench/grid.h"
#include "config/buffer.h"
#include "config/input_file.h"
#include "mesh/formats/bytes.h"
#include "mesh/formats/gltf.h"
#include "mesh/formats/mesh_io.h"
#include "mesh/formats/obj.h"
#include "mesh/formats/off.h"
#include "mesh/formats/ply.h"
#include "mesh/formats/point_cache.h"

namespace {

using namespace kinemesh;
namespace fs = std::filesystem;

/// A wavy grid of 10 mm cells; `frames` of it.
AnimatedMesh wavy_grid(uint32_t side, std::size_t frames) {
  AnimatedMesh mesh(Topology::create(std::size_t{side} * side, grid_faces(side)), frames, 120.0);
  for (std::size_t f = 0; f < frames; ++f) {
    const double t = static_cast<double>(f) / 120.0;
    for (uint32_t v = 0; v < side * side; ++v) {
      const double x = 3.0 * (v % side), y = 3.0 * (v / side);
      double z = 0.002 * (x - 90) * (y - 80);
      for (int k = 1; k <= 6; ++k) {
        z += 6.0 / k * std::sin(0.9 * k * t + k * k) * std::sin(0.013 * k * x + k) *
             std::cos(0.017 * k * y);
      }
      mesh.position(f, v) =
          Eigen::Vector3d(x + 4 * std::sin(0.7 * t), y + 2 * std::cos(1.1 * t), z).cast<float>();
    }
  }
  return mesh;
}

/// The same with 24 bumps of some 15 mm that travel over it on paths of their own: a motion that no
/// small number of modes describes.
AnimatedMesh lively_grid(uint32_t side, std::size_t frames) {
  AnimatedMesh mesh = wavy_grid(side, frames);
  const double width = 3.0 * (side - 1);
  for (std::size_t f = 0; f < frames; ++f) {
    const double t = static_cast<double>(f) / 120.0;
    for (int k = 0; k < 24; ++k) {
      const double cx = width * (0.5 + 0.45 * std::sin((0.31 + 0.07 * k) * t + 1.3 * k));
      const double cy = width * (0.5 + 0.45 * std::cos((0.43 + 0.05 * k) * t + 0.7 * k));
      const double height = 3.0 * std::sin((1.0 + 0.21 * k) * t + k);
      for (uint32_t v = 0; v < side * side; ++v) {
        const double dx = 3.0 * (v % side) - cx, dy = 3.0 * (v / side) - cy;
        const double far = 1.0 + (dx * dx + dy * dy) / 450.0;
        mesh.position(f, v).z() += static_cast<float>(height / (far * far));
      }
    }
  }
  return mesh;
}

/// Files made once per run in a temporary folder.
class Files {
 public:
  Files() {
    std::string name = (fs::temp_directory_path() / "kinemesh_bench_XXXXXX").string();
    if (::mkdtemp(name.data()) != nullptr) folder_ = name;
  }
  Files(const Files&) = delete;
  Files& operator=(const Files&) = delete;
  ~Files() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  const fs::path& get(const std::string& kind) {
    fs::path& path = made_[kind];
    if (path.empty()) path = make(kind);
    return path;
  }

 private:
  fs::path make(const std::string& kind) const {
    const FormatRegistry formats = builtin_mesh_formats();
    WriteOptions options;
    if (kind == "ply_ascii") options.encoding = Encoding::ascii;
    if (kind == "ply_big") options.encoding = Encoding::binary_big;
    const std::string extension = kind.starts_with("ply") ? "ply" : kind;
    const fs::path path = folder_ / (kind + "." + extension);
    const bool animation = kind == "pc2" || kind == "mdd";
    write_animation(formats, animation ? wavy_grid(100, 1000) : wavy_grid(1000, 1), path, options);
    return path;
  }
  fs::path folder_;
  std::map<std::string, fs::path> made_;
};

Files& files() {
  static Files all;
  return all;
}

void count_bytes(benchmark::State& state, const fs::path& path) {
  const auto bytes = static_cast<double>(fs::file_size(path));
  state.counters["MB"] = bytes / 1e6;
  state.counters["MB/s"] =
      benchmark::Counter(bytes / 1e6, benchmark::Counter::kIsIterationInvariantRate);
}

void fread_reference(benchmark::State& state, const std::string& kind) {
  const fs::path& path = files().get(kind);
  for (auto _ : state) {
    Buffer<std::byte> buffer(fs::file_size(path));
    std::FILE* file = std::fopen(path.c_str(), "rb");
    benchmark::DoNotOptimize(std::fread(buffer.data(), 1, buffer.size(), file));
    std::fclose(file);
  }
  count_bytes(state, path);
}

MeshData decode_file(const fs::path& path, const std::string& kind) {
  if (kind == "pc2") return read_pc2_positions(path);
  if (kind == "mdd") return read_mdd_positions(path);
  const Buffer<std::byte> bytes = load_bytes(path);
  const auto decode = kind == "obj" ? decode_obj : kind == "off" ? decode_off : decode_ply;
  return decode(bytes.span(), path.string());
}

void decode_bench(benchmark::State& state, const std::string& kind) {
  const fs::path& path = files().get(kind);
  for (auto _ : state) benchmark::DoNotOptimize(decode_file(path, kind).positions.data());
  count_bytes(state, path);
}

void mesh_bench(benchmark::State& state, const std::string& kind) {
  const fs::path& path = files().get(kind);
  const FormatRegistry formats = builtin_mesh_formats();
  for (auto _ : state) benchmark::DoNotOptimize(read_animation(formats, path).positions().data());
  count_bytes(state, path);
}

/// 5,000 vertices × 60 s × 120 Hz into the default budget.
void glb_bench(benchmark::State& state, AnimatedMesh (*make)(uint32_t, std::size_t)) {
  const AnimatedMesh mesh = make(71, 7200);
  for (auto _ : state) {
    const GltfContent content = encode_gltf(mesh, {}, "", RunContext());
    state.counters["MB"] =
        static_cast<double>(content.json.size() + content.binary.size() + 28) / 1e6;
    state.counters["max_error_mm"] = content.report.max_error_mm;
    state.counters["rms_error_mm"] = content.report.rms_error_mm;
  }
}

}  // namespace

int main(int argc, char** argv) {
  for (const char* kind : {"ply", "ply_big", "ply_ascii", "obj", "off", "pc2", "mdd"}) {
    const std::string name(kind);
    const auto add = [&name](const std::string& what,
                             void (*run)(benchmark::State&, const std::string&)) {
      benchmark::RegisterBenchmark((what + "/" + name).c_str(), [run,
                                                                 name](benchmark::State& state) {
        run(state, name);
      })->Unit(benchmark::kMillisecond);
    };
    add("fread", fread_reference);
    add("decode", decode_bench);
    add("mesh", mesh_bench);
  }
  const auto add_glb = [](const char* name, AnimatedMesh (*make)(uint32_t, std::size_t)) {
    benchmark::RegisterBenchmark(name, [make](benchmark::State& state) { glb_bench(state, make); })
        ->Unit(benchmark::kMillisecond)
        ->Iterations(1);
  };
  add_glb("glb/wavy", wavy_grid);
  add_glb("glb/lively", lively_grid);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
