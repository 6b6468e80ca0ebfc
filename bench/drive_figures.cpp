// Drives model faces by their markers in all 57 expressions with every method and compares with the
// truth; then the speed of the product. One JSON object a line on stdout; for
// tools/verify.d/10_driving. `drive_figures [IDENTITIES [FIRST]]`.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "bench/drive_accuracy.h"
#include "config/multiversion.h"
#include "reconstruct/animate_scan.h"
#include "reconstruct/marker_field.h"
#include "reconstruct/retarget.h"
#include "reconstruct/spread_product.h"
#include "reconstruct/triangulate.h"

namespace kinemesh {
namespace {

DriveWay linear(const std::string& name, DriveMethod method, bool smooth, uint64_t identities) {
  return {name,
          [=](const test::IctExpressions& ict) {
            DriveOptions options;
            options.method = method;
            options.smooth = smooth;
            return drive_scan(ict.scan, ict.markers, ict.measured, options).animation;
          },
          identities};
}

/// Deformation transfer from the mesh of the markers.
AnimatedMesh transferred(const test::IctExpressions& ict) {
  const auto topology = triangulate(ict.measured).topology;
  Mesh rest{topology, {}, {}};
  SurfaceMap map;
  for (const AttachedMarker& m : ict.markers) {
    rest.positions.push_back(
        position_of(m.point, *ict.scan.topology, ict.scan.positions).cast<float>());
    map.points.push_back(m.point);
  }
  AnimatedMesh moving(topology, ict.measured.frame_count(), 0.0);
  for (std::size_t f = 0; f < moving.frame_count(); ++f) {
    for (VertexIndex m = 0; m < moving.vertex_count(); ++m) {
      moving.position(f, m) = ict.measured.position(f, m);
    }
  }
  return retarget(moving, rest, ict.scan, map).animation;
}

std::vector<DriveWay> ways() {
  return {linear("surface", DriveMethod::surface, true, 1000),
          linear("biharmonic", DriveMethod::biharmonic, false, 1000),
          linear("euclidean", DriveMethod::euclidean, false, 1000),
          linear("surface, exact at the markers", DriveMethod::surface, false, 3),
          {"deformation transfer", transferred, 3},
          linear("geodesic", DriveMethod::geodesic, false, 1)};
}

void accuracy(const IdentityRange& range) {
  for (uint64_t i = 0; i < range.count; ++i) {
    for (const DriveWay& way : ways()) {
      if (i < way.identities) print_accuracy(range.first + i, way);
    }
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

double seconds_of(auto&& work, int rounds = 80) {
  double best = 1e9;
  for (int round = 0; round < rounds; ++round) {
    const auto start = std::chrono::steady_clock::now();
    work();
    best = std::min(
        best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return best;
}

/// Milliseconds a frame that taking the noise off the markers adds.
double settling_ms(const RunContext& ctx) {
  constexpr Eigen::Index markers = 160, frames = 64;
  Eigen::MatrixXd covariance(markers, markers);
  for (Eigen::Index i = 0; i < markers; ++i) {
    for (Eigen::Index j = 0; j < markers; ++j) {
      covariance(i, j) = std::exp(-0.2 * std::abs(static_cast<double>(i - j)));
    }
  }
  const Eigen::MatrixXd moves = Eigen::MatrixXd::Random(markers, 3 * frames);
  const Eigen::MatrixXf absence = Eigen::MatrixXf::Zero(markers, frames);
  const MarkerFieldOptions options{.noise_mm = 0.2};
  return 1e3 / static_cast<double>(frames) *
         seconds_of([&] { settle_markers(moves, absence, covariance, options, ctx); }, 5);
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
        "%.1f, \"share_of_peak\": %.3f, \"settling_ms\": %.4f, \"check\": %.3g}\n",
        threads, 1e3 * s / frames, flops / s * 1e-9, peak * threads,
        flops / s * 1e-9 / (peak * threads), settling_ms(ctx), static_cast<double>(kept));
  }
}

}  // namespace
}  // namespace kinemesh

int main(int argc, char** argv) {
  const kinemesh::IdentityRange range = kinemesh::identity_range(argc, argv, 10);
  kinemesh::speed();
  for (uint64_t i = 0; i < range.count; ++i) kinemesh::registration(range.first + i);
  kinemesh::accuracy(range);
}
