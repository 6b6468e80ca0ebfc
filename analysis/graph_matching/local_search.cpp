#include "analysis/graph_matching/local_search.h"

#include <algorithm>
#include <limits>

namespace kinemesh::graph_matching {
namespace {

constexpr uint32_t move_overhead = 20;  // asking the clock, in assignments
constexpr double tiny = 1e-12;          // moves that gain less than this are no gain

}  // namespace

LocalSearch::LocalSearch(const PairTable& table, uint64_t seed)
    : table_(table),
      random_(seed),
      best_(table.left_count(), unmatched),
      tabu_(table.size(), 0),
      tabu_null_(table.left_count(), 0) {
  reset();
}

void LocalSearch::reset() {
  now_.assign(table_.left_count(), unmatched);
  at_right_.assign(table_.right_count(), unmatched);
  gain_.resize(table_.size());
  for (uint32_t a = 0; a < table_.size(); ++a) gain_[a] = table_.cost(a);
  energy_ = 0.0;
  start_best_ = 0.0;
  std::ranges::fill(tabu_, 0);
  std::ranges::fill(tabu_null_, 0);
  clock_ = 0;
}

void LocalSearch::set(uint32_t i, uint32_t a) {
  if (const uint32_t old = now_[i]; old != unmatched) {
    energy_ -= gain_[old];
    table_.add_row(old, -1.0, gain_);
    at_right_[table_.right(old)] = unmatched;
  }
  now_[i] = a;
  if (a == unmatched) return;
  energy_ += gain_[a];
  table_.add_row(a, 1.0, gain_);
  at_right_[table_.right(a)] = a;
}

void LocalSearch::record() {
  start_best_ = std::min(start_best_, energy_);
  if (energy_ >= best_energy_ - tiny) return;
  best_energy_ = energy_;
  best_ = now_;
  best_is_new_ = true;
}

/// Sums the energy of the best matching afresh, without what moves left over by rounding.
void LocalSearch::confirm_best() {
  if (!best_is_new_) return;
  best_is_new_ = false;
  std::vector<char> chosen(table_.size(), 0);
  double energy = 0.0;
  for (const uint32_t a : best_) {
    if (a == unmatched) continue;
    energy += table_.cost(a);
    for (const PairTable::Entry& e : table_.row(a)) energy += chosen[e.other] != 0 ? e.cost : 0.0;
    chosen[a] = 1;
  }
  best_energy_ = energy;
  if (energy <= 0.0) return;
  best_energy_ = 0.0;
  std::ranges::fill(best_, unmatched);
}

void LocalSearch::start_from(std::span<const uint32_t> matching) {
  reset();
  for (uint32_t i = 0; i < table_.left_count(); ++i) {
    if (matching[i] != unmatched) set(i, matching[i]);
  }
  start_best_ = energy_;
  record();
}

void LocalSearch::start_greedy() {
  reset();
  std::vector<uint32_t> order(table_.left_count());
  for (uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::shuffle(order, random_);
  for (const uint32_t i : order) {
    uint32_t first = unmatched, second = unmatched;
    for (const uint32_t a : table_.of_left(i)) {
      if (at_right_[table_.right(a)] != unmatched) continue;
      if (first == unmatched || gain_[a] < gain_[first]) {
        second = first;
        first = a;
      } else if (second == unmatched || gain_[a] < gain_[second]) {
        second = a;
      }
    }
    const uint32_t pick = second != unmatched && random_() % 4 == 0 ? second : first;
    if (pick != unmatched) set(i, pick);
  }
  start_best_ = energy_;
  record();
}

void LocalSearch::start_grown(std::span<const double> least) {
  reset();
  const auto draw = [this] { return static_cast<uint32_t>(random_() % table_.size()); };
  uint32_t next = draw();
  for (uint32_t k = 0; k < std::min(64U, table_.size() / 8); ++k) {
    if (const uint32_t other = draw(); least[other] < least[next]) next = other;
  }
  while (next != unmatched) {
    set(table_.left(next), next);
    next = unmatched;
    for (uint32_t a = 0; a < table_.size(); ++a) {
      if (now_[table_.left(a)] != unmatched || at_right_[table_.right(a)] != unmatched) continue;
      if (gain_[a] < (next == unmatched ? -tiny : gain_[next])) next = a;
    }
    work_ += table_.size();
  }
  start_best_ = energy_;
  record();
}

void LocalSearch::start_near_best(uint32_t changes) {
  const Matching best = best_;
  start_from(best);
  for (uint32_t k = 0; k < changes; ++k) {
    const uint32_t i = static_cast<uint32_t>(random_() % table_.left_count());
    set(i, unmatched);
    const std::span<const uint32_t> mine = table_.of_left(i);
    if (mine.empty()) continue;
    const uint32_t to = mine[random_() % mine.size()];
    if (const uint32_t holder = at_right_[table_.right(to)]; holder != unmatched) {
      set(table_.left(holder), unmatched);
    }
    set(i, to);
  }
  start_best_ = energy_;
}

bool LocalSearch::is_tabu(uint32_t i, uint32_t to) const {
  return (to == unmatched ? tabu_null_[i] : tabu_[to]) > clock_;
}

void LocalSearch::forbid(uint32_t i, uint32_t from) {
  const uint64_t n = table_.left_count();
  const uint64_t until = clock_ + 1 + n / 4 + random_() % (n + 2);
  (from == unmatched ? tabu_null_[i] : tabu_[from]) = until;
}

/// For a move that would be better than the best so far: takes it unless it is forbidden.
void LocalSearch::offer(const Move& move, Move& best) const {
  const bool tabu = is_tabu(move.left, move.to) ||
                    (move.other != unmatched && is_tabu(move.other, move.other_to));
  if (tabu && energy_ + move.delta >= start_best_ - tiny) return;
  best = move;
}

/// Moves of left node i, at `from`, to another assignment. Most are no better than the best so far,
/// so that is asked first.
void LocalSearch::consider(uint32_t i, uint32_t from, uint32_t to, Move& best) const {
  const uint32_t held = at_right_[table_.right(to)];
  const double base = gain_[to] - gain(from);
  if (held == unmatched) {
    if (base < best.delta) offer({.delta = base, .left = i, .to = to}, best);
    return;
  }
  const uint32_t k = table_.left(held);
  const double between = from == unmatched ? 0.0 : table_.pair_cost(from, held);
  const double take = base - gain_[held] + between;
  if (take < best.delta) offer({.delta = take, .left = i, .to = to, .other = k}, best);
  if (from == unmatched || k < i) return;  // an exchange is considered once
  const uint32_t back = table_.find(k, table_.right(from));
  if (back == unmatched) return;
  const double exchange = take + gain_[back] + table_.pair_cost(to, back);
  if (!(exchange < best.delta)) return;
  offer({.delta = exchange, .left = i, .to = to, .other = k, .other_to = back}, best);
}

LocalSearch::Move LocalSearch::best_move() const {
  Move best{.delta = std::numeric_limits<double>::infinity()};
  for (uint32_t i = 0; i < table_.left_count(); ++i) {
    const uint32_t from = now_[i];
    if (from != unmatched && -gain_[from] < best.delta) {
      offer({.delta = -gain_[from], .left = i}, best);
    }
    for (const uint32_t to : table_.of_left(i)) {
      if (to != from) consider(i, from, to, best);
    }
  }
  return best;
}

void LocalSearch::apply(const Move& move) {
  forbid(move.left, now_[move.left]);
  if (move.other != unmatched) {
    forbid(move.other, now_[move.other]);
    set(move.other, unmatched);
  }
  set(move.left, move.to);
  if (move.other_to != unmatched) set(move.other, move.other_to);
}

void LocalSearch::search(uint32_t moves, const std::function<bool()>& stop) {
  uint32_t left = moves;
  while (left > 0 && !stop()) {
    const Move move = best_move();
    ++clock_;
    --left;
    work_ += table_.size() + move_overhead;
    if (move.left == unmatched) continue;  // everything is tabu for now
    const double before = start_best_;
    apply(move);
    record();
    if (start_best_ < before - tiny) left = moves;
  }
  confirm_best();
}

}  // namespace kinemesh::graph_matching
