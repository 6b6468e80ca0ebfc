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

double perimeter(const std::vector<VertexIndex>& loop, const Points& points) {
  double length = 0.0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    length += (points[loop[i]] - points[loop[(i + 1) % loop.size()]]).norm();
  }
  return length;
}

/// The boundary loops of the result but the rim: those that were cut keep their names, others are
/// gaps. The rim is the longest loop that was not cut.
std::vector<Opening> name_loops(const Topology& topology, const Points& points,
                                const std::vector<Opening>& cut,
                                const std::vector<VertexIndex>& original) {
  std::vector<Opening> named, gaps;
  double longest = -1.0;
  std::size_t rim = 0;
  for (const auto& loop : topology.boundary_loops()) {
    const auto found = std::find_if(cut.begin(), cut.end(), [&](const Opening& o) {
      return std::find(loop.begin(), loop.end(), original[o.loop.front()]) != loop.end();
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

std::shared_ptr<const Topology> to_topology(const EditMesh& mesh,
                                            const std::vector<VertexIndex>& original) {
  std::vector<Triangle> faces;
  for (const auto& t : mesh.triangles())
    faces.push_back({original[t[0]], original[t[1]], original[t[2]]});
  return Topology::create(mesh.vertex_count(), std::move(faces));
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void add_warnings(TriangulateResult& result, const MarkerSequence& take) {
  TriangulateDiagnostics& d = result.diagnostics;
  const auto warn = [&d](std::string text) { d.warnings.push_back(std::move(text)); };
  if (!result.all_measured) {
    warn("in no frame are all markers measured: frame " + std::to_string(result.frame_number) +
         " was triangulated with filled samples");
  }
  if (d.method != "advancing front") warn("the markers were triangulated on a " + d.method);
  constexpr double flat = 0.005;
  if (d.outwardness < flat) warn("the markers are almost flat: which side is outside is a guess");
  if (d.jump_samples > 0) {
    warn(std::to_string(d.jump_samples) + " of " + std::to_string(take.sample_count()) +
         " samples lie beyond jumps of their marker and were left out of the search for openings");
  }
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
  Surface surface = reconstruct_surface(pose.points, surface_options);
  const double geometry_seconds = seconds_since(start);
  OpeningSearch search =
      cut_openings(surface.mesh, pose.points, surface.spacing.mean, take, pose.original,
                   options.openings, {surface_options.edges, surface_options.no_edges}, ctx);

  TriangulateResult result;
  result.topology = to_topology(surface.mesh, pose.original);
  result.frame = reference.frame;
  result.frame_number = take.first_frame + static_cast<int64_t>(reference.frame);
  result.all_measured = reference.measured == take.marker_count();
  result.openings = name_loops(*result.topology, reference.points, search.openings, pose.original);
  result.candidates = std::move(search.candidates);
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
  d.jump_samples = search.jump_samples;
  d.seconds = geometry_seconds;
  add_warnings(result, take);
  return result;
}

}  // namespace kinemesh
