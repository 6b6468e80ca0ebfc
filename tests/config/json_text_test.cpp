#include "config/json_text.h"

#include <gtest/gtest.h>

#include "config/error.h"

namespace kinemesh::json_text_test {
namespace {

TEST(JsonText, NestingIsCountedOutsideStrings) {
  EXPECT_EQ(json_nesting(""), 0U);
  EXPECT_EQ(json_nesting(R"({"a": [1, {"b": []}], "c": {}})"), 4U);
  EXPECT_EQ(json_nesting(R"(["[[[", "\"[[", "\\", [1]])"), 2U);
  EXPECT_EQ(json_nesting("]]][["), 2U);
}

TEST(JsonText, TooDeepIsRefusedWithTheFilesName) {
  EXPECT_NO_THROW(refuse_deep_json(std::string(100, '['), "a.json"));
  try {
    refuse_deep_json(std::string(100000, '['), "a.json");
    FAIL();
  } catch (const InputError& e) {
    EXPECT_EQ(e.details().file, "a.json");
    EXPECT_NE(std::string(e.what()).find("nested 100000 deep"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace kinemesh::json_text_test
