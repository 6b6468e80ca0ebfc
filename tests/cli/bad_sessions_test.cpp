// Sessions that lack something, through quality, process and convert: a clear message with the
// remedy, or a correction that is stated.
#include <gtest/gtest.h>

#include "capture/c3d/writer.h"
#include "capture/formats/session_export.h"
#include "capture/session.h"
#include "tests/support/data.h"
#include "tests/support/run_program.h"
#include "tests/support/sanitizers.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::bad_sessions_test {
namespace {

class BadSessions : public ::testing::Test {
 protected:
  struct Runs {
    test::ProgramRun quality, process, convert;
  };

  std::string in(const std::string& name) const { return (folder_.path() / name).string(); }

  /// The take through the three commands; `stabilise`: with the head's motion taken out.
  Runs run(const MarkerSequence& take, bool stabilise = false) const {
    export_session(take, in("take.csv"));
    const auto with = [&](std::vector<std::string> arguments) {
      if (stabilise) arguments.emplace_back("--stabilise");
      return test::run_program(KINEMESH_PROGRAM, arguments);
    };
    return {
        test::run_program(KINEMESH_PROGRAM, {"c3d", "quality", in("take.csv")}),
        with({"c3d", "process", in("take.csv"), "-o", in("clean.c3d")}),
        with({"convert", in("take.csv"), "-o", in("face.ply"), "--no-pictures", "--no-report"})};
  }

  static MarkerSequence sample() { return read_session(test::sample_folder() / "anna_happy.c3d"); }
  /// Only the markers for which `keep` holds are ever seen.
  template <class Keep>
  static MarkerSequence seen(Keep keep) {
    MarkerSequence take = sample();
    for (std::size_t f = 0; f < take.frame_count(); ++f) {
      for (std::size_t m = 0; m < take.marker_count(); ++m) {
        if (!keep(take.markers()[m].label)) take.flags()[take.sample(f, m)] = 0;
      }
    }
    return take;
  }
  static void expect(const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << "missing: " << part << "\nin: " << text;
  }

  test::TemporaryFolder folder_;
};

TEST_F(BadSessions, NoRigidMarkersLeft) {
  const Runs runs =
      run(seen([](const std::string& l) {
            return (l.starts_with("LMOU") && l < "LMOU05") || l == "RMOU01" || l == "RMOU02";
          }),
          true);
  expect(runs.quality.out, "repeat the take");
  for (const test::ProgramRun& r : {runs.process, runs.convert}) {
    EXPECT_EQ(r.exit_code, 4);
    expect(r.err, "No markers move as one rigid body");
    expect(r.err, "--rigid");
  }
}

TEST_F(BadSessions, TheRigIsLost) {
  KINEMESH_LEAVE_TO_RELEASE("AMarkerExistsTwice");
  const Runs runs = run(seen([](const std::string& l) {
                          return !l.ends_with("HD") && l != "HeadTop" && l != "rootNape";
                        }),
                        true);
  EXPECT_EQ(runs.process.exit_code, 0);
  expect(runs.process.err, "taken as rigid from their motion");
  expect(runs.convert.out, "taken as rigid from their motion");
}

TEST_F(BadSessions, ARegionIsLostForTheWholeTake) {
  KINEMESH_LEAVE_TO_RELEASE("AMarkerExistsTwice");
  const Runs runs = run(seen([](const std::string& l) { return !l.starts_with("LCHK"); }));
  expect(runs.quality.out, "repeat the take");
  expect(runs.quality.out, "33 markers of 173 seen in less than 40.0 % of the take (LCHK01");
  EXPECT_EQ(runs.process.exit_code, 0);
  expect(runs.process.err, "33 markers were not measured in any frame");
  expect(runs.process.err, "repeat the take");
  EXPECT_EQ(runs.convert.exit_code, 0);
  expect(runs.convert.out, "are invalid in every frame and are left out: no surface is made there");
}

TEST_F(BadSessions, OneFrame) {
  const MarkerSequence take = sample();
  MarkerSequence one = MarkerSequence::invalid(1, take.markers(), take.rate_hz);
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    one.position(0, m) = take.position(0, m);
    one.flags()[m] = take.flags()[m];
  }
  const Runs runs = run(one);
  expect(runs.quality.out, "repeat the take: there is one frame only, no motion");
  EXPECT_EQ(runs.process.exit_code, 0) << runs.process.err;
  expect(runs.process.err, "one frame only");
  EXPECT_EQ(runs.convert.exit_code, 0) << runs.convert.err;
  expect(runs.convert.out, "one frame only: a still surface");
}

TEST_F(BadSessions, AllPointsUnlabelled) {
  MarkerSequence take = sample();
  for (Marker& m : take.markers()) m.kind = MarkerKind::unlabelled;
  const Runs runs = run(take);
  expect(runs.quality.out, "cannot be graded before it is labelled: all points are unlabelled");
  expect(runs.quality.out, "--template");
  for (const test::ProgramRun& r : {runs.process, runs.convert}) {
    EXPECT_EQ(r.exit_code, 4);
    expect(r.err, "--template");
  }
}

TEST_F(BadSessions, AMarkerExistsTwice) {
  const MarkerSequence take = sample();
  std::vector<Marker> markers = take.markers();
  markers.push_back(markers[40]);  // broken in two: its second half has a column of its own
  MarkerSequence twice = MarkerSequence::invalid(take.frame_count(), markers, take.rate_hz);
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    for (std::size_t m = 0; m < take.marker_count(); ++m) {
      const std::size_t to = m == 40 && f > 200 ? markers.size() - 1 : m;
      twice.position(f, to) = take.position(f, m);
      twice.flags()[twice.sample(f, to)] = take.flags()[take.sample(f, m)];
    }
  }
  const Runs runs = run(twice);
  const std::string done = "joined the two trajectories of " + markers[40].label;
  expect(runs.quality.out, "1 label used twice, " + done);
  EXPECT_EQ(runs.process.exit_code, 0);
  expect(runs.process.out, done);
  EXPECT_EQ(runs.convert.exit_code, 0);
  expect(runs.convert.out, done);
  expect(runs.convert.out, "167 vertices");
}

}  // namespace
}  // namespace kinemesh::bad_sessions_test
