// kinemesh convert, as an operator types it, on the samples and on real takes.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "config/input_file.h"
#include "mesh/formats/mesh_io.h"
#include "report/image.h"
#include "tests/support/data.h"
#include "tests/support/run_program.h"
#include "tests/support/samples.h"
#include "tests/support/sanitizers.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::convert_test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using test::TemporaryFolder;

struct Converted {
  Json summary;
  AnimatedMesh mesh;
};

/// Converts with --json and reads the mesh back.
Converted convert(const fs::path& session, const fs::path& out,
                  const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments{"convert", session.string(), "-o", out.string(), "--json"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const test::ProgramRun run = test::run_program(KINEMESH_PROGRAM, arguments);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  Converted result{Json::parse(run.out), {}};
  result.mesh = read_animation(builtin_mesh_formats(), out);
  return result;
}

void expect_sound(const Converted& c) {
  EXPECT_TRUE(c.mesh.topology().is_manifold());
  EXPECT_EQ(c.mesh.topology().component_count(), 1U);
  EXPECT_EQ(c.mesh.topology().isolated_vertex_count(), 0U);
  EXPECT_EQ(c.mesh.topology().euler_characteristic(),
            1 - static_cast<int64_t>(c.summary["mesh"]["openings"].size()));
  for (const float x : c.mesh.positions()) ASSERT_TRUE(std::isfinite(x));
  for (std::size_t f = 0; f < c.mesh.frame_count(); ++f) {
    ASSERT_GT(c.mesh.frame(f).rowwise().norm().minCoeff(), 0.0F);
  }
}

/// Marker count of the opening of this name, 0 without it.
std::size_t ring(const Json& summary, const std::string& name) {
  for (const Json& opening : summary["mesh"]["openings"]) {
    if (opening["name"] == name) return opening["markers"].size();
  }
  return 0;
}

/// For tests that are not about filling: the default takes most of the time of a conversion.
const std::vector<std::string> quick{"--no-pictures", "--no-report", "--fill",
                                     "linear",        "--max-gap",   "60"};

std::vector<std::string> with_quick(std::vector<std::string> more) {
  more.insert(more.end(), quick.begin(), quick.end());
  return more;
}

class Samples : public ::testing::TestWithParam<std::string> {};

TEST_P(Samples, ConvertWithNoOption) {
  const TemporaryFolder folder;
  const Converted c =
      convert(test::sample_folder() / (GetParam() + ".c3d"), folder.path() / "face.ply");
  expect_sound(c);
  EXPECT_GT(ring(c.summary, "mouth"), 0U);
  EXPECT_GT(ring(c.summary, "left eye"), 0U);
  EXPECT_GT(ring(c.summary, "right eye"), 0U);
  EXPECT_EQ(c.summary["left_out"].size(), 6U);  // the head rig
  EXPECT_EQ(c.summary["session"]["rate_hz"], 120.0);
  EXPECT_EQ(c.mesh.rate_hz, 120.0);
  for (const Json& output : c.summary["outputs"]) {
    EXPECT_TRUE(fs::is_regular_file(output.get<std::string>())) << output;
  }
  const Image picture = decode_png(read_file(folder.path() / "face_frames.png"));
  EXPECT_GT(picture.width, 800);
}

INSTANTIATE_TEST_SUITE_P(All, Samples,
                         ::testing::ValuesIn(test::under_sanitizers
                                                 ? std::vector<std::string>{"ben_surprise"}
                                                 : test::sample_names()));

TEST(Convert, RealTakesGiveSoundMeshes) {
  KINEMESH_NEED_DATA("c3d_face/Facial-Sing.c3d");
  const fs::path takes = test::data_folder() / "c3d_face";
  const TemporaryFolder folder;
  const std::vector<std::string> fast{"--no-pictures", "--no-report"};
  const Converted sing = convert(takes / "Facial-Sing.c3d", folder.path() / "sing.ply", fast);
  expect_sound(sing);
  EXPECT_EQ(sing.mesh.vertex_count(), 31U);
  EXPECT_EQ(sing.mesh.frame_count(), 3000U);
  EXPECT_EQ(ring(sing.summary, "mouth"), 8U);
  const Converted jaw = convert(takes / "AnimFace-Jaw.c3d", folder.path() / "jaw.ply", fast);
  expect_sound(jaw);
  EXPECT_EQ(jaw.mesh.vertex_count(), 41U);
  EXPECT_EQ(ring(jaw.summary, "mouth"), 8U);
  EXPECT_EQ(jaw.summary["mesh"]["openings"].size(), 1U);
  const Converted brows =
      convert(takes / "AnimFace-Eyebrows.c3d", folder.path() / "brows.ply", fast);
  expect_sound(brows);
  EXPECT_TRUE(brows.summary["mesh"]["openings"].empty());
}

TEST(Convert, ATopologyIsUsedAgainByMarkerName) {
  const TemporaryFolder folder;
  const Converted happy =
      convert(test::sample_folder() / "anna_happy.c3d", folder.path() / "happy.ply", quick);
  const Converted surprise =
      convert(test::sample_folder() / "anna_surprise.c3d", folder.path() / "surprise.ply",
              with_quick({"--topology", folder.path() / "happy.ply"}));
  EXPECT_EQ(surprise.mesh.topology(), happy.mesh.topology());
  EXPECT_EQ(surprise.mesh.vertex_names, happy.mesh.vertex_names);
  // One marker fewer: the rest keeps its edges, and the missing one is said.
  const Converted fewer =
      convert(test::sample_folder() / "anna_surprise.c3d", folder.path() / "fewer.ply",
              with_quick({"--topology", folder.path() / "happy.ply", "--exclude", "CNOS03"}));
  EXPECT_EQ(fewer.mesh.vertex_count(), happy.mesh.vertex_count() - 1);
  EXPECT_TRUE(fewer.mesh.topology().is_manifold());
  EXPECT_NE(fewer.summary["doubtful"].dump().find("CNOS03"), std::string::npos);
}

TEST(Convert, TheNumberOfThreadsDoesNotChangeAByte) {
  KINEMESH_LEAVE_TO_RELEASE("Samples.ConvertWithNoOption");
  const TemporaryFolder folder;
  const fs::path session = test::sample_folder() / "anna_happy.c3d";
  std::vector<std::string> bytes;
  for (const std::string threads : {"1", "3"}) {
    convert(session, folder.path() / "face.ply", {"--threads", threads, "--no-report"});
    bytes.push_back(read_file(folder.path() / "face.pc2") +
                    read_file(folder.path() / "face_frames.png") +
                    read_file(folder.path() / "face_quality.csv"));
  }
  EXPECT_TRUE(bytes[0] == bytes[1]);
}

TEST(Convert, FilledSamplesAreMarkedInTheMesh) {
  const TemporaryFolder folder;
  const Converted sample = convert(test::sample_folder() / "ben_happy.c3d",
                                   folder.path() / "ben.pvd", {"--no-pictures", "--no-report"});
  std::size_t marked = 0;
  for (const uint8_t filled : sample.mesh.filled()) marked += filled;
  EXPECT_EQ(marked, sample.summary["quality"]["filled_samples"].get<std::size_t>());
  EXPECT_GT(marked, 0U);
}

TEST(Convert, TheFilledSamplesOfPlyAndPc2AreMarkedToo) {
  const TemporaryFolder folder;
  const Converted sample =
      convert(test::sample_folder() / "ben_happy.c3d", folder.path() / "ben.ply", quick);
  std::size_t marked = 0;
  for (const uint8_t filled : sample.mesh.filled()) marked += filled;
  EXPECT_EQ(marked, sample.summary["quality"]["filled_samples"].get<std::size_t>());
  std::size_t uncertain = 0;  // the comments of the PLY say how uncertain they are
  for (const float mm : sample.mesh.uncertainty()) uncertain += mm > 0 ? 1 : 0;
  EXPECT_EQ(uncertain, marked);
  EXPECT_EQ(sample.summary["written"]["format"], "ply+pc2");
  EXPECT_EQ(sample.summary["written"]["not_kept"], Json::array());
}

TEST(Convert, OptionsAreDumpedWithoutASession) {
  const TemporaryFolder folder;
  const auto dump = test::run_program(KINEMESH_PROGRAM, {"convert", "--dump-config"});
  EXPECT_EQ(dump.exit_code, 0);
  EXPECT_NE(dump.out.find("max-gap"), std::string::npos);
  const auto nothing = test::run_program(KINEMESH_PROGRAM, {"convert"});
  EXPECT_EQ(nothing.exit_code, 2);
  EXPECT_NE(nothing.err.find("SESSION is required"), std::string::npos) << nothing.err;
}

TEST(Convert, AForcedEdgeNamesTheMarkerThatIsMissing) {
  const TemporaryFolder folder;
  const std::string session = (test::sample_folder() / "anna_happy.c3d").string();
  const auto wrong = test::run_program(
      KINEMESH_PROGRAM, {"convert", session, "-o", folder.path() / "f.ply", "--edge", "LMOU01:B"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_NE(wrong.err.find("--edge LMOU01:B: the mesh has no marker 'B'"), std::string::npos)
      << wrong.err;
}

TEST(Convert, GltfIsTurnedByTheAxesOfTheSession) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "y.toml")
      << "[[edit]]\ndo = \"axes\"\nfrom = \"z-up\"\npreset = \"y-up\"\n";
  const auto up_of = [&](const std::vector<std::string>& more) {
    std::vector<std::string> options{"--no-pictures", "--no-report", "--fill", "linear"};
    options.insert(options.end(), more.begin(), more.end());
    convert(test::sample_folder() / "anna_happy.c3d", folder.path() / "face.glb", options);
    const std::string glb = read_file(folder.path() / "face.glb");
    return glb.find(R"("up":"y")") != std::string::npos   ? "y"
           : glb.find(R"("up":"z")") != std::string::npos ? "z"
                                                          : "";
  };
  EXPECT_EQ(up_of({}), "z");
  EXPECT_EQ(up_of({"--edits", folder.path() / "y.toml"}), "y");
  EXPECT_EQ(up_of({"--gltf-up", "y"}), "y");
}

TEST(Convert, CtrlCLeavesNothingBehind) {
  const TemporaryFolder folder;
  bool cancelled = false;
  for (const double delay : {0.03, 0.06, 0.1, 0.2, 0.4, 0.8}) {
    const fs::path out = folder.path() / std::to_string(delay);
    fs::create_directory(out);
    const test::ProgramRun run = test::run_program(
        KINEMESH_PROGRAM,
        {"convert", (test::sample_folder() / "ben_happy.c3d").string(), "-o", out / "face.obj"},
        delay);
    if (run.exit_code == 130 || run.exit_code == -1) {
      // -1: the signal came while the program was still being loaded.
      cancelled |= run.exit_code == 130;
      EXPECT_TRUE(fs::is_empty(out));
    } else {
      EXPECT_EQ(run.exit_code, 0) << run.err;
      EXPECT_FALSE(fs::is_empty(out));
    }
  }
  EXPECT_TRUE(cancelled);
}

TEST(Convert, AMeshIsWrittenInAnotherFormatWithTheUnitAndRateThatItDoesNotSay) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "step_1.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  std::ofstream(folder.path() / "step_2.obj") << "v 0 0 .5\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  const auto run = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"convert", folder.path() / "step_#.obj"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return test::run_program(KINEMESH_PROGRAM, arguments);
  };
  const std::string out = folder.path() / "steps.pvd";
  const auto done = run({"-o", out, "--unit", "cm", "--rate", "25", "--json"});
  ASSERT_EQ(done.exit_code, 0) << done.err;
  EXPECT_EQ(Json::parse(done.out)["frames"], 2);
  const AnimatedMesh mesh = read_animation(builtin_mesh_formats(), out);
  EXPECT_EQ(mesh.rate_hz, 25.0);
  EXPECT_EQ(mesh.frame(1)(0, 2), 5.0F);
  EXPECT_EQ(run({}).exit_code, 2);
  EXPECT_EQ(run({"-o", out, "--edits", "list.toml"}).exit_code, 2);
}

