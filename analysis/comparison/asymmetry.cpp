#include "analysis/comparison/asymmetry.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kinemesh {
namespace {

/// One side of a pair.
struct Side {
  double mm = 0.0;
  const std::optional<MovementTiming>* timing = nullptr;
};

Asymmetry between(const Side& left, const Side& right) {
  Asymmetry result{left.mm, right.mm, 0.0, std::numeric_limits<double>::quiet_NaN()};
  const double mean = (std::abs(left.mm) + std::abs(right.mm)) / 2.0;
  if (mean > 0.0) result.percent = 100.0 * (std::abs(left.mm) - std::abs(right.mm)) / mean;
  if (*left.timing && *right.timing)
    result.onset_ms = 1e3 * ((*left.timing)->onset_s - (*right.timing)->onset_s);
  return result;
}

/// `name` with "left" replaced; empty when it does not hold it.
std::string with_instead(const std::string& name, const std::string& word) {
  const std::size_t at = name.find("left");
  if (at == std::string::npos) return {};
  std::string other = name;
  return other.replace(at, 4, word);
}

std::string without_side(const std::string& name) {
  std::string base = with_instead(name, "");
  while (base.find("  ") != std::string::npos) base.erase(base.find("  "), 1);
  if (!base.empty() && base.front() == ' ') base.erase(0, 1);
  if (!base.empty() && base.back() == ' ') base.pop_back();
  return base;
}

}  // namespace

std::vector<AsymmetryRow> asymmetry_of(const std::vector<RegionResult>& regions,
                                       const std::vector<MeasureResult>& measures) {
  std::vector<AsymmetryRow> rows;
  const auto side = [](const RegionCourse& c) { return Side{c.largest_mm, &c.timing}; };
  for (const RegionResult& left : regions) {
    const std::string& name = left.region.name;
    const auto right = std::ranges::find_if(regions, [&](const RegionResult& r) {
      return !with_instead(name, "").empty() && r.region.name == with_instead(name, "right");
    });
    if (right == regions.end()) continue;
    rows.push_back({without_side(name) + " region", between(side(left.a), side(right->a)),
                    between(side(left.b), side(right->b))});
  }
  const auto change = [](const MeasureCourse& c) { return Side{c.change_mm, &c.timing}; };
  for (const MeasureResult& left : measures) {
    const std::string& name = left.spec.name;
    const auto right = std::ranges::find_if(measures, [&](const MeasureResult& m) {
      return !with_instead(name, "").empty() && m.spec.name == with_instead(name, "right");
    });
    if (right == measures.end()) continue;
    rows.push_back({without_side(name), between(change(left.a), change(right->a)),
                    between(change(left.b), change(right->b))});
  }
  return rows;
}

}  // namespace kinemesh
