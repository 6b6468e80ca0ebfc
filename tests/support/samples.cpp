#include "tests/support/samples.h"

#include "config/error.h"

namespace kinemesh::test {

namespace {

struct Recipe {
  std::string name, subject;
  MotionKind motion;
  uint64_t seed;
  std::size_t short_gaps, long_gaps;
};

const std::vector<Recipe>& recipes() {
  static const std::vector<Recipe> all{{"anna_happy", "anna", MotionKind::happy, 101, 70, 5},
                                       {"anna_surprise", "anna", MotionKind::surprise, 102, 60, 4},
                                       {"ben_happy", "ben", MotionKind::happy, 110, 150, 8},
                                       {"ben_surprise", "ben", MotionKind::surprise, 104, 60, 4}};
  return all;
}

}  // namespace

const std::vector<std::string>& sample_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const Recipe& r : recipes()) list.push_back(r.name);
    return list;
  }();
  return names;
}

std::shared_ptr<const SyntheticFace> sample_face(const std::string& subject) {
  return make_face({.seed = subject == "anna" ? 29U : 27U});
}

MarkerLayout sample_layout(const std::string& subject) {
  const auto anna = sample_face("anna");
  const MarkerLayout layout = place_markers(
      *anna, {.spacing_mm = 9.5, .seed = 5, .sideways = 65, .top = 53, .bottom = -70});
  if (subject == "anna") return layout;
  return transfer_markers(layout, *sample_face(subject),
                          {.jitter_mm = 0.7, .missing = 3, .least_mm = 8.2, .seed = 6});
}

SyntheticTake make_sample(const std::string& name) {
  for (const Recipe& r : recipes()) {
    if (r.name != name) continue;
    TakeOptions options;
    options.short_gaps = r.short_gaps;
    options.long_gaps = r.long_gaps;
    options.head_degrees = 6;
    options.head_mm = 25;
    options.head_rig = true;
    options.label_swap = r.name == sample_with_swap;
    options.subject = r.subject;
    options.seed = r.seed;
    return make_take(sample_face(r.subject), sample_layout(r.subject),
                     vary(make_motion(r.motion), r.seed), options);
  }
  throw UsageError({.what = "There is no sample session named " + name});
}

}  // namespace kinemesh::test
