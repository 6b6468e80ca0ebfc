// Repairs: known damage done to sound files, and the real damaged ones.
#include "capture/c3d/repair.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "capture/c3d/header_block.h"
#include "capture/c3d/number_format.h"
#include "capture/c3d/parameter_section.h"
#include "capture/c3d/writer.h"
#include "capture/session_diff.h"
#include "config/error.h"
#include "config/input_file.h"
#include "config/output_file.h"
#include "tests/support/c3d_takes.h"
#include "tests/support/data.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::c3d_repair_test {
namespace {

struct Variant {
  std::string processor, storage;
};

const std::vector<Variant>& variants() {
  static const std::vector<Variant> all = {{"intel", "float"}, {"intel", "int"}, {"dec", "float"},
                                           {"dec", "int"},     {"sgi", "float"}, {"sgi", "int"}};
  return all;
}

MarkerSequence sound_take() {
  MarkerSequence take = test::make_take(40, 12);
  test::add_analog(take, 3, 4);
  return take;
}

std::string encode(const MarkerSequence& take, const Variant& v) {
  return encode_c3d(take, {.processor = v.processor, .storage = v.storage, .scale = 1.0 / 16});
}

void put_word(std::string& bytes, std::size_t at, uint16_t value, Processor p) {
  std::string word;
  append_u16(word, value, p);
  bytes.replace(at, 2, word);
}

/// Repairs `damaged` and checks that no error is left and that `frames` frames hold what the
/// sound file held.
C3dRepairResult expect_mended(const std::string& sound, const std::string& damaged,
                              std::string_view code, std::size_t frames = 40) {
  const C3dReadResult whole = test::read_encoded(sound);
  C3dRepairResult result;
  const std::string repaired = repaired_bytes(damaged, "damaged.c3d", {}, result);
  EXPECT_TRUE(
      std::ranges::any_of(result.before, [&](const C3dFinding& f) { return f.code == code; }))
      << "the damage is not found as " << code;
  const C3dReadResult back = test::read_encoded(repaired);
  EXPECT_FALSE(has_errors(back.findings)) << back.findings.front().message;
  EXPECT_FALSE(test::has_finding(back, code));
  EXPECT_EQ(back.take.frame_count(), frames);
  EXPECT_EQ(result.changed, 0U);
  SessionDiffOptions exact{
      .tolerance_mm = 0, .event_tolerance_s = 0, .analog_tolerance = 0, .parameters = false};
  for (const Difference& d : diff_sessions(whole.take, back.take, exact).differences) {
    if (d.kind == DifferenceKind::frames && frames != whole.take.frame_count()) continue;
    ADD_FAILURE() << d.place << ": " << d.message;
  }
  return result;
}

TEST(C3dRepair, SoundFilesAreCopied) {
  const test::TemporaryFolder folder;
  for (const Variant& v : variants()) {
    const std::string sound = encode(sound_take(), v);
    write_file(folder.path() / "sound.c3d", sound);
    const C3dRepairResult result =
        repair_c3d(folder.path() / "sound.c3d", folder.path() / "out.c3d");
    EXPECT_TRUE(result.copied) << v.processor << v.storage
                               << (result.before.empty() ? "" : result.before[0].message);
    EXPECT_EQ(read_file(folder.path() / "out.c3d"), sound);
    EXPECT_TRUE(result.healthy());
  }
}

TEST(C3dRepair, LeadingZeros) {
  for (const Variant& v : variants()) {
    const std::string sound = encode(sound_take(), v);
    for (const std::size_t zeros : {1U, 7U, 512U}) {
      expect_mended(sound, std::string(zeros, '\0') + sound, "C3D102");
    }
  }
}

TEST(C3dRepair, TruncatedLastFrames) {
  for (const Variant& v : variants()) {
    const std::string sound = encode(sound_take(), v);
    const C3dLayout layout = test::read_encoded(sound).layout;
    const C3dRepairResult result = expect_mended(
        sound, sound.substr(0, layout.data_begin + 29 * layout.frame_bytes + 11), "C3D302", 29);
    EXPECT_EQ(result.frames, 29U);
    EXPECT_EQ(result.frames_lost, 11U);
  }
}

TEST(C3dRepair, WrongParameterPointer) {
  for (const Variant& v : variants()) {
    const std::string sound = encode(sound_take(), v);
    for (const char pointer : {'\5', '\1', '\xFF'}) {
      std::string damaged = sound;
      damaged[0] = pointer;
      expect_mended(sound, damaged, "C3D103");
    }
  }
}

TEST(C3dRepair, CountsThatDisagree) {
  for (const Variant& v : variants()) {
    const std::string sound = encode(sound_take(), v);
    const C3dReadResult whole = test::read_encoded(sound);
    const Processor p = whole.layout.processor;
    std::string damaged = sound;
    put_word(damaged, test::place_of(sound, "POINT", "FRAMES"), 17, p);
    expect_mended(sound, damaged, "C3D301");
    damaged = sound;
    put_word(damaged, 8, 23, p);  // last frame in the header
    expect_mended(sound, damaged, "C3D301");
    damaged = sound;
    put_word(damaged, test::place_of(sound, "POINT", "USED"), 5, p);
    expect_mended(sound, damaged, "C3D304");
    damaged = sound;
    put_word(damaged, 2, 30, p);  // points in the header
    expect_mended(sound, damaged, "C3D304");
    damaged = sound;
    put_word(damaged, 16, 99, p);  // data start in the header
    expect_mended(sound, damaged, "C3D303");
    damaged = sound;
    put_word(damaged, test::place_of(sound, "POINT", "DATA_START"), 2, p);
    expect_mended(sound, damaged, "C3D303");
  }
}

TEST(C3dRepair, BlockCountOfTheParametersTooSmall) {
  for (const Variant& v : variants()) {
    const std::string sound = encode(test::make_take(40, 200), v);  // labels of over a block
    std::string damaged = sound;
    damaged[test::read_encoded(sound).layout.parameters_begin + 2] = 1;
    expect_mended(sound, damaged, "C3D201");
  }
}

/// The file with all labels in one LABELS record whose dimension says `count`.
std::string with_overflowed_labels(const std::string& sound, uint8_t count) {
  const C3dReadResult whole = test::read_encoded(sound);
  const Processor p = whole.layout.processor;
  C3dParameters tree = whole.take.parameters;
  C3dParameter* labels = tree.find("POINT", "LABELS");
  const std::size_t width = labels->dimensions[0];
  std::string all = labels->characters;
  for (const char* more : {"LABELS2", "LABELS3"}) {
    if (tree.find("POINT", more) != nullptr) all += tree.find("POINT", more)->characters;
  }
  labels->characters = all.substr(0, count * width);
  labels->dimensions[1] = count;
  std::erase_if(tree.group("POINT")->parameters,
                [](const C3dParameter& q) { return q.name == "LABELS2" || q.name == "LABELS3"; });
  std::vector<std::string> ignored;
  const std::string section = encode_section(tree, p, ignored);
  std::string damaged = encode_header(whole.header, p) + section;
  const std::size_t values = test::place_of(damaged, "POINT", "LABELS");
  damaged.insert(values + count * width, all.substr(count * width));
  const std::size_t pointer = values - 6;  // behind it: type, number of dimensions, two dimensions
  const auto old = read_u16(reinterpret_cast<const std::byte*>(damaged.data()) + pointer, p);
  put_word(damaged, pointer, static_cast<uint16_t>(old + all.size() - count * width), p);
  damaged.resize((damaged.size() + 511) / 512 * 512, '\0');
  const auto block = static_cast<uint16_t>(damaged.size() / 512 + 1);
  put_word(damaged, 16, block, p);
  const auto start = damaged.find("DATA_START");
  put_word(damaged, start + 10 + 4, block, p);
  return damaged + sound.substr(whole.layout.data_begin);
}

TEST(C3dRepair, MoreLabelsThanEightBitsCanCount) {
  for (const Variant& v : variants()) {
    const std::string sound = encode(test::make_take(10, 300), v);
    for (const uint8_t count : {static_cast<uint8_t>(300 & 255), uint8_t{255}}) {
      expect_mended(sound, with_overflowed_labels(sound, count), "C3D214", 10);
    }
    const std::string even = encode(test::make_take(10, 512), v);  // the low byte is 0
    expect_mended(even, with_overflowed_labels(even, 0), "C3D214", 10);
  }
}

TEST(C3dRepair, AMissingByteInAParameterRecord) {
  for (const Variant& v : variants()) {
    const std::string sound = encode(sound_take(), v);
    const C3dReadResult whole = test::read_encoded(sound);
    const auto place = std::ranges::find(whole.layout.places, "LABELS", &C3dParameterPlace::name);
    ASSERT_NE(place, whole.layout.places.end());
    // As in mocap36: the byte with the description's length is gone, the data begin where they did.
    const C3dParameter* labels = whole.take.parameters.find("POINT", "LABELS");
    const std::size_t length_byte = place->data + labels->characters.size();
    ASSERT_EQ(sound[length_byte], '\0');
    std::string damaged = sound;
    damaged.erase(length_byte, 1);
    damaged.insert(whole.layout.parameters_end - 1, 1, '\0');
    const std::size_t pointer = place->record + 2 + 6;
    const auto* bytes = reinterpret_cast<const std::byte*>(sound.data());
    put_word(damaged, pointer,
             static_cast<uint16_t>(read_u16(bytes + pointer, whole.layout.processor) - 1),
             whole.layout.processor);
    expect_mended(sound, damaged, "C3D207");
  }
}

TEST(C3dRepair, Mocap36IsMendedAsByHand) {
  KINEMESH_NEED_DATA("c3d_conformance/others/mocap36.c3d");
  const auto path = test::data_folder() / "c3d_conformance/others/mocap36.c3d";
  const test::TemporaryFolder folder;
  const std::string before = read_file(path);
  const C3dRepairResult result = repair_c3d(path, folder.path() / "mocap36.c3d");
  EXPECT_EQ(read_file(path), before);  // never touched
  ASSERT_EQ(result.mended.size(), 1U);
  EXPECT_EQ(result.mended[0].finding.code, "C3D207");
  EXPECT_TRUE(result.healthy());
  EXPECT_EQ(result.after.second_opinion, SecondOpinion::agrees);

  // By hand: LABELS begins at byte 621, has 25 × 36 characters, and lacks the byte behind them.
  std::string by_hand = before;
  by_hand.insert(1535, 1, '\0');
  put_word(by_hand, 629, 907, Processor::intel);
  by_hand.erase(5631, 1);  // one byte of the padding before the data at byte 5632
  const C3dReadResult hand = test::read_encoded(by_hand);
  const std::string repaired = read_file(folder.path() / "mocap36.c3d");
  const C3dReadResult ours = test::read_encoded(repaired);
  EXPECT_TRUE(hand.take.sample_count() == 36U * 1380U);
  SessionDiffOptions exact{.tolerance_mm = 0};
  SessionDiffResult diff = diff_sessions(hand.take, ours.take, exact);
  std::erase_if(diff.differences, [](const Difference& d) {  // padding may be left out
    return d.place == "parameter POINT:DATA_START";
  });
  EXPECT_TRUE(diff.identical()) << diff_text(diff, "by hand", "repaired");
  EXPECT_EQ(by_hand.substr(hand.layout.data_begin), repaired.substr(ours.layout.data_begin));
}

TEST(C3dRepair, AllConformanceFilesAreHealthyAfterwardsAndKeepEveryValue) {
  KINEMESH_NEED_DATA("c3d_conformance");
  const test::TemporaryFolder folder;
  std::size_t files = 0;
  for (const char* set : {"c3d_conformance", "c3d_face"}) {
    for (const auto& entry :
         std::filesystem::recursive_directory_iterator(test::data_folder() / set)) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".c3d" && extension != ".C3D") continue;
      SCOPED_TRACE(entry.path());
      if (std::filesystem::file_size(entry.path()) == 0) {
        EXPECT_THROW(repair_c3d(entry.path(), folder.path() / "out.c3d"), InputError);
        continue;
      }
      const C3dRepairResult result = repair_c3d(entry.path(), folder.path() / "out.c3d");
      EXPECT_TRUE(result.healthy());
      EXPECT_TRUE(result.data_verbatim);
      EXPECT_EQ(result.changed, 0U);
      EXPECT_NE(result.after.second_opinion, SecondOpinion::differs);
      EXPECT_NE(result.after.second_opinion, SecondOpinion::refused);
      const bool not_asked = result.after.second_opinion == SecondOpinion::not_asked;
      const bool sgi = entry.path().filename().string().find("s") != std::string::npos;
      EXPECT_TRUE(!not_asked || sgi);  // Eb015si, Eb015sr, sgi_int, sgi_real
      ++files;
    }
  }
  EXPECT_GE(files, 34U);
}

