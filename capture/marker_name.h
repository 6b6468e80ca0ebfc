// The one marker that a user means by a name.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "capture/marker_sequence.h"

namespace kinemesh {

/// Index of the first marker called `name` ("label" or "subject:label"). Throws UsageError when
/// there is none (naming the nearest) and when a label without a subject is that of markers of
/// several subjects. `who`: how the message begins, such as "--donor names".
std::size_t marker_meant(const std::vector<Marker>& markers, const std::string& name,
                         const std::string& who);

}  // namespace kinemesh
