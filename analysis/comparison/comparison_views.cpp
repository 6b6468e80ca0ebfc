#include "analysis/comparison/comparison_views.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "analysis/comparison/course.h"

namespace kinemesh::comparison {
namespace {

// Of each animation; its fields may take a third each. A large mesh needs 12 bytes a vertex for its
// mean and 6 for each mode of motion.
constexpr std::size_t least_bytes = 600000, most_bytes = 2500000, bytes_per_vertex = 60;

/// The size that all but one in two hundred samples stay below.
double usual_largest(std::initializer_list<const std::vector<float>*> fields) {
  std::vector<float> sizes;
  for (const std::vector<float>* field : fields) {
    const std::size_t step = field->size() / 200000 + 1;
    for (std::size_t k = 0; k < field->size(); k += step) {
      if (std::isfinite((*field)[k])) sizes.push_back(std::abs((*field)[k]));
    }
  }
  if (sizes.empty()) return 1.0;
  const auto at =
      sizes.begin() + static_cast<std::ptrdiff_t>(0.995 * static_cast<double>(sizes.size() - 1));
  std::nth_element(sizes.begin(), at, sizes.end());
  return *at > 1e-6F ? *at : 1.0;
}

/// Rounded up to 1, 2 or 5 times a power of ten.
double round_up(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {1.0, 2.0, 5.0}) {
    if (value <= step * power * 1.0001) return step * power;
  }
  return 10.0 * power;
}

/// Lengths of 3-vectors.
std::vector<float> lengths_of(const Field& field) {
  std::vector<float> lengths(field.values.size() / 3);
  for (std::size_t k = 0; k < lengths.size(); ++k)
    lengths[k] = Eigen::Map<const Eigen::Vector3f>(field.values.data() + 3 * k).norm();
  return lengths;
}

/// A's frame at each frame of B: the inverse of the warp, which does not descend.
std::vector<double> frames_of_a(const Comparison& c) {
  std::vector<double> frames(c.b.frame_count, 0.0);
  if (!c.warp) return frames;
  const std::vector<double>& times = c.warp->b_of_a_s;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const double time = static_cast<double>(f) / c.b.rate_hz;
    const auto next = std::ranges::lower_bound(times, time);
    if (next == times.begin() || next == times.end()) {
      frames[f] = next == times.begin() ? 0.0 : static_cast<double>(times.size() - 1);
      continue;
    }
    const double before = *(next - 1), step = *next - before;
    frames[f] =
        static_cast<double>(next - 1 - times.begin()) + (step > 0.0 ? (time - before) / step : 0.0);
  }
  return frames;
}

/// Values on A's vertices brought to B's: one per vertex, or per sample.
std::vector<float> on_b(const std::vector<float>& values, const ComparisonStory& story) {
  const Comparison& c = story.comparison;
  const std::size_t n = c.forward.points.size();
  const Field field{n, values};
  const bool fixed = values.size() == n;
  return brought_to(field, 1, c.reverse, story.a.mesh.topology(),
                    fixed ? std::vector<double>{0.0} : frames_of_a(c))
      .values;
}

/// How far up A a place lies, %: shows by its stripes what corresponds.
std::vector<float> height_on_a(const ComparisonStory& story, const BodyAxes& axes) {
  std::vector<float> heights;
  for (const Eigen::Vector3d& p : story.comparison.a.rest)
    heights.push_back(axes.up.dot(p.cast<float>()));
  const auto [low, high] = std::ranges::minmax(heights);
  for (float& h : heights) h = high > low ? 100.0F * (h - low) / (high - low) : 0.0F;
  return heights;
}

struct Both {
  MeshViewerOptions a, b;
  void add(const ColourScale& scale, std::vector<float> of_a, std::vector<float> of_b) {
    a.fields.push_back({scale, std::move(of_a)});
    if (!of_b.empty()) b.fields.push_back({scale, std::move(of_b)});
  }
};

