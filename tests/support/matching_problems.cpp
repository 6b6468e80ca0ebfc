#include "tests/support/matching_problems.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace kinemesh::test {
namespace {

constexpr int descriptor_size = 6;
constexpr uint32_t few = 8;         // assignments of a left node in flow and worms
constexpr uint32_t neighbours = 5;  // of a node in car, flow and worms

struct Side {
  std::vector<Eigen::Vector2d> points;
  std::vector<Eigen::VectorXd> descriptors;
  std::vector<std::vector<char>> near;
};

class Planter {
 public:
  Planter(ProblemKind kind, uint64_t seed, const PlantedOptions& options)
      : kind_(kind), options_(options), random_(seed) {}

  PlantedProblem make() {
    make_sides();
    PlantedProblem result{.problem = {.left_count = options_.nodes, .right_count = options_.nodes},
                          .planted = planted_};
    add_assignments(result.problem);
    drop_impossible(result);
    add_pairs(result.problem);
    return result;
  }

 private:
  double normal() { return std::normal_distribution<double>()(random_); }
  double uniform() { return std::uniform_real_distribution<double>()(random_); }

  void make_sides() {
    const uint32_t n = options_.nodes;
    std::vector<uint32_t> order(n);
    std::iota(order.begin(), order.end(), 0U);
    std::ranges::shuffle(order, random_);
    planted_.assign(n, unmatched);
    right_.points.resize(n);
    right_.descriptors.resize(n);
    const double turn = kind_ == ProblemKind::house ? 0.35 : 0.0;
    const auto partners = static_cast<uint32_t>(std::lround((1.0 - options_.outliers) * n));
    for (uint32_t i = 0; i < n; ++i) {
      const Eigen::Vector3d place(uniform(), uniform(), uniform());
      Eigen::VectorXd descriptor(descriptor_size);
      for (double& value : descriptor) value = normal();
      left_.points.emplace_back(place.head<2>());
      left_.descriptors.push_back(descriptor);
      const uint32_t j = order[i];
      if (i < partners) {
        planted_[i] = j;
        right_.points[j] = (Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitY()) * place).head<2>() +
                           options_.noise * Eigen::Vector2d(normal(), normal());
        for (double& value : descriptor) value += 0.7 * normal();
      } else {
        right_.points[j] = {uniform(), uniform()};
        for (double& value : descriptor) value = normal();
      }
      right_.descriptors[j] = descriptor;
    }
    for (Side* side : {&left_, &right_}) find_near(*side);
  }

  static void find_near(Side& side) {
    const std::size_t n = side.points.size();
    side.near.assign(n, std::vector<char>(n, 0));
    for (std::size_t i = 0; i < n; ++i) {
      std::vector<std::pair<double, std::size_t>> order;
      for (std::size_t k = 0; k < n; ++k) {
        if (k != i) order.emplace_back((side.points[i] - side.points[k]).norm(), k);
      }
      std::ranges::sort(order);
      for (std::size_t k = 0; k < std::min<std::size_t>(neighbours, order.size()); ++k) {
        side.near[i][order[k].second] = side.near[order[k].second][i] = 1;
      }
    }
  }

  /// 0 for the same, about 1 for strangers.
  double unlikeness(uint32_t i, uint32_t j) const {
    return (left_.descriptors[i] - right_.descriptors[j]).squaredNorm() / (2.0 * descriptor_size);
  }

  double unary(uint32_t i, uint32_t j) {
    switch (kind_) {
      case ProblemKind::house: return 0.8 * std::min(1.0, unlikeness(i, j)) - 0.2;
      case ProblemKind::synth: return 0.0;
      case ProblemKind::car: return 0.0;
      case ProblemKind::complete: return 0.2 * unlikeness(i, j) - 10.0;
      case ProblemKind::flow: return unlikeness(i, j) - 0.9;
      case ProblemKind::worms: return 3.0 * (unlikeness(i, j) - 0.8);
    }
    return 0.0;
  }

  void add_assignments(MatchingProblem& problem) {
    const uint32_t n = options_.nodes;
    const bool sparse = kind_ == ProblemKind::flow || kind_ == ProblemKind::worms;
    for (uint32_t i = 0; i < n; ++i) {
      std::vector<uint32_t> order(n);
      std::iota(order.begin(), order.end(), 0U);
      std::ranges::sort(order, {}, [&](uint32_t j) { return unlikeness(i, j); });
      if (sparse) order.resize(std::min(n, few));
      for (const uint32_t j : order) problem.assignments.push_back({i, j, unary(i, j)});
    }
  }

  static void drop_impossible(PlantedProblem& result) {
    std::vector<char> possible(result.planted.size(), 0);
    for (const MatchingAssignment& a : result.problem.assignments) {
      if (result.planted[a.left] == a.right) possible[a.left] = 1;
    }
    for (std::size_t i = 0; i < possible.size(); ++i) {
      if (possible[i] == 0) result.planted[i] = unmatched;
    }
  }

  /// The cost of a pair, 0 where there is none.
  double pair(const MatchingAssignment& a, const MatchingAssignment& b) const {
    const Eigen::Vector2d d = left_.points[b.left] - left_.points[a.left];
    const Eigen::Vector2d e = right_.points[b.right] - right_.points[a.right];
    const double change = std::abs(d.norm() - e.norm());
    const bool near_left = left_.near[a.left][b.left] != 0;
    const bool near_right = right_.near[a.right][b.right] != 0;
    switch (kind_) {
      case ProblemKind::house: return 2.0 * (1.0 - std::exp(-change * change / 0.02)) - 0.4;
      case ProblemKind::synth: return -2.0 * std::exp(-change * change / 0.0225);
      case ProblemKind::car:
        return near_left && near_right ? -std::exp(-(d - e).squaredNorm() / 0.02) : 0.0;
      case ProblemKind::complete: return change;
      case ProblemKind::flow: return near_left ? 4.0 * (d - e).norm() - 0.5 : 0.0;
      case ProblemKind::worms: return near_left ? 8.0 * (d - e).squaredNorm() - 0.05 : 0.0;
    }
    return 0.0;
  }

  void add_pairs(MatchingProblem& problem) const {
    const std::vector<MatchingAssignment>& all = problem.assignments;
    for (uint32_t a = 0; a < all.size(); ++a) {
      for (uint32_t b = a + 1; b < all.size(); ++b) {
        if (all[a].left == all[b].left || all[a].right == all[b].right) continue;
        const double cost = pair(all[a], all[b]);
        if (std::abs(cost) > 1e-6) problem.pairs.push_back({a, b, cost});
      }
    }
  }

  ProblemKind kind_;
  PlantedOptions options_;
  std::mt19937_64 random_;
  Side left_, right_;
  std::vector<uint32_t> planted_;
};

}  // namespace

PlantedProblem plant_problem(ProblemKind kind, uint64_t seed, const PlantedOptions& options) {
  return Planter(kind, seed, options).make();
}

}  // namespace kinemesh::test
