// The primal side: tabu search over matchings. Internal to analysis/graph_matching.
//
// After Taillard's robust tabu search (1991) for quadratic assignment, with moves for partial
// matchings: a left node is matched anew, let go, takes another's right node (which is let go), or
// exchanges with it.
#pragma once

#include <cstdint>
#include <functional>
#include <random>
#include <span>
#include <vector>

#include "analysis/graph_matching/pair_table.h"

namespace kinemesh::graph_matching {

/// The matching chosen so far: per left node its assignment or `unmatched`.
using Matching = std::vector<uint32_t>;

class LocalSearch {
 public:
  LocalSearch(const PairTable& table, uint64_t seed);

  /// The least energy found (without the problem's constant), and its matching.
  double best_energy() const { return best_energy_; }
  const Matching& best() const { return best_; }

  /// Starts anew from a matching, which must be unique on both sides.
  void start_from(std::span<const uint32_t> matching);
  /// Starts anew from a greedy matching with random choices among the best.
  void start_greedy();
  /// Starts anew from one assignment, to which the best remaining one is added again and again:
  /// matchings that hold together where pairs are few. The first is drawn among those that promise
  /// most by `least`, one value for each assignment.
  void start_grown(std::span<const double> least);
  /// Starts from the best matching with `changes` left nodes let go at random.
  void start_near_best(uint32_t changes);
  /// Makes tabu moves until `moves` of them in a row have not improved this start's best, or `stop`
  /// asks to end.
  void search(uint32_t moves, const std::function<bool()>& stop);
  /// Work done, in tabu moves × assignments.
  uint64_t work() const { return work_; }

 private:
  struct Move {
    double delta = 0.0;
    uint32_t left = unmatched;   // the left node that moves
    uint32_t to = unmatched;     // its new assignment
    uint32_t other = unmatched;  // the left node that loses its right node
    uint32_t other_to = unmatched;
  };
  void reset();
  void set(uint32_t i, uint32_t a);  // i's assignment becomes a; the right node must be free
  void apply(const Move& move);
  Move best_move() const;
  void consider(uint32_t i, uint32_t from, uint32_t to, Move& best) const;
  void offer(const Move& move, Move& best) const;
  bool is_tabu(uint32_t i, uint32_t to) const;
  void forbid(uint32_t i, uint32_t from);
  double gain(uint32_t a) const { return a == unmatched ? 0.0 : gain_[a]; }
  void record();
  void confirm_best();

  const PairTable& table_;
  std::mt19937_64 random_;
  Matching now_, at_right_;   // assignment by left and by right node
  std::vector<double> gain_;  // cost of each assignment beside the matching
  double energy_ = 0.0, start_best_ = 0.0, best_energy_ = 0.0;
  Matching best_;
  bool best_is_new_ = false;  ///< its energy was not summed afresh
  uint64_t clock_ = 0, work_ = 0;
  std::vector<uint64_t> tabu_, tabu_null_;  // until when
};

}  // namespace kinemesh::graph_matching
