#include "analysis/feature_energy.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "config/error.h"

namespace kinemesh {
namespace {

constexpr int samples = 64;            // of a curve over normalised time
constexpr double largest_cost = 2.0;   // of a geodesic term
constexpr double short_length = 0.15;  // √area: lengths below count in full, not in proportion
constexpr double broken_prior = 10.0;  // instead of the thesis' infinity: the bound stays finite

/// Linear interpolation at `samples` equal steps.
Eigen::VectorXd resampled(const std::vector<float>& curve) {
  Eigen::VectorXd values = Eigen::VectorXd::Zero(samples);
  if (curve.empty()) return values;
  for (int k = 0; k < samples; ++k) {
    const double at = static_cast<double>(curve.size() - 1) * k / (samples - 1);
    const std::size_t left = std::min(static_cast<std::size_t>(at), curve.size() - 1);
    const std::size_t right = std::min(left + 1, curve.size() - 1);
    const double part = at - static_cast<double>(left);
    values[k] = (1.0 - part) * curve[left] + part * curve[right];
  }
  return values;
}

using Places = std::vector<FeaturePlaces::Place>;

template <class Curve>
Eigen::MatrixXd curve_distances(const Places& source, const Places& target, Curve&& curve) {
  std::vector<Eigen::VectorXd> right;
  for (const auto& q : target) right.push_back(resampled(curve(q)));
  Eigen::MatrixXd distances(source.size(), target.size());
  for (Eigen::Index p = 0; p < distances.rows(); ++p) {
    const Eigen::VectorXd left = resampled(curve(source[static_cast<std::size_t>(p)]));
    for (Eigen::Index q = 0; q < distances.cols(); ++q) {
      distances(p, q) =
          (left - right[static_cast<std::size_t>(q)]).norm() / std::sqrt(double{samples});
    }
  }
  return distances;
}

/// Divided by its mean, so that it has no unit; left alone where all is alike.
Eigen::MatrixXd without_unit(Eigen::MatrixXd distances) {
  const double mean = distances.size() > 0 ? distances.mean() : 0.0;
  if (mean > 0.0) distances /= mean;
  return distances;
}

Eigen::MatrixXd twists(const Places& places) {
  const auto count = static_cast<Eigen::Index>(places.size());
  Eigen::MatrixXd twist = Eigen::MatrixXd::Zero(count, count);
  for (Eigen::Index p = 0; p < count; ++p) {
    for (Eigen::Index q = p + 1; q < count; ++q) {
      const auto &a = places[static_cast<std::size_t>(p)], &b = places[static_cast<std::size_t>(q)];
      const Eigen::Vector3d chord = b.position - a.position;
      const double length = chord.norm();
      if (length > 0.0) twist(p, q) = a.normal.cross(b.normal).dot(chord) / length;
      twist(q, p) = twist(p, q);
    }
  }
  return twist;
}

/// In the problem, in the solver's table (both ways) and for the runners-up (both ways).
constexpr double bytes_per_pair = 80.0;

void refuse_too_many(std::size_t source, std::size_t target, std::size_t assignments,
                     const FeatureMatchingOptions& options) {
  const double size = static_cast<double>(assignments);
  if (0.5 * size * size <= options.max_pairs || options.neighbours > 0) return;
  throw NoResultError(
      {.what = std::to_string(source) + " and " + std::to_string(target) + " features give " +
               std::to_string(static_cast<int64_t>(0.5 * size * size)) +
               " pairs of matches to compare, about " +
               std::to_string(static_cast<int64_t>(size * size * 0.5e-6 * bytes_per_pair)) + " MB",
       .remedy = "Compare neighbours only (--neighbours 6), match fewer features, or raise "
                 "--max-pairs"});
}

Eigen::Index at(std::size_t k) { return static_cast<Eigen::Index>(k); }

}  // namespace

void refuse_too_many_features(std::size_t source, std::size_t target,
                              const FeatureMatchingOptions& options) {
  const std::size_t more = std::max(source, target), fewer = std::min(source, target);
  const auto candidates = static_cast<std::size_t>(std::max(0, options.candidates));
  refuse_too_many(source, target, more * (candidates > 0 ? std::min(candidates, fewer) : fewer),
                  options);
}

FeatureEnergy::FeatureEnergy(const FeaturePlaces& source, const FeaturePlaces& target,
                             const FeatureMatchingOptions& options)
    : source_(source),
      target_(target),
      options_(options),
      source_twist_(twists(source.places)),
      target_twist_(twists(target.places)) {
  measure_descriptors();
}

void FeatureEnergy::measure_descriptors() {
  const Places &a = source_.places, &b = target_.places;
  const auto displacement = [](const auto& p) -> const auto& { return p.displacement; };
  const auto deformation = [](const auto& p) -> const auto& { return p.deformation; };
  Eigen::MatrixXd times(a.size(), b.size());
  for (Eigen::Index p = 0; p < times.rows(); ++p) {
    for (Eigen::Index q = 0; q < times.cols(); ++q) {
      times(p, q) =
          std::abs(a[static_cast<std::size_t>(p)].time - b[static_cast<std::size_t>(q)].time);
    }
  }
  descriptor_ = (without_unit(curve_distances(a, b, displacement)) +
                 without_unit(curve_distances(a, b, deformation)) +
                 options_.time_weight * without_unit(std::move(times))) /
                (2.0 + options_.time_weight);
}

std::pair<double, double> FeatureEnergy::lengths(std::size_t p, std::size_t p2, std::size_t q,
                                                 std::size_t q2) const {
  return {source_.distances(at(p), at(p2)), target_.distances(at(q), at(q2))};
}

PairTerms FeatureEnergy::pair(std::size_t p, std::size_t p2, std::size_t q, std::size_t q2) const {
  PairTerms terms;
  const auto [a, b] = lengths(p, p2, q, q2);
  if (std::isfinite(a) && std::isfinite(b)) {
    const double mean = 0.5 * (a + b);
    terms.geodesic = std::min(std::abs(a - b) / std::max(mean, short_length), largest_cost);
  } else if (std::isfinite(a) != std::isfinite(b)) {
    terms.geodesic = largest_cost;
  }
  terms.orientation = std::abs(source_twist_(at(p), at(p2)) - target_twist_(at(q), at(q2)));
  if (options_.prior != GeodesicPrior::none && !source_.path_classes.empty() &&
      !target_.path_classes.empty()) {
    const PathClass left = source_.path_classes[p * source_.places.size() + p2];
    const PathClass right = target_.path_classes[q * target_.places.size() + q2];
    const bool agree = left == right || left == PathClass::level || right == PathClass::level;
    const bool monotonous = left != PathClass::neither && right != PathClass::neither;
    terms.prior_broken = !agree || (options_.prior == GeodesicPrior::printed && !monotonous);
  }
  return terms;
}

/// Algorithm 5-1: the nearest of the other side by descriptor, from both sides.
std::vector<MatchingAssignment> FeatureEnergy::assignments() const {
  const std::size_t n = source_.places.size(), m = target_.places.size();
  const std::size_t wanted = options_.candidates > 0 ? options_.candidates : std::max(n, m);
  std::vector<char> chosen(n * m, 0);
  const auto choose = [&](std::size_t count, auto&& cost, auto&& mark) {
    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), std::size_t{0});
    const std::size_t kept = std::min(wanted, count);
    std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(kept), order.end(),
                      [&](std::size_t x, std::size_t y) {
                        return std::pair(cost(x), x) < std::pair(cost(y), y);
                      });
    for (std::size_t k = 0; k < kept; ++k) mark(order[k]);
  };
  for (std::size_t p = 0; p < n; ++p) {
    choose(
        m, [&](std::size_t q) { return descriptor(p, q); },
        [&](std::size_t q) { chosen[p * m + q] = 1; });
  }
  for (std::size_t q = 0; q < m; ++q) {
    choose(
        n, [&](std::size_t p) { return descriptor(p, q); },
        [&](std::size_t p) { chosen[p * m + q] = 1; });
  }
  std::vector<MatchingAssignment> all;
  for (std::size_t p = 0; p < n; ++p) {
    for (std::size_t q = 0; q < m; ++q) {
      if (chosen[p * m + q] == 0) continue;
      all.push_back({static_cast<uint32_t>(p), static_cast<uint32_t>(q), 0.0});
    }
  }
  return all;
}

