// How well features of animations with known truth are matched: pairs of model faces doing the same
// motion (scaled for each subject), and bending cylinders. One JSON object per line.
//
//   feature_matching_figures [PAIRS] [name=value …]      names as the options of kinemesh match
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <iostream>
#include <random>
#include <string>

#include "analysis/anim_dog.h"
#include "analysis/feature_matching.h"
#include "config/error.h"
#include "tests/support/bending_cylinder.h"
#include "tests/support/ict_performer.h"

namespace {

using namespace kinemesh;

constexpr double near = 0.025, near_time = 0.05, wrong = 0.05, far_off = 0.10;

struct Pair {
  FeaturePlaces a, b;
  std::vector<Eigen::Vector3d> truth{};  // of each place of a, on b's rest mesh
  double diagonal = 0.0;                 // of b
};

struct Score {
  int matches = 0, wrong = 0, far_off = 0, matchable = 0, matched = 0, pairs = 0, certified = 0;
  std::vector<double> errors;  // over √area
  double worst = 0.0, slowest = 0.0, slowest_cpu = 0.0;
};

double diagonal_of(const AnimatedMesh& mesh) {
  const auto frame = mesh.frame(0);
  return (frame.colwise().maxCoeff() - frame.colwise().minCoeff()).norm();
}

Pair make_pair(const AnimatedMesh& a, const AnimatedMesh& b,
               const std::function<Eigen::Vector3d(VertexIndex)>& truth,
               const FeatureMatchingOptions& options, int strongest) {
  DetectOptions detect;
  detect.strongest = strongest;
  Pair pair{.a = feature_places(detect_features(a, deformation_of(a), detect).set, a, options),
            .b = feature_places(detect_features(b, deformation_of(b), detect).set, b, options),
            .diagonal = diagonal_of(b)};
  for (const auto& p : pair.a.places) pair.truth.push_back(truth(p.feature.vertex));
  return pair;
}

/// Keeps a share of the places, drawn at random.
FeaturePlaces thinned(const FeaturePlaces& places, double kept, uint64_t seed) {
  std::vector<std::size_t> order(places.places.size());
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
  std::shuffle(order.begin(), order.end(), std::mt19937_64(seed));
  order.resize(static_cast<std::size_t>(std::ceil(kept * static_cast<double>(order.size()))));
  std::ranges::sort(order);
  FeaturePlaces result{.root_area_mm = places.root_area_mm};
  const auto n = static_cast<Eigen::Index>(order.size());
  result.distances.resize(n, n);
  for (std::size_t p = 0; p < order.size(); ++p) {
    result.places.push_back(places.places[order[p]]);
    result.places.back().index = static_cast<uint32_t>(p);
    for (std::size_t q = 0; q < order.size(); ++q) {
      result.distances(static_cast<Eigen::Index>(p), static_cast<Eigen::Index>(q)) =
          places.distances(static_cast<Eigen::Index>(order[p]),
                           static_cast<Eigen::Index>(order[q]));
      if (!places.path_classes.empty()) {
        result.path_classes.push_back(
            places.path_classes[order[p] * places.places.size() + order[q]]);
      }
    }
  }
  return result;
}

void add(Score& score, const Pair& pair, const FeaturePlaces& b,
         const FeatureMatchingOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  const std::clock_t cpu = std::clock();
  const FeatureMatching m = match_features(pair.a, b, options, {.gap = 1e-3, .iterations = 60});
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin;
  score.slowest = std::max(score.slowest, spent.count());
  score.slowest_cpu =
      std::max(score.slowest_cpu, static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC);
  score.certified += m.solution.certified ? 1 : 0;
  ++score.pairs;
  std::vector<char> matched(pair.a.places.size(), 0);
  for (const FeatureMatch& match : m.matches) {
    matched[match.source] = 1;
    const double error = (b.places[match.target].position - pair.truth[match.source]).norm();
    score.errors.push_back(error / b.root_area_mm);
    score.worst = std::max(score.worst, error / pair.diagonal);
    score.wrong += error > wrong * pair.diagonal ? 1 : 0;
    score.far_off += error > far_off * pair.diagonal ? 1 : 0;
    ++score.matches;
    if (std::getenv("KINEMESH_VERBOSE") != nullptr && error > wrong * pair.diagonal) {
      std::printf("wrong %u-%u error %.3f dscr %.2f geod %.3f orient %.3f margin %.2f\n",
                  match.source, match.target, error / pair.diagonal, match.descriptor,
                  match.geodesic, match.orientation, match.margin);
    }
  }
  for (std::size_t p = 0; p < pair.a.places.size(); ++p) {
    const bool matchable = std::ranges::any_of(b.places, [&](const auto& q) {
      return (q.position - pair.truth[p]).norm() <= near * pair.diagonal &&
             std::abs(q.time - pair.a.places[p].time) <= near_time;
    });
    score.matchable += matchable ? 1 : 0;
    score.matched += matchable && matched[p] != 0 ? 1 : 0;
  }
}

void print(const char* name, Score& s) {
  std::ranges::sort(s.errors);
  const double median = s.errors.empty() ? 0.0 : s.errors[s.errors.size() / 2];
  std::printf(
      "{\"case\": \"%s\", \"pairs\": %d, \"matches\": %d, \"wrong\": %.4f, \"far_off\": %d, "
      "\"worst\": %.4f, \"matchable\": %d, \"matched\": %.4f, \"median_error\": %.4f, "
      "\"certified\": %d, \"slowest_s\": %.4f, \"slowest_cpu_s\": %.4f}\n",
      name, s.pairs, s.matches, s.wrong / std::max(1.0, double(s.matches)), s.far_off, s.worst,
      s.matchable, s.matched / std::max(1.0, double(s.matchable)), median, s.certified, s.slowest,
      s.slowest_cpu);
  std::fflush(stdout);
}

std::vector<Pair> face_pairs(int count, const FeatureMatchingOptions& options) {
  std::vector<Pair> pairs;
  const test::IctModel& model = test::ict_model();
  for (int k = 0; k < count; ++k) {
    const test::IctMotion motion = make_ict_motion(model, 1 + static_cast<uint64_t>(k) % 3);
    const auto subject = [&](int which) {
      test::PerformOptions perform_options;
      perform_options.variation.scale = 0.3;
      return perform(model, {.seed = 500 + 2 * static_cast<uint64_t>(k) + which}, motion,
                     perform_options);
    };
    const test::Performance a = subject(0), b = subject(1);
    const auto rest = b.mesh.mesh_at(0);
    pairs.push_back(make_pair(
        a.mesh, b.mesh, [&](VertexIndex v) { return rest.positions[v].cast<double>().eval(); },
        options, k % 2 == 0 ? 20 : 24));
  }
  return pairs;
}

std::vector<Pair> cylinder_pairs(const FeatureMatchingOptions& options) {
  std::vector<Pair> pairs;
  for (const auto& [a, b] : test::bending_cylinder_pairs()) {
    const test::BendingCylinder source = make_bending_cylinder(a),
                                target = make_bending_cylinder(b);
    pairs.push_back(make_pair(
        source.mesh, target.mesh,
        [&](VertexIndex v) { return target.rest_place(source.parameters[v]); }, options, 12));
  }
  return pairs;
}

void measure(const char* name, const std::vector<Pair>& pairs,
             const FeatureMatchingOptions& options) {
  Score whole, thin;
  uint64_t seed = 1;
  for (const Pair& pair : pairs) {
    add(whole, pair, pair.b, options);
    for (int draw = 0; draw < 3; ++draw) add(thin, pair, thinned(pair.b, 0.6, seed++), options);
  }
  print(name, whole);
  print((std::string(name) + ", 40 % removed").c_str(), thin);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    FeatureMatchingOptions options;
    ParameterSet parameters;
    options.declare(parameters);
    int count = 20;
    for (int k = 1; k < argc; ++k) {
      const std::string word = argv[k];
      const std::size_t equals = word.find('=');
      if (equals == std::string::npos) {
        count = std::atoi(argv[k]);
      } else if (Parameter* p = parameters.find(word.substr(0, equals))) {
        p->set({word.substr(equals + 1)});
      }
    }
    measure("cylinders", cylinder_pairs(options), options);
    const std::vector<Pair> faces = face_pairs(count, options);
    measure("faces", faces, options);
    if (std::getenv("KINEMESH_SWEEP") == nullptr) return 0;
    for (std::string line; std::getline(std::cin, line);) {  // name=value …, one set per line
      FeatureMatchingOptions changed = options;
      ParameterSet set;
      changed.declare(set);
      for (std::size_t at = 0; at < line.size();) {
        const std::size_t end = std::min(line.find(' ', at), line.size());
        const std::string word = line.substr(at, end - at);
        const std::size_t equals = word.find('=');
        if (Parameter* p = set.find(word.substr(0, equals))) p->set({word.substr(equals + 1)});
        at = end + 1;
      }
      std::printf("%s\n", line.c_str());
      measure("faces", faces, changed);
    }
  } catch (const Error& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 1;
  }
  return 0;
}
