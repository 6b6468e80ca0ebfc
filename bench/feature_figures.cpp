// Figures of the features on model faces with a true map, one JSON object a line, for
// tools/verify.d/6_features:
//   feature_figures pairs FIRST COUNT [others]   agreement of pairs of subjects; with other methods
//   feature_figures noise COUNT                  repeatability under noise
//   feature_figures descriptors FIRST COUNT      nearest neighbour by each descriptor
//   feature_figures cylinder                     the bending cylinders of figure 4-15
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <random>
#include <string>

#include "analysis/descriptors.h"
#include "analysis/feature_consistency.h"
#include "bench/feature_baselines.h"
#include "tests/support/deforming_shapes.h"
#include "tests/support/ict_performer.h"

using namespace kinemesh;
using namespace kinemesh::test;
using nlohmann::json;

namespace {

struct Take {
  Performance performance;
  DeformationResult deformation;
  FeatureSet set;
};

Take take_of(uint64_t subject, uint64_t motion, std::size_t remeshed, double noise_mm = 0) {
  const IctModel& model = ict_model();
  PerformOptions options;
  options.remesh_vertices = remeshed;
  options.noise_mm = noise_mm;
  options.seed = subject;
  Take take{perform(model, {.seed = subject}, make_ict_motion(model, motion), options), {}, {}};
  take.deformation = deformation_of(take.performance.mesh);
  take.set = detect_features(take.performance.mesh, take.deformation).set;
  return take;
}

json json_of(const Consistency& c) { return {c.strict, c.slack, c.nearest}; }

json compared(const Take& a, const FeatureSet& fa, const Take& b, const FeatureSet& fb) {
  const auto r = feature_consistency(fa, fb, true_map(ict_model(), a.performance, b.performance),
                                     b.performance.mesh.mesh_at(0));
  json errors = json::array();  // share within 1 … 20 % of the diagonal: the curve
  for (int percent = 1; percent <= 20; ++percent) {
    const auto within = std::upper_bound(r.errors.begin(), r.errors.end(), 0.01 * percent);
    errors.push_back(static_cast<double>(within - r.errors.begin()) /
                     static_cast<double>(std::max<std::size_t>(r.errors.size(), 1)));
  }
  return {{"features", json_of(r.features)},
          {"random", json_of(r.random)},
          {"shuffled", json_of(r.shuffled)},
          {"within_percent", errors}};
}

FeatureSet with(const FeatureSet& set, std::vector<Feature> features) {
  FeatureSet other = set;
  other.features = std::move(features);
  return other;
}

json others(const Take& a, const Take& b) {
  json row;
  const auto run = [&](const std::string& name, auto method) {
    row[name] = compared(a, with(a.set, method(a.performance.mesh, a.deformation)), b,
                         with(b.set, method(b.performance.mesh, b.deformation)))["features"];
  };
  for (const double octave : {1.0, 2.0, 3.0}) {
    for (const double apart : {0.0, 0.05}) {
      run("meshdog " + std::to_string(octave).substr(0, 3) + (apart > 0 ? " apart" : ""),
          [&](const auto& m, const auto& d) { return bench::mesh_dog(m, d, 20, octave, apart); });
    }
  }
  for (const double wider : {1.0, 2.0, 4.0}) {
    for (const double apart : {0.0, 0.05}) {
      run("velocity " + std::to_string(wider).substr(0, 3) + (apart > 0 ? " apart" : ""),
          [&](const auto& m, const auto& d) {
            return bench::velocity_saliency(m, d, 20, wider, apart);
          });
    }
  }
  DeformationOptions deformation;
  DetectOptions detect;
  set_thesis_preset(deformation, detect);
  detect.smoothings = 77;
  const auto printed = [&](const AnimatedMesh& m, const DeformationResult&) {
    return detect_features(m, deformation_of(m, deformation), detect).set.features;
  };
  run("thesis preset", printed);
  return row;
}

void pairs(int first, int count, bool with_others) {
  for (int i = first; i < first + count; ++i) {
    const auto motion = static_cast<uint64_t>(1 + i % 3), seed = static_cast<uint64_t>(100 + 2 * i);
    const Take a = take_of(seed, motion, 0), b = take_of(seed + 1, motion, 0);
    const Take c = take_of(seed + 1, motion, 5000);
    json row{{"pair", i},
             {"same", compared(a, a.set, b, b.set)},
             {"remeshed", compared(a, a.set, c, c.set)}};
    if (with_others) row["others"] = others(a, b);
    std::printf("%s\n", row.dump().c_str());
    std::fflush(stdout);
  }
}

void noise(int count) {
  for (int i = 0; i < count; ++i) {
    const auto subject = static_cast<uint64_t>(700 + i), motion = static_cast<uint64_t>(1 + i % 3);
    Take clean = take_of(subject, motion, 0);
    for (const bool smooth : {false, true}) {
      DeformationOptions options;
      if (smooth) {
        options.strain_radius = 0.06;
        options.position_smoothing = 2.5;
        clean.deformation = deformation_of(clean.performance.mesh, options);
        clean.set = detect_features(clean.performance.mesh, clean.deformation).set;
      }
      Take noisy = clean;
      std::mt19937_64 random(subject);
      std::normal_distribution<float> normal(
          0.0F, static_cast<float>(0.001 * clean.deformation.diagonal_mm));
      for (float& x : noisy.performance.mesh.positions()) x += normal(random);
      noisy.deformation = deformation_of(noisy.performance.mesh, options);
      noisy.set = detect_features(noisy.performance.mesh, noisy.deformation).set;
      const json row = compared(clean, clean.set, noisy, noisy.set);
      std::printf("%s\n", json{{"subject", subject},
                               {"smooth", smooth},
                               {"strict", row["features"][0]},
                               {"slack", row["features"][1]}}
                              .dump()
                              .c_str());
      std::fflush(stdout);
    }
  }
}

/// Of the pairs that are the same by the truth: is the partner the nearest by descriptor?
void descriptors(int first, int count) {
  const std::array<const char*, 5> names{"displacement", "deformation", "anim_mesh_hog",
                                         "composite", "chance"};
  std::array<double, 5> right{};
  double pairs_seen = 0;
  for (int i = first; i < first + count; ++i) {
    const auto motion = static_cast<uint64_t>(1 + i % 3), seed = static_cast<uint64_t>(100 + 2 * i);
    std::array<Take, 2> takes{take_of(seed, motion, 0), take_of(seed + 1, motion, 5000)};
    for (Take& t : takes) describe_features(t.set, t.performance.mesh, t.deformation);
    const SurfaceMap map = true_map(ict_model(), takes[0].performance, takes[1].performance);
    const Mesh rest = takes[1].performance.mesh.mesh_at(0);
    const double near = 0.05 * takes[1].set.diagonal_mm;
    const auto same = [&](const Feature& a, const Feature& b) {
      return (position_of(map.points[a.vertex], *rest.topology, rest.positions) -
              rest.positions[b.vertex].cast<double>())
                     .norm() <= near &&
             std::abs(a.time_s - b.time_s) <= 0.05 * takes[0].performance.mesh.duration_s();
    };
    for (const Feature& a : takes[0].set.features) {
      const auto& all = takes[1].set.features;
      const auto partners =
          std::count_if(all.begin(), all.end(), [&](const Feature& b) { return same(a, b); });
      if (partners == 0) continue;
      ++pairs_seen;
      const std::array<DescriptorWeights, 4> weights{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}}};
      for (std::size_t w = 0; w < weights.size(); ++w) {
        const auto nearest =
            std::min_element(all.begin(), all.end(), [&](const auto& x, const auto& y) {
              return descriptor_distance(a, x, weights[w]) < descriptor_distance(a, y, weights[w]);
            });
        right[w] += same(a, *nearest) ? 1 : 0;
      }
      right[4] += static_cast<double>(partners) / static_cast<double>(all.size());
    }
  }
  json row{{"pairs", pairs_seen}};
  for (std::size_t w = 0; w < names.size(); ++w) row[names[w]] = right[w] / pairs_seen;
  std::printf("%s\n", row.dump().c_str());
}

