// The manifest of a batch, and the journal by which it goes on.
#include <gtest/gtest.h>

#include <fstream>

#include "config/error.h"
#include "config/output_file.h"
#include "reconstruct/batch_journal.h"
#include "reconstruct/batch_manifest.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::batch_test {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;

BatchManifest manifest_of(const TemporaryFolder& folder, const std::string& name,
                          const std::string& text, const BatchManifestOptions& options = {}) {
  write_file(folder.path() / name, text);
  return read_batch_manifest(folder.path() / name, options);
}

std::string complaint_of(const std::string& name, const std::string& text) {
  const TemporaryFolder folder;
  try {
    manifest_of(folder, name, text);
  } catch (const InputError& e) {
    return e.what();
  }
  return "nothing";
}

TEST(BatchManifest, TomlAndCsvSayTheSame) {
  const TemporaryFolder folder;
  const BatchManifest toml = manifest_of(folder, "study.toml",
                                         "output = \"out\"\nextension = \".glb\"\n"
                                         "[options.gap-filling]\nmax-gap = 0.1\n"
                                         "[[session]]\nsession = \"a/s.c3d\"\n"
                                         "topology = \"h.glb\"\noutput = \"s.glb\"\n"
                                         "[[session]]\nsession = \"a/h.c3d\"\n");
  const BatchManifest csv = manifest_of(folder, "study.csv",
                                        "# two takes\r\nsession,output,topology\r\n"
                                        "a/s.c3d,s.glb,h.glb\r\n\r\na/h.c3d\r\n",
                                        {.folder = folder.path() / "out", .extension = ".glb"});
  const BatchManifest spreadsheet =
      manifest_of(folder, "sheet.csv", "session;output\r\na/h.c3d;\"b, c.glb\"\r\n");
  EXPECT_EQ(spreadsheet.sessions.at(0).session, folder.path() / "a/h.c3d");
  EXPECT_EQ(spreadsheet.sessions.at(0).output.filename(), "b, c.glb");
  ASSERT_EQ(toml.sessions.size(), 2U);
  ASSERT_EQ(csv.sessions.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(toml.sessions[i].session, csv.sessions[i].session);
    EXPECT_EQ(toml.sessions[i].output, csv.sessions[i].output);
    EXPECT_EQ(toml.sessions[i].topology, csv.sessions[i].topology);
    EXPECT_EQ(toml.sessions[i].after, csv.sessions[i].after);
  }
  EXPECT_EQ(toml.sessions[0].session, folder.path() / "a/s.c3d");
  EXPECT_EQ(toml.sessions[0].after, std::size_t{1});
  EXPECT_EQ(toml.sessions[1].output, folder.path() / "out/h.glb");
  EXPECT_NE(toml.options_toml.find("max-gap = 0.1"), std::string::npos);
}

TEST(BatchManifest, ResultsLieBesideTheManifestAndATopologyMayBeAnyFile) {
  const TemporaryFolder folder;
  const BatchManifest m =
      manifest_of(folder, "study.csv", "session,topology\na.c3d,before/face.ply\n");
  EXPECT_EQ(m.folder, folder.path() / "study_results");
  EXPECT_EQ(m.sessions[0].output, folder.path() / "study_results/a.ply");
  EXPECT_EQ(m.sessions[0].topology, folder.path() / "before/face.ply");
  EXPECT_FALSE(m.sessions[0].after.has_value());
}

TEST(BatchManifest, BadOnesAreRefusedWithLineAndReason) {
  EXPECT_NE(complaint_of("a.toml", "output = 3\n").find("must be a text"), std::string::npos);
  EXPECT_NE(complaint_of("a.toml", "\nsesion = 1\n").find("unknown key 'sesion'"),
            std::string::npos);
  EXPECT_NE(complaint_of("a.toml", "a = [\n").find("not valid TOML"), std::string::npos);
  EXPECT_NE(complaint_of("a.toml", "output = \"x\"\n").find("names no session"), std::string::npos);
  EXPECT_NE(complaint_of("a.csv", "").find("names no session"), std::string::npos);
  EXPECT_NE(complaint_of("a.csv", "file\na.c3d\n").find("unknown column 'file'"),
            std::string::npos);
  const std::string same = complaint_of("a.csv", "session\na/x.c3d\nb/x.c3d\n");
  EXPECT_NE(same.find("line 3"), std::string::npos) << same;
  EXPECT_NE(same.find("also that of line 2"), std::string::npos) << same;
  // Their summaries and reports would be the same files.
  EXPECT_NE(complaint_of("a.csv", "session,output\na.c3d,m.glb\nb.c3d,n/../m_####.obj\n")
                .find("also that of line 2"),
            std::string::npos);
  EXPECT_NE(complaint_of("a.csv", "session,topology\na.c3d,b.ply\nb.c3d,a.ply\n").find("circle"),
            std::string::npos);
  EXPECT_NE(complaint_of("a.csv", "session,topology\na.c3d,a.ply\n").find("circle"),
            std::string::npos);
}

