// How long the pictures of `convert` take: contact sheet and gap chart of 160 markers × 3,000
// frames, PNG and SVG, beside the PNG encoder alone.
#include <benchmark/benchmark.h>

#include <Eigen/Core>
#include <cmath>
#include <memory>
#include <random>

#include "report/contact_sheet.h"
#include "report/gap_chart.h"

namespace {

using namespace kinemesh;

constexpr VertexIndex columns = 16, rows = 10;
constexpr std::size_t frame_count = 3000;

// A dome of 160 vertices whose middle swells and shrinks.
AnimatedMesh dome() {
  std::vector<Triangle> faces;
  for (VertexIndex r = 0; r + 1 < rows; ++r) {
    for (VertexIndex c = 0; c + 1 < columns; ++c) {
      const VertexIndex a = r * columns + c;
      faces.push_back({a, a + 1, a + columns});
      faces.push_back({a + 1, a + columns + 1, a + columns});
    }
  }
  AnimatedMesh mesh(Topology::create(columns * rows, faces), frame_count, 120.0);
  mesh.add_filled();
  std::mt19937 random(1);
  for (std::size_t f = 0; f < frame_count; ++f) {
    const float swell = 0.3F + 0.1F * std::sin(0.02F * static_cast<float>(f));
    for (VertexIndex v = 0; v < columns * rows; ++v) {
      const float x = 10.0F * (static_cast<float>(v % columns) - 7.5F);
      const float y = 14.0F * (4.5F - static_cast<float>(v / columns));
      mesh.position(f, v) << x, y, 60.0F - swell * (x * x + y * y) / 60.0F;
      mesh.filled()[f * columns * rows + v] = random() % 50 == 0;
    }
  }
  return mesh;
}

GapChart gaps() {
  GapChart chart;
  chart.frame_count = frame_count;
  chart.rate_hz = 120.0;
  std::mt19937 random(2);
  for (std::size_t m = 0; m < columns * rows; ++m) {
    GapChart::Row row{"marker " + std::to_string(m), {}};
    for (std::size_t begin = random() % 400; begin < frame_count; begin += 20 + random() % 600) {
      row.gaps.push_back({begin, begin + 1 + random() % 60, 1 + random() % 2});
    }
    chart.markers.push_back(std::move(row));
  }
  return chart;
}

void contact_sheet_png(benchmark::State& state) {
  const AnimatedMesh mesh = dome();
  RunContext ctx;
  ctx.set_threads(0);
  for (auto _ : state) {
    benchmark::DoNotOptimize(encode_png(draw_contact_sheet(mesh, {}, ctx).sheet.raster(2.0)));
  }
}
BENCHMARK(contact_sheet_png)->Unit(benchmark::kMillisecond);

void gap_chart_png_and_svg(benchmark::State& state) {
  const GapChart chart = gaps();
  for (auto _ : state) {
    const Canvas canvas = draw_gap_chart(chart);
    benchmark::DoNotOptimize(encode_png(canvas.raster(png_scale(canvas))));
    benchmark::DoNotOptimize(canvas.svg());
  }
}
BENCHMARK(gap_chart_png_and_svg)->Unit(benchmark::kMillisecond);

// The reference: what only compressing the two pictures takes.
void png_encoder_alone(benchmark::State& state) {
  const Image sheet = draw_contact_sheet(dome()).sheet.raster(2.0);
  const Canvas canvas = draw_gap_chart(gaps());
  const Image chart = canvas.raster(png_scale(canvas));
  for (auto _ : state) {
    benchmark::DoNotOptimize(encode_png(sheet));
    benchmark::DoNotOptimize(encode_png(chart));
  }
}
BENCHMARK(png_encoder_alone)->Unit(benchmark::kMillisecond);

}  // namespace
