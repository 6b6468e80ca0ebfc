#include "capture/marker_selection.h"

#include <gtest/gtest.h>

#include "config/error.h"

namespace kinemesh::marker_selection_test {
namespace {

Marker marker(std::string label, std::string subject = {}, MarkerKind kind = MarkerKind::marker) {
  return {.label = std::move(label), .subject = std::move(subject), .kind = kind};
}

MarkerSequence take_of(std::vector<Marker> markers) {
  MarkerSequence take = MarkerSequence::invalid(3, std::move(markers), 100.0);
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    take.position(1, m) = Eigen::Vector3f(1, 2, 3);
    take.flags()[take.sample(1, m)] = SampleFlag::valid;
  }
  return take;
}

std::vector<std::string> labels(const MarkerSequence& take, const std::vector<std::size_t>& which) {
  std::vector<std::string> out;
  for (const std::size_t m : which) out.push_back(take.markers()[m].label);
  return out;
}

using Names = std::vector<std::string>;

MarkerSequence mixed_take() {
  return take_of({marker("lip1", "Ann"), marker("ROOT-1", "Ann"), marker("lfhd", "Ann"),
                  marker("Unlabeled1", "", MarkerKind::unlabelled),
                  marker("LKneeAngles", "Ann", MarkerKind::angle), marker("brow", "Bob"),
                  marker("Head_Top", "Bob"), marker("forehead", "Bob")});
}

TEST(MarkerSelection, LeavesUnlabelledNonMarkersAndTheHeadRigAside) {
  const MarkerSequence take = mixed_take();
  const auto result = select_markers(take);
  EXPECT_EQ(labels(take, result.chosen), (Names{"lip1", "brow", "forehead"}));
  EXPECT_EQ(labels(take, result.head_rig), (Names{"ROOT-1", "lfhd", "Head_Top"}));
  EXPECT_EQ(result.decisions[1].reason, SelectionReason::head_rig);
  EXPECT_EQ(result.decisions[3].reason, SelectionReason::other_kind);
  EXPECT_EQ(result.decisions[4].text, "kind angle; choose it with --kind angle");
  EXPECT_TRUE(result.warnings.empty());
}

TEST(MarkerSelection, ATakeWithoutAnyLabelIsToldHowToGetThem) {
  const MarkerSequence take =
      take_of({marker("*0", "", MarkerKind::unlabelled), marker("*1", "", MarkerKind::unlabelled)});
  try {
    select_markers(take);
    FAIL();
  } catch (const NoResultError& e) {
    EXPECT_NE(e.details().remedy.find("kinemesh c3d process TAKE.c3d --template"),
              std::string::npos)
        << e.details().remedy;
  }
  EXPECT_EQ(select_markers(take, {.kinds = {"unlabelled"}}).chosen.size(), 2U);
}

TEST(MarkerSelection, TakesWhatIsAskedFor) {
  const MarkerSequence take = mixed_take();
  const auto chosen = [&](const MarkerSelectionOptions& options) {
    return labels(take, select_markers(take, options).chosen);
  };
  EXPECT_EQ(chosen({.subjects = {"b*"}}), (Names{"brow", "forehead"}));
  EXPECT_EQ(chosen({.subjects = {"ann"}, .head_rig = true}), (Names{"lip1", "ROOT-1", "lfhd"}));
  EXPECT_EQ(chosen({.include = {"*ro*"}, .exclude = {"Bob:fore*"}}), (Names{"ROOT-1", "brow"}));
  EXPECT_EQ(chosen({.include = {"*"}}), (Names{"lip1", "brow", "forehead"}));
  EXPECT_EQ(chosen({.include = {"unlabeled1", "root*"}}), (Names{"ROOT-1", "Unlabeled1"}));
  EXPECT_EQ(chosen({.kinds = {"Angle", "unlabelled"}}), (Names{"Unlabeled1", "LKneeAngles"}));
  EXPECT_EQ(chosen({.head_rig_patterns = {"lip?"}}),
            (Names{"ROOT-1", "lfhd", "brow", "Head_Top", "forehead"}));
}

TEST(MarkerSelection, DropsAMarkerOnlyWhenItIsNeverValidAndSaysSo) {
  MarkerSequence take = take_of({marker("a"), marker("b", "S"), marker("root1")});
  take.flags()[take.sample(1, 1)] = 0;
  take.flags()[take.sample(1, 2)] = 0;
  std::vector<std::string> logged;
  RunContext ctx;
  ctx.set_log([&](LogLevel, std::string_view text) { logged.emplace_back(text); });
  const auto result = select_markers(take, {}, ctx);
  EXPECT_EQ(result.chosen, std::vector<std::size_t>{0});
  EXPECT_TRUE(result.head_rig.empty());
  EXPECT_EQ(result.warnings, (Names{"Marker S:b is invalid in every frame and is left out."}));
  EXPECT_EQ(logged, result.warnings);
}

TEST(MarkerSelection, AHeadWithNothingButHeadNamesIsNoRig) {
  const MarkerSequence take = take_of({marker("head1"), marker("head2")});
  const auto result = select_markers(take);
  EXPECT_EQ(result.chosen.size(), 2U);
  EXPECT_TRUE(result.head_rig.empty());
  EXPECT_EQ(result.warnings.size(), 1U);
}

TEST(MarkerSelection, SaysWhatIsWrong) {
  const MarkerSequence take = mixed_take();
  EXPECT_THROW(select_markers(take, {.kinds = {"blob"}}), UsageError);
  const auto result = select_markers(take, {.exclude = {"nose*"}});
  EXPECT_EQ(result.warnings, (Names{"--exclude nose* matches nothing in the take."}));
  EXPECT_THROW(select_markers(take, {.include = {"nose*"}}), NoResultError);
  EXPECT_THROW(select_markers(take_of({})), NoResultError);
  EXPECT_THROW(select_markers(MarkerSequence::invalid(0, {marker("a")}, 100.0)), NoResultError);
}

}  // namespace
}  // namespace kinemesh::marker_selection_test
