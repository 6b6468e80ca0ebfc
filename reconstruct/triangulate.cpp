#include "reconstruct/triangulate.h"

#include <algorithm>
#include <chrono>

#include "config/error.h"
#include "reconstruct/canonical_pose.h"
#include "reconstruct/reference_frame.h"
#include "reconstruct/surface.h"

namespace kinemesh {
namespace {

/// Marker indices of "A:B" constraints; labels may hold colons themselves.
std::vector<DirectedEdge> parse_edges(const MarkerSequence& take,
                                      const std::vector<std::string>& texts) {
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
      throw UsageError({.what = "'" + text + "' does not name two markers of the mesh as A:B",
                        .file = take.origin.path});
    }
  }
  return edges;
}

/// Indices of the canonical order for constraints in the take's.
std::vector<DirectedEdge> renumbered(const std::vector<DirectedEdge>& edges,
                                     const std::vector<VertexIndex>& position) {
  std::vector<DirectedEdge> out;
  for (const auto& [a, b] : edges) {
    out.push_back({std::min(position[a], position[b]), std::max(position[a], position[b])});
  }
  return out;
}

double longest_rim_edge(const Topology& topology, const Points& points) {
  double longest = 0.0;
  for (const Edge& e : topology.edges()) {
    if (e.boundary())
      longest = std::max(longest, (points[e.vertices[0]] - points[e.vertices[1]]).norm());
  }
  return longest;
}

/// All boundary loops but the rim, which is the longest one, mm.
std::vector<Opening> gaps_of(const Topology& topology, const Points& points) {
  std::vector<Opening> gaps;
  double longest = -1.0;
  std::size_t rim = 0;
  for (const auto& loop : topology.boundary_loops()) {
    double length = 0.0;
    for (std::size_t i = 0; i < loop.size(); ++i) {
      length += (points[loop[i]] - points[loop[(i + 1) % loop.size()]]).norm();
    }
    if (length > longest) {
      longest = length;
      rim = gaps.size();
    }
    gaps.push_back({OpeningName::gap, loop, 0.0, false});
  }
  if (!gaps.empty()) gaps.erase(gaps.begin() + static_cast<std::ptrdiff_t>(rim));
  return gaps;
}

}  // namespace

void TriangulateOptions::declare(ParameterSet& p) {
  p.group("triangulate", "From markers to mesh");
  p.number("frame", frame,
           {.min = -1,
            .help = "number of the frame to triangulate; -1 for the first one in which all "
                    "markers are measured"});
  p.number("edge-bound", edge_bound,
           {.min = 1.2,
            .max = 10,
            .help = "longest edge to look for, in mean distances of a marker to its five nearest"});
  p.number("rim-bound", rim_bound,
           {.min = 1.0, .max = 10, .help = "longest edge to keep on the rim, in the same measure"});
  p.number(
      "hole-bound", hole_bound,
      {.min = 0.0, .max = 100, .help = "longest edge to close a hole with, in the same measure"});
  p.list("edge", edges, {.metavar = "A:B", .help = "join markers A and B by an edge"});
  p.list("no-edge", no_edges, {.metavar = "A:B", .help = "do not join markers A and B by an edge"});
  openings.declare(p);
}

TriangulateResult triangulate(const MarkerSequence& take, const TriangulateOptions& options,
                              const RunContext& ctx) {
  options.validate();
  if (take.marker_count() < 3) {
    throw NoResultError({.what = "a mesh needs at least three markers, but only " +
                                 std::to_string(take.marker_count()) + " are chosen",
                         .file = take.origin.path});
  }
  const ReferenceFrame reference = choose_reference_frame(take, options.frame);
  ctx.check_cancelled();
  const auto start = std::chrono::steady_clock::now();
  const CanonicalPose pose = canonical_pose(reference.points);
  std::vector<VertexIndex> position(pose.original.size());
  for (std::size_t i = 0; i < pose.original.size(); ++i)
    position[pose.original[i]] = static_cast<VertexIndex>(i);
  SurfaceOptions surface_options{options.edge_bound, options.rim_bound, options.hole_bound,
                                 renumbered(parse_edges(take, options.edges), position),
                                 renumbered(parse_edges(take, options.no_edges), position)};
  const Surface surface = reconstruct_surface(pose.points, surface_options);

  TriangulateResult result;
  std::vector<Triangle> faces;
  for (const auto& t : surface.mesh.triangles()) {
    faces.push_back({pose.original[t[0]], pose.original[t[1]], pose.original[t[2]]});
  }
  result.topology = Topology::create(take.marker_count(), std::move(faces));
  result.frame = reference.frame;
  result.frame_number = take.first_frame + static_cast<int64_t>(reference.frame);
  result.all_measured = reference.measured == take.marker_count();
  result.openings = gaps_of(*result.topology, reference.points);
  TriangulateDiagnostics& d = result.diagnostics;
  d.spacing = surface.spacing.mean;
  d.method = surface.method;
  d.bound = surface.bound;
  d.inserted = surface.inserted;
  d.holes_filled = surface.holes_filled;
  d.rim_faces_trimmed = surface.rim_faces_trimmed;
  d.flips = surface.flips;
  d.outwardness = surface.outwardness;
  d.frames_measured = reference.frames_measured;
  d.longest_rim_edge =
      longest_rim_edge(*result.topology, reference.points) / std::max(d.spacing, 1e-12);
  d.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace kinemesh