TEST(Convert, WhatWasRecordedIsNeverReplaced) {
  const TemporaryFolder folder;
  const fs::path session = folder.path() / "take.c3d";
  fs::copy_file(test::sample_folder() / "anna_happy.c3d", session);
  fs::create_hard_link(session, folder.path() / "same.c3d");
  const std::string before = read_file(session);
  for (const auto& command : {std::vector<std::string>{"convert"}, {"c3d", "process"}}) {
    for (const char* output : {"take.c3d", "same.c3d"}) {
      std::vector<std::string> words = command;
      words.insert(words.end(), {session.string(), "-o", folder.path() / output});
      const auto run = test::run_program(KINEMESH_PROGRAM, words);
      EXPECT_EQ(run.exit_code, 2) << command.back() << " " << output;
      EXPECT_NE(run.err.find("would replace the input"), std::string::npos) << run.err;
    }
  }
  EXPECT_EQ(read_file(session), before);
  std::ofstream(folder.path() / "m.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  const std::string mesh = folder.path() / "m.obj";
  EXPECT_EQ(test::run_program(KINEMESH_PROGRAM, {"convert", mesh, "-o", mesh}).exit_code, 2);
}

TEST(Convert, AMeshIsNeverReplacedByItsOwnConversion) {
  const TemporaryFolder folder;
  const auto run = [&](const std::string& from, const std::string& to,
                       const std::vector<std::string>& more = {}) {
    std::vector<std::string> words{"convert", folder.path() / from, "-o", folder.path() / to};
    words.insert(words.end(), more.begin(), more.end());
    return test::run_program(KINEMESH_PROGRAM, words);
  };
  std::ofstream(folder.path() / "s_1.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  std::ofstream(folder.path() / "s_2.obj") << "v 0 0 .5\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  ASSERT_EQ(run("s_#.obj", "a.ply", {"--rate", "25"}).exit_code, 0);
  const std::string before = read_file(folder.path() / "a.ply");
  const auto replacing = run("a.ply", "a.mdd", {"--output-unit", "m", "--frames", "1:2"});
  EXPECT_EQ(replacing.exit_code, 2) << replacing.err;
  EXPECT_EQ(run("a.ply", "a.ply", {"--frames", "2"}).exit_code, 2);
  EXPECT_EQ(read_file(folder.path() / "a.ply"), before);
  EXPECT_FALSE(fs::exists(folder.path() / "a.mdd"));
  // What a mesh cannot be asked for is said, not passed over.
  const auto asked = run("a.ply", "b.glb", {"--stabilise", "--include", "A"});
  EXPECT_EQ(asked.exit_code, 2);
  EXPECT_NE(asked.err.find("--include"), std::string::npos) << asked.err;
  for (const char* option : {"--picture-frames=3", "--up-axis=x", "--reader=ezc3d"}) {
    EXPECT_EQ(run("a.ply", "b.glb", {option}).exit_code, 2) << option;
  }
  EXPECT_EQ(run("a.ply", "b.glb", {"--anonymous", "--no-report"}).exit_code, 0);
  const auto assumed = run("s_#.obj", "c.glb");
  EXPECT_NE(assumed.err.find("does not say its unit: taken as mm"), std::string::npos);
  EXPECT_EQ(run("s_#.obj", "c.glb", {"--unit", "m", "--rate", "50"}).err.find("does not say"),
            std::string::npos);
}

TEST(Convert, UnreachableInputIsNoInternalError) {
  const TemporaryFolder folder;
  fs::create_symlink(folder.path() / "loop.c3d", folder.path() / "loop.c3d");
  for (const std::string& path :
       {(folder.path() / "loop.c3d").string(), std::string(300, 'x') + ".c3d"}) {
    EXPECT_EQ(test::run_program(KINEMESH_PROGRAM, {"convert", path}).exit_code, 3) << path;
    EXPECT_EQ(test::run_program(KINEMESH_PROGRAM, {"info", path}).exit_code, 3) << path;
  }
}

TEST(Convert, ContradictionsAndTwoSubjectsAreSaid) {
  const TemporaryFolder folder;
  const std::string session = (test::sample_folder() / "anna_happy.c3d").string();
  const auto run = test::run_program(
      KINEMESH_PROGRAM, with_quick({"convert", session, "-o", folder.path() / "f.ply", "--edge",
                                    "LCHK04:LCHK05", "--no-edge", "LCHK05:LCHK04"}));
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("forbidden by --no-edge"), std::string::npos) << run.err;
}

TEST(Convert, ErrorsNameFileAndRemedy) {
  const TemporaryFolder folder;
  const std::string session = (test::sample_folder() / "anna_happy.c3d").string();
  const auto failing = [](const std::vector<std::string>& arguments) {
    return test::run_program(KINEMESH_PROGRAM, arguments);
  };
  const std::string out = folder.path() / "f.ply";
  const auto unwritable = failing({"convert", session, "-o", session + "/face.ply"});
  EXPECT_EQ(unwritable.exit_code, 3);
  EXPECT_NE(unwritable.err.find("cannot create the folder"), std::string::npos) << unwritable.err;
  EXPECT_EQ(failing({"convert", session, "-o", folder.path() / "face.xyz"}).exit_code, 2);
  EXPECT_EQ(failing({"convert", session, "-o", out, "--include", "zzz"}).exit_code, 4);
  EXPECT_EQ(failing({"convert", session, "-o", out, "--edge", "A:B"}).exit_code, 2);
  EXPECT_EQ(failing({"convert", session, "-o", out, "--frame", "99999"}).exit_code, 2);
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

}  // namespace
}  // namespace kinemesh::convert_test
