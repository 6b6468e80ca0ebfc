#include "reconstruct/named_constraints.h"

#include <algorithm>

#include "config/error.h"
#include "config/text.h"

namespace kinemesh {
namespace {

std::string what_is_missing(const MarkerSequence& take, const std::string& text) {
  const auto colon = text.find(':');
  if (colon == std::string::npos) return "this is not of the form A:B";
  for (const std::string& label : {text.substr(0, colon), text.substr(colon + 1)}) {
    if (take.find(label) == MarkerSequence::npos) {
      return "the mesh has no marker '" + label + "'";
    }
  }
  return "both markers are the same";
}

/// Marker indices of "A:B" constraints; labels may hold colons themselves.
std::vector<DirectedEdge> parse_edges(const MarkerSequence& take,
                                      const std::vector<std::string>& texts,
                                      const std::string& option) {
  std::vector<DirectedEdge> edges;
  for (const std::string& text : texts) {
    bool found = false;
    for (auto colon = text.find(':'); colon != std::string::npos && !found;
         colon = text.find(':', colon + 1)) {
      const std::size_t a = take.find(text.substr(0, colon));
      const std::size_t b = take.find(text.substr(colon + 1));
      if (a == MarkerSequence::npos || b == MarkerSequence::npos || a == b) continue;
      edges.push_back(
          {static_cast<VertexIndex>(std::min(a, b)), static_cast<VertexIndex>(std::max(a, b))});
      found = true;
    }
    if (!found) {
      throw UsageError({.what = join({"--" + option, text + ":", what_is_missing(take, text)}, " "),
                        .file = take.origin.path,
                        .remedy = "Name two markers of the mesh as A:B"});
    }
  }
  return edges;
}

}  // namespace

EdgeConstraints named_constraints(const MarkerSequence& take, const std::vector<std::string>& edges,
                                  const std::vector<std::string>& no_edges) {
  EdgeConstraints constraints{parse_edges(take, edges, "edge"),
                              parse_edges(take, no_edges, "no-edge")};
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (std::ranges::find(constraints.no_edges, constraints.edges[i]) ==
        constraints.no_edges.end()) {
      continue;
    }
    throw UsageError({.what = "--edge " + edges[i] + " is forbidden by --no-edge",
                      .file = take.origin.path,
                      .remedy = "Leave one of both out"});
  }
  return constraints;
}

EdgeConstraints renumbered(EdgeConstraints constraints, const std::vector<VertexIndex>& position) {
  for (auto* list : {&constraints.edges, &constraints.no_edges}) {
    for (auto& [a, b] : *list) {
      a = position[a];
      b = position[b];
      if (a > b) std::swap(a, b);
    }
  }
  return constraints;
}

void refuse_unmet(const EdgeConstraints& unmet, const MarkerSequence& take) {
  if (unmet.empty()) return;
  const bool wanted = !unmet.edges.empty();
  const auto [a, b] = wanted ? unmet.edges.front() : unmet.no_edges.front();
  const std::string names = take.markers()[a].label + " and " + take.markers()[b].label;
  throw UsageError(
      {.what = "the markers " + names +
               (wanted ? " cannot be joined by an edge" : " cannot be left without an edge"),
       .file = take.origin.path,
       .remedy =
           wanted ? "Markers far apart, or with another wanted edge between them, cannot be joined"
                  : "The mesh would lose a marker without it"});
}

}  // namespace kinemesh
