// Options that would do nothing beside the others: said instead of ignored.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "config/error.h"
#include "config/parameter.h"
#include "config/text.h"

namespace kinemesh {

/// Names of the parameters that differ from their default.
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

/// Throws UsageError when one of `names` is among those `changed`: it would do nothing `because`.
inline void refuse_idle(const std::vector<std::string>& changed,
                        std::initializer_list<std::string_view> names, const std::string& because,
                        const std::string& remedy) {
  for (const std::string_view name : names) {
    if (std::ranges::find(changed, name) == changed.end()) continue;
    throw UsageError(
        {.what = "--" + std::string(name) + " does nothing here: " + because, .remedy = remedy});
  }
}

}  // namespace kinemesh
