// Options that would do nothing are said, with what to do instead.
#include "capture/idle_options.h"

#include <gtest/gtest.h>

#include <functional>

#include "capture/clean.h"
#include "capture/session.h"
#include "tests/support/data.h"

namespace kinemesh::idle_options_test {
namespace {

std::string refusal(const std::function<void(CleanOptions&)>& change) {
  CleanOptions options;
  change(options);
  try {
    options.validate();
  } catch (const UsageError& e) {
    return e.what();
  }
  return "";
}

TEST(IdleOptions, EachIsRefusedWithARemedy) {
  const auto starts = [](const std::string& text, const std::string& with) {
    EXPECT_EQ(text.substr(0, with.size()), with);
  };
  starts(refusal([](auto& o) { o.head.rigid = {"LFHD"}; }),
         "--rigid does nothing here: the head's motion is not removed. Add --stabilise");
  starts(refusal([](auto& o) { o.gaps.donor = "LCHK04"; }),
         "--donor does nothing here: gaps are filled by auto. Add --fill pattern");
  starts(refusal([](auto& o) {
           o.gaps.companions = {"a", "b", "c"};
         }),
         "--companion does nothing here: gaps are filled by auto. Add --fill rigid");
  starts(refusal([](auto& o) { o.filter.cutoff_hz = 6; }),
         "--cutoff does nothing here: nothing is smoothed. Add --filter");
  starts(refusal([](auto& o) {
           o.filter.method = FilterMethod::butterworth;
           o.filter.window = 9;
         }),
         "--window does nothing here: butterworth has a cut-off");
  starts(refusal([](auto& o) {
           o.filter.method = FilterMethod::median;
           o.filter.cutoff_hz = 6;
         }),
         "--cutoff does nothing here: only butterworth");
  starts(refusal([](auto& o) {
           o.fill = false;
           o.gaps.method = FillMethod::cubic;
         }),
         "--fill does nothing here: gaps are left open");
  starts(refusal([](auto& o) {
           o.label = false;
           o.template_file = "a.c3d";
         }),
         "--template does nothing here");
}

TEST(IdleOptions, FewerThanThreeCompanionsAreNoBody) {
  const auto with = [](std::vector<std::string> companions) {
    return refusal([&](auto& o) {
      o.gaps.method = FillMethod::rigid;
      o.gaps.companions = companions;
    });
  };
  EXPECT_NE(with({"a", "b"}).find("three companions at least, and 2 markers are named"),
            std::string::npos);
  EXPECT_NE(with({"a", "a", "a"}).find("1 marker is named"), std::string::npos);
  EXPECT_EQ(with({"a", "b", "c"}), "");
}

TEST(IdleOptions, WhatIsUsedIsNotRefused) {
  EXPECT_EQ(refusal([](auto&) {}), "");
  EXPECT_EQ(refusal([](auto& o) {
              o.stabilise = true;
              o.head.rigid = {"LFHD"};
              o.filter.method = FilterMethod::butterworth;
              o.filter.cutoff_hz = 6;
              o.gaps.method = FillMethod::pattern;
              o.gaps.donor = "LCHK04";
            }),
            "");
}

TEST(IdleOptions, AWindowBeyondTheTakeAndALimitThatDoesNotHoldAreSaid) {
  const MarkerSequence take = read_session(test::sample_folder() / "anna_happy.c3d");
  EXPECT_THROW(filter_take(take, {.method = FilterMethod::median, .window = 9999}), UsageError);
  EXPECT_EQ(fill_gaps(take, {.max_gap_s = 0.1}).warnings.size(), 1U);
  EXPECT_TRUE(fill_gaps(take, {.method = FillMethod::cubic, .max_gap_s = 0.1, .fill_rest = false})
                  .warnings.empty());
}

}  // namespace
}  // namespace kinemesh::idle_options_test
