// The graph matching solver against exhaustive search, known optima and its own promises.
#include "analysis/graph_matching/solve_matching.h"

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "analysis/graph_matching/dd_file.h"
#include "config/error.h"
#include "tests/analysis/matching_instances.h"
#include "tests/support/data.h"
#include "tests/support/matching_problems.h"

namespace kinemesh::solve_matching_test {
namespace {

using test::InstanceKind;

constexpr InstanceKind all_kinds[] = {InstanceKind::geometric, InstanceKind::distortion,
                                      InstanceKind::sparse, InstanceKind::random,
                                      InstanceKind::complete};

void expect_sound(const MatchingProblem& p, const MatchingResult& r) {
  EXPECT_NEAR(p.energy(r.labelling), r.energy,
              1e-9 * (1 + std::abs(r.energy)));  // throws if broken
  EXPECT_LE(r.bound, r.energy + 1e-9);
}

TEST(SolveMatching, FindsAndProvesTheOptimumOfSmallProblems) {
  for (const InstanceKind kind : all_kinds) {
    for (const uint64_t seed : {1, 2, 3, 4}) {
      const MatchingProblem p = test::make_instance(kind, 4 + seed % 2, seed);
      const double optimum = test::exhaustive_optimum(p);
      const MatchingResult r = solve_matching(p);
      expect_sound(p, r);
      EXPECT_NEAR(r.energy, optimum, 1e-9) << static_cast<int>(kind) << " seed " << seed;
      EXPECT_NEAR(r.bound, optimum, 1e-6 * (1 + std::abs(optimum)));
      EXPECT_TRUE(r.certified);
    }
  }
}

TEST(SolveMatching, TheThesisMethodBoundsFromBelow) {
  for (const InstanceKind kind : all_kinds) {
    const MatchingProblem p = test::make_instance(kind, 5, 9);
    const double optimum = test::exhaustive_optimum(p);
    const MatchingResult r = solve_matching(
        p, {.method = MatchingMethod::subgradient, .time_limit_s = 2, .iterations = 300});
    expect_sound(p, r);
    EXPECT_NEAR(r.energy, optimum, 1e-9);
    EXPECT_LE(r.bound, optimum + 1e-9);
  }
}

TEST(SolveMatching, LargerProblemsAreProvedOrBounded) {
  for (const InstanceKind kind : all_kinds) {
    const MatchingProblem p = test::make_instance(kind, 14, 5);
    const MatchingResult r = solve_matching(p, {.time_limit_s = 60, .iterations = 12});
    expect_sound(p, r);
  }
  const MatchingProblem p = test::make_instance(InstanceKind::sparse, 14, 5);
  EXPECT_TRUE(solve_matching(p).certified);
}

constexpr test::ProblemKind planted_kinds[] = {
    test::ProblemKind::house,    test::ProblemKind::synth, test::ProblemKind::car,
    test::ProblemKind::complete, test::ProblemKind::flow,  test::ProblemKind::worms};

TEST(SolveMatching, FindsAtLeastWhatWasPlanted) {
  for (const test::ProblemKind kind : planted_kinds) {
    const test::PlantedProblem made = plant_problem(kind, 3, {.nodes = 20});
    const MatchingResult r = solve_matching(made.problem, {.time_limit_s = 60, .iterations = 6});
    expect_sound(made.problem, r);
    EXPECT_LE(r.energy, made.problem.energy(made.planted) + 1e-9) << static_cast<int>(kind);
  }
}

TEST(SolveMatching, StarsOverNeighboursFirstComeToTheSameEnd) {
  // Few left nodes share pairs: stars begin over those and are widened.
  for (const test::ProblemKind kind : {test::ProblemKind::flow, test::ProblemKind::worms}) {
    const MatchingProblem p = plant_problem(kind, 2, {.nodes = 44}).problem;
    const MatchingResult r = solve_matching(p, {.time_limit_s = 60, .iterations = 400});
    expect_sound(p, r);
    EXPECT_TRUE(r.certified) << static_cast<int>(kind);
    const MatchingResult thesis =
        solve_matching(p, {.method = MatchingMethod::subgradient, .iterations = 20});
    EXPECT_LE(thesis.bound, r.energy + 1e-9);
    EXPECT_LE(r.bound, thesis.energy + 1e-9);
  }
}

TEST(SolveMatching, WithoutTimeThereIsStillAMatching) {
  for (const MatchingMethod method : {MatchingMethod::ascent, MatchingMethod::subgradient}) {
    const test::PlantedProblem made = plant_problem(test::ProblemKind::complete, 1);
    const MatchingResult r =
        solve_matching(made.problem, {.method = method, .time_limit_s = 0.001});
    expect_sound(made.problem, r);
    EXPECT_LT(r.energy, -100.0);  // each of the 30 nodes gains about 10
    EXPECT_TRUE(r.time_is_up);
  }
}

TEST(SolveMatching, LittleMemoryGivesAWeakerBoundNotAWrongOne) {
  const MatchingProblem p = test::make_instance(InstanceKind::sparse, 60, 4);
  const MatchingResult r =
      solve_matching(p, {.time_limit_s = 0.5, .iterations = 2, .memory_mb = 8});
  expect_sound(p, r);
  const MatchingProblem small = test::make_instance(InstanceKind::geometric, 5, 4);
  const MatchingResult none = solve_matching(small, {.time_limit_s = 0.05, .memory_mb = 1});
  EXPECT_LE(none.bound, test::exhaustive_optimum(small) + 1e-9);
}

TEST(SolveMatching, MuchMemoryIsSaidBeforehand) {
  std::string said;
  RunContext ctx;
  ctx.set_log([&](LogLevel, std::string_view text) { said += text; });
  MatchingProblem p{.left_count = 60, .right_count = 60};
  for (uint32_t k = 0; k < 3600; ++k) p.assignments.push_back({k / 60, k % 60, 1.0});
  solve_matching(p, {.time_limit_s = 0.01}, ctx);
  EXPECT_NE(said.find("3600 assignments and 0 pairs: about 104 MB"), std::string::npos) << said;
  EXPECT_NE(said.find("at most 221 MB for the bound (--bound-memory)"), std::string::npos) << said;
  said.clear();
  p.assignments.resize(1200);
  solve_matching(p, {.time_limit_s = 0.01}, ctx);
  EXPECT_TRUE(said.empty()) << said;
}

TEST(SolveMatching, TheBoundOverNeighboursAloneHolds) {
  // 8 × 8 in 1 MB: stars reach over left nodes that share pairs, without column slacks.
  for (const uint64_t seed : {1, 2, 3}) {
    MatchingProblem p = test::make_instance(InstanceKind::sparse, 6, seed);
    MatchingProblem many = p;  // copies side by side, so that the whole does not fit
    for (uint32_t copy = 1; copy < 40; ++copy) {
      const auto shift = static_cast<uint32_t>(many.assignments.size());
      for (MatchingAssignment a : p.assignments) {
        many.assignments.push_back({a.left + 6 * copy, a.right + 6 * copy, a.cost});
      }
      for (const MatchingPair& e : p.pairs)
        many.pairs.push_back({e.a + shift, e.b + shift, e.cost});
    }
    many.left_count = many.right_count = 240;
    const MatchingResult r = solve_matching(many, {.iterations = 30, .memory_mb = 4});
    expect_sound(many, r);
    const double optimum = 40 * test::exhaustive_optimum(p);
    EXPECT_LE(r.bound, optimum + 1e-6);
    EXPECT_GE(r.bound, optimum - 0.05 * std::abs(optimum));
    EXPECT_NEAR(r.energy, optimum, 0.02 * std::abs(optimum));
  }
}

TEST(SolveMatching, SameSeedSameResultForAnyThreadCount) {
  const MatchingProblem p = test::make_instance(InstanceKind::geometric, 10, 3);
  const MatchingOptions options{.time_limit_s = 1000, .iterations = 8};
  RunContext one, four;
  one.set_threads(1);
  four.set_threads(4);
  const MatchingResult a = solve_matching(p, options, one);
  const MatchingResult b = solve_matching(p, options, four);
  EXPECT_EQ(a.labelling, b.labelling);
  EXPECT_EQ(a.bound, b.bound);
  EXPECT_EQ(a.iterations, b.iterations);
}

TEST(SolveMatching, TheBoundHoldsWhateverTheGap) {
  for (const InstanceKind kind : all_kinds) {
    const MatchingProblem p = test::make_instance(kind, 5, 3);
    const double optimum = test::exhaustive_optimum(p);
    for (const double gap : {0.01, 0.3, 1.0}) {
      EXPECT_LE(solve_matching(p, {.gap = gap}).bound, optimum + 1e-9 * std::abs(optimum));
    }
  }
}

TEST(SolveMatching, CostsThatForbidDoNotBlurTheOthers) {
  for (const InstanceKind kind : all_kinds) {
    MatchingProblem p = test::make_instance(kind, 5, 7);
    double optimum = 0.0;
    for (const double cost : {1e5, 1e15, 1e18, 1e290}) {
      for (std::size_t e = 0; e < p.pairs.size(); e += 3) p.pairs[e].cost = cost;
      p.assignments[p.assignments.size() / 2].cost = cost;
      if (cost == 1e5) optimum = test::exhaustive_optimum(p);
      const MatchingResult r = solve_matching(p);
      EXPECT_NEAR(r.energy, optimum, 1e-9 * (1 + std::abs(optimum)));
      EXPECT_NEAR(r.bound, optimum, 1e-6 * (1 + std::abs(optimum)));
      EXPECT_TRUE(r.certified);
    }
  }
}

TEST(SolveMatching, CostsOfAPairThatCancelLeaveTheRest) {
  MatchingProblem p{.left_count = 2, .right_count = 2, .assignments = {{0, 0, -1}, {1, 1, -1}}};
  p.pairs = {{0, 1, 1e300}, {0, 1, -1e300}};
  EXPECT_EQ(solve_matching(p).energy, -2.0);
}

TEST(SolveMatching, CostsOfAnyMagnitudeGiveTheSameMatching) {
  for (const MatchingMethod method : {MatchingMethod::ascent, MatchingMethod::subgradient}) {
    const MatchingProblem p = test::make_instance(InstanceKind::geometric, 5, 3);
    const MatchingOptions options{.method = method, .iterations = 50};
    const MatchingResult r = solve_matching(p, options);
    for (const int exponent : {-900, -50, 900}) {
      MatchingProblem scaled = p;
      for (MatchingAssignment& a : scaled.assignments) a.cost = std::ldexp(a.cost, exponent);
      for (MatchingPair& e : scaled.pairs) e.cost = std::ldexp(e.cost, exponent);
      const MatchingResult s = solve_matching(scaled, options);
      EXPECT_EQ(s.labelling, r.labelling);
      EXPECT_EQ(s.bound, std::ldexp(r.bound, exponent));
      EXPECT_EQ(s.certified, r.certified);
    }
  }
}

TEST(SolveMatching, NothingToMatch) {
  EXPECT_TRUE(solve_matching({}).certified);
  const MatchingResult r = solve_matching({.left_count = 3, .right_count = 0, .constant = 2.0});
  EXPECT_EQ(r.labelling, std::vector<uint32_t>(3, unmatched));
  EXPECT_EQ(r.energy, 2.0);
  EXPECT_TRUE(r.certified);
  const MatchingProblem dear{.left_count = 1, .right_count = 1, .assignments = {{0, 0, 5.0}}};
  EXPECT_EQ(solve_matching(dear).labelling[0], unmatched);
  EXPECT_EQ(solve_matching(dear).iterations, 0);  // nothing can be better: no search
}

TEST(SolveMatching, AllAlikeIsAnswered) {
  MatchingProblem p{.left_count = 8, .right_count = 8};
  for (uint32_t i = 0; i < 8; ++i) {
    for (uint32_t j = 0; j < 8; ++j) p.assignments.push_back({i, j, -1.0});
  }
  const MatchingResult r = solve_matching(p);
  EXPECT_EQ(r.energy, -8.0);
  EXPECT_TRUE(r.certified);
}

TEST(SolveMatching, RefusesCostsThatAreNoNumbers) {
  MatchingProblem p{.left_count = 1, .right_count = 1, .assignments = {{0, 0, NAN}}};
  EXPECT_THROW(solve_matching(p), InputError);
  p.assignments = {{0, 0, 1.0}, {0, 0, 2.0}};
  EXPECT_THROW(solve_matching(p), InputError);
  p.assignments = {{0, 1, 1.0}};
  EXPECT_THROW(solve_matching(p), InputError);
  p.assignments = {{0, 0, 1.0}};
  p.pairs = {{0, 0, 1.0}};
  EXPECT_THROW(solve_matching(p), InputError);
  p.pairs = {{0, 7, 1.0}};
  EXPECT_THROW(solve_matching(p), InputError);
  p = {.left_count = 2, .right_count = 2, .assignments = {{0, 0, -1e308}, {1, 1, -1e308}}};
  EXPECT_THROW(solve_matching(p), InputError);  // their sum is no number
}

TEST(SolveMatching, EndsWhenCancelled) {
  RunContext ctx;
  ctx.cancel();
  EXPECT_THROW(solve_matching(test::make_instance(InstanceKind::random, 12, 1), {}, ctx),
               CancelledError);
}

TEST(SolveMatching, BenchmarkOptimaAreFoundAndCertified) {
  KINEMESH_NEED_DATA("graph_matching/optimal.csv");
  std::ifstream csv(test::data_folder() / "graph_matching/optimal.csv");
  std::string line;
  std::getline(csv, line);
  int files = 0;
  while (std::getline(csv, line)) {
    const std::size_t comma = line.find(',');
    if (++files % 8 != 1) continue;  // tools/verify.d/7_graph_matching runs all
    const MatchingProblem p =
        read_dd(test::data_folder() / "graph_matching" / line.substr(0, comma));
    const MatchingResult r = solve_matching(p, {.time_limit_s = 60});
    EXPECT_NEAR(r.energy, std::stod(line.substr(comma + 1)), 1e-6) << line;
    EXPECT_TRUE(r.certified) << line;
  }
}

struct BadFile {
  const char* text;
  const char* place;
  const char* says;
};

TEST(DdFile, RefusesMalformedFilesByLine) {
  const BadFile files[] = {
      {"", "line 1", "no line 'p"},
      {"a 0 0 0 1\n", "line 1", "before the 'p' line"},
      {"p 1 1 1\n", "line 1", "expected 'p"},
      {"p 1 1 1 0 0\n", "line 1", "expected 'p"},
      {"p 1 1 1 0\np 1 1 1 0\n", "line 2", "second 'p'"},
      {"p 1 1 x 0\n", "line 1", "'x' is no number of assignments"},
      {"p -1 1 1 0\n", "line 1", "'-1' is no number of left nodes"},
      {"p 4000000000 1 1 0\n", "line 1", "not below"},
      {"p 1 1 4000000000 4000000000\n", "line 1", "ends after 0 of 4000000000"},
      {"p 1 1 1 0\na 0 0 0\n", "line 2", "expected 'a"},
      {"p 1 1 1 0\na 0 0 0 1 1\n", "line 2", "expected 'a"},
      {"p 1 1 1 0\na 1 0 0 1\n", "line 2", "assignment 1 is not below 1"},
      {"p 1 1 1 0\na 0 1 0 1\n", "line 2", "left node 1 is not below 1"},
      {"p 1 1 1 0\na 0 0 2 1\n", "line 2", "right node 2 is not below 1"},
      {"p 1 1 1 0\na 0 0 0 nan\n", "line 2", "not a finite number"},
      {"p 1 1 1 0\na 0 0 0 1e999\n", "line 2", "no cost"},
      {"p 1 1 1 0\na 0 0 0 1x\n", "line 2", "'1x' is no cost"},
      {"p 2 2 2 0\na 0 0 0 -1e308\na 1 1 1 -1e308\n", "line 3", "more than a number can hold"},
      {"p 1 1 2 0\na 0 0 0 1\na 0 0 0 1\n", "line 3", "line 2 already"},
      {"p 1 1 2 0\nc\na 0 0 0 1\na 1 0 0 1\n", "line 4", "assigned in line 3 already"},
      {"p 1 1 1 0\na 0 0 0 1\na 0 0 0 1\n", "line 3", "more assignments"},
      {"p 1 1 1 1\na 0 0 0 1\ne 0 0 1\n", "line 3", "with itself"},
      {"p 1 1 1 0\na 0 0 0 1\nx 1\n", "line 3", "begins with 'x'"},
      {"p 2 2 2 1\na 0 0 0 1\na 1 1 1 1\ne 0 1 1\ne 0 1 1\n", "line 5", "more pairs"},
      {"p 2 2 2 1\na 0 0 0 1\na 1 1 1 1\n", "line 3", "0 of 1 pairs"},
      {"p 2 2 2 1\na 0 0 0 1\na 1 1 1 1\ne 0 2 1\n", "line 4", "not below 2"},
  };
  for (const BadFile& file : files) {
    try {
      parse_dd(file.text, "bad.dd");
      ADD_FAILURE() << "accepted: " << file.text;
    } catch (const InputError& e) {
      EXPECT_EQ(e.details().file, "bad.dd");
      EXPECT_EQ(e.details().place, file.place) << file.text;
      EXPECT_NE(std::string(e.what()).find(file.says), std::string::npos) << e.what();
    }
  }
}

TEST(DdFile, ReadsCommentsAnyOrderAndRepeatedPairs) {
  const MatchingProblem p = parse_dd(
      "c a comment with many many many many words\r\np 2 3 2 2\r\n\r\na 1 1 2 -2.5\r\n"
      "a 0 0 0 +1e-1\r\ni0 0 1.5 2.5\r\nn1 0 1\r\ne 1 0 3\r\ne 0 1 -1",
      "x.dd");
  ASSERT_EQ(p.assignments.size(), 2U);
  EXPECT_EQ(p.assignments[0].cost, 0.1);
  EXPECT_EQ(p.assignments[1].right, 2U);
  EXPECT_DOUBLE_EQ(p.energy(std::vector<uint32_t>{0, 2}), 0.1 - 2.5 + 3 - 1);
}

TEST(DdFile, CostsNearerToNoughtThanANumberCanBeAreNought) {
  const MatchingProblem p = parse_dd("p 1 2 2 0\na 0 0 0 -1e-999\na 1 0 1 1e-310\n", "x.dd");
  EXPECT_EQ(p.assignments[0].cost, 0.0);
  EXPECT_EQ(p.assignments[1].cost, 1e-310);
}

TEST(DdFile, TheMarkOfUtf8IsSkipped) {
  EXPECT_EQ(parse_dd("\xEF\xBB\xBFp 1 1 1 0\na 0 0 0 -1\n", "x.dd").assignments.size(), 1U);
}

TEST(DdFile, WrittenAndReadBackIsTheSame) {
  const MatchingProblem p = test::make_instance(InstanceKind::geometric, 6, 2);
  const MatchingProblem q = parse_dd(format_dd(p), "again.dd");
  ASSERT_EQ(q.pairs.size(), p.pairs.size());
  for (std::size_t e = 0; e < p.pairs.size(); ++e) EXPECT_EQ(q.pairs[e].cost, p.pairs[e].cost);
}

TEST(MatchingProblem, EnergyRefusesLabellingsThatBreakUniqueness) {
  const MatchingProblem p = test::make_instance(InstanceKind::sparse, 4, 1);
  EXPECT_THROW(p.energy(std::vector<uint32_t>{1, 1, unmatched, unmatched}), InputError);
  EXPECT_THROW(p.energy(std::vector<uint32_t>{9, unmatched, unmatched, unmatched}), InputError);
  EXPECT_THROW(p.energy(std::vector<uint32_t>{0}), InputError);
}

}  // namespace
}  // namespace kinemesh::solve_matching_test
