#include "config/text.h"

#include <gtest/gtest.h>

namespace kinemesh::text_test {
namespace {

TEST(Text, NumbersReadBackAndIgnoreTheLocale) {
  EXPECT_EQ(format_number(0.1), "0.1");
  EXPECT_EQ(format_number(120.0), "120");
  EXPECT_EQ(format_number(1e-7), "1e-07");
  EXPECT_EQ(format_fixed(2.345, 1), "2.3");
  EXPECT_EQ(format_fixed(1e300, 0).size(), 301U);
}

TEST(Text, Wildcards) {
  EXPECT_TRUE(matches_wildcard("head*", "HeadFront"));
  EXPECT_TRUE(matches_wildcard("*-?", "section3-2"));
  EXPECT_TRUE(matches_wildcard("a*b*c", "axxbyybc"));
  EXPECT_FALSE(matches_wildcard("a*b*c", "axxbyyb"));
  EXPECT_FALSE(matches_wildcard("head", "headx"));
  EXPECT_TRUE(matches_wildcard("*", ""));
  EXPECT_FALSE(matches_wildcard("?", ""));
}

TEST(Text, NearestWordIsCloseOrNone) {
  EXPECT_EQ(nearest_word("cutof", {"order", "cutoff"}), "cutoff");
  EXPECT_EQ(nearest_word("zzzz", {"order", "cutoff"}), "");
}

TEST(Text, JoinTrimCount) {
  EXPECT_EQ(join({"a", "b", "c"}, ", ", " and "), "a, b and c");
  EXPECT_EQ(join({}, ", "), "");
  EXPECT_EQ(trim("  x y\r\n"), "x y");
  EXPECT_EQ(count_of(1, "marker"), "1 marker");
  EXPECT_EQ(count_of(2, "vertex", "vertices"), "2 vertices");
}

}  // namespace
}  // namespace kinemesh::text_test
