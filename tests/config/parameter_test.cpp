#include "config/parameter.h"

#include <gtest/gtest.h>

#include "config/error.h"

namespace kinemesh::parameter_test {
namespace {

enum class Fill { none, spline };

struct Options {
  double cutoff_hz = 6.0;
  int order = 4;
  bool zero_phase = true;
  Fill fill = Fill::spline;
  std::vector<std::string> markers{"a", "b \"c\""};
  std::string note;

  void declare(ParameterSet& p) {
    p.group("filter", "Filtering");
    p.number("cutoff", cutoff_hz, {.unit = "Hz", .min = 0.1, .max = 100, .help = "cut-off"});
    p.number("order", order, {.min = 1, .max = 8, .help = "order"});
    p.flag("zero-phase", zero_phase, "both ways");
    p.group("gaps", "Gaps");
    p.choice("fill", fill, {{Fill::none, "none", "leave"}, {Fill::spline, "spline", "fill"}},
             "how");
    p.list("markers", markers, {.help = "which"});
    p.text("note", note, {.help = "free text"});
  }
  void validate() const { validate_options(*this); }
};

std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const UsageError& e) {
    return e.what();
  }
  return "no error";
}

TEST(Parameter, DumpedTomlLoadsBackAlike) {
  Options written;
  written.cutoff_hz = 0.1 + 0.2;
  written.fill = Fill::none;
  written.note = "tab\t and \"quotes\"";
  ParameterSet from;
  written.declare(from);
  Options read;
  read.markers.clear();
  ParameterSet to;
  read.declare(to);
  to.load_toml(from.dump_toml(), "x.toml");
  EXPECT_EQ(read.cutoff_hz, written.cutoff_hz);
  EXPECT_EQ(read.fill, Fill::none);
  EXPECT_EQ(read.markers, written.markers);
  EXPECT_EQ(read.note, written.note);
}

TEST(Parameter, WrongValueSaysWhatWasGivenAndWhatIsAllowed) {
  Options options;
  ParameterSet set;
  options.declare(set);
  EXPECT_EQ(message_of([&] { set.find("cutoff")->set({"500"}); }),
            "option 'cutoff': it was given as '500', but must be a number from 0.1 to 100 Hz");
  EXPECT_EQ(message_of([&] { set.find("order")->set({"2.5"}); }),
            "option 'order': it was given as '2.5', but must be a whole number from 1 to 8");
  EXPECT_EQ(message_of([&] { set.find("fill")->set({"cubic"}); }),
            "option 'fill': it was given as 'cubic', but must be none or spline");
  EXPECT_EQ(message_of([&] { set.find("zero-phase")->set({"maybe"}); }),
            "option 'zero-phase': it was given as 'maybe', but must be true or false");
  EXPECT_EQ(options.cutoff_hz, 6.0);
}

TEST(Parameter, NotANumberIsRefused) {
  Options options;
  options.cutoff_hz = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(options.validate(), UsageError);
  ParameterSet set;
  options.declare(set);
  EXPECT_THROW(set.find("cutoff")->set({"nan"}), UsageError);
  EXPECT_THROW(set.find("cutoff")->set({""}), UsageError);
  EXPECT_THROW(set.find("order")->set({"1e300"}), UsageError);
}

TEST(Parameter, UnknownKeyNamesLineAndNearest) {
  Options options;
  ParameterSet set;
  options.declare(set);
  EXPECT_EQ(message_of([&] { set.load_toml("[filter]\norder = 2\ncutof = 3\n", "o.toml"); }),
            "o.toml: line 3: unknown option 'cutof' in table [filter]. Did you mean 'cutoff' in "
            "table [filter]?");
  EXPECT_EQ(message_of([&] { set.load_toml("[filter]\ncutoff = 500\n", "o.toml"); }),
            "o.toml: line 2: option 'cutoff': it was given as '500', but must be a number from 0.1 "
            "to 100 Hz");
  EXPECT_THROW(set.load_toml("[filter\n", "o.toml"), UsageError);
  EXPECT_THROW(set.load_toml("[filter]\ncutoff = [1, 2]\n", "o.toml"), UsageError);
}

}  // namespace
}  // namespace kinemesh::parameter_test
