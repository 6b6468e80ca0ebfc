#include "capture/edit_list.h"

#include <algorithm>

#include "capture/edit/operation.h"
#include "config/error.h"
#include "config/input_file.h"
#include "config/text.h"
#include "config/toml_steps.h"

namespace kinemesh {
namespace {

std::shared_ptr<EditOperation> operation_named(const std::string& name) {
  auto operation = make_operation(name);
  if (operation) return operation;
  const std::string near = nearest_word(name, operation_names());
  throw UsageError({.what = "there is no editing step '" + name + "'",
                    .remedy = near.empty()
                                  ? "The steps are " + join(operation_names(), ", ", " and ")
                                  : "Did you mean '" + near + "'?"});
}

void assign(EditOperation& operation, const std::string& key, const std::vector<std::string>& words,
            bool list) {
  ParameterSet parameters;
  operation.declare(parameters);
  Parameter* parameter = parameters.find(key);
  if (parameter == nullptr) {
    std::vector<std::string> known;
    for (const Parameter& p : parameters.parameters()) known.push_back(p.name());
    throw UsageError(
        {.what = "the step '" + std::string(operation.name()) + "' has no parameter '" + key + "'",
         .remedy = known.empty() ? "It has none" : "It has " + join(known, ", ", " and ")});
  }
  if (list && parameter->kind() != Parameter::Kind::text_list) {
    throw UsageError({.what = "'" + key + "' is a list, but must be " + parameter->allowed()});
  }
  parameter->set(words);
}

/// Says where a step stands that could not be read or applied.
[[noreturn]] void rethrow_at(const UsageError& error, const std::string& file,
                             const std::string& place) {
  ErrorDetails details = error.details();
  if (!details.place.empty()) details.what = details.place + ": " + details.what;
  details.file = file;
  details.place = place;
  throw UsageError(details);
}

std::shared_ptr<EditOperation> operation_from(const TomlStep& step, const std::string& file) {
  const auto place = [](std::size_t line) { return "line " + std::to_string(line); };
  const auto name = std::ranges::find(step.values, "do", &TomlStep::Value::key);
  if (name == step.values.end() || name->list) {
    throw UsageError(
        {.what = "an [[edit]] does not say what to do",
         .file = file,
         .place = place(step.line),
         .remedy = "Add do = \"…\" with one of " + join(operation_names(), ", ", " and ")});
  }
  std::size_t line = name->line;
  try {
    auto operation = operation_named(name->words.front());
    for (const TomlStep::Value& value : step.values) {
      line = value.line;
      if (value.key != "do") assign(*operation, value.key, value.words, value.list);
    }
    return operation;
  } catch (const UsageError& e) {
    rethrow_at(e, file, place(line));
  }
}

}  // namespace

EditList parse_edits(std::string_view toml, const std::string& file_name) {
  EditList edits;
  for (const TomlStep& step : read_toml_steps(toml, file_name, "edit")) {
    edits.steps.push_back(operation_from(step, file_name));
  }
  return edits;
}

EditList read_edits(const std::filesystem::path& path) {
  EditList edits = parse_edits(read_file(path), path.string());
  edits.folder = path.parent_path();
  return edits;
}

std::string edits_toml(const EditList& edits) {
  std::string out = "# Kinemesh edit list: kinemesh c3d process IN -o OUT --edits THIS\n";
  for (const auto& step : edits.steps) {
    out += "\n[[edit]]\ndo = " + quote_toml(step->name()) + "\n";
    // declare() binds fields of an object that may change.
    auto& bound = const_cast<EditOperation&>(*step);  // NOLINT(*-const-cast): only read here
    const auto plain = make_operation(step->name());
    ParameterSet values, defaults;
    bound.declare(values);
    plain->declare(defaults);
    for (const Parameter& p : values.parameters()) {
      if (p.get() != defaults.find(p.name())->get()) out += p.name() + " = " + p.toml() + "\n";
    }
  }
  return out;
}

std::shared_ptr<const EditOperation> make_edit(
    std::string_view operation,
    const std::vector<std::pair<std::string, std::vector<std::string>>>& values) {
  auto step = operation_named(std::string(operation));
  for (const auto& [key, words] : values) assign(*step, key, words, false);
  return step;
}

std::vector<std::filesystem::path> files_read(const EditList& edits) {
  std::vector<std::filesystem::path> all;
  for (const auto& step : edits.steps) {
    for (const std::string& file : step->files()) {
      if (!file.empty()) all.push_back(edits.folder / file);
    }
  }
  return all;
}

EditResult apply_edits(const MarkerSequence& take, const EditList& edits, const RunContext& ctx) {
  EditResult result{take, {}};
  const auto count = static_cast<double>(edits.steps.size());
  for (std::size_t i = 0; i < edits.steps.size(); ++i) {
    ctx.check_cancelled();
    const EditOperation& step = *edits.steps[i];
    const auto at = static_cast<double>(i);
    const EditContext context{edits.folder,
                              ctx.part(at / count, (at + 1.0) / count, std::string(step.name()))};
    try {
      result.done.push_back(step.apply(result.take, context));
    } catch (const UsageError& e) {
      rethrow_at(e, e.details().file,
                 "edit " + std::to_string(i + 1) + " (" + std::string(step.name()) + ")");
    }
  }
  ctx.progress(1.0);
  return result;
}

}  // namespace kinemesh
