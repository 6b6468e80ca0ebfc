#include "analysis/jumps.h"

#include <algorithm>
#include <cmath>

#include "config/text.h"

namespace kinemesh {
namespace {

constexpr double least_jump = 0.25;  // of the diagonal
constexpr double least_ratio = 20.0;
constexpr std::size_t most_named = 5;

/// Mean length of the vertices' steps to the frame.
double mean_step(const AnimatedMesh& animation, std::size_t frame) {
  const auto before = animation.frame(frame - 1), now = animation.frame(frame);
  double sum = 0.0;
  std::size_t count = 0;
  for (Eigen::Index v = 0; v < now.rows(); ++v) {
    const double step = (now.row(v) - before.row(v)).norm();
    if (!std::isfinite(step)) continue;
    sum += step;
    ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) : 0.0;
}

}  // namespace

std::vector<std::size_t> jumping_frames(const AnimatedMesh& animation) {
  std::vector<std::size_t> jumping;
  if (animation.frame_count() < 3 || animation.vertex_count() == 0) return jumping;
  std::vector<double> steps;
  for (std::size_t f = 1; f < animation.frame_count(); ++f) {
    steps.push_back(mean_step(animation, f));
  }
  std::vector<double> sorted = steps;
  // The lower one of two in the middle: of three frames the step that is no jump.
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>((sorted.size() - 1) / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  const auto first = animation.frame(0);
  const double diagonal = (first.colwise().maxCoeff() - first.colwise().minCoeff()).norm();
  for (std::size_t f = 1; f < animation.frame_count(); ++f) {
    if (steps[f - 1] > least_jump * diagonal && steps[f - 1] > least_ratio * *middle) {
      jumping.push_back(f);
    }
  }
  return jumping;
}

void warn_of_jumps(const AnimatedMesh& animation, const RunContext& ctx) {
  const std::vector<std::size_t> jumping = jumping_frames(animation);
  if (jumping.empty()) return;
  std::vector<std::string> named;
  for (std::size_t i = 0; i < std::min(jumping.size(), most_named); ++i) {
    named.push_back(std::to_string(jumping[i]));
  }
  const std::size_t others = jumping.size() - named.size();
  if (others > 0) named.push_back(count_of(others, "other"));
  std::string text =
      jumping.size() == 1 ? "the surface jumps to frame " : "the surface jumps to frames ";
  text += join(named, ", ", " and ");
  text +=
      " (0-based), far more than it moves otherwise: deformation there may outweigh all else; mend "
      "or cut these frames";
  ctx.warn(text);
}

}  // namespace kinemesh
