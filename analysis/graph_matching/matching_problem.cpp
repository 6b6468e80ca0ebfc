#include "analysis/graph_matching/matching_problem.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "config/error.h"

namespace kinemesh {
namespace {

[[noreturn]] void refuse(const std::string& place, const std::string& what,
                         const std::string& remedy) {
  throw InputError({.what = what, .place = place, .remedy = remedy});
}

void check_assignments(const MatchingProblem& p) {
  std::vector<std::pair<uint32_t, uint32_t>> seen;
  seen.reserve(p.assignments.size());
  for (std::size_t a = 0; a < p.assignments.size(); ++a) {
    const MatchingAssignment& it = p.assignments[a];
    const std::string place = "assignment " + std::to_string(a);
    if (it.left >= p.left_count || it.right >= p.right_count) {
      refuse(place, "the assignment joins nodes that do not exist", "Count nodes from 0");
    }
    if (!std::isfinite(it.cost)) {
      refuse(place, "the cost is not a finite number", "Leave out an assignment to forbid it");
    }
    seen.emplace_back(it.left, it.right);
  }
  std::ranges::sort(seen);
  if (const auto twice = std::ranges::adjacent_find(seen); twice != seen.end()) {
    refuse(std::to_string(twice->first) + " with " + std::to_string(twice->second),
           "two assignments join the same nodes", "Give each assignment once");
  }
}

}  // namespace

void MatchingProblem::validate() const {
  double sum = std::abs(constant);
  check_assignments(*this);
  for (const MatchingAssignment& it : assignments) sum += std::abs(it.cost);
  if (!std::isfinite(constant)) refuse("constant", "the constant is not finite", "");
  for (std::size_t e = 0; e < pairs.size(); ++e) {
    const MatchingPair& it = pairs[e];
    const std::string place = "pair " + std::to_string(e);
    if (it.a >= assignments.size() || it.b >= assignments.size()) {
      refuse(place, "the pair names an assignment that does not exist", "Count from 0");
    }
    if (it.a == it.b) refuse(place, "the pair joins an assignment with itself", "");
    if (!std::isfinite(it.cost)) {
      refuse(place, "the cost is not a finite number", "Use a large finite cost to forbid a pair");
    }
    sum += std::abs(it.cost);
  }
  if (!std::isfinite(sum)) {
    refuse("", "the costs add up to more than a number can hold (1.8e308)",
           "Divide all costs by the same number");
  }
}

std::vector<uint32_t> MatchingProblem::chosen(std::span<const uint32_t> labelling) const {
  if (labelling.size() != left_count) {
    refuse("labelling", "it does not have one entry per left node", "");
  }
  std::vector<uint32_t> result(left_count, unmatched);
  std::vector<char> taken(right_count, 0);
  for (std::size_t i = 0; i < labelling.size(); ++i) {
    const uint32_t right = labelling[i];
    if (right == unmatched) continue;
    const std::string place = "left node " + std::to_string(i);
    if (right >= right_count) refuse(place, "it is matched to a node that does not exist", "");
    if (taken[right] != 0) refuse(place, "its right node is matched twice", "");
    taken[right] = 1;
  }
  for (std::size_t a = 0; a < assignments.size(); ++a) {
    const MatchingAssignment& it = assignments[a];
    if (labelling[it.left] == it.right) result[it.left] = static_cast<uint32_t>(a);
  }
  for (std::size_t i = 0; i < labelling.size(); ++i) {
    if (labelling[i] != unmatched && result[i] == unmatched) {
      refuse("left node " + std::to_string(i), "its match is not among the assignments", "");
    }
  }
  return result;
}

double MatchingProblem::energy(std::span<const uint32_t> labelling) const {
  const std::vector<uint32_t> chosen_at = chosen(labelling);
  std::vector<char> active(assignments.size(), 0);
  // With what rounding takes away (Neumaier 1974): costs of a pair given twice may cancel.
  double sum = constant, lost = 0.0;
  const auto add = [&](double cost) {
    const double total = sum + cost;
    lost += std::abs(sum) >= std::abs(cost) ? (sum - total) + cost : (cost - total) + sum;
    sum = total;
  };
  for (const uint32_t a : chosen_at) {
    if (a == unmatched) continue;
    active[a] = 1;
    add(assignments[a].cost);
  }
  for (const MatchingPair& e : pairs) {
    if (active[e.a] != 0 && active[e.b] != 0) add(e.cost);
  }
  return sum + lost;
}

}  // namespace kinemesh
