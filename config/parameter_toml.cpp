// TOML in and out of a ParameterSet.
#define TOML_ENABLE_FORMATTERS 0
#include <toml++/toml.h>

#include <sstream>

#include "config/error.h"
#include "config/parameter.h"
#include "config/text.h"
#include "config/toml_steps.h"

namespace kinemesh {
namespace {

std::string place_of(const toml::node& node) {
  return "line " + std::to_string(node.source().begin.line);
}

/// A scalar node as the word a user would type; arrays give several.
std::vector<std::string> words_of(const toml::node& node) {
  if (const auto* array = node.as_array()) {
    std::vector<std::string> words;
    for (const toml::node& item : *array) {
      for (std::string& word : words_of(item)) words.push_back(std::move(word));
    }
    return words;
  }
  if (const auto* text = node.as_string()) return {text->get()};
  if (const auto* flag = node.as_boolean()) return {flag->get() ? "true" : "false"};
  if (const auto* integer = node.as_integer()) return {std::to_string(integer->get())};
  if (const auto* number = node.as_floating_point()) return {format_number(number->get())};
  return {"?"};
}

toml::table parse(std::string_view text, const std::string& file_name) {
  try {
    return toml::parse(text);
  } catch (const toml::parse_error& e) {
    throw UsageError({.what = "not valid TOML: " + std::string(e.description()),
                      .file = file_name,
                      .place = "line " + std::to_string(e.source().begin.line)});
  }
}

class Loader {
 public:
  Loader(ParameterSet& set, const std::string& file) : set_(set), file_(file) {}

  void load(const toml::table& table, const std::string& group) {
    for (const auto& [key, node] : table) {
      const std::string name(key.str());
      if (const auto* inner = node.as_table(); inner != nullptr && group.empty()) {
        load(*inner, name);
      } else {
        assign(group, name, node);
      }
    }
  }

 private:
  void assign(const std::string& group, const std::string& name, const toml::node& node) {
    Parameter* parameter = set_.find(name);
    if (parameter == nullptr || parameter->group() != group) refuse_unknown(group, name, node);
    try {
      if (node.is_array() && parameter->kind() != Parameter::Kind::text_list) {
        throw UsageError({.what = "it is a list, but must be " + parameter->allowed(),
                          .place = "option '" + name + "'"});
      }
      parameter->set(words_of(node));
    } catch (const UsageError& e) {
      throw UsageError({.what = e.details().place + ": " + e.details().what,
                        .file = file_,
                        .place = place_of(node)});
    }
  }

  [[noreturn]] void refuse_unknown(const std::string& group, const std::string& name,
                                   const toml::node& node) const {
    std::vector<std::string> known;
    for (const Parameter& p : set_.parameters()) known.push_back(p.name());
    const std::string nearest = nearest_word(name, known);
    std::string remedy = "See --dump-config for all options";
    if (!nearest.empty()) {
      const std::string& table = set_.find(nearest)->group();
      remedy = "Did you mean '" + nearest + "'" +
               (table.empty() ? " at the top level?" : " in table [" + table + "]?");
    }
    throw UsageError({.what = "unknown option '" + name + "'" +
                              (group.empty() ? "" : " in table [" + group + "]"),
                      .file = file_,
                      .place = place_of(node),
                      .remedy = remedy});
  }

  ParameterSet& set_;
  const std::string& file_;
};

}  // namespace

void ParameterSet::load_toml(std::string_view text, const std::string& file_name) {
  Loader(*this, file_name).load(parse(text, file_name), "");
}

std::vector<TomlStep> read_toml_steps(std::string_view text, const std::string& file_name,
                                      const std::string& array) {
  std::vector<TomlStep> steps;
  const auto refuse = [&](const toml::node& node, const std::string& what) {
    throw UsageError({.what = what, .file = file_name, .place = place_of(node)});
  };
  const toml::table document = parse(text, file_name);
  for (const auto& [key, node] : document) {
    const toml::array* tables = node.as_array();
    if (key.str() != array || tables == nullptr) {
      refuse(node, "'" + std::string(key.str()) + "' does not belong here; there must be [[" +
                       array + "]] tables alone");
    }
    for (const toml::node& item : *tables) {
      const toml::table* table = item.as_table();
      if (table == nullptr) refuse(item, "'" + array + "' must be a list of tables");
      TomlStep step{.line = item.source().begin.line, .values = {}};
      for (const auto& [name, value] : *table) {
        if (value.is_table()) refuse(value, "'" + std::string(name.str()) + "' is a table");
        step.values.push_back({std::string(name.str()), words_of(value), value.is_array(),
                               value.source().begin.line});
      }
      steps.push_back(std::move(step));
    }
  }
  return steps;
}

std::string ParameterSet::dump_toml() const {
  std::ostringstream out;
  const auto dump_group = [&](const std::string& group) {
    for (const Parameter& p : parameters_) {
      if (p.group() != group) continue;
      out << "# " << p.help();
      if (p.kind() != Parameter::Kind::text && p.kind() != Parameter::Kind::text_list) {
        out << " (" << p.allowed() << ")";
      }
      out << "\n" << p.name() << " = " << p.toml() << "\n";
    }
  };
  dump_group("");
  for (const Group& group : groups_) {
    out << "\n# " << group.title << "\n[" << group.name << "]\n";
    dump_group(group.name);
  }
  return out.str();
}

}  // namespace kinemesh
