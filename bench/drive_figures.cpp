// Drives model faces by their markers in all 57 expressions with every method and compares with the
// truth; then the speed of the product. One JSON object a line on stdout; for
// tools/verify.d/10_driving. `drive_figures [IDENTITIES]`.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <tuple>
#include <vector>

#include "config/multiversion.h"
#include "reconstruct/animate_scan.h"
#include "reconstruct/spread_product.h"
#include "tests/support/ict_expressions.h"

namespace kinemesh {
namespace {

struct Way {
  const char* name;
  DriveOptions options;
};

std::vector<Way> ways() {
  std::vector<Way> all;
  for (const auto& [name, method, smooth] :
       {std::tuple{"surface", DriveMethod::surface, true},
        std::tuple{"surface, exact at the markers", DriveMethod::surface, false},
        std::tuple{"geodesic", DriveMethod::geodesic, false},
        std::tuple{"biharmonic", DriveMethod::biharmonic, false},
        std::tuple{"euclidean", DriveMethod::euclidean, false}}) {
    DriveOptions options;
    options.method = method;
    options.smooth = smooth;
    all.push_back({name, options});
  }
  return all;
}

void accuracy(uint64_t identity) {
  const auto ict = test::ict_expressions(identity);
  const auto left_out = test::draw_markers(20, ict.markers.size(), identity + 100);
  for (const Way& way : ways()) {
    const DriveResult driven = drive_scan(ict.scan, ict.markers, ict.measured, way.options);
    const auto all = test::drive_error(ict, driven.animation);
    const auto near = test::drive_error(ict, driven.animation, ict.near_markers);
    const auto out = test::left_out_error(ict, left_out, way.options);
    std::printf(
        "{\"identity\": %d, \"method\": \"%s\", \"markers\": %zu, \"mean\": %.4f, "
        "\"p95\": %.4f, \"near_mean\": %.4f, \"near_p95\": %.4f, \"left_out_mean\": %.4f, "
        "\"left_out_p95\": %.4f, \"noise_mm\": %.3f, \"operator_s\": %.2f}\n",
        static_cast<int>(identity), way.name, ict.markers.size(), all.mean, all.p95, near.mean,
        near.p95, out.mean, out.p95, driven.noise_mm, driven.operator_seconds);
    std::fflush(stdout);
  }
}

/// Markers found on the scan of a face that moves its head while it performs.
void registration(uint64_t identity) {
  const test::IctModel& model = test::ict_model();
  const auto points = test::place_ict_markers(model, 9.0, 70 + identity);
  const test::IctActor actor(model, {.seed = identity},
                             test::make_ict_motion(model, identity + 1, 2.0));
  const test::IctTake take = test::record_ict(
      actor, points,
      {.rate_hz = 30, .noise_mm = 0.2, .head_degrees = 6, .head_mm = 25, .seed = identity + 1});
  Mesh scan{model.topology, {}, {}};
  for (const auto& p : actor.rest()) scan.positions.push_back(p.cast<float>());
  const Registration found = animate_scan(scan, take.measured).registration;
  double worst = 0.0, sum = 0.0;
  for (std::size_t i = 0; i < found.kept.size(); ++i) {
    const double off = (position_of(found.markers[i].point, *scan.topology, scan.positions) -
                        position_of(points[found.kept[i]], *scan.topology, scan.positions))
                           .norm();
    worst = std::max(worst, off);
    sum += off;
  }
  std::printf(
      "{\"identity\": %d, \"worst_place_mm\": %.3f, \"mean_place_mm\": %.3f, \"attached\": %zu, "
      "\"markers\": %zu}\n",
      static_cast<int>(identity), worst, sum / static_cast<double>(found.kept.size()),
      found.kept.size(), points.size());
  std::fflush(stdout);
}

/// Multiply and add, never fused, in registers: what one thread can do at most.
KINEMESH_MULTIVERSION float chains(std::size_t steps, float factor, float term) {
  float sums[128];
  for (std::size_t k = 0; k < 128; ++k) sums[k] = static_cast<float>(k);
  for (std::size_t i = 0; i < steps; ++i) {
    for (std::size_t k = 0; k < 128; ++k) sums[k] = sums[k] * factor + term;
  }
  float total = 0.0F;
  for (const float s : sums) total += s;
  return total;
}

double seconds_of(auto&& work) {
  double best = 1e9;
  for (int round = 0; round < 80; ++round) {
    const auto start = std::chrono::steady_clock::now();
    work();
    best = std::min(
        best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return best;
}

void speed() {
  constexpr Eigen::Index vertices = 10000, markers = 160, frames = 32;
  const Eigen::MatrixXf weights = Eigen::MatrixXf::Random(vertices, markers);
  const Eigen::MatrixXf moves = Eigen::MatrixXf::Random(markers, 3 * frames);
  const PackedSpread spread(weights);
  const std::vector<float> rest(3 * vertices, 1.0F);
  std::vector<float> out(static_cast<std::size_t>(3 * vertices * frames));
  constexpr std::size_t steps = 200000;
  float kept = 0.0F;
  const double peak_s = seconds_of([&] { kept += chains(steps, 0.999F, 1e-3F); });
  const double peak = 2.0 * 128.0 * static_cast<double>(steps) / peak_s * 1e-9;
  for (const int threads : {1, 2}) {
    RunContext ctx;
    ctx.set_threads(threads);
    const double s = seconds_of([&] { spread.apply(rest, moves, out, ctx); });
    const double flops = 6.0 * vertices * markers * frames;
    std::printf(
        "{\"threads\": %d, \"ms_per_frame\": %.4f, \"gflops\": %.1f, \"peak_gflops\": "
        "%.1f, \"share_of_peak\": %.3f, \"check\": %.3g}\n",
        threads, 1e3 * s / frames, flops / s * 1e-9, peak * threads,
        flops / s * 1e-9 / (peak * threads), static_cast<double>(kept));
  }
}

}  // namespace
}  // namespace kinemesh

int main(int argc, char** argv) {
  const long identities = argc > 1 ? std::strtol(argv[1], nullptr, 10) : 10;
  kinemesh::speed();
  for (long i = 0; i < identities; ++i) kinemesh::registration(static_cast<uint64_t>(i));
  for (long i = 0; i < identities; ++i) kinemesh::accuracy(static_cast<uint64_t>(i));
}
