// One damaged file per code of the reader: the code is found, and what can be read is read.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>

#include "capture/c3d/finding.h"
#include "capture/c3d/parameter_access.h"
#include "capture/c3d/writer.h"
#include "config/error.h"
#include "tests/support/c3d_parts.h"
#include "tests/support/c3d_takes.h"

namespace kinemesh::c3d_findings_test {
namespace {

using test::C3dParts;
using test::erase_parameter;
using test::put_real;
using test::put_together;
using test::put_u16;

constexpr std::size_t frames = 30;
constexpr std::size_t markers = 4;

MarkerSequence healthy_take() {
  MarkerSequence take = test::make_take(frames, markers);
  test::add_analog(take, 2, 2);
  take.events = {{"Foot Strike", "Left", "S", 0.125}};
  take.parameters.set("SUBJECTS", integer_parameter("USED", {1.0}));
  take.parameters.set("SUBJECTS", texts_parameter("NAMES", {"S"}));
  // So that the section takes several blocks.
  take.parameters.set(
      "NOTES", texts_parameter("TEXTS", std::vector<std::string>(10, std::string(150, 'n'))));
  return take;
}

std::string healthy(const char* storage = "float") {
  return encode_c3d(healthy_take(), {.storage = storage});
}

/// A healthy file whose parameters are changed by `edit`.
std::string with_parameters(const std::function<void(C3dParameters&)>& edit,
                            const char* storage = "float") {
  C3dParts parts = test::take_apart(healthy(storage));
  edit(parts.parameters);
  return put_together(parts);
}

std::string with_number(const char* group, const char* name, double value) {
  return with_parameters([&](C3dParameters& t) { t.find(group, name)->numbers = {value}; });
}

/// Changes bytes of a healthy file.
std::string with_bytes(const std::function<void(std::string&)>& edit,
                       const char* storage = "float") {
  std::string bytes = healthy(storage);
  edit(bytes);
  return bytes;
}

std::size_t record_of(const std::string& bytes, const std::string& group, const std::string& name) {
  const C3dReadResult r = test::read_encoded(bytes);
  const auto it = std::ranges::find_if(r.layout.places, [&](const C3dParameterPlace& p) {
    return p.group == group && p.name == name;
  });
  return it->record;
}

std::size_t data_of(const std::string& bytes) {
  return test::read_encoded(bytes).layout.data_begin;
}

/// Removes the byte that holds a description's length, shortening the record.
std::string without_description_byte(const std::string& name) {
  return with_bytes([&](std::string& b) {
    const std::size_t record = record_of(b, "POINT", name);
    const std::size_t field = record + 2 + name.size();
    const unsigned offset =
        static_cast<uint8_t>(b[field]) + 256U * static_cast<uint8_t>(b[field + 1]);
    b.erase(field + offset - 1, 1);
    put_u16(b, field, offset - 1);
    b.insert(data_of(healthy()) - 1, 1, '\0');
  });
}

struct Case {
  const char* code;
  std::function<std::string()> damaged;
  bool same_data = true;  ///< positions must come out as in the healthy file
};

void set_offset(std::string& b, const std::string& group, const std::string& name, unsigned value) {
  put_u16(b, record_of(b, group, name) + 2 + name.size(), value);
}

std::vector<Case> header_cases() {
  return {
      {"C3D101", [] { return with_bytes([](std::string& b) { b[1] = 81; }); }},
      {"C3D102", [] { return std::string(7, '\0') + healthy(); }},
      {"C3D103", [] { return with_bytes([](std::string& b) { b[0] = 9; }); }},
      {"C3D104",
       [] {
         return with_bytes([](std::string& b) {
           std::fill(b.begin() + 512 + 4, b.begin() + static_cast<std::ptrdiff_t>(data_of(b)),
                     '\0');
         });
       }},
      {"C3D105",
       [] {
         return with_bytes([](std::string& b) {
           put_u16(b, 6, 0);
           put_u16(b, 8, frames - 1);
         });
       }},
      {"C3D106", [] { return healthy(); }},
      {"C3D107",
       [] {
         return with_bytes(
             [](std::string& b) { put_real(b, 2 * 152, std::numeric_limits<float>::quiet_NaN()); });
       }},
  };
}

std::vector<Case> section_cases() {
  return {
      {"C3D201", [] { return with_bytes([](std::string& b) { b[514] = 1; }); }},
      {"C3D202", [] { return with_bytes([](std::string& b) { b[515] = 99; }); }},
      {"C3D203",
       [] { return with_bytes([](std::string& b) { set_offset(b, "POINT", "USED", 60'000); }); }},
      {"C3D204",
       [] {
         return with_bytes([](std::string& b) { b[test::place_of(b, "POINT", "LABELS") - 1] = 9; });
       }},
      {"C3D205",
       [] {
         return with_bytes(
             [](std::string& b) { b[record_of(b, "POINT", "RATE") + 2 + 4 + 2] = 7; });
       }},
      {"C3D206",
       [] {
         return with_bytes([](std::string& b) { b[record_of(b, "SUBJECTS", "NAMES") + 1] = 99; });
       }},
      {"C3D207", [] { return without_description_byte("LABELS"); }},
      {"C3D208",
       [] {
         return with_parameters([](C3dParameters& t) {
           t.group("POINT")->parameters.push_back(text_parameter("UNITS", "m"));
         });
       }},
      {"C3D209",
       [] {
         return with_bytes([](std::string& b) { b[test::place_of(b, "POINT", "RATE") + 4] = 40; });
       }},
      {"C3D210",
       [] {
         return with_bytes([](std::string& b) {
           // The last record continues in the data, which begin before the header says.
           const std::size_t data = data_of(b);
           const C3dReadResult r = test::read_encoded(b);
           const auto last =
               std::ranges::max_element(r.layout.places, {}, &C3dParameterPlace::record);
           const std::size_t field = last->record + 2 + last->name.size();
           put_u16(b, field, static_cast<unsigned>(data + 100 - field));
           put_u16(b, 16, static_cast<unsigned>(data / 512 + 3));
         });
       },
       true},
      {"C3D211",
       [] {
         return with_bytes([](std::string& b) {
           const std::size_t record = record_of(b, "POINT", "RATE");
           b.insert(record + 2 + 4 + 2 + 2 + 4 + 1, 3, '\0');
           put_u16(b, record + 6, 9 + 3);
           b.erase(data_of(healthy()), 3);
         });
       }},
      {"C3D212",
       [] {
         C3dParts parts = test::take_apart(healthy());
         C3dGroup& many = parts.parameters.groups.emplace_back(C3dGroup{.name = "MANY"});
         for (int p = 0; p < 17'000; ++p) {
           many.parameters.push_back(integer_parameter("P" + std::to_string(p), {1.0}));
         }
         return put_together(parts);
       }},
      {"C3D213",
       [] {
         return with_bytes([](std::string& b) {
           const C3dReadResult r = test::read_encoded(b);
           const auto last =
               std::ranges::max_element(r.layout.places, {}, &C3dParameterPlace::record);
           put_u16(b, last->record + 2 + last->name.size(), 50'000);
         });
       }},
  };
}

std::vector<Case> layout_cases() {
  return {
      {"C3D301", [] { return with_number("POINT", "FRAMES", 77); }},
      {"C3D302", [] { return with_bytes([](std::string& b) { b.resize(b.size() - 2000); }); },
       false},
      {"C3D303",
       [] {
         return with_bytes(
             [](std::string& b) { put_u16(b, test::place_of(b, "POINT", "DATA_START"), 3); });
       }},
      {"C3D304", [] { return with_number("POINT", "USED", 9); }},
      {"C3D305", [] { return with_number("ANALOG", "USED", 5); }},
      {"C3D306",
       [] {
         return with_parameters([](C3dParameters& t) { erase_parameter(t, "POINT", "RATE"); });
       }},
      {"C3D307", [] { return with_bytes([](std::string& b) { put_real(b, 20, 50.0F); }); }},
      {"C3D308", [] { return with_bytes([](std::string& b) { put_real(b, 12, 0.0625F); }); }},
      {"C3D309", [] { return with_bytes([](std::string& b) { put_real(b, 12, -1.0F); }); }},
      {"C3D310",
       [] {
         return with_bytes([](std::string& b) {
           put_real(b, 12, 0.0F);
           put_real(b, test::place_of(b, "POINT", "SCALE"), 0.0F);
         });
       }},
      {"C3D311", [] { return healthy() + std::string(5000, 'x'); }},
      {"C3D312",
       [] {
         C3dParts parts = test::take_apart(encode_c3d(test::make_take(70'000, 1)));
         erase_parameter(parts.parameters, "POINT", "LONG_FRAMES");
         parts.parameters.groups.erase(
             std::ranges::find(parts.parameters.groups, "TRIAL", &C3dGroup::name));
         return put_together(parts);
       },
       false},
      {"C3D313", [] { return encode_c3d(test::make_take(70'000, 1)); }, false},
      {"C3D314",
       [] {
         MarkerSequence take(5, {}, 100.0);
         test::add_analog(take, 2, 3);
         return encode_c3d(take);
       },
       false},
      {"C3D315",
       [] {
         MarkerSequence take = test::make_take(20, 3);
         take.rotations.count = 1;
         take.rotations.samples_per_frame = 1;
         take.rotations.values = Buffer<float>(20 * 17, 0.5F);
         return encode_c3d(take);
       },
       false},
      {"C3D319",
       [] {
         return with_parameters([](C3dParameters& t) {
           t.set("ROTATION", integer_parameter("USED", {1}));
           t.set("ROTATION", integer_parameter("DATA_START", {9}));
         });
       }},
      {"C3D316",
       [] {
         C3dParts parts = test::take_apart(healthy());
         erase_parameter(parts.parameters, "POINT", "RATE");
         erase_parameter(parts.parameters, "ANALOG", "RATE");
         parts.header.rate_hz = 0.0F;
         return put_together(parts);
       }},
      {"C3D317",
       [] {
         const std::string b = healthy();
         return b.substr(0, data_of(b));
       },
       false},
      {"C3D320",
       [] {
         return with_parameters([](C3dParameters& t) { erase_parameter(t, "POINT", "FRAMES"); });
       }},
      {"C3D318",
       [] {
         return with_parameters([](C3dParameters& t) { erase_parameter(t, "POINT", "USED"); });
       }},
  };
}

/// Writes one float of point 1 in frame 1, or of its fourth word (index 3).
std::string with_real(std::size_t index, float value) {
  return with_bytes([&](std::string& b) { put_real(b, data_of(b) + 4 * index, value); });
}

std::string with_point(float x, float y, float z) {
  return with_bytes([&](std::string& b) {
    const std::size_t at = data_of(b);
    put_real(b, at, x);
    put_real(b, at + 4, y);
    put_real(b, at + 8, z);
  });
}

std::vector<Case> point_cases() {
  return {
      {"C3D401",
       [] {
         return with_parameters([](C3dParameters& t) {
           t.set("POINT", texts_parameter("LABELS", {"A", "B"}));
         });
       }},
      {"C3D402",
       [] {
         return with_parameters([](C3dParameters& t) {
           t.set("POINT", texts_parameter("LABELS", {"A", "B", "C", "D", "E"}));
         });
       }},
      {"C3D403",
       [] {
         return with_parameters([](C3dParameters& t) {
           t.set("POINT", texts_parameter("LABELS", {"A", "B", "A", "D"}));
         });
       }},
      {"C3D404",
       [] {
         return with_parameters([](C3dParameters& t) { erase_parameter(t, "POINT", "UNITS"); });
       }},
      {"C3D405",
       [] {
         return with_parameters(
             [](C3dParameters& t) { t.set("POINT", text_parameter("UNITS", "furlong")); });
       }},
      {"C3D406",
       [] {
         return with_parameters([](C3dParameters& t) {
           t.set("POINT", texts_parameter("LABELS", {"Gro\xDF", "B", "C", "D"}));
         });
       }},
      {"C3D407", [] { return with_point(0, 0, 0); }, false},
      {"C3D408", [] { return with_real(1, std::numeric_limits<float>::infinity()); }, false},
      {"C3D409", [] { return with_real(3, 65535.0F); }, false},
      {"C3D410", [] { return with_real(3, 1e9F); }, false},
      {"C3D411",
       [] {
         return with_parameters([](C3dParameters& t) {
           t.set("POINT", texts_parameter("LABELS", {"A", "", "C", "D"}));
         });
       }},
      {"C3D412", [] { return with_point(-16512, -16512, -16512); }, false},
      {"C3D413", [] { return with_real(0, 3e6F); }, false},
      {"C3D414",
       [] {
         return with_parameters([](C3dParameters& t) {
           t.set("POINT", texts_parameter("UNITS", {"mm", "mm", "mm", "deg"}));
         });
       }},
  };
}

std::vector<Case> analog_and_event_cases() {
  return {
      {"C3D501",
       [] {
         return with_parameters([](C3dParameters& t) { erase_parameter(t, "ANALOG", "RATE"); });
       }},
      {"C3D502", [] { return with_number("ANALOG", "RATE", 250); }},
      {"C3D503",
       [] {
         return with_parameters([](C3dParameters& t) {
           t.set("ANALOG", text_parameter("FORMAT", "UNSIGNED"));
           t.set("ANALOG", integer_parameter("OFFSET", {-32768, 0}, {2}));
         });
       }},
      {"C3D504",
       [] {
         return with_parameters(
             [](C3dParameters& t) { t.set("ANALOG", texts_parameter("LABELS", {"A"})); });
       }},
      {"C3D505",
       [] {
         return with_parameters([](C3dParameters& t) { erase_parameter(t, "ANALOG", "SCALE"); });
       }},
      {"C3D506", [] { return with_number("ANALOG", "GEN_SCALE", -1); }},
      {"C3D507", [] { return with_number("ANALOG", "GEN_SCALE", 0); }},
      {"C3D508", [] { return with_real(4 * markers, std::numeric_limits<float>::quiet_NaN()); }},
      {"C3D601", [] { return with_number("EVENT", "USED", 4); }},
      {"C3D602",
       [] {
         return with_parameters([](C3dParameters& t) {
           t.set("EVENT", real_parameter("TIMES", {1, 5}, {2, 1}));
         });
       }},
      {"C3D603", [] { return with_number("SUBJECTS", "USED", 3); }},
  };
}

std::vector<Case> all_cases() {
  std::vector<Case> all;
  for (auto cases :
       {header_cases(), section_cases(), layout_cases(), point_cases(), analog_and_event_cases()}) {
    all.insert(all.end(), cases.begin(), cases.end());
  }
  return all;
}

class C3dFindings : public testing::TestWithParam<Case> {};

TEST_P(C3dFindings, IsReportedAndTheDataAreRead) {
  const Case& c = GetParam();
  const C3dReadResult r = test::read_encoded(c.damaged());
  EXPECT_TRUE(test::has_finding(r, c.code));
  for (const C3dFinding& f : r.findings) {
    const C3dFindingKind* kind = c3d_finding_kind(f.code);
    ASSERT_NE(kind, nullptr);
    EXPECT_EQ(f.severity, kind->severity);
    EXPECT_FALSE(f.message.empty() || f.place.empty() || f.remedy.empty()) << f.code;
  }
  if (!c.same_data) return;
  const MarkerSequence truth = healthy_take();
  ASSERT_EQ(r.take.frame_count(), frames);
  ASSERT_EQ(r.take.marker_count(), markers);
  EXPECT_TRUE(std::ranges::equal(r.take.positions(), truth.positions()));
  EXPECT_TRUE(std::ranges::equal(r.take.flags(), truth.flags()));
}

INSTANTIATE_TEST_SUITE_P(Codes, C3dFindings, testing::ValuesIn(all_cases()),
                         [](const auto& tested) { return std::string(tested.param.code); });

TEST(C3dReadOptions, TheUserSaysTheUnitAndTheRateOfAFileThatDoesNot) {
  C3dParts parts = test::take_apart(healthy());
  erase_parameter(parts.parameters, "POINT", "UNITS");
  erase_parameter(parts.parameters, "POINT", "RATE");
  erase_parameter(parts.parameters, "ANALOG", "RATE");
  parts.header.rate_hz = 0.0F;
  const std::string file = put_together(parts);
  const auto bytes = std::as_bytes(std::span(file));
  const C3dReadResult plain = read_c3d(bytes, "plain.c3d");
  const C3dReadResult told =
      read_c3d(bytes, "told.c3d", {.unstated = {.unit = LengthUnit::m, .rate_hz = 50.0}});
  EXPECT_EQ(plain.take.rate_hz, 1.0);
  EXPECT_EQ(told.take.rate_hz, 50.0);
  EXPECT_FALSE(test::has_finding(told, "C3D316"));
  EXPECT_EQ(told.take.position(0, 1), 1000.0F * plain.take.position(0, 1));
  // A file that says its own is believed.
  const std::string stated = healthy();
  const C3dReadResult same = read_c3d(std::as_bytes(std::span(stated)), "stated.c3d",
                                      {.unstated = {.unit = LengthUnit::m, .rate_hz = 50.0}});
  EXPECT_EQ(same.take.rate_hz, healthy_take().rate_hz);
  EXPECT_EQ(same.take.position(0, 1), healthy_take().position(0, 1));
}

TEST(C3dFindingTable, EveryCodeOfTheReaderHasItsCase) {
  const std::vector<Case> cases = all_cases();
  for (const C3dFindingKind& kind : c3d_finding_kinds()) {
    // 214 has a test of its own beside the repair; 0xx, 7xx and 8xx are check's.
    if (kind.code == "C3D214" || kind.code < "C3D100" || kind.code >= "C3D700") continue;
    EXPECT_TRUE(std::ranges::any_of(cases, [&](const Case& c) { return c.code == kind.code; }))
        << kind.code;
  }
}

TEST(C3dFindingTable, CodesAscendAndAreExplained) {
  std::string_view last;
  for (const C3dFindingKind& kind : c3d_finding_kinds()) {
    EXPECT_LT(last, kind.code);
    EXPECT_FALSE(kind.meaning.empty() || kind.remedy.empty());
    last = kind.code;
  }
  EXPECT_EQ(c3d_finding_kind("C3D999"), nullptr);
  EXPECT_THROW(c3d_finding("C3D999", "", ""), InternalError);
}

TEST(C3dFindingTable, HealthyFilesHaveNone) {
  for (const char* storage : {"int", "float"}) {
    for (const char* processor : {"intel", "dec", "sgi"}) {
      const C3dReadResult r = test::read_encoded(encode_c3d(
          test::make_take(frames, markers), {.processor = processor, .storage = storage}));
      EXPECT_TRUE(r.findings.empty()) << r.findings[0].message;
    }
  }
}

}  // namespace
}  // namespace kinemesh::c3d_findings_test