TEST(BatchManifest, WhatIsReadIsNeverWrittenOver) {
  const auto refused = [](const std::string& rows) {
    return complaint_of("a.toml", "output = \"data\"\n" + rows).find("would replace") !=
           std::string::npos;
  };
  const auto session = [](const std::string& file, const std::string& output,
                          const std::string& topology = "") {
    return "[[session]]\nsession = \"" + file + "\"\noutput = \"" + output + "\"\n" +
           (topology.empty() ? "" : "topology = \"" + topology + "\"\n");
  };
  EXPECT_TRUE(refused(session("data/p.c3d", "q.c3d") + session("data/q.c3d", "r.c3d")));
  EXPECT_TRUE(refused(session("data/p.c3d", "p.c3d")));
  EXPECT_TRUE(refused(session("data/../data/p.c3d", "x/../p.c3d")));
  EXPECT_TRUE(refused(session("data/p_quality.csv", "p.ply")));
  EXPECT_TRUE(refused(session("data/p.c3d", "t.mdd", "data/t.ply")));
  EXPECT_FALSE(refused(session("data/p.c3d", "p.ply")));
  EXPECT_FALSE(refused(session("data/p.c3d", "p.ply") + session("data/q.c3d", "q.ply", "p.ply")));
}

TEST(BatchManifest, AnErrorInTheOptionsIsOnTheLineOfTheManifest) {
  const TemporaryFolder folder;
  const BatchManifest m =
      manifest_of(folder, "a.toml",
                  "# a\n\n[[session]]\nsession = \"x.c3d\"\n[options.write]\nformat = \"glb\"\n");
  EXPECT_EQ(m.options_toml, "\n\n\n\n[write]\nformat = \"glb\"\n");
  EXPECT_EQ(m.sessions[0].line, 3U);
}

TEST(BatchManifest, ANameIsNoPatternUnlessTheManifestSaysSo) {
  const TemporaryFolder folder;
  const BatchManifest m =
      manifest_of(folder, "a.csv",
                  "session,output\nsubject#1.c3d,\nsubject#11.c3d,\nx%04d.c3d,\ny.c3d,y_##.obj\n");
  EXPECT_EQ(m.sessions[0].output.filename(), "subject-1.ply");
  EXPECT_EQ(m.sessions[1].output.filename(), "subject-11.ply");
  EXPECT_EQ(m.sessions[2].output.filename(), "x-04d.ply");
  EXPECT_EQ(m.sessions[3].output.filename(), "y_##.obj");
}

TEST(BatchJournal, KnowsWhatIsFinishedAndTrustsNothingElse) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "journal", mesh = folder.path() / "a.ply";
  write_file(mesh, "mesh");
  {
    BatchJournal journal(file, true);
    journal.note({.output = "a", .key = "k", .files = {{mesh.string(), 4}}, .vertices = 7});
    journal.note({.output = "b", .key = "k", .files = {{mesh.string(), 5}}});
  }
  // A power cut while the next line was written.
  std::ofstream(file, std::ios::app) << "{\"output\":\"c\",\"key\":\"k\",\"fi";
  BatchJournal again(file, true);
  ASSERT_NE(again.finished("a", "k"), nullptr);
  EXPECT_EQ(again.finished("a", "k")->vertices, 7U);
  EXPECT_EQ(again.finished("a", "other options"), nullptr);
  EXPECT_EQ(again.finished("b", "k"), nullptr);  // its file has another size
  EXPECT_EQ(again.finished("c", "k"), nullptr);
  again.note({.output = "c", .key = "k", .files = {{mesh.string(), 4}}});
  EXPECT_NE(BatchJournal(file, true).finished("c", "k"), nullptr);
  EXPECT_EQ(BatchJournal(file, false).finished("a", "k"), nullptr);
}

TEST(BatchJournal, ItsPathsAreRelativeToItsFolderSoThatBothCanMove) {
  const TemporaryFolder folder;
  const fs::path old = folder.path() / "old";
  fs::create_directories(old / "sub");
  write_file(old / "sub/a.ply", "mesh");
  BatchJournal journal(old / "journal", true);
  EXPECT_EQ(journal.name_of(old / "x/../sub/a.ply"), "sub/a.ply");
  EXPECT_EQ(journal.name_of(fs::proximate(old / "sub/a.ply")), "sub/a.ply");
  journal.note({.output = "sub/a.ply", .key = "k", .files = {{"sub/a.ply", 4}}});
  fs::rename(old, folder.path() / "new");
  const BatchJournal moved(folder.path() / "new/journal", true);
  EXPECT_NE(moved.finished("sub/a.ply", "k"), nullptr);
}

TEST(BatchJournal, TheKeyChangesWithContentOptionsAndProgram) {
  const TemporaryFolder folder;
  const fs::path a = folder.path() / "a", b = folder.path() / "b";
  write_file(a, "1");
  write_file(b, "1");
  const std::string key = batch_key({a}, "o", "p");
  EXPECT_EQ(key, batch_key({b}, "o", "p"));
  EXPECT_NE(key, batch_key({a}, "o2", "p"));
  EXPECT_NE(key, batch_key({a}, "o", "p2"));
  EXPECT_NE(key, batch_key({a, b}, "o", "p"));
  write_file(a, "2");
  EXPECT_NE(key, batch_key({a}, "o", "p"));
}

}  // namespace
}  // namespace kinemesh::batch_test
