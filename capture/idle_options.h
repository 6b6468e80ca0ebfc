// Options that would do nothing beside the others: said instead of ignored.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "config/changed_parameters.h"
#include "config/error.h"

namespace kinemesh {

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