void add_fields(Both& both, const ComparisonStory& story, const BodyAxes& axes) {
  using enum ColourScale::Map;
  const Comparison& c = story.comparison;
  const bool back = !c.reverse.points.empty();
  const auto transferred = [&](const std::vector<float>& values) {
    return back ? on_b(values, story) : std::vector<float>();
  };
  const std::vector<float> heights = height_on_a(story, axes);
  both.add({sequential, 0.0, 100.0, "place: height on A", "%"}, heights, transferred(heights));
  std::vector<float> confidence;
  for (const double sure : c.forward.confidence)
    confidence.push_back(static_cast<float>(100.0 * sure));
  both.add({sequential, 0.0, 100.0, "confidence of the correspondence", "%"}, confidence,
           transferred(confidence));
  const double shape = round_up(usual_largest({&c.shape_mm}));
  both.add({diverging, -shape, shape, "shape difference at rest, B outside A positive", "mm"},
           c.shape_mm, transferred(c.shape_mm));
  const double stretch = round_up(usual_largest({&c.strain_difference.values}));
  if (c.warp) {
    both.add({diverging, -stretch, stretch, "motion difference: strain, B − A", "%"},
             c.strain_difference.values, transferred(c.strain_difference.values));
    const double motion = round_up(usual_largest({&c.motion_difference.values}));
    both.add({sequential, 0.0, motion, "motion difference: displacement", "mm"},
             c.motion_difference.values, transferred(c.motion_difference.values));
  }
  const double strain = round_up(usual_largest({&c.a.strain.values, &c.b.strain.values}));
  both.add({sequential, 0.0, strain, "motion: strain from rest", "%"}, c.a.strain.values,
           c.b.strain.values);
  const std::vector<float> of_a = lengths_of(c.a.displacement), of_b = lengths_of(c.b.displacement);
  const double far = round_up(usual_largest({&of_a, &of_b}));
  both.add({sequential, 0.0, far, "motion: displacement from rest", "mm"}, of_a, of_b);
}

AnimatedMesh turned(const AnimatedMesh& mesh, const Eigen::Matrix3d& turn) {
  AnimatedMesh result = mesh;
  for (std::size_t f = 0; f < mesh.frame_count(); ++f)
    result.frame(f) = (mesh.frame(f) * turn.cast<float>().transpose()).eval();
  return result;
}

}  // namespace

std::pair<MeshViewer, MeshViewer> viewers_of(const ComparisonStory& story, const RunContext& ctx) {
  const Comparison& c = story.comparison;
  const BodyAxes axes = estimate_axes(story.a.mesh.topology(), story.a.mesh.frame(0));
  Both both;
  const std::size_t vertices = std::max<std::size_t>(1, story.a.mesh.vertex_count());
  for (MeshViewerOptions* view : {&both.a, &both.b}) {
    view->axes = axes;
    view->group = "faces";
    // A browser adds up three million products a frame with ease: small meshes may have more.
    view->code.max_modes = std::max<std::size_t>(view->code.max_modes, 500000 / vertices);
  }
  const auto room = [](const AnimatedMesh& mesh) {
    return std::clamp(bytes_per_vertex * mesh.vertex_count(), least_bytes, most_bytes);
  };
  both.a.code.max_bytes = room(story.a.mesh);
  both.b.code.max_bytes = room(story.b.mesh);
  both.a.title = "A · " + story.name_a;
  both.b.title = "B · " + story.name_b;
  add_fields(both, story, axes);
  if (c.warp) {
    for (std::size_t f = 0; f < c.a.frame_count; ++f) {
      both.a.timeline.push_back(static_cast<double>(f));
      both.b.timeline.push_back(std::clamp(c.warp->b_of_a_s[f] * c.b.rate_hz, 0.0,
                                           static_cast<double>(c.b.frame_count - 1)));
    }
  }
  return {MeshViewer(story.a.mesh, both.a, ctx),
          MeshViewer(turned(story.b.mesh, c.turn), both.b, ctx)};
}

}  // namespace kinemesh::comparison
