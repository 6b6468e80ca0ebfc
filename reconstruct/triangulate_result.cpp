#include "reconstruct/triangulate_result.h"

#include <algorithm>
#include <string>

#include "config/text.h"

namespace kinemesh {
namespace {

double longest_rim_edge(const Topology& topology, const Points& points) {
  double longest = 0.0;
  for (const Edge& e : topology.edges()) {
    if (e.boundary())
      longest = std::max(longest, (points[e.vertices[0]] - points[e.vertices[1]]).norm());
  }
  return longest;
}

/// The boundary loops of the result but the rim: those that were cut keep their names, others are
/// gaps. The rim is the longest loop that was not cut.
std::vector<Opening> name_loops(const Topology& topology, const Points& points,
                                const std::vector<Opening>& cut) {
  std::vector<Opening> named, gaps;
  double longest = -1.0;
  std::size_t rim = 0;
  for (const auto& loop : topology.boundary_loops()) {
    const auto found = std::find_if(cut.begin(), cut.end(), [&](const Opening& o) {
      return std::find(loop.begin(), loop.end(), o.loop.front()) != loop.end();
    });
    if (found != cut.end()) {
      named.push_back({found->name, loop, found->score, found->forced});
      continue;
    }
    if (perimeter(loop, points) > longest) {
      longest = perimeter(loop, points);
      rim = gaps.size();
    }
    gaps.push_back({OpeningName::gap, loop, 0.0, false});
  }
  std::sort(named.begin(), named.end(), [](auto& a, auto& b) { return a.name < b.name; });
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    if (i != rim) named.push_back(std::move(gaps[i]));
  }
  return named;
}

void add_warnings(TriangulateResult& result, const MarkerSequence& take) {
  TriangulateDiagnostics& d = result.diagnostics;
  const auto warn = [&d](std::string text) { d.warnings.push_back(std::move(text)); };
  if (!result.all_measured && d.frames_measured > 0) {
    warn("frame " + std::to_string(result.frame_number) +
         ", as asked for, was triangulated with filled samples; in " +
         count_of(d.frames_measured, "other frame") + " all markers are measured");
  } else if (!result.all_measured) {
    warn("in no frame are all markers measured: frame " + std::to_string(result.frame_number) +
         " was triangulated with filled samples");
  }
  if (d.method.ends_with("chart")) warn("the markers were triangulated on a " + d.method);
  constexpr double flat = 0.005;
  if (d.outwardness < flat) warn("the markers are almost flat: which side is outside is a guess");
  if (d.jump_samples > 0) {
    warn(std::to_string(d.jump_samples) + " of " + std::to_string(take.sample_count()) +
         " samples lie beyond jumps of their marker and were left out of the search for openings");
  }
}

}  // namespace

double perimeter(const std::vector<VertexIndex>& loop, const Points& points) {
  double length = 0.0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    length += (points[loop[i]] - points[loop[(i + 1) % loop.size()]]).norm();
  }
  return length;
}

void describe_result(TriangulateResult& result, const MarkerSequence& take,
                     const ReferenceFrame& reference, double spacing,
                     const std::vector<Opening>& cut) {
  result.frame = reference.frame;
  result.frame_number = take.first_frame + static_cast<int64_t>(reference.frame);
  result.all_measured = reference.measured == take.marker_count();
  result.openings = name_loops(*result.topology, reference.points, cut);
  TriangulateDiagnostics& d = result.diagnostics;
  d.spacing = spacing;
  d.frames_measured = reference.frames_measured;
  d.longest_rim_edge =
      longest_rim_edge(*result.topology, reference.points) / std::max(spacing, 1e-12);
  add_warnings(result, take);
}

}  // namespace kinemesh