void cylinder() {
  const std::array<std::array<double, 2>, 3> cases{{{2.5, 60}, {1.25, 60}, {2.5, 120}}};
  for (const auto& [spacing, rate] : cases) {
    const BendingCylinder shape = bending_cylinder(spacing, rate);
    DetectOptions detect;
    detect.strongest = 8;
    const auto deformation = deformation_of(shape.mesh);
    const auto found = detect_features(shape.mesh, deformation, detect);
    json features = json::array();
    for (const Feature& f : found.set.features) {
      features.push_back({{"height_mm", deformation.rest[f.vertex].y() - deformation.rest[0].y()},
                          {"side_mm", deformation.rest[f.vertex].x()},
                          {"time_s", f.time_s},
                          {"sigma_mm", f.sigma_mm},
                          {"tau_s", f.tau_s},
                          {"response", f.response}});
    }
    std::printf(
        "%s\n",
        json{{"spacing_mm", spacing}, {"rate_hz", rate}, {"features", features}}.dump().c_str());
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "";
  const auto number = [&](int i, int otherwise) {
    return argc > i ? std::atoi(argv[i]) : otherwise;
  };
  if (what == "pairs") {
    pairs(number(2, 20), number(3, 20), argc > 4);
  } else if (what == "noise") {
    noise(number(2, 3));
  } else if (what == "descriptors") {
    descriptors(number(2, 20), number(3, 6));
  } else if (what == "cylinder") {
    cylinder();
  } else {
    std::printf("feature_figures pairs|noise|descriptors|cylinder …\n");
    return 2;
  }
  return 0;
}
