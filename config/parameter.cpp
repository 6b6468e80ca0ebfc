#include "config/parameter.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>

#include "config/error.h"
#include "config/text.h"

namespace kinemesh {
namespace {

template <class... Ts>
struct Overloaded : Ts... {
  using Ts::operator()...;
};
template <class... Ts>
Overloaded(Ts...) -> Overloaded<Ts...>;

/// The whole text as a number, or NaN.
double parse_number(std::string_view text) {
  double value = std::nan("");
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nan("");
  return value;
}

}  // namespace

std::string Parameter::allowed() const {
  if (kind_ == Kind::boolean) return "true or false";
  if (kind_ == Kind::choice) {
    std::vector<std::string> all;
    for (const ChoiceWord& w : words_) all.push_back(w.word);
    return join(all, ", ", " or ");
  }
  if (kind_ == Kind::text || kind_ == Kind::text_list) return "text";
  const std::string suffix = unit_.empty() ? "" : " " + unit_;
  const std::string what = kind_ == Kind::integer ? "a whole number" : "a number";
  const bool low = std::isfinite(min_);
  const bool high = std::isfinite(max_);
  if (low && high)
    return what + " from " + format_number(min_) + " to " + format_number(max_) + suffix;
  if (low) return what + " of at least " + format_number(min_) + suffix;
  if (high) return what + " of at most " + format_number(max_) + suffix;
  return unit_.empty() ? what : what + " in " + unit_;
}

void Parameter::refuse(const std::string& given) const {
  throw UsageError({.what = "it was given as '" + given + "', but must be " + allowed(),
                    .place = "option '" + name_ + "'"});
}

void Parameter::set(const std::vector<std::string>& values) {
  const std::string given = values.empty() ? "" : values.back();
  const auto set_integer = [&](auto* field) {
    const double value = parse_number(given);
    if (!(std::abs(value) <= 9e15) || value != std::floor(value) || value < min_ || value > max_) {
      refuse(given);
    }
    *field = static_cast<std::remove_pointer_t<decltype(field)>>(value);
  };
  const Overloaded assign{
      [&](bool* field) {
        if (given != "true" && given != "false" && given != "yes" && given != "no") refuse(given);
        *field = given == "true" || given == "yes";
      },
      [&](int* field) { set_integer(field); },
      [&](int64_t* field) { set_integer(field); },
      [&](double* field) {
        const double value = parse_number(given);
        if (!std::isfinite(value) || value < min_ || value > max_) refuse(given);
        *field = value;
      },
      [&](std::string* field) { *field = given; },
      [&](std::vector<std::string>* field) { *field = values; },
      [&](const ChoiceBinding& binding) {
        const auto it = std::ranges::find(words_, given, &ChoiceWord::word);
        if (it == words_.end()) refuse(given);
        binding.set(static_cast<std::size_t>(it - words_.begin()));
      }};
  std::visit(assign, target_);
}

std::vector<std::string> Parameter::get() const {
  const Overloaded read{
      [](const bool* field) { return std::vector<std::string>{*field ? "true" : "false"}; },
      [](const int* field) { return std::vector{std::to_string(*field)}; },
      [](const int64_t* field) { return std::vector{std::to_string(*field)}; },
      [](const double* field) { return std::vector{format_number(*field)}; },
      [](const std::string* field) { return std::vector{*field}; },
      [](const std::vector<std::string>* field) { return *field; },
      [this](const ChoiceBinding& binding) {
        const std::size_t i = binding.get();
        return std::vector{i < words_.size() ? words_[i].word : std::string("?")};
      }};
  return std::visit(read, target_);
}

std::string Parameter::toml() const {
  const std::vector<std::string> values = get();
  switch (kind_) {
    case Kind::boolean:
    case Kind::integer: return values.front();
    case Kind::number: {
      // TOML tells floats from integers by their look.
      const std::string& text = values.front();
      return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;
    }
    case Kind::choice:
    case Kind::text: return quote_toml(values.front());
    case Kind::text_list: {
      std::vector<std::string> quoted;
      for (const std::string& v : values) quoted.push_back(quote_toml(v));
      return "[" + join(quoted, ", ") + "]";
    }
  }
  return {};
}

void Parameter::check() const {
  const auto in_range = [this](double value) {
    if (!std::isfinite(value) || value < min_ || value > max_) refuse(format_number(value));
  };
  const Overloaded test{[](const bool*) {},
                        [&](const int* field) { in_range(*field); },
                        [&](const int64_t* field) { in_range(static_cast<double>(*field)); },
                        [&](const double* field) { in_range(*field); },
                        [](const std::string*) {},
                        [](const std::vector<std::string>*) {},
                        [&](const ChoiceBinding& binding) {
                          if (binding.get() >= words_.size()) refuse("?");
                        }};
  std::visit(test, target_);
}

Parameter& ParameterSet::add(std::string name, Parameter::Kind kind, std::string help) {
  if (find(name) != nullptr) throw InternalError("parameter '" + name + "' is declared twice");
  Parameter p;
  p.name_ = std::move(name);
  p.group_ = current_group_;
  p.kind_ = kind;
  p.help_ = std::move(help);
  parameters_.push_back(std::move(p));
  return parameters_.back();
}

void ParameterSet::group(std::string name, std::string title) {
  current_group_ = name;
  const auto known = std::ranges::find(groups_, name, &Group::name);
  if (known == groups_.end()) groups_.push_back({std::move(name), std::move(title)});
}

const std::string& ParameterSet::title(std::string_view group) const {
  static const std::string none;
  const auto it = std::ranges::find(groups_, group, &Group::name);
  return it == groups_.end() ? none : it->title;
}

void ParameterSet::flag(std::string name, bool& field, std::string help) {
  add(std::move(name), Parameter::Kind::boolean, std::move(help)).target_ = &field;
}

void ParameterSet::number(std::string name, double& field, NumberSpec spec) {
  Parameter& p = add(std::move(name), Parameter::Kind::number, std::move(spec.help));
  p.unit_ = std::move(spec.unit);
  p.min_ = spec.min;
  p.max_ = spec.max;
  p.target_ = &field;
}

void ParameterSet::number(std::string name, int& field, NumberSpec spec) {
  Parameter& p = add(std::move(name), Parameter::Kind::integer, std::move(spec.help));
  p.unit_ = std::move(spec.unit);
  p.min_ = std::max<double>(spec.min, std::numeric_limits<int>::min());
  p.max_ = std::min<double>(spec.max, std::numeric_limits<int>::max());
  p.target_ = &field;
}

void ParameterSet::number(std::string name, int64_t& field, NumberSpec spec) {
  Parameter& p = add(std::move(name), Parameter::Kind::integer, std::move(spec.help));
  p.unit_ = std::move(spec.unit);
  p.min_ = spec.min;
  p.max_ = spec.max;
  p.target_ = &field;
}

void ParameterSet::text(std::string name, std::string& field, TextSpec spec) {
  Parameter& p = add(std::move(name), Parameter::Kind::text, std::move(spec.help));
  p.metavar_ = std::move(spec.metavar);
  p.target_ = &field;
}

void ParameterSet::list(std::string name, std::vector<std::string>& field, TextSpec spec) {
  Parameter& p = add(std::move(name), Parameter::Kind::text_list, std::move(spec.help));
  p.metavar_ = std::move(spec.metavar);
  p.target_ = &field;
}

Parameter* ParameterSet::find(std::string_view name) {
  const auto it = std::ranges::find(parameters_, name, &Parameter::name);
  return it == parameters_.end() ? nullptr : &*it;
}

void ParameterSet::check() const {
  for (const Parameter& p : parameters_) p.check();
}

}  // namespace kinemesh
