#include "capture/marker_name.h"

#include <algorithm>

#include "config/error.h"
#include "config/text.h"

namespace kinemesh {

std::size_t marker_meant(const std::vector<Marker>& markers, const std::string& name,
                         const std::string& who) {
  std::vector<std::string> labels;
  std::vector<std::string> owners;
  std::size_t found = MarkerSequence::npos;
  for (std::size_t m = 0; m < markers.size(); ++m) {
    const Marker& marker = markers[m];
    labels.push_back(marker.label);
    if (marker.label != name) {
      if (marker.subject.empty() || marker.subject + ":" + marker.label != name) continue;
      return m;
    }
    if (found == MarkerSequence::npos) found = m;
    if (std::ranges::find(owners, marker.subject) == owners.end()) {
      owners.push_back(marker.subject);
    }
  }
  if (owners.size() > 1) {
    std::vector<std::string> full;
    for (const std::string& owner : owners) {
      std::string quoted = "\"";
      if (!owner.empty()) quoted.append(owner).append(":");
      full.push_back(quoted.append(name).append("\""));
    }
    throw UsageError({.what = who + " \"" + name + "\", which several subjects have",
                      .marker = name,
                      .remedy = "Say which one: " + join(full, ", ", " or ")});
  }
  if (found != MarkerSequence::npos) return found;
  const std::string near = nearest_word(name, labels);
  throw UsageError({.what = who + " no marker of the take: \"" + name + "\"",
                    .marker = name,
                    .remedy = near.empty() ? "See the labels with \"kinemesh c3d info\""
                                           : "Did you mean \"" + near + "\"?"});
}

}  // namespace kinemesh
