// One declaration per parameter. An options struct declares each field once, beside itself:
//
//   struct SmoothOptions {
//     double cutoff_hz = 6.0;
//     void declare(ParameterSet& p) {
//       p.group("smooth", "Smoothing of trajectories");
//       p.number("cutoff", cutoff_hz, {.unit = "Hz", .min = 0.1, .max = 100, .help = "…"});
//     }
//     void validate() const { validate_options(*this); }
//   };
//
// TOML files, --dump-config, the command line, help texts, man pages and GUI panels are derived
// from it; the default is the field's initial value.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace kinemesh {

struct NumberSpec {
  std::string unit{};  ///< "mm", "s", "Hz"; empty for a pure number
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  std::string help;  ///< in the user's words, without unit, range and default
};

struct TextSpec {
  std::string metavar = "TEXT";
  std::string help;
};

/// One word a choice can take, and what it means.
struct ChoiceWord {
  std::string word;
  std::string help;
};

/// A declared parameter, bound to a field of an options struct.
class Parameter {
 public:
  enum class Kind { boolean, integer, number, choice, text, text_list };

  const std::string& name() const { return name_; }    ///< "max-gap": TOML key and --max-gap
  const std::string& group() const { return group_; }  ///< TOML table; empty for the top level
  const std::string& unit() const { return unit_; }
  const std::string& help() const { return help_; }
  const std::string& metavar() const { return metavar_; }
  Kind kind() const { return kind_; }
  double min() const { return min_; }
  double max() const { return max_; }
  const std::vector<ChoiceWord>& words() const { return words_; }

  /// Sets the field from the words of a command line or file (several only for a text_list).
  /// Throws UsageError that says which parameter, what was given and what is allowed.
  void set(const std::vector<std::string>& values);
  /// The field's value as a user would type it; one word per entry of a list.
  std::vector<std::string> get() const;
  /// The field's value as TOML.
  std::string toml() const;
  /// Throws UsageError when the field's value is outside its range (or not finite).
  void check() const;
  /// "0.1 to 100 Hz", "linear, cubic or auto", "yes or no".
  std::string allowed() const;

 private:
  friend class ParameterSet;
  struct ChoiceBinding {
    std::function<void(std::size_t)> set;
    std::function<std::size_t()> get;
  };
  using Target = std::variant<bool*, int*, int64_t*, double*, std::string*,
                              std::vector<std::string>*, ChoiceBinding>;
  [[noreturn]] void refuse(const std::string& given) const;

  std::string name_, group_, unit_, help_, metavar_;
  Kind kind_ = Kind::number;
  double min_ = 0.0, max_ = 0.0;
  std::vector<ChoiceWord> words_;
  Target target_;
};

/// A choice's value beside its word and meaning.
template <class E>
struct Choice {
  E value;
  std::string word;
  std::string help;
};

class ParameterSet {
 public:
  /// Parameters declared from here on belong to this TOML table and help heading.
  void group(std::string name, std::string title);

  void flag(std::string name, bool& field, std::string help);
  void number(std::string name, double& field, NumberSpec spec);
  void number(std::string name, int& field, NumberSpec spec);
  void number(std::string name, int64_t& field, NumberSpec spec);
  void text(std::string name, std::string& field, TextSpec spec);
  void list(std::string name, std::vector<std::string>& field, TextSpec spec);

  template <class E>
  void choice(std::string name, E& field, std::vector<Choice<E>> choices, std::string help) {
    Parameter& p = add(std::move(name), Parameter::Kind::choice, std::move(help));
    std::vector<E> values;
    for (Choice<E>& c : choices) {
      p.words_.push_back({std::move(c.word), std::move(c.help)});
      values.push_back(c.value);
    }
    p.target_ = Parameter::ChoiceBinding{[&field, values](std::size_t i) { field = values.at(i); },
                                         [&field, values] {
                                           std::size_t i = 0;
                                           while (i < values.size() && values[i] != field) ++i;
                                           return i;
                                         }};
  }

  std::vector<Parameter>& parameters() { return parameters_; }
  const std::vector<Parameter>& parameters() const { return parameters_; }
  /// Title of a group, for help headings.
  const std::string& title(std::string_view group) const;
  /// Null when no parameter has this name.
  Parameter* find(std::string_view name);

  /// Checks every field against its declaration. Throws UsageError for the first wrong one.
  void check() const;
  /// All values as a TOML document, each with its help, unit and range as a comment.
  std::string dump_toml() const;
  /// Sets fields from a TOML document. Throws UsageError naming file, line and key for a syntax
  /// error, an unknown key (with the nearest known one) or a value that is not allowed.
  void load_toml(std::string_view text, const std::string& file_name);

 private:
  Parameter& add(std::string name, Parameter::Kind kind, std::string help);

  struct Group {
    std::string name, title;
  };
  std::vector<Group> groups_;
  std::string current_group_;
  std::vector<Parameter> parameters_;
};

/// The body of every options struct's validate(): checks each field against its declaration.
template <class Options>
void validate_options(const Options& options) {
  Options copy = options;  // declare() binds fields by reference and so needs a mutable object
  ParameterSet set;
  copy.declare(set);
  set.check();
}

}  // namespace kinemesh
