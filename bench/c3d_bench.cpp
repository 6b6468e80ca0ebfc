// Time and peak memory of the C3D reader beside ezc3d, and beside fread into a fresh buffer with a
// float sum, on generated files of 0.5 to 500 MB, integer and float. Peak memory is measured in
// child processes (this program with --peak-of). All single-threaded, cache warm.
#include <benchmark/benchmark.h>
#include <malloc.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include "capture/c3d/ezc3d_reader.h"
#include "capture/c3d/reader.h"
#include "capture/c3d/writer.h"

namespace {

using namespace kinemesh;

constexpr std::size_t markers = 60;
constexpr std::array<double, 6> sizes_mb = {0.5, 1, 10, 50, 100, 500};

/// A file of about this size, written once per run into a temporary folder.
class Files {
 public:
  Files() {
    std::string name = (std::filesystem::temp_directory_path() / "kinemesh_bench_XXXXXX").string();
    if (::mkdtemp(name.data()) != nullptr) folder_ = name;
  }
  Files(const Files&) = delete;
  Files& operator=(const Files&) = delete;
  ~Files() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  const std::filesystem::path& get(double megabytes, bool integers) {
    std::filesystem::path& path = made_[{megabytes, integers}];
    if (path.empty()) path = make(megabytes, integers);
    return path;
  }

 private:
  std::filesystem::path make(double megabytes, bool integers) {
    const double frame_bytes = static_cast<double>(markers) * (integers ? 8.0 : 16.0);
    const auto frames = static_cast<std::size_t>(megabytes * 1e6 / frame_bytes);
    std::vector<Marker> names(markers);
    for (std::size_t m = 0; m < markers; ++m) names[m].label = "M" + std::to_string(m + 1);
    MarkerSequence take(frames, names, 100.0);
    for (std::size_t i = 0; i < take.sample_count(); ++i) {
      for (std::size_t k = 0; k < 3; ++k)
        take.positions()[3 * i + k] = static_cast<float>((i * 7 + k * 1001) % 20'000) * 0.1F + 1.0F;
      take.flags()[i] = i % 17 != 0 ? SampleFlag::valid : 0;
      take.residuals()[i] = 0.5F;
      take.camera_masks()[i] = static_cast<uint8_t>(i % 128);
    }
    take.origin.path = "made for the benchmark";
    take.origin.scale = -0.1;
    const auto path =
        folder_ / ((integers ? "int_" : "float_") + std::to_string(megabytes) + ".c3d");
    write_c3d(take, path, {.storage = integers ? "int" : "float", .scale = integers ? 0.1 : 0.0});
    return path;
  }
  std::filesystem::path folder_;
  std::map<std::pair<double, bool>, std::filesystem::path> made_;
};

Files& files() {
  static Files all;
  return all;
}

// ---- what is compared ---------------------------------------------------------------------------

std::size_t decoded_bytes(const std::string& path) {
  const C3dReadResult r = read_c3d(path);
  benchmark::DoNotOptimize(r.take.positions().data());
  return r.take.sample_count() * (3 * sizeof(float) + 1 + sizeof(float) + 1) +
         r.take.analog.values.size() * sizeof(float);
}

void fread_and_sum(const std::string& path) {
  std::FILE* file = std::fopen(path.c_str(), "rb");
  if (file == nullptr) return;
  const std::size_t bytes = std::filesystem::file_size(path);
  auto* buffer = static_cast<float*>(std::malloc(bytes));
  const std::size_t got = std::fread(buffer, 1, bytes, file);
  std::fclose(file);
  float sum = 0.0F;
  for (std::size_t i = 0; i < got / sizeof(float); ++i) sum += buffer[i];
  benchmark::DoNotOptimize(sum);
  std::free(buffer);
}

std::size_t run(const std::string& what, const std::string& path) {
  if (what == "own") return decoded_bytes(path);
  if (what == "ezc3d") return load_with_ezc3d(path);
  fread_and_sum(path);
  return 0;
}

// ---- peak memory --------------------------------------------------------------------------------

double status_mb(const char* key) {
  std::ifstream status("/proc/self/status");
  std::string line;
  while (std::getline(status, line)) {
    if (line.starts_with(key))
      return std::strtod(line.c_str() + std::strlen(key) + 1, nullptr) * 1024.0 / 1e6;
  }
  return 0.0;
}

/// In the child: prints the peak above what the program takes anyway, and the decoded arrays.
int print_peak(const std::string& what, const std::string& path) {
  const double before = status_mb("VmRSS");
  const std::size_t decoded = run(what, path);
  std::printf("%.3f %.3f\n", status_mb("VmHWM") - before, static_cast<double>(decoded) / 1e6);
  return 0;
}

std::pair<double, double> peak_of(const std::string& what, const std::string& path) {
  static std::map<std::string, std::pair<double, double>> known;  // repetitions share it
  if (const auto it = known.find(what + path); it != known.end()) return it->second;
  const std::string self = std::filesystem::read_symlink("/proc/self/exe").string();
  const std::string command = "'" + self + "' --peak-of " + what + " '" + path + "'";
  std::FILE* child = ::popen(command.c_str(), "r");
  double peak = 0.0;
  double decoded = 0.0;
  if (child == nullptr || std::fscanf(child, "%lf %lf", &peak, &decoded) != 2) peak = std::nan("");
  if (child != nullptr) ::pclose(child);
  return known[what + path] = {peak, decoded};
}

void measure(benchmark::State& state, const std::string& what, double megabytes, bool integers) {
  const std::string path = files().get(megabytes, integers).string();
  fread_and_sum(path);  // warms the cache
  for (auto _ : state) run(what, path);
  const double bytes = static_cast<double>(std::filesystem::file_size(path));
  state.counters["MB_per_s"] =
      benchmark::Counter(bytes / 1e6, benchmark::Counter::kIsIterationInvariantRate);
  state.counters["Msamples_per_s"] = benchmark::Counter(
      bytes / (integers ? 8.0 : 16.0) / 1e6, benchmark::Counter::kIsIterationInvariantRate);
  const auto [peak, decoded] = peak_of(what, path);
  state.counters["peak_MB"] = peak;
  if (what == "own") state.counters["decoded_MB"] = decoded;
}

void register_all() {
  for (const bool integers : {false, true}) {
    for (const double megabytes : sizes_mb) {
      for (const char* what : {"fread", "own", "ezc3d"}) {
        char name[100];
        std::snprintf(name, sizeof name, "%s/%s/%gMB", what, integers ? "int" : "float", megabytes);
        benchmark::RegisterBenchmark(
            name, [=](benchmark::State& state) { measure(state, what, megabytes, integers); })
            ->Unit(benchmark::kMillisecond)
            ->Iterations(1);
      }
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  // Large blocks always come fresh from the kernel, for all that is compared: otherwise the second
  // round would find its pages mapped already.
  ::mallopt(M_MMAP_THRESHOLD, 128 * 1024);
  if (argc == 4 && std::string(argv[1]) == "--peak-of") return print_peak(argv[2], argv[3]);
  register_all();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
