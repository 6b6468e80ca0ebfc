#include "reconstruct/anonymous.h"

#include <gtest/gtest.h>

namespace kinemesh::anonymous_test {
namespace {

MarkerSequence session_of(const std::string& subject) {
  MarkerSequence take = MarkerSequence::invalid(1, {{.label = "LFHD", .subject = subject}}, 60.0);
  take.events.push_back({.label = "smile of " + subject, .subject = subject});
  return take;
}

TEST(Anonymiser, ReplacesSubjectsAndPathsInAnyCase) {
  Anonymiser a(session_of("Anna"));
  a.add_path("/data/Anna_Schmidt_01.c3d", "session.c3d");
  EXPECT_EQ(a("kinemesh convert /data/Anna_Schmidt_01.c3d -o x.ply"),
            "kinemesh convert session.c3d -o x.ply");
  EXPECT_EQ(a("marker ANNA:LFHD in anna_schmidt_01"), "marker subject1:LFHD in session");
  EXPECT_EQ(a("nothing to do"), "nothing to do");
}

TEST(Anonymiser, ACommandIsQuotedAfterTheNamesAreGone) {
  Anonymiser a(session_of("Anna"));
  a.add_path("/data/Anna's takes/t 1.c3d", "session.c3d");
  EXPECT_EQ(a.command("kinemesh convert '/data/Anna'\\''s takes/t 1.c3d' -o x.ply --config "
                      "/home/schmidt/o.toml --edits=/home/schmidt/e.toml --fill 'a b'"),
            "kinemesh convert session.c3d -o x.ply --config options.toml --edits=file.toml "
            "--fill 'a b'");
}

TEST(Anonymiser, AMeshKeepsNoName) {
  AnimatedMesh mesh;
  mesh.vertex_names = {"Anna:LFHD", "RFHD"};
  mesh.provenance = {.command = "kinemesh convert anna.c3d",
                     .options = "subject = \"Anna\"",
                     .inputs = {{"/data/anna.c3d", "00"}},
                     .source = "Anna"};
  anonymise_mesh(mesh);
  EXPECT_EQ(mesh.vertex_names[0], "subject1:LFHD");
  EXPECT_EQ(mesh.vertex_names[1], "RFHD");
  EXPECT_EQ(mesh.provenance.inputs[0].path, "input1.c3d");
  EXPECT_EQ(mesh.provenance.inputs[0].sha256, "00");
  EXPECT_EQ(mesh.provenance.command + mesh.provenance.options + mesh.provenance.source, "");
}

TEST(Anonymiser, ShortNamesAreReplacedOnlyWhereTheyStandAlone) {
  const Anonymiser a(session_of("B"));
  EXPECT_EQ(a("B:LBHD, a_b_c, (B)"), "subject1:LBHD, a_subject1_c, (subject1)");
}

TEST(Anonymiser, NoTextOfAConversionKeepsTheName) {
  MarkerSequence session = session_of("Anna");
  session.origin.path = "anna.c3d";
  ConvertResult result;
  result.markers = session.markers();
  result.warnings = {"marker 'Anna:LFHD' jumps"};
  result.selection.decisions = {{.text = "its subject is Anna"}};
  result.animation.vertex_names = {"Anna:LFHD"};
  result.animation.provenance.inputs = {{"anna.c3d", "00"}};
  result.animation.provenance.options = "subject = [\"Anna\"]";
  const Anonymiser anonymiser(session);
  anonymise(anonymiser, session, result);
  EXPECT_EQ(session.markers()[0].subject, "subject1");
  EXPECT_EQ(session.events[0].label, "smile of subject1");
  EXPECT_EQ(session.origin.path, "subject1.c3d");
  EXPECT_EQ(result.warnings[0], "marker 'subject1:LFHD' jumps");
  EXPECT_EQ(result.selection.decisions[0].text, "its subject is subject1");
  EXPECT_EQ(result.animation.vertex_names[0], "subject1:LFHD");
  EXPECT_EQ(result.animation.provenance.inputs[0].path, "subject1.c3d");
  EXPECT_EQ(result.animation.provenance.options, "subject = [\"subject1\"]");
}

}  // namespace
}  // namespace kinemesh::anonymous_test
