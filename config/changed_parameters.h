// Which options somebody changed.
#pragma once

#include <string>
#include <vector>

#include "config/parameter.h"

namespace kinemesh {

/// Names ("budget", …) of the parameters whose values in `options` are not those in `plain`.
template <class Options>
std::vector<std::string> changed_parameters(const Options& options, const Options& plain = {}) {
  Options copy = options;
  Options standard = plain;
  ParameterSet given, defaults;
  copy.declare(given);
  standard.declare(defaults);
  std::vector<std::string> names;
  for (const Parameter& p : given.parameters()) {
    if (p.get() != defaults.find(p.name())->get()) names.push_back(p.name());
  }
  return names;
}

/// The same as a user gives them: "--budget", ….
template <class Options>
std::vector<std::string> changed_options(const Options& options, const Options& plain = {}) {
  std::vector<std::string> words = changed_parameters(options, plain);
  for (std::string& word : words) word.insert(0, "--");
  return words;
}

}  // namespace kinemesh
