// Writes a report page with every component, for the browser test, and beside it what the browser
// must find: report_page_demo FOLDER.
#include <cmath>
#include <exception>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>

#include "config/output_file.h"
#include "report/chart.h"
#include "report/gap_chart.h"
#include "report/html/components.h"
#include "report/html/mesh_viewer.h"

namespace kinemesh {
namespace {

constexpr VertexIndex columns = 12, rows = 14;
constexpr std::size_t frame_count = 900;
constexpr const char* hostile = "<script>window.hostile = 1</script><img src=x onerror=hostile=1>";

// A face-like dome, upright in z and facing −y, that bulges in a travelling wave and turns.
AnimatedMesh moving_dome() {
  std::vector<Triangle> faces;
  for (VertexIndex r = 0; r + 1 < rows; ++r) {
    for (VertexIndex c = 0; c + 1 < columns; ++c) {
      const VertexIndex a = r * columns + c;
      faces.push_back({a, a + columns, a + 1});
      faces.push_back({a + 1, a + columns, a + columns + 1});
    }
  }
  AnimatedMesh mesh(Topology::create(columns * rows, faces), frame_count, 60.0);
  mesh.first_frame = 101;
  mesh.add_filled();
  for (std::size_t f = 0; f < frame_count; ++f) {
    const auto time = static_cast<float>(f) / 60.0F;
    for (VertexIndex v = 0; v < columns * rows; ++v) {
      const float x = 12.0F * (static_cast<float>(v % columns) - 0.5F * (columns - 1));
      const float z = 12.0F * (0.5F * (rows - 1) - static_cast<float>(v / columns));
      const float width = 1.0F + 0.001F * z;  // narrower at the chin
      const float depth = 70.0F - 0.008F * (x * x + 0.7F * z * z) +
                          6.0F * std::sin(2.0F * time + 0.03F * z + 0.02F * x);
      const float turn = 0.2F * std::sin(0.7F * time);
      mesh.position(f, v) << x * width * std::cos(turn) + depth * std::sin(turn),
          x * width * std::sin(turn) - depth * std::cos(turn), z;
      mesh.filled()[f * columns * rows + v] = v % 37 == 5 && f % 300 < 120;
    }
  }
  for (VertexIndex v = 0; v < columns * rows; ++v) {
    mesh.vertex_names.push_back(v == 5 ? hostile : "m" + std::to_string(v));
  }
  return mesh;
}

ViewerField displacement(const AnimatedMesh& mesh) {
  ViewerField field{{ColourScale::Map::sequential, 0.0, 30.0, "displacement", "mm"}, {}};
  for (std::size_t f = 0; f < mesh.frame_count(); ++f) {
    for (VertexIndex v = 0; v < mesh.vertex_count(); ++v) {
      field.values.push_back((mesh.position(f, v) - mesh.position(0, v)).norm());
    }
  }
  return field;
}

void add_charts(HtmlPage& page) {
  GapChart gaps{.title = "Gaps over time", .frame_count = frame_count, .rate_hz = 60.0};
  for (std::size_t m = 0; m < 24; ++m) {
    GapChart::Row row{m == 5 ? hostile : "m" + std::to_string(m), {}};
    for (std::size_t g = 0; g < m % 5; ++g) {
      row.gaps.push_back({100 * g + 7 * m, 100 * g + 7 * m + 4 * m, g % 3});
    }
    gaps.markers.push_back(std::move(row));
  }
  page.add_section("Gaps").add(Figure{draw_gap_chart(gaps, 1000.0), "Gaps over time",
                                      "Each row is a marker; the worst come first.", 720.0});
  LineChart stretch{.title = "Edge stretch",
                    .x = {.label = "time", .unit = "s"},
                    .y = {.label = "stretch", .unit = "%"}};
  Series series{"stretch", {}, {}};
  for (std::size_t f = 0; f < frame_count; ++f) {
    series.x.push_back(static_cast<double>(f) / 60.0);
    series.y.push_back(4.0 + 3.0 * std::sin(0.02 * static_cast<double>(f)));
  }
  stretch.series.push_back(std::move(series));
  page.add_section("Quality")
      .add(Figure{canvas_of(stretch, 900.0, 280.0), "Edge stretch over time", "", 480.0})
      .add(Table{"Markers",
                 {{"marker"}, {"missing (frames)", true}, {"method"}},
                 {{hostile, "12", "Gaussian process"}, {"m6", "1", "spline"}}});
}

void write_page(const std::filesystem::path& folder) {
  const AnimatedMesh mesh = moving_dome();
  HtmlPage page("Demonstration & test", "Generated dome · 168 vertices · 15.0 s at 60 Hz",
                "kinemesh report components");
  page.add_section("Warnings")
      .add(WarningList{{std::string("Marker ") + hostile + " is missing for 1.9 s."}})
      .add(Figures{{{"168", "vertices"}, {"900", "frames"}, {"15.0 s", "duration"}}});
  const MeshViewer viewer(mesh, {.title = "Whole take"});
  page.add_section("Animated mesh").add(viewer);
  page.add_section("Two views")
      .add_beside(MeshViewer(mesh, {.title = "A", .fields = {displacement(mesh)}, .group = "pair"}),
                  MeshViewer(mesh, {.title = "B", .group = "pair"}));
  add_charts(page);
  page.add_section("How it was made")
      .add(KeyValues{{{"input", "generated"}, {"SHA-256", std::string(64, 'a')}}})
      .add(CodeBlock{"Command", "report_page_demo FOLDER"})
      .add(CodeBlock{"Options", "[demo]\nhostile = \"" + std::string(hostile) + "\"\n", true});
  page.write(folder / "page.html");

  nlohmann::json expected = {{"max_error_mm", viewer.code().max_error_mm},
                             {"statement", viewer.statement()},
                             {"frames", frame_count},
                             {"first_frame", mesh.first_frame},
                             {"hostile", hostile}};
  for (const std::size_t f : {std::size_t{0}, std::size_t{333}, frame_count - 1}) {
    nlohmann::json positions = nlohmann::json::array();
    for (const float c : mesh.frame(f).reshaped<Eigen::RowMajor>()) positions.push_back(c);
    expected["positions"][std::to_string(f)] = positions;
  }
  write_file(folder / "expected.json", expected.dump());
}

}  // namespace
}  // namespace kinemesh

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  try {
    kinemesh::write_page(argv[1]);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
  return 0;
}
