// Writes the sample sessions and their truth: make_samples [FOLDER] (default: this folder).
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "capture/c3d/writer.h"
#include "config/output_file.h"
#include "mesh/formats/mesh_io.h"
#include "mesh/formats/npz.h"
#include "tests/support/samples.h"

using namespace kinemesh;
using namespace kinemesh::test;
using nlohmann::json;

namespace {

Mesh as_mesh(const TrueSurface& surface) {
  Mesh mesh{surface.topology, {}, {}};
  for (const Eigen::Vector3d& p : surface.positions) mesh.positions.push_back(p.cast<float>());
  return mesh;
}

/// The frame that a triangulation starts from: the first in which all face markers are measured.
std::size_t first_complete_frame(const SyntheticTake& take) {
  for (std::size_t f = 0; f < take.measured.frame_count(); ++f) {
    bool complete = true;
    for (std::size_t m = 0; m < take.face_marker_count(); ++m)
      complete &= take.measured.valid(f, m);
    if (complete) return f;
  }
  return 0;
}

json openings_of(const SyntheticTake& take) {
  json list = json::array();
  for (const auto& opening : take.reference_at(first_complete_frame(take)).openings) {
    json ring = json::array();
    for (const uint32_t site : opening.ring) ring.push_back(take.layout.labels[site]);
    list.push_back({{"name", opening.name}, {"ring", ring}});
  }
  return list;
}

json gaps_of(const SyntheticTake& take) {
  json list = json::array();
  for (const GapRecord& gap : take.gaps) {
    list.push_back({{"marker", take.measured.markers()[gap.marker].label},
                    {"first_frame", gap.first_frame},
                    {"last_frame", gap.last_frame}});
  }
  return list;
}

json correspondence() {
  const MarkerLayout anna = sample_layout("anna"), ben = sample_layout("ben");
  json pairs = json::array();
  for (const auto& [a, b] : correspondence_of(anna, ben))
    pairs.push_back({anna.labels[a], ben.labels[b]});
  return {{"synthetic", true},
          {"subjects", {"anna", "ben"}},
          {"markers", pairs},
          {"surfaces", "vertex i of anna_rest.ply is vertex i of ben_rest.ply"}};
}

json description_of(const SyntheticTake& take) {
  json swap = nullptr;
  if (take.swap) {
    swap = {
        {"markers", {take.layout.labels[take.swap->first], take.layout.labels[take.swap->second]}},
        {"from_frame", take.swap->from_frame}};
  }
  return {{"synthetic", true},
          {"motion", take.motion.name},
          {"rate_hz", take.measured.rate_hz},
          {"frames", take.measured.frame_count()},
          {"onset_s", take.motion.onset_s},
          {"peak_s", take.motion.peak_s},
          {"openings_at_frame", first_complete_frame(take)},
          {"openings", openings_of(take)},
          {"gaps", gaps_of(take)},
          {"label_swap", swap}};
}

/// Noise-free markers, head poses, expression weights and the markers' places on the surface.
void write_arrays(const SyntheticTake& take, const std::filesystem::path& path) {
  NpzWriter npz;
  const std::size_t frames = take.truth.frame_count(), markers = take.truth.marker_count();
  npz.add("positions", {frames, markers, 3}, take.truth.positions());
  std::vector<std::string> labels;
  for (const Marker& m : take.truth.markers()) labels.push_back(m.label);
  npz.add("labels", std::span<const std::string>(labels));
  std::vector<double> rotations, translations, weights;
  for (const Eigen::Isometry3d& pose : take.head_pose) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) rotations.push_back(pose.linear()(row, column));
    }
    for (int k = 0; k < 3; ++k) translations.push_back(pose.translation()[k]);
  }
  std::vector<std::string> expressions;
  for (std::size_t e = 0; e < expression_count; ++e) {
    expressions.emplace_back(name_of(static_cast<Expression>(e)));
  }
  for (const ExpressionWeights& w : take.weights) {
    weights.insert(weights.end(), w.values.begin(), w.values.end());
  }
  npz.add("head_rotation", {frames, 3, 3}, std::span<const double>(rotations));
  npz.add("head_translation", {frames, 3}, std::span<const double>(translations));
  npz.add("expressions", std::span<const std::string>(expressions));
  npz.add("expression_weights", {frames, expression_count}, std::span<const double>(weights));
  std::vector<int32_t> faces;
  std::vector<double> barycentric;
  for (const SurfacePoint& p : take.layout.points) {
    faces.push_back(static_cast<int32_t>(p.face));
    barycentric.insert(barycentric.end(), p.weights.begin(), p.weights.end());
  }
  npz.add("marker_face", {faces.size()}, std::span<const int32_t>(faces));
  npz.add("marker_barycentric", {faces.size(), 3}, std::span<const double>(barycentric));
  npz.write(path);
}

void write_session(const std::string& name, const std::filesystem::path& folder,
                   const FormatRegistry& formats) {
  const SyntheticTake take = make_sample(name);
  write_c3d(take.measured, folder / (name + ".c3d"));
  const std::filesystem::path truth = folder / "truth";
  write_arrays(take, truth / (name + ".npz"));
  write_file(truth / (name + ".json"), description_of(take).dump(1) + "\n");
  const auto peak = static_cast<std::size_t>(take.motion.peak_s * take.measured.rate_hz);
  write_mesh(formats, as_mesh(take.face->surface(take.weights.at(peak))),
             truth / (name + "_peak.ply"));
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const std::filesystem::path folder = argc > 1 ? argv[1] : KINEMESH_SAMPLES;
    std::filesystem::create_directories(folder / "truth");
    const FormatRegistry formats = builtin_mesh_formats();
    for (const std::string& name : sample_names()) {
      write_session(name, folder, formats);
      std::printf("%s\n", (folder / (name + ".c3d")).c_str());
    }
    for (const char* subject : {"anna", "ben"}) {
      write_mesh(formats, as_mesh(sample_face(subject)->rest()),
                 folder / "truth" / (std::string(subject) + "_rest.ply"));
    }
    write_file(folder / "truth" / "correspondence.json", correspondence().dump(1) + "\n");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "make_samples: %s\n", error.what());
    return 1;
  }
  return 0;
}
