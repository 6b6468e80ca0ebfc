// kinemesh compare as a user runs it.
#include <nlohmann/json.hpp>

#include "config/output_file.h"
#include "tests/support/command_test.h"
#include "tests/support/data.h"
#include "tests/support/sanitizers.h"

namespace kinemesh::compare_test {
namespace {

class CompareCommand : public test::CommandTest {
 protected:
  CompareCommand() : CommandTest(std::string(KINEMESH_PROGRAM) + " compare") {}
  std::string sample(const std::string& name) const {
    return (test::sample_folder() / (name + ".c3d")).string();
  }
};

TEST_F(CompareCommand, WritesReportTablesAndJsonOfTwoSessions) {
  write_file(place("regions.json"), R"({"mouth": ["LMOU*", "RMOU*", "CMOU*"]})");
  write_file(place("measures.json"), R"({"lip": {"excursion": ["LMOU01"]}})");
  ASSERT_EQ(
      run(sample("anna_happy") + " " + sample("ben_happy") + " --regions " + place("regions.json") +
          " --measures " + place("measures.json") + " -o " + place("r.html")),
      0)
      << errors_;
  const nlohmann::json json = nlohmann::json::parse(read_file(place("r.json")));
  EXPECT_EQ(json["inputs"].size(), 4U);
  EXPECT_EQ(json["inputs"][0]["sha256"].get<std::string>().size(), 64U);
  EXPECT_EQ(json["regions"][1]["region"], "mouth");
  EXPECT_EQ(json["measures"][0]["measure"], "lip");
  EXPECT_GT(json["measures"][0]["a"]["change_mm"], 2.0);
  EXPECT_EQ(json["correspondence"]["poor"], false);
  const std::string page = read_file(place("r.html"));
  EXPECT_LT(page.find("Look at this first"), page.find("Both faces"));
  for (const char* words : {"shape difference", "motion difference", "anna_happy", "SHA-256"})
    EXPECT_NE(page.find(words), std::string::npos) << words;
  EXPECT_EQ(read_file(place("r_measures.csv")).substr(0, 8), "measure,");
  EXPECT_EQ(read_file(place("r_curves.csv")).substr(0, 8), "a_s,b_s,");
}

TEST_F(CompareCommand, NamesNobodyWhenAsked) {
  KINEMESH_LEAVE_TO_RELEASE("WritesReportTablesAndJsonOfTwoSessions");
  ASSERT_EQ(run(sample("anna_surprise") + " " + sample("ben_surprise") + " --anonymous -o " +
                place("r.html")),
            0)
      << errors_;
  for (const char* file : {"r.html", "r.json", "r_measures.csv", "r_regions.csv", "r_curves.csv"}) {
    const std::string text = read_file(place(file));
    EXPECT_EQ(text.find("anna_"), std::string::npos) << file;
    EXPECT_EQ(text.find("ben_"), std::string::npos) << file;
  }
}

TEST_F(CompareCommand, RefusesWhatItCannotRead) {
  EXPECT_EQ(run(sample("anna_happy") + " " + place("none.ply") + " -o " + place("r.html")), 3);
  write_file(place("regions.json"), R"({"mouth": ["NOSUCH*"]})");
  EXPECT_EQ(run(sample("anna_happy") + " " + sample("anna_happy") + " --regions " +
                place("regions.json") + " -o " + place("r.html")),
            3);
  EXPECT_NE(errors_.find("NOSUCH"), std::string::npos) << errors_;
  EXPECT_FALSE(std::filesystem::exists(place("r.html")));
}

}  // namespace
}  // namespace kinemesh::compare_test