/// Whether either of two places is among the `count` nearest of the other; 0: all are.
FeatureEnergy::Near FeatureEnergy::nearest(const FeaturePlaces& places, int count) const {
  const std::size_t n = places.places.size();
  Near near(n, std::vector<char>(n, count == 0 ? 1 : 0));
  if (count == 0) return near;
  for (std::size_t p = 0; p < n; ++p) {
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t q = 0; q < n; ++q) {
      if (q != p) order.emplace_back(places.distances(at(p), at(q)), q);
    }
    std::ranges::sort(order);
    for (std::size_t k = 0; k < std::min<std::size_t>(order.size(), count); ++k) {
      near[p][order[k].second] = near[order[k].second][p] = 1;
    }
  }
  return near;
}

/// λ_coh for one pair of neighbours: the term is a mean over them, times the smaller count.
double FeatureEnergy::coherence_weight(const Near& source, const Near& target) const {
  double pairs = 0.0;
  for (const Near* near : {&source, &target}) {
    for (const std::vector<char>& row : *near)
      pairs += 0.5 * std::accumulate(row.begin(), row.end(), 0.0);
  }
  const double smaller = static_cast<double>(std::min(source.size(), target.size()));
  return pairs > 0.0 ? options_.coherence * smaller / pairs : 0.0;
}

double FeatureEnergy::smaller_count() const {
  return static_cast<double>(std::min(source_.places.size(), target_.places.size()));
}

FeatureEnergy::Neighbourhoods FeatureEnergy::neighbourhoods() const {
  Neighbourhoods around{
      .compared_source = nearest(source_, options_.neighbours),
      .compared_target = nearest(target_, options_.neighbours),
      .coherent_source = nearest(source_, std::max(1, options_.coherence_neighbours)),
      .coherent_target = nearest(target_, std::max(1, options_.coherence_neighbours))};
  around.coherence = coherence_weight(around.coherent_source, around.coherent_target);
  const double others = options_.neighbours > 0
                            ? std::min<double>(options_.neighbours, smaller_count() - 1.0)
                            : smaller_count() - 1.0;
  around.share = 2.0 / std::max(1.0, others);
  return around;
}

