#include "reconstruct/triangulate.h"

#include <algorithm>
#include <chrono>

#include "config/error.h"
#include "reconstruct/canonical_pose.h"
#include "reconstruct/named_constraints.h"
#include "reconstruct/reference_frame.h"
#include "reconstruct/surface.h"
#include "reconstruct/triangulate_result.h"

namespace kinemesh {
namespace {

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
  const EdgeConstraints wanted = named_constraints(take, options.edges, options.no_edges);
  const SurfaceOptions surface_options{options.edge_bound, options.rim_bound, options.hole_bound,
                                       renumbered(wanted, position)};
  Surface surface = reconstruct_surface(pose.points, surface_options, ctx);
  refuse_unmet(renumbered(surface.unmet, pose.original), take);
  OpeningSearch search =
      cut_openings(surface.mesh, pose.points, surface.spacing.mean, take, pose.original,
                   options.openings, surface_options.constraints, ctx);

  TriangulateResult result;
  result.topology = to_topology(surface.mesh, pose.original);
  result.candidates = std::move(search.candidates);
  TriangulateDiagnostics& d = result.diagnostics;
  d.method = surface.method;
  d.bound = surface.bound;
  d.inserted = surface.inserted;
  d.holes_filled = surface.holes_filled;
  d.rim_faces_trimmed = surface.rim_faces_trimmed;
  d.flips = surface.flips;
  d.outwardness = surface.outwardness;
  d.jump_samples = search.jump_samples;
  for (Opening& o : search.openings) {
    for (VertexIndex& v : o.loop) v = pose.original[v];
  }
  d.seconds = seconds_since(start) - search.statistics_seconds;
  describe_result(result, take, reference, surface.spacing.mean, search.openings);
  return result;
}

}  // namespace kinemesh
