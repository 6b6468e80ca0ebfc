// Draws driven scans beside the truth with an error map in mm: both sample subjects and a model
// face. `drive_view_figures FOLDER`; prints one JSON object for each picture.
#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "config/text.h"
#include "reconstruct/animate_scan.h"
#include "report/error_view.h"
#include "tests/support/ict_expressions.h"
#include "tests/support/samples.h"

namespace kinemesh {
namespace {

struct Compared {
  std::string caption;
  std::vector<Eigen::Vector3f> truth, driven;
};

void draw(const std::filesystem::path& path, const std::shared_ptr<const Topology>& topology,
          const std::vector<Compared>& rows, const std::string& title) {
  std::vector<ErrorPanel> panels;
  double sum = 0.0;
  std::size_t count = 0;
  for (const Compared& row : rows) {
    ErrorPanel error{row.caption + ", error", topology, row.driven};
    double mean = 0.0;
    for (std::size_t v = 0; v < row.truth.size(); ++v) {
      error.values.push_back((row.truth[v] - row.driven[v]).norm());
      mean += static_cast<double>(error.values.back());
    }
    sum += mean;
    count += row.truth.size();
    error.caption +=
        ", mean " + format_fixed(mean / static_cast<double>(row.truth.size()), 2) + " mm";
    panels.push_back({row.caption + ", truth", topology, row.truth});
    panels.push_back({row.caption + ", driven by markers", topology, row.driven});
    panels.push_back(std::move(error));
  }
  draw_error_view(panels, {.title = title,
                           .subtitle = "truth, the scan driven by its markers, distance between "
                                       "the two",
                           .value_label = "distance to the true surface's vertex",
                           .high_mm = 3.0})
      .write_png(path, 1.0);
  std::printf("{\"picture\": \"%s\", \"mean_mm\": %.3f}\n", path.filename().c_str(),
              sum / static_cast<double>(count));
}

std::vector<Eigen::Vector3f> frame_of(const AnimatedMesh& mesh, std::size_t f) {
  return mesh.mesh_at(f).positions;
}

void sample(const std::filesystem::path& folder, const std::string& name) {
  const test::SyntheticTake take = test::make_sample(name);
  Mesh scan{take.face->rest().topology, {}, {}};
  for (const auto& p : take.face->rest().positions) scan.positions.push_back(p.cast<float>());
  AnimateOptions options;
  options.gaps.method = FillMethod::cubic;
  const AnimateResult result = animate_scan(scan, take.measured, {}, options);
  const auto strongest = [&](test::Expression e) {
    std::size_t best = 0;
    for (std::size_t f = 0; f < take.weights.size(); ++f) {
      if (take.weights[f][e] > take.weights[best][e]) best = f;
    }
    return best;
  };
  std::vector<Compared> rows;
  for (const auto& [caption, frame] :
       {std::pair{"peak", static_cast<std::size_t>(take.motion.peak_s * take.measured.rate_hz)},
        std::pair{"blink", strongest(test::Expression::blink_left)}}) {
    Compared row{caption, {}, frame_of(result.drive.animation, frame)};
    for (const auto& p : take.face->surface(take.weights[frame]).positions) {
      row.truth.push_back(p.cast<float>());
    }
    rows.push_back(std::move(row));
  }
  draw(folder / ("driven_" + name + ".png"), scan.topology, rows, name + ", markers found");
}

void model_face(const std::filesystem::path& folder) {
  const auto ict = test::ict_expressions(4);
  const DriveResult driven = drive_scan(ict.scan, ict.markers, ict.measured);
  std::vector<Compared> rows;
  for (const char* name : {"jawOpen", "mouthSmile_L", "eyeBlink_R"}) {
    const std::size_t f = test::ict_model().expression(name);
    rows.push_back({name, ict.truth[f], frame_of(driven.animation, f)});
  }
  draw(folder / "driven_model_face.png", ict.scan.topology, rows,
       "Model face, identity 4, " + count_of(ict.markers.size(), "marker") + ", 0.2 mm noise");
}

}  // namespace
}  // namespace kinemesh

int main(int argc, char** argv) {
  const std::filesystem::path folder = argc > 1 ? argv[1] : ".";
  kinemesh::model_face(folder);
  kinemesh::sample(folder, "anna_surprise");
  kinemesh::sample(folder, "ben_happy");
}
