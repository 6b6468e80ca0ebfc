#include <gtest/gtest.h>

#include <cmath>

#include "config/error.h"
#include "report/html/components.h"
#include "report/html/mesh_viewer.h"

namespace kinemesh::html_test {
namespace {

constexpr const char* hostile = "<script>alert(1)</script>\"'&</pre><!--";

std::size_t count_in(const std::string& text, const std::string& what) {
  std::size_t count = 0;
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; ++at) ++count;
  return count;
}

// A strip of vertices that swings with several frequencies; `noise` makes it incompressible.
AnimatedMesh swinging_strip(std::size_t vertices, std::size_t frames, float noise) {
  std::vector<Triangle> faces;
  for (VertexIndex v = 0; v + 2 < vertices; ++v) {
    faces.push_back(v % 2 == 0 ? Triangle{v, v + 1, v + 2} : Triangle{v + 1, v, v + 2});
  }
  AnimatedMesh mesh(Topology::create(vertices, faces), frames, 120.0);
  uint32_t state = 1;
  for (std::size_t f = 0; f < frames; ++f) {
    const auto t = static_cast<float>(f) / 120.0F;
    for (VertexIndex v = 0; v < vertices; ++v) {
      const auto s = static_cast<float>(v);
      state = state * 1664525U + 1013904223U;
      const float random = static_cast<float>(state >> 8U) / 16777216.0F - 0.5F;
      mesh.position(f, v) << s, v % 2 == 0 ? 0.0F : 5.0F,
          8.0F * std::sin(2.0F * t + 0.1F * s) + 3.0F * std::sin(9.0F * t - 0.3F * s) +
              noise * random;
    }
  }
  return mesh;
}

double largest_error(const AnimatedMesh& mesh, const AnimationCode& code) {
  double largest = 0.0;
  for (std::size_t f = 0; f < mesh.frame_count(); ++f) {
    const std::vector<float> decoded = decode_frame(code, mesh.vertex_count(), f);
    for (VertexIndex v = 0; v < mesh.vertex_count(); ++v) {
      const Eigen::Vector3f at(decoded[3 * v], decoded[3 * v + 1], decoded[3 * v + 2]);
      largest = std::max<double>(largest, (at - mesh.position(f, v)).norm());
    }
  }
  return largest;
}

TEST(AnimationCode, ReachesTheErrorItStates) {
  const AnimatedMesh mesh = swinging_strip(60, 400, 0.0F);
  const AnimationCode code = encode_animation(mesh);
  EXPECT_LE(code.max_error_mm, 0.05);
  EXPECT_NEAR(largest_error(mesh, code), code.max_error_mm, 1e-4);
  EXPECT_LE(code.rms_error_mm, code.max_error_mm);
  EXPECT_LE(code.scales.size(), 6U) << "four waves need no more modes";
}

TEST(AnimationCode, StaysWithinTheBudgetAndSaysWhatItCosts) {
  const AnimatedMesh mesh = swinging_strip(100, 1500, 2.0F);
  double before = 1e9;
  for (const std::size_t budget : {std::size_t{4000}, std::size_t{20000}, std::size_t{100000}}) {
    const AnimationCode code = encode_animation(mesh, {.max_bytes = budget});
    EXPECT_LE(code.bytes.size(), budget);
    EXPECT_NEAR(largest_error(mesh, code), code.max_error_mm, 1e-3);
    EXPECT_LE(code.rms_error_mm, before) << "more room, less error";
    before = code.rms_error_mm;
  }
}

TEST(AnimationCode, OddAnimations) {
  EXPECT_THROW(encode_animation(AnimatedMesh()), NoResultError);
  AnimatedMesh mesh = swinging_strip(20, 1, 0.0F);
  EXPECT_LE(encode_animation(mesh).max_error_mm, 1e-5) << "one frame is its own mean";
  EXPECT_THROW(encode_animation(mesh, {.max_bytes = 100}), NoResultError);
  mesh.position(0, 3).x() = NAN;
  EXPECT_THROW(encode_animation(mesh), InputError);
}

TEST(MeshViewer, FillsItsBudgetAndNoMore) {
  const AnimatedMesh mesh = swinging_strip(160, 3000, 1.0F);
  const MeshViewer viewer(mesh);
  HtmlPage page("t");
  page.add_section("3D").add(viewer);
  EXPECT_LT(page.html().size(), 3000000U);
  EXPECT_GT(viewer.code().bytes.size(), 300000U);
  EXPECT_NE(page.html().find(viewer.statement()), std::string::npos);
}

TEST(MeshViewer, RefusesFieldsThatDoNotFit) {
  const AnimatedMesh mesh = swinging_strip(20, 10, 0.0F);
  EXPECT_THROW(MeshViewer(mesh, {.fields = {{{}, std::vector<float>(30, 0.0F)}}}), InternalError);
  EXPECT_NO_THROW(MeshViewer(mesh, {.fields = {{{}, std::vector<float>(20, NAN)}}}));
  EXPECT_NO_THROW(MeshViewer(mesh, {.fields = {{{}, std::vector<float>(200, 0.5F)}}}));
}

TEST(HtmlPage, HostileTextsStayTexts) {
  AnimatedMesh mesh = swinging_strip(20, 10, 0.0F);
  mesh.vertex_names.assign(20, hostile);
  mesh.vertex_names[1] = "\xFF\xFE";
  HtmlPage page(hostile, hostile, hostile);
  Canvas canvas(50, 50);
  canvas.text({0, 0}, hostile);
  page.add_section(hostile)
      .add(Paragraph{hostile})
      .add(WarningList{{hostile}})
      .add(Figures{{{hostile, hostile}}})
      .add(KeyValues{{{hostile, hostile}}})
      .add(Table{hostile, {{hostile}}, {{hostile}}})
      .add(CodeBlock{hostile, hostile})
      .add(Figure{std::move(canvas), hostile, hostile})
      .add(Picture{Image(2, 2), hostile, hostile})
      .add(MeshViewer(mesh, {.title = hostile, .group = hostile}));
  const std::string html = page.html();
  EXPECT_EQ(count_in(html, "<script>alert"), 0U);
  EXPECT_EQ(count_in(html, "</script"), 3U) << "of the view's two data blocks and of the script";
  EXPECT_EQ(count_in(html, "<!--"), 0U);
  EXPECT_EQ(count_in(html, "</pre>"), 1U);
  EXPECT_EQ(count_in(html, "\xFF"), 0U);
  EXPECT_GE(count_in(html, "&lt;script&gt;alert(1)&lt;/script&gt;"), 14U);
}

TEST(HtmlPage, LoadsNothingFromOutside) {
  HtmlPage page("t");
  page.add_section("a").add(WarningList{});
  const std::string html = page.html();
  EXPECT_NE(html.find("default-src 'none'"), std::string::npos);
  EXPECT_NE(html.find("script-src 'sha256-"), std::string::npos);
  EXPECT_EQ(count_in(html, "http://"), 0U);
  EXPECT_EQ(count_in(html, "https://"), 0U);
  EXPECT_EQ(count_in(html, " src="), 0U);
  EXPECT_NE(html.find("No warnings."), std::string::npos);
  EXPECT_LT(html.size(), 50000U) << "an empty page is small";
}

TEST(HtmlPage, IdsAreUnique) {
  HtmlPage page("t");
  for (int i = 0; i < 3; ++i) {
    Canvas canvas(50, 50);
    canvas.begin_clip({0, 0, 10, 10});
    page.add_section("s").add(Figure{std::move(canvas), "f", ""}).add(CodeBlock{"c", "x"});
  }
  const std::string html = page.html();
  for (const char* id : {"section-1", "chart-2-clip0", "code-3", "section-4"}) {
    EXPECT_EQ(count_in(html, "id=\"" + std::string(id) + "\""), 1U) << id;
  }
}

}  // namespace
}  // namespace kinemesh::html_test
