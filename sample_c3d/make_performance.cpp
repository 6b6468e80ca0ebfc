// A performer with truth, for users of the library who hold the linear face model: writes the
// animation of any subject doing any motion, where its vertices lie on the model, and, on demand,
// markers on it as C3D.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>

#include "capture/c3d/writer.h"
#include "mesh/formats/mesh_io.h"
#include "mesh/formats/npz.h"
#include "tests/support/ict_performer.h"

using namespace kinemesh;
using namespace kinemesh::test;

namespace {

struct Arguments {
  std::string model, output;
  uint64_t subject = 1, motion = 1;
  double duration_s = 2, marker_mm = 0;
  PerformOptions perform;
  TakeOptions take{.rate_hz = 120, .noise_mm = 0.2, .short_gaps = 20, .long_gaps = 2};
};

void declare(CLI::App& app, Arguments& a) {
  app.add_option("MODEL", a.model, "Folder with neutral.ply, the deltas and meta.json")->required();
  app.add_option("-o,--output", a.output, "Animation to write, such as face.ply")->required();
  app.add_option("--subject", a.subject, "Seed of the person; 0 is the neutral face");
  app.add_option("--motion", a.motion, "Seed of the motion");
  app.add_option("--duration", a.duration_s, "Length of the motion in s")
      ->check(CLI::Range(0.1, 60.0));
  app.add_option("--rate", a.perform.rate_hz, "Frames per second")->check(CLI::Range(1.0, 1000.0));
  app.add_option("--remesh", a.perform.remesh_vertices,
                 "Vertices of an independent connectivity; 0 keeps the model's")
      ->check(CLI::Range(0, 100000));
  app.add_option("--noise", a.perform.noise_mm, "Noise of each coordinate of a vertex in mm");
  app.add_option("--turn", a.perform.variation.turn_degrees,
                 "Turns this subject's displacements by up to so many degrees");
  app.add_option("--scale", a.perform.variation.scale, "Scales each expression by 1 ± up to this");
  app.add_option("--delay", a.perform.variation.delay_s, "Delays the motion by up to this, in s");
  app.add_option("--markers", a.marker_mm,
                 "Also writes a C3D of markers at least so many mm apart; 9 gives about 160");
}

/// Face and weights on the model for each vertex: "model_face", "model_barycentric".
void write_truth(const Performance& p, const std::filesystem::path& path) {
  std::vector<int64_t> faces;
  std::vector<double> weights;
  for (const SurfacePoint& point : p.on_model) {
    faces.push_back(point.valid() ? static_cast<int64_t>(point.face) : -1);
    weights.insert(weights.end(), point.weights.begin(), point.weights.end());
  }
  NpzWriter npz;
  npz.add("model_face", {faces.size()}, std::span<const int64_t>(faces));
  npz.add("model_barycentric", {faces.size(), 3}, std::span<const double>(weights));
  npz.write(path);
}

void run(const Arguments& a) {
  const auto model = load_ict(a.model);
  const IctMotion motion = make_ict_motion(*model, a.motion, a.duration_s);
  const IctActor actor(*model, {.seed = a.subject}, motion, a.perform.variation);
  const Performance performance = perform(actor, a.perform);
  const std::filesystem::path output = a.output;
  for (const auto& file : write_animation(builtin_mesh_formats(), performance.mesh, output).files) {
    std::printf("%s\n", file.c_str());
  }
  const auto stem = output.parent_path() / output.stem();
  write_truth(performance, stem.string() + "_truth.npz");
  if (a.marker_mm <= 0) return;
  TakeOptions options = a.take;
  options.subject = "subject" + std::to_string(a.subject);
  const auto points = place_ict_markers(*model, a.marker_mm, 1);
  write_c3d(record_ict(actor, points, options).measured, stem.string() + ".c3d");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Makes an animation with known truth from a linear face model.");
  Arguments arguments;
  declare(app, arguments);
  CLI11_PARSE(app, argc, argv);
  try {
    run(arguments);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "make_performance: %s\n", error.what());
    return 1;
  }
  return 0;
}
