// docs/c3d.md lists the codes as the program has them.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "capture/c3d/finding.h"
#include "config/input_file.h"
#include "config/output_file.h"
#include "tests/support/data.h"

namespace kinemesh::c3d_docs_test {
namespace {

constexpr std::string_view begin_mark =
    "<!-- codes: begin; written by the test C3dDocs.CodeTable -->\n";
constexpr std::string_view end_mark = "<!-- codes: end -->";

std::string code_table() {
  std::string table = "| code | severity | meaning | what to do |\n|---|---|---|---|\n";
  for (const C3dFindingKind& k : c3d_finding_kinds()) {
    table += "| " + std::string(k.code) + " | " + std::string(name_of(k.severity)) + " | " +
             std::string(k.meaning) + " | " + std::string(k.remedy) + " |\n";
  }
  return table;
}

/// With KINEMESH_UPDATE_DOCS set the table is written instead of compared.
TEST(C3dDocs, CodeTable) {
  const auto path = test::sample_folder().parent_path() / "docs" / "c3d.md";
  std::string text = read_file(path);
  const std::size_t begin = text.find(begin_mark);
  std::size_t end = text.find(end_mark);
  ASSERT_TRUE(begin != std::string::npos && end != std::string::npos && begin < end);
  const std::size_t from = begin + begin_mark.size();
  if (std::getenv("KINEMESH_UPDATE_DOCS") != nullptr) {
    text.replace(from, end - from, code_table());
    write_file(path, text);
    end = text.find(end_mark);
  }
  EXPECT_EQ(text.substr(from, end - from), code_table())
      << "run test_capture --gtest_filter=C3dDocs.* with KINEMESH_UPDATE_DOCS=1";
}

TEST(C3dDocs, CodesAscendAndAreUnique) {
  std::string_view previous;
  for (const C3dFindingKind& k : c3d_finding_kinds()) {
    EXPECT_LT(previous, k.code);
    previous = k.code;
    EXPECT_EQ(k.code.size(), 6U);
    EXPECT_FALSE(k.meaning.empty());
    EXPECT_FALSE(k.remedy.empty());
  }
}

/// Each code has a test: it is named in one of the tests of this folder.
TEST(C3dDocs, EveryCodeIsTested) {
  const auto folder = test::sample_folder().parent_path() / "tests" / "capture";
  std::string all;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".cpp") all += read_file(entry.path());
  }
  for (const C3dFindingKind& k : c3d_finding_kinds()) {
    EXPECT_NE(all.find(k.code), std::string::npos) << k.code << " has no test";
  }
}

}  // namespace
}  // namespace kinemesh::c3d_docs_test
