// Ticks, charts and the canvas below them.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "config/error.h"
#include "report/chart.h"
#include "report/clean_text.h"
#include "report/gap_chart.h"

namespace kinemesh::chart_test {
namespace {

using Values = std::vector<double>;

void expect_ticks(const Ticks& ticks, const Values& expected) {
  ASSERT_EQ(ticks.values.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(ticks.values[i], expected[i], 1e-12 * std::max(1.0, std::abs(expected[i])));
  }
}

TEST(Ticks, AreRoundAndWithinTheRange) {
  expect_ticks(nice_ticks(0.0, 25.0, 6), {0, 5, 10, 15, 20, 25});
  expect_ticks(nice_ticks(0.0, 1.0, 6), {0, 0.2, 0.4, 0.6, 0.8, 1.0});
  expect_ticks(nice_ticks(-0.013, 0.011, 6), {-0.01, -0.005, 0, 0.005, 0.01});
  expect_ticks(nice_ticks(1.0, 3000.0, 4), {1000, 2000, 3000});
  expect_ticks(nice_ticks(0.0, 2.0, 9, true), {0, 1, 2});
  EXPECT_EQ(nice_ticks(0.0, 0.3, 4).decimals, 1);
  EXPECT_EQ(nice_ticks(0.0, 400.0, 5).decimals, 0);
  // For any range: ascending, inside, no more than asked for, and not absurdly few.
  for (int i = 1; i < 400; ++i) {
    const double low = std::sin(i) * std::pow(10.0, i % 9 - 4);
    const double high = low + std::abs(std::cos(3.0 * i)) * std::pow(10.0, i % 7 - 3) + 1e-6;
    const Ticks ticks = nice_ticks(low, high, 7);
    ASSERT_GE(ticks.values.size(), 2U);
    ASSERT_LE(ticks.values.size(), 7U);
    ASSERT_GE(ticks.values.front(), low - 1e-9 * (high - low));
    ASSERT_LE(ticks.values.back(), high + 1e-9 * (high - low));
  }
}

TEST(Ticks, OddRangesEndWell) {
  expect_ticks(nice_ticks(3.0, 3.0, 5), {3});
  EXPECT_TRUE(nice_ticks(NAN, 1.0, 5).values.empty());
  EXPECT_TRUE(nice_ticks(0.0, std::numeric_limits<double>::infinity(), 5).values.empty());
  EXPECT_LE(nice_ticks(-1e308, 1e308, 5).values.size(), 5U);
  EXPECT_LE(nice_ticks(0.0, 5e-324, 5).values.size(), 5U);
  EXPECT_LE(nice_ticks(1e17, 1e17 + 64, 5).values.size(), 5U);
}

TEST(Ticks, LabelsReadWell) {
  EXPECT_EQ(tick_label(-0.5, 1), "−0.5");
  EXPECT_EQ(tick_label(-0.0001, 1), "0.0");
  EXPECT_EQ(tick_label(3000, 0), "3000");
  EXPECT_EQ(tick_label(1234567.5, 1), "1,234,567.5");
  EXPECT_EQ(with_unit("strain", "%"), "strain (%)");
}

TEST(CleanText, TakesAnyBytes) {
  EXPECT_EQ(clean_text("a\xFFz\t\n\x01é"), "a\xEF\xBF\xBDz  é");
  EXPECT_EQ(clean_text("\xC0\x80\xED\xA0\x80\xF5"),
            "\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD");
  EXPECT_EQ(escape_markup("<script>\"&'"), "&lt;script&gt;&quot;&amp;&#39;");
  EXPECT_EQ(escape_lines("a\r\nb<"), "a\nb&lt;");
  EXPECT_EQ(shorten("Köpfe", 5), "Köpfe");
  EXPECT_EQ(shorten("Köpfen", 5), "Köpf…");
}

TEST(Canvas, PngAndSvgShowTheSameDrawing) {
  Canvas canvas(40, 20);
  canvas.rectangle({4, 5, 10, 8}, {1, 0, 0, 1});
  canvas.begin_clip({20, 0, 10, 20});
  canvas.circle({25, 10}, 30, {0, 0, 1, 1});
  canvas.end_clip();
  canvas.text({1, 0}, "a<b\xFF", {.size = 4.0, .anchor = TextAnchor::top});
  const Image image = decode_png(encode_png(canvas.raster(2.0)));
  ASSERT_EQ(image.width, 80);
  ASSERT_EQ(image.height, 40);
  EXPECT_EQ(image.colour_at(20, 22).r, 1.0);
  EXPECT_EQ(image.colour_at(20, 22).g, 0.0);
  EXPECT_EQ(image.colour_at(50, 20).b, 1.0);
  EXPECT_EQ(image.colour_at(50, 20).r, 0.0);
  EXPECT_EQ(image.colour_at(70, 20).r, 1.0) << "the clip ends at 30";
  const std::string svg = canvas.svg({.title = "a \"title\""}, "p");
  EXPECT_NE(svg.find("<rect x=\"4\" y=\"5\" width=\"10\" height=\"8\" fill=\"#ff0000\"/>"),
            std::string::npos);
  EXPECT_NE(svg.find(">a&lt;b\xEF\xBF\xBD</text>"), std::string::npos);
  EXPECT_NE(svg.find("<title>a &quot;title&quot;</title>"), std::string::npos);
  EXPECT_NE(svg.find("clip-path=\"url(#p-clip0)\""), std::string::npos);
}

TEST(Canvas, TextIsMeasuredAndShortened) {
  const double wide = text_width("a long marker name");
  EXPECT_NEAR(text_width("a long marker name", {.size = 24.0}), 2.0 * wide, 1e-3 * wide);
  Canvas canvas(200, 20);
  canvas.text_within({0, 10}, "a long marker name", 0.5 * wide);
  EXPECT_NE(canvas.svg().find("…</text>"), std::string::npos);
}

TEST(Png, RefusesWhatIsNone) {
  EXPECT_THROW(decode_png(""), InputError);
  EXPECT_THROW(decode_png("no picture at all, just some text"), InputError);
  std::string bytes = encode_png(Image(8, 8, {1, 0, 0, 1}));
  EXPECT_THROW(decode_png(std::string_view(bytes).substr(0, 40)), InputError);
  bytes[16] = '\x7F';  // a width of two thousand million
  EXPECT_THROW(decode_png(bytes), InputError);
  Image clear(2, 1, {1, 0, 0, 0.5});
  EXPECT_NEAR(decode_png(encode_png(clear)).colour_at(1, 0).a, 0.5, 0.01);
  EXPECT_EQ(base64("Man"), "TWFu");
  EXPECT_EQ(base64("Ma"), "TWE=");
  EXPECT_EQ(base64("M"), "TQ==");
}

TEST(LineChart, KeepsExtremesOfManySamplesAndGaps) {
  LineChart chart{.y = {.label = "d", .unit = "mm"}};
  Series series{"d", {}, {}};
  for (int i = 0; i < 200000; ++i) {
    series.x.push_back(i);
    series.y.push_back(i == 123456 ? 50.0 : i > 150000 && i < 160000 ? NAN : 1.0);
  }
  chart.series.push_back(series);
  const std::string svg = canvas_of(chart, 800, 200).svg();
  EXPECT_LT(svg.size(), 60000U);
  EXPECT_NE(svg.find(">40<"), std::string::npos) << "the axis reaches the single peak";
  std::size_t paths = 0;
  for (std::size_t at = 0; (at = svg.find("stroke-width=\"1.6\"", at)) != std::string::npos; ++at) {
    ++paths;
  }
  EXPECT_EQ(paths, 2U) << "the missing stretch interrupts the curve";
}

TEST(Charts, EmptyOrOddDataAreDrawn) {
  EXPECT_NO_THROW(canvas_of(LineChart{}, 300, 200).raster());
  EXPECT_NO_THROW(canvas_of(BarChart{}, 300, 200).raster());
  EXPECT_NO_THROW(canvas_of(Histogram{}, 300, 200).raster());
  EXPECT_NO_THROW(canvas_of(HeatStrip{}, 300, 200).raster());
  LineChart constant;
  constant.series.push_back({"c", {1, 2, 3}, {5, 5, 5}});
  constant.series.push_back({"nothing", {1, 2, 3}, {NAN, INFINITY, NAN}});
  EXPECT_NO_THROW(canvas_of(constant, 300, 200).raster());
  BarChart bars{.bars = {{"x", NAN}, {"y", -3.0}, {"z", 1e300}}};
  EXPECT_NO_THROW(canvas_of(bars, 300, bars.natural_height()).raster());
}

TEST(Histogram, CountsEachValueOnce) {
  Histogram chart{.values = {0.0, 0.1, 0.1, 0.9, 1.0, NAN}, .bins = 10};
  const std::string svg = canvas_of(chart, 300, 200).svg();
  EXPECT_NE(svg.find(">2<"), std::string::npos) << "the fullest bin holds two";
}

GapChart gaps_of(std::size_t markers, std::size_t frames) {
  GapChart chart{.title = "Gaps", .frame_count = frames, .rate_hz = 100.0};
  for (std::size_t m = 0; m < markers; ++m) {
    chart.markers.push_back({"m" + std::to_string(m), {}});
  }
  return chart;
}

TEST(GapChart, DrawsWhatWasMissing) {
  GapChart chart = gaps_of(3, 1000);
  chart.kinds = {{"missing", {1, 0, 0, 1}}, {"filled", {0, 0, 1, 1}}};
  chart.markers[1].gaps = {{0, 500, 0}, {500, 600, 1}};
  chart.markers[2].gaps = {{700, 701, 1}};  // a single frame
  const std::string svg = draw_gap_chart(chart).svg();
  EXPECT_NE(svg.find(">60.0 %<"), std::string::npos);
  EXPECT_NE(svg.find(">6.00 s<"), std::string::npos) << "both kinds make one stretch";
  EXPECT_NE(svg.find(">0.1 %<"), std::string::npos);
  EXPECT_LT(svg.find(">m1<"), svg.find(">m2<")) << "worst first";
  EXPECT_LT(svg.find(">m2<"), svg.find(">m0<"));
  const Image image = draw_gap_chart(chart).raster();
  double red = 0.0;
  double blue = 0.0;
  for (int y = 120; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const Colour c = image.colour_at(x, y);
      red += c.r == 1.0 && c.g == 0.0 ? 1.0 : 0.0;
      blue += c.b == 1.0 && c.g < 0.3 ? 1.0 : 0.0;
    }
  }
  EXPECT_NEAR(red / (red + blue), 500.0 / 600.0, 0.02);
}

TEST(GapChart, OddIntervalsAndNoMarkersAreDrawn) {
  GapChart chart = gaps_of(2, 100);
  chart.markers[0].gaps = {{90, 5000, 0}, {50, 20, 1}, {3, 4, 99}, {10, 30, 0}, {20, 40, 1}};
  chart.markers[1].label = "<script>\xFF";
  EXPECT_NE(draw_gap_chart(chart).svg().find(">41.0 %<"), std::string::npos)
      << "overlapping intervals count once, those beyond the take not";
  EXPECT_NO_THROW(draw_gap_chart(gaps_of(0, 0)).raster());
  GapChart untimed = gaps_of(2, 100);
  untimed.rate_hz = 0.0;
  EXPECT_NE(draw_gap_chart(untimed).svg().find(">frame<"), std::string::npos);
}

TEST(GapChart, StaysLegibleForTwoHundredMarkers) {
  const Canvas canvas = draw_gap_chart(gaps_of(200, 3000));
  EXPECT_GE(canvas.height(), 200 * 12.0) << "rows keep the height of their labels";
  EXPECT_LE(canvas.width() * canvas.height() * std::pow(png_scale(canvas), 2), 8.1e6);
}

}  // namespace
}  // namespace kinemesh::chart_test
