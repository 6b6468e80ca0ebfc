#include "capture/filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "config/error.h"

namespace kinemesh::filter_test {
namespace {

constexpr double rate_hz = 100.0;

std::vector<double> wave(std::size_t n) {
  std::vector<double> out;
  for (std::size_t k = 0; k < n; ++k) {
    const auto i = static_cast<double>(k);
    out.push_back(5 * std::sin(0.13 * i) + 0.7 * std::sin(1.9 * i) + 0.3 * std::cos(2.7 * i * i) +
                  800);
  }
  return out;
}

struct Reference {
  FilterMethod method;
  double cutoff_hz;
  int order, window, degree;
  std::vector<double> expected;
};

const std::vector<Reference>& references() {
  static const std::vector<Reference> all = {
#include "tests/capture/filter_reference.inc"
  };
  return all;
}

MarkerSequence one_marker(const std::vector<double>& x) {
  auto take = MarkerSequence::invalid(x.size(), {{.label = "A"}}, rate_hz);
  for (std::size_t f = 0; f < x.size(); ++f) {
    take.position(f, 0) = Eigen::Vector3f(static_cast<float>(x[f]), 1.0F, 2.0F);
    take.flags()[f] = SampleFlag::valid;
  }
  return take;
}

TEST(Filter, AgreesWithSciPy) {
  for (const Reference& r : references()) {
    std::vector<double> values = wave(r.expected.size());
    filter_series(values, rate_hz,
                  {.method = r.method,
                   .cutoff_hz = r.cutoff_hz,
                   .order = r.order,
                   .window = r.window,
                   .degree = r.degree});
    for (std::size_t i = 0; i < values.size(); ++i) {
      EXPECT_NEAR(values[i], r.expected[i], 1e-6)
          << name_of(r.method) << " order " << r.order << " window " << r.window << " at " << i;
    }
  }
  EXPECT_EQ(references().size(), 11U);
}

TEST(Filter, NeverCrossesAGapThatWasNotFilled) {
  const std::vector<double> x = wave(60);
  MarkerSequence take = one_marker(x);
  // What lies behind the gap must not matter for what lies before it.
  MarkerSequence other = take;
  for (std::size_t f = 30; f < 33; ++f) take.flags()[f] = other.flags()[f] = 0;
  for (std::size_t f = 33; f < 60; ++f) other.position(f, 0) *= 3.0F;
  for (const FilterMethod method : {FilterMethod::butterworth, FilterMethod::savitzky_golay,
                                    FilterMethod::moving_average, FilterMethod::median}) {
    FilterOptions options{.method = method};
    if (method == FilterMethod::butterworth) options.cutoff_hz = 8.0;
    const auto a = filter_take(take, options);
    const auto b = filter_take(other, options);
    EXPECT_EQ(a.runs, 2U);
    for (std::size_t f = 0; f < 30; ++f) EXPECT_EQ(a.take.position(f, 0), b.take.position(f, 0));
    for (std::size_t f = 30; f < 33; ++f) {
      EXPECT_EQ(a.take.position(f, 0), take.position(f, 0));
      EXPECT_FALSE(a.take.valid(f, 0));
    }
    EXPECT_GT(a.rms_change_mm, 0.05);
  }
  for (std::size_t f = 30; f < 33; ++f) {
    take.flags()[f] = SampleFlag::valid | SampleFlag::filled;  // filled: one run
  }
  EXPECT_EQ(filter_take(take).runs, 1U);
}

TEST(Filter, ResidualAnalysisKeepsTheMotionAndTakesTheNoise) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 0.2);
  std::vector<double> truth;
  std::vector<double> measured;
  for (int i = 0; i < 1000; ++i) {
    const double t = i / rate_hz;
    truth.push_back(10 * std::sin(2 * M_PI * 1.5 * t) + 2 * std::sin(2 * M_PI * 4 * t));
    measured.push_back(truth.back() + noise(random));
  }
  const std::vector<std::vector<double>> runs{measured};
  const double cutoff = suggest_cutoff(runs, rate_hz);
  EXPECT_GT(cutoff, 5.0);
  EXPECT_LT(cutoff, 16.0);
  filter_series(measured, rate_hz, {.cutoff_hz = cutoff});
  double squares = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    squares += std::pow(measured[i] - truth[i], 2) / static_cast<double>(truth.size());
  }
  EXPECT_LT(std::sqrt(squares), 0.15);  // the noise is 0.2
  const auto result = filter_take(one_marker(runs[0]));
  EXPECT_NEAR(result.cutoffs_hz[0], cutoff, 2.0);
}

TEST(Filter, TheSuggestedCutoffKeepsABlink) {
  // 0.1 mm of noise on slow motion for 17 s, in which the lid closes once, within 0.2 s.
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, 0.1);
  std::vector<double> truth;
  std::vector<double> measured;
  for (int i = 0; i < 1700; ++i) {
    const double t = i / rate_hz;
    truth.push_back(3.0 * std::sin(2.0 * t) - 8.0 * std::exp(-std::pow((t - 8.0) / 0.05, 2)));
    measured.push_back(truth.back() + noise(random));
  }
  const auto worst = [&](const MarkerSequence& take) {
    double error = 0.0;
    for (std::size_t i = 700; i < 900; ++i) {
      error = std::max(error, std::abs(take.position(i, 0).x() - truth[i]));
    }
    return error;
  };
  const MarkerSequence take = one_marker(measured);
  const auto suggested = filter_take(take);
  EXPECT_LT(worst(suggested.take), 0.45);  // the noise alone: some 0.3
  EXPECT_TRUE(suggested.warnings.empty());
  const auto slow = filter_take(take, {.cutoff_hz = 1.0});
  EXPECT_GT(worst(slow.take), 3.0);
  ASSERT_EQ(slow.warnings.size(), 1U);
  EXPECT_NE(slow.warnings[0].find("more than noise explains"), std::string::npos);
}

TEST(Filter, RecordingsWithoutNoiseAreHardlySmoothed) {
  std::vector<double> x;
  for (int i = 0; i < 400; ++i) x.push_back(5.0 * std::sin(0.05 * i));
  EXPECT_LT(filter_take(one_marker(x)).rms_change_mm, 0.01);
}

TEST(Filter, BadInput) {
  const MarkerSequence take = one_marker(wave(20));
  EXPECT_THROW(filter_take(take, {.cutoff_hz = 50.0}), UsageError);
  EXPECT_THROW(filter_take(take, {.method = FilterMethod::median, .window = 4}), UsageError);
  EXPECT_THROW(
      filter_take(take, {.method = FilterMethod::savitzky_golay, .window = 5, .degree = 5}),
      UsageError);
  // Runs that are too short, no frames, no markers: nothing happens.
  MarkerSequence holes = take;
  for (std::size_t f = 0; f < 20; f += 2) holes.flags()[f] = 0;
  const auto result = filter_take(holes);
  EXPECT_EQ(result.short_runs, 10U);
  EXPECT_EQ(result.warnings.size(), 1U);
  EXPECT_EQ(filter_take(MarkerSequence::invalid(0, {{.label = "A"}}, rate_hz)).runs, 0U);
  EXPECT_EQ(filter_take(one_marker(wave(1))).short_runs, 1U);
}

}  // namespace
}  // namespace kinemesh::filter_test