TEST(C3dRepair, RefusesToReplaceTheOriginalAndWhatIsNoC3d) {
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "a.c3d";
  write_file(path, encode(sound_take(), variants()[0]));
  EXPECT_THROW(repair_c3d(path, path), UsageError);
  std::filesystem::create_symlink(path, folder.path() / "link.c3d");
  EXPECT_THROW(repair_c3d(path, folder.path() / "link.c3d"), UsageError);
  EXPECT_THROW(repair_c3d(folder.path() / "none.c3d", folder.path() / "b.c3d"), InputError);
  write_file(folder.path() / "t.trc", "PathFileType\t4\n");
  EXPECT_THROW(repair_c3d(folder.path() / "t.trc", folder.path() / "b.c3d"), UsageError);
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "b.c3d"));
}

TEST(C3dRepair, SaysWhatItDid) {
  const test::TemporaryFolder folder;
  const std::string sound = encode(sound_take(), variants()[0]);
  const C3dLayout layout = test::read_encoded(sound).layout;
  write_file(folder.path() / "cut.c3d",
             sound.substr(0, layout.data_begin + 29 * layout.frame_bytes));
  const C3dRepairResult result = repair_c3d(folder.path() / "cut.c3d", folder.path() / "out.c3d");
  const std::string text = repair_text(result);
  EXPECT_NE(text.find("C3D302  frame 30: 40 frames are declared, 29 are complete\n            the "
                      "complete frames were kept and the counts corrected\n"),
            std::string::npos)
      << text;
  EXPECT_NE(
      text.find("Kept: 29 frames, 348 samples, all with the values they had.\n  Lost: 11 frames "
                "that the original announces but does not hold.\n"),
      std::string::npos)
      << text;
  const nlohmann::json json = nlohmann::json::parse(repair_json(result));
  EXPECT_EQ(json["frames_lost"], 11);
  EXPECT_EQ(json["values_changed"], 0);
  EXPECT_TRUE(json["healthy"]);
  EXPECT_EQ(json["mended"][0]["code"], "C3D302");
}

}  // namespace
}  // namespace kinemesh::c3d_repair_test