MatchingProblem FeatureEnergy::problem() const {
  const std::size_t n = source_.places.size(), m = target_.places.size();
  MatchingProblem problem{.left_count = static_cast<uint32_t>(n),
                          .right_count = static_cast<uint32_t>(m),
                          .assignments = assignments(),
                          .constant = options_.matched * smaller_count()};
  refuse_too_many(n, m, problem.assignments.size(), options_);
  const Neighbourhoods around = neighbourhoods();
  set_costs(around, problem.assignments);
  add_pairs(around, problem);
  return problem;
}

/// What a match costs as long as no neighbour is matched.
double FeatureEnergy::own_coherence(const Neighbourhoods& around, std::size_t p,
                                    std::size_t q) const {
  const auto degree = [](const Near& near, std::size_t k) {
    return std::accumulate(near[k].begin(), near[k].end(), 0.0);
  };
  return around.coherence * (degree(around.coherent_source, p) + degree(around.coherent_target, q));
}

double FeatureEnergy::shared_coherence(const Neighbourhoods& around, const MatchingAssignment& a,
                                       const MatchingAssignment& b) {
  return -2.0 * around.coherence *
         ((around.coherent_source[a.left][b.left] != 0 ? 1.0 : 0.0) +
          (around.coherent_target[a.right][b.right] != 0 ? 1.0 : 0.0));
}

bool FeatureEnergy::are_compared(const Neighbourhoods& around, const MatchingAssignment& a,
                                 const MatchingAssignment& b) {
  return around.compared_source[a.left][b.left] != 0 ||
         around.compared_target[a.right][b.right] != 0;
}

/// What each match costs by itself.
void FeatureEnergy::set_costs(const Neighbourhoods& around,
                              std::vector<MatchingAssignment>& assignments) const {
  for (MatchingAssignment& a : assignments) {
    a.cost = options_.descriptor * descriptor(a.left, a.right) - options_.matched +
             own_coherence(around, a.left, a.right);
  }
}

double FeatureEnergy::pair_cost(const Neighbourhoods& around, const MatchingAssignment& a,
                                const MatchingAssignment& b) const {
  double cost = shared_coherence(around, a, b);
  if (are_compared(around, a, b)) {
    const PairTerms terms = pair(a.left, b.left, a.right, b.right);
    cost += around.share *
            (options_.geodesic * terms.geodesic + options_.orientation * terms.orientation +
             (terms.prior_broken ? broken_prior : 0.0));
  }
  return cost;
}

EnergyTerms FeatureEnergy::terms(std::span<const uint32_t> labelling) const {
  const Neighbourhoods around = neighbourhoods();
  std::vector<MatchingAssignment> chosen;
  for (uint32_t p = 0; p < labelling.size(); ++p) {
    if (labelling[p] != unmatched) chosen.push_back({p, labelling[p], 0.0});
  }
  EnergyTerms sum;
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    const MatchingAssignment& a = chosen[k];
    sum.descriptor += options_.descriptor * descriptor(a.left, a.right);
    sum.coherence += own_coherence(around, a.left, a.right);
    for (std::size_t o = 0; o < k; ++o) {
      const MatchingAssignment& b = chosen[o];
      sum.coherence += shared_coherence(around, a, b);
      if (!are_compared(around, a, b)) continue;
      const PairTerms two = pair(a.left, b.left, a.right, b.right);
      sum.geodesic += around.share * options_.geodesic * two.geodesic;
      sum.orientation += around.share * options_.orientation * two.orientation;
      sum.prior += around.share * (two.prior_broken ? broken_prior : 0.0);
    }
  }
  sum.unmatched_part = options_.matched * (smaller_count() - static_cast<double>(chosen.size()));
  for (double* term : {&sum.descriptor, &sum.geodesic, &sum.orientation, &sum.prior,
                       &sum.unmatched_part, &sum.coherence}) {
    *term /= smaller_count();
  }
  return sum;
}

void FeatureEnergy::add_pairs(const Neighbourhoods& around, MatchingProblem& problem) const {
  const std::vector<MatchingAssignment>& all = problem.assignments;
  for (uint32_t a = 0; a < all.size(); ++a) {
    for (uint32_t b = a + 1; b < all.size(); ++b) {
      if (all[a].left == all[b].left || all[a].right == all[b].right) continue;
      const double cost = pair_cost(around, all[a], all[b]);
      if (cost != 0.0) problem.pairs.push_back({a, b, cost});
    }
    if (static_cast<double>(problem.pairs.size()) > options_.max_pairs) {
      throw NoResultError({.what = "more than " + std::to_string(problem.pairs.size()) +
                                   " pairs of matches to compare",
                           .remedy = "Match fewer features, or raise --max-pairs"});
    }
  }
}

}  // namespace kinemesh
