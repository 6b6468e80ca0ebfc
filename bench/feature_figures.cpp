// Figures of the features on model faces with a true map, one JSON object a line, for
// tools/verify.d/6_features:
//   feature_figures pairs FIRST COUNT [others]   agreement of pairs of subjects; with other methods
//   feature_figures noise COUNT                  repeatability under noise
//   feature_figures descriptors FIRST COUNT      nearest neighbour by each descriptor
//   feature_figures sweep FIRST COUNT            agreement and noise for each line of settings on
//                                                stdin
//   feature_figures bumps                        two bumps of different size, a travelling one
//   feature_figures histograms ANIMATION         time of AnimMeshHoG for 200 features
//   feature_figures cylinder                     the bending cylinders of figure 4-15
#include <Eigen/Geometry>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <string>

#include "analysis/descriptors.h"
#include "analysis/feature_consistency.h"
#include "bench/feature_baselines.h"
#include "mesh/formats/mesh_io.h"
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

/// `scale`: each expression of this subject is stronger or weaker by up to this part.
Take take_of(uint64_t subject, uint64_t motion, std::size_t remeshed, double scale = 0) {
  const IctModel& model = ict_model();
  PerformOptions options;
  options.remesh_vertices = remeshed;
  options.variation.scale = scale;
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

/// Settings of both stages as name=value words; those after "|" are for noisy data only.
struct Settings {
  DeformationOptions deformation, noisy_deformation;
  DetectOptions detect, noisy_detect;
  explicit Settings(const std::string& line) {
    ParameterSet clean, noisy;
    deformation.declare(clean);
    detect.declare(clean);
    noisy_deformation.declare(noisy);
    noisy_detect.declare(noisy);
    std::istringstream words(line);
    bool both = true;
    for (std::string word; words >> word;) {
      if (word == "|") both = false;
      const std::size_t equals = word.find('=');
      if (equals == std::string::npos) continue;
      const std::string name = word.substr(0, equals), value = word.substr(equals + 1);
      if (both) clean.find(name)->set({value});
      noisy.find(name)->set({value});
    }
  }
};

AnimatedMesh with_noise(const AnimatedMesh& mesh, double diagonal, uint64_t seed) {
  AnimatedMesh noisy = mesh;
  std::mt19937_64 random(seed);
  std::normal_distribution<float> normal(0.0F, static_cast<float>(0.001 * diagonal));
  for (float& x : noisy.positions()) x += normal(random);
  return noisy;
}

FeatureSet features_of(const AnimatedMesh& mesh, const DeformationOptions& deformation,
                       const DetectOptions& detect) {
  return detect_features(mesh, deformation_of(mesh, deformation), detect).set;
}

void noise(int count) {
  for (int i = 0; i < count; ++i) {
    const auto subject = static_cast<uint64_t>(700 + i), motion = static_cast<uint64_t>(1 + i % 3);
    const Take clean = take_of(subject, motion, 0);
    Take noisy = clean;
    noisy.performance.mesh =
        with_noise(clean.performance.mesh, clean.deformation.diagonal_mm, subject);
    noisy.set = features_of(noisy.performance.mesh, {}, {});
    const json row = compared(clean, clean.set, noisy, noisy.set);
    std::printf(
        "%s\n",
        json{{"subject", subject}, {"strict", row["features"][0]}, {"slack", row["features"][1]}}
            .dump()
            .c_str());
    std::fflush(stdout);
  }
}

void sweep(int first, int count) {
  std::vector<std::array<Performance, 3>> takes;
  const IctModel& model = ict_model();
  for (int i = first; i < first + count; ++i) {
    const auto motion = make_ict_motion(model, static_cast<uint64_t>(1 + i % 3));
    const auto seed = static_cast<uint64_t>(100 + 2 * i);
    const auto act = [&](uint64_t subject, std::size_t remeshed) {
      return perform(model, {.seed = subject}, motion,
                     {.remesh_vertices = remeshed, .seed = subject});
    };
    takes.push_back({act(seed, 0), act(seed + 1, 0), act(seed + 1, 5000)});
  }
  for (std::string line; std::getline(std::cin, line);) {
    const Settings settings(line);
    std::array<double, 8> sums{};
    for (const auto& [a, b, c] : takes) {
      const FeatureSet fa = features_of(a.mesh, settings.deformation, settings.detect);
      const auto add = [&](std::size_t at, const Performance& other, const FeatureSet& found) {
        const auto r = feature_consistency(fa, found, true_map(model, a, other),
                                           other.mesh.mesh_at(0), {.trials = 1})
                           .features;
        sums[at] += r.strict / count;
        sums[at + 1] += r.slack / count;
        if (at < 6) sums[at + 2] += r.nearest / count;
      };
      add(0, b, features_of(b.mesh, settings.deformation, settings.detect));
      add(3, c, features_of(c.mesh, settings.deformation, settings.detect));
      Performance noisy{with_noise(a.mesh, fa.diagonal_mm, 7), a.on_model, a.head_pose};
      add(6, noisy, features_of(noisy.mesh, settings.noisy_deformation, settings.noisy_detect));
    }
    std::printf("%.3f/%.3f %.3f/%.3f %.3f/%.3f noise %.3f %.3f  %s\n", sums[0], sums[3], sums[1],
                sums[4], sums[2], sums[5], sums[6], sums[7], line.c_str());
    std::fflush(stdout);
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
    // Without other strengths both would have the same displacements, which leaks the answer.
    std::array<Take, 2> takes{take_of(seed, motion, 0, 0.25),
                              take_of(seed + 1, motion, 5000, 0.25)};
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
      const std::array<DescriptorWeights, 4> weights{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {}}};
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

/// Features with where they lie in the rest pose of the untransformed shape.
struct Found {
  FeatureSet set;
  std::vector<Eigen::Vector3d> at;
  double edge_mm = 0, duration_s = 0;
};

/// Of positions that were turned and scaled: `back` undoes it.
Found found_in(const AnimatedMesh& mesh, const Eigen::Matrix3d& back, double scale) {
  const DeformationResult d = deformation_of(mesh);
  Found found{detect_features(mesh, d).set, {}, d.mean_edge_mm / scale, mesh.duration_s()};
  for (Feature& f : found.set.features) {
    found.at.push_back(back * d.rest[f.vertex] / scale);
    f.sigma_mm /= scale;
  }
  return found;
}

/// The most features of both that lie within an edge and 5 % of the duration of each other, over
/// the larger count; each the nearest free one of the other.
double same_set(const Found& a, const Found& b) {
  std::vector<char> taken(b.at.size(), 0);
  int pairs = 0;
  for (std::size_t i = 0; i < a.at.size(); ++i) {
    std::size_t best = b.at.size();
    double least = std::max(a.edge_mm, b.edge_mm);
    for (std::size_t j = 0; j < b.at.size(); ++j) {
      const double time = std::abs(a.set.features[i].time_s - b.set.features[j].time_s);
      const double r = (a.at[i] - b.at[j]).norm();
      if (taken[j] != 0 || time > 0.05 * a.duration_s || r > least) continue;
      least = r;
      best = j;
    }
    if (best == b.at.size()) continue;
    taken[best] = 1;
    ++pairs;
  }
  return pairs / std::max(1.0, static_cast<double>(std::max(a.at.size(), b.at.size())));
}

void cylinder() {
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  struct Case {
    const char* name;
    double spacing, rate, scale;
    bool moved;
  };
  Found first;
  for (const Case& c :
       {Case{"as it is", 2.5, 60, 1, false}, Case{"double density", 1.25, 60, 1, false},
        Case{"double rate", 2.5, 120, 1, false}, Case{"turned and moved", 2.5, 60, 1, true},
        Case{"scaled by 1000", 2.5, 60, 1000, false}}) {
    TwoJointCylinder shape = two_joint_cylinder(c.spacing, c.rate);
    for (std::size_t f = 0; f < shape.mesh.frame_count(); ++f) {
      for (VertexIndex v = 0; v < shape.mesh.vertex_count(); ++v) {
        auto p = shape.mesh.position(f, v);
        if (c.moved) p = (turn.cast<float>() * p + Eigen::Vector3f(300, -500, 800)).eval();
        p *= static_cast<float>(c.scale);
      }
    }
    const Found found = found_in(
        shape.mesh, c.moved ? Eigen::Matrix3d(turn.transpose()) : Eigen::Matrix3d::Identity(),
        c.scale);
    if (first.at.empty()) first = found;
    // The joint's surface is stretched most on its outer side, at x = −10 mm; rest is centred.
    json joints = json::array();
    for (std::size_t j = 0; j < 2; ++j) {
      const double height = shape.joint_height_mm[j] - 60.0;
      std::size_t best = 0;
      for (std::size_t i = 1; i < found.at.size(); ++i) {
        const auto score = [&](std::size_t k) {
          return std::abs(found.at[k].y() - height) / 20.0 +
                 std::abs(found.set.features[k].time_s - shape.joint_time_s[j]);
        };
        if (score(i) < score(best)) best = i;
      }
      if (found.at.empty()) break;
      const Feature& f = found.set.features[best];
      joints.push_back({{"off_sigma", std::abs(found.at[best].y() - height) / f.sigma_mm},
                        {"off_time", std::abs(f.time_s - shape.joint_time_s[j]) / 2.0},
                        {"rank", best},
                        {"sigma_mm", f.sigma_mm},
                        {"tau_s", f.tau_s}});
    }
    std::printf("%s\n", json{{"case", c.name},
                             {"features", found.at.size()},
                             {"joints", joints},
                             {"same_set", same_set(first, found)}}
                            .dump()
                            .c_str());
  }
}

/// Bumps that rise out of a sheet: the strongest feature near each.
void bump_figures() {
  const auto sheet = make_sheet(300, 300, 4, 3);
  const std::vector<std::pair<const char*, std::vector<Bump>>> cases{
      {"two sizes", {{{75, 85}, 8, 0.6, 0.1, 6}, {{210, 190}, 16, 1.3, 0.2, 12}}},
      {"travelling", {{{140, 150}, 12, 1.0, 0.25, 9, {60, 0}}}}};
  for (const auto& [name, all] : cases) {
    const AnimatedMesh mesh = test::bumps(sheet, all, 2.0, 60);
    const DeformationResult d = deformation_of(mesh);
    const auto features = detect_features(mesh, d).set.features;
    for (const Bump& b : all) {
      const auto off = [&](const Feature& f) {
        const Eigen::Vector2d centre = b.centre + b.velocity * (f.time_s - b.time_s);
        return (sheet.positions[f.vertex].head<2>() - centre).norm() / b.sigma_mm;
      };
      const auto hit = std::find_if(features.begin(), features.end(), [&](const Feature& f) {
        return off(f) <= 2.0 && std::abs(f.time_s - b.time_s) <= 0.2;
      });
      if (hit == features.end()) {
        std::printf("%s\n", json{{"case", name}, {"found", false}}.dump().c_str());
        continue;
      }
      std::printf("%s\n", json{{"case", name},
                               {"found", true},
                               {"rank", hit - features.begin()},
                               {"off_sigma", off(*hit)},
                               {"off_time", std::abs(hit->time_s - b.time_s) / 2.0},
                               {"bump_sigma_mm", b.sigma_mm},
                               {"sigma_mm", hit->sigma_mm},
                               {"tau_s", hit->tau_s}}
                              .dump()
                              .c_str());
    }
  }
}

/// AnimMeshHoG of 200 features of an animation: seconds of processor time.
void histograms(const std::string& path) {
  const AnimatedMesh mesh = read_animation(builtin_mesh_formats(), path);
  const DeformationResult d = deformation_of(mesh);
  DetectOptions options;
  options.strongest = 200;
  options.threshold = options.apart = options.apart_time = 0.0;
  FeatureSet set = detect_features(mesh, d, options).set;
  RunContext ctx;
  ctx.set_threads(2);
  const std::clock_t begin = std::clock();
  describe_features(set, mesh, d, {}, ctx);
  const double cpu = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  std::printf("%s\n", json{{"features", set.features.size()}, {"cpu_s", cpu}}.dump().c_str());
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "";
  const auto number = [&](int i, int otherwise) {
    return argc > i ? std::atoi(argv[i]) : otherwise;
  };
  if (what == "pairs") {
    pairs(number(2, 20), number(3, 20), argc > 4);
  } else if (what == "sweep") {
    sweep(number(2, 20), number(3, 6));
  } else if (what == "noise") {
    noise(number(2, 3));
  } else if (what == "descriptors") {
    descriptors(number(2, 20), number(3, 6));
  } else if (what == "cylinder") {
    cylinder();
  } else if (what == "bumps") {
    bump_figures();
  } else if (what == "histograms") {
    histograms(argc > 2 ? argv[2] : "");
  } else {
    std::printf("feature_figures pairs|noise|descriptors|cylinder …\n");
    return 2;
  }
  return 0;
}
