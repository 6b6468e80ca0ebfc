// Which options somebody changed.
#pragma once

#include <string>
#include <vector>

#include "config/parameter.h"

namespace kinemesh {

/// "--budget", …: the parameters whose values in `options` are not the standard ones.
template <class Options>
std::vector<std::string> changed_parameters(Options options) {
  Options standard;
  ParameterSet given_set, standard_set;
  options.declare(given_set);
  standard.declare(standard_set);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < given_set.parameters().size(); ++i) {
    const Parameter& p = given_set.parameters()[i];
    if (p.get() != standard_set.parameters()[i].get()) names.push_back("--" + p.name());
  }
  return names;
}

}  // namespace kinemesh
