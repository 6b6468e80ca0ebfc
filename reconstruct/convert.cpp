#include "reconstruct/convert.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

#include "capture/idle_options.h"
#include "config/error.h"
#include "config/text.h"
#include "reconstruct/named_constraints.h"
#include "reconstruct/reference_frame.h"
#include "reconstruct/topology_reuse.h"

namespace kinemesh {
namespace {

/// The session without what is neither vertex nor head rig, and where the vertices are in it.
struct Working {
  MarkerSequence take;
  std::vector<std::size_t> vertices;  ///< columns of `take` that become vertices, in their order
};

Working working_set(const MarkerSequence& session, const MarkerSelectionResult& selection) {
  std::vector<std::size_t> kept = selection.chosen;
  kept.insert(kept.end(), selection.head_rig.begin(), selection.head_rig.end());
  std::ranges::sort(kept);
  kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
  Working working{session.select(kept), {}};
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (std::ranges::binary_search(selection.chosen, kept[i])) working.vertices.push_back(i);
  }
  return working;
}

/// Brings the vertices into the order of the previous mesh, so that both takes share their indices;
/// markers that it does not have come last.
void order_like(const Mesh& previous, Working& working) {
  const auto place = [&](std::size_t column) {
    const Marker& marker = working.take.markers()[column];
    const auto& names = previous.vertex_names;
    auto it = std::ranges::find(names, marker.label);
    if (it == names.end()) it = std::ranges::find(names, marker.subject + ":" + marker.label);
    return it - names.begin();
  };
  std::ranges::stable_sort(working.vertices, {}, place);
}

void stabilise(Working& working, const ConvertOptions& options, ConvertResult& result,
               const RunContext& ctx) {
  StabiliseResult steady = stabilise_head(working.take, options.head, ctx);
  for (const std::size_t m : steady.shape.markers) {
    result.rigid.push_back(working.take.markers()[m].label);
  }
  result.head_poses = std::move(steady.poses);
  result.head_error_mm = steady.rms_error_mm;
  std::ranges::move(steady.warnings, std::back_inserter(result.warnings));
  working.take = std::move(steady.take);
}

/// One mesh over two heads is rarely meant.
void warn_of_subjects(ConvertResult& result) {
  std::set<std::string> subjects;
  for (const Marker& marker : result.markers) {
    if (!marker.subject.empty()) subjects.insert(marker.subject);
  }
  if (subjects.size() < 2) return;
  const std::vector<std::string> names(subjects.begin(), subjects.end());
  result.warnings.insert(result.warnings.begin(),
                         "the mesh joins markers of " + count_of(names.size(), "subject") + " (" +
                             join(names, ", ") + "): choose one with --subject");
}

/// Markers are found by name in other takes, in --edge and in --topology.
void warn_of_twins(ConvertResult& result) {
  std::map<std::string, std::size_t> counts;
  for (const Marker& marker : result.markers) ++counts[marker.subject + ":" + marker.label];
  for (const auto& [name, count] : counts) {
    if (count < 2) continue;
    const std::string label = name.starts_with(':') ? name.substr(1) : name;
    result.warnings.insert(result.warnings.begin(),
                           count_of(count, "marker") + " are called '" + label +
                               "': 'kinemesh c3d process' joins or renames them");
  }
}

/// A name or number that the take does not have is said before the work is done, not after it.
void refuse_unknown(const MarkerSequence& take, const TriangulateOptions& options) {
  named_constraints(take, options.edges, options.no_edges);
  if (options.frame != -1) frame_numbered(take, options.frame);
}

/// Fills all gaps and keeps the record of those that concern vertices.
MarkerSequence fill(const Working& working, const ConvertOptions& options, ConvertResult& result,
                    const RunContext& ctx) {
  GapFillResult filled = fill_gaps(working.take, options.gaps, ctx);
  std::vector<std::size_t> vertex_of(working.take.marker_count(), MarkerSequence::npos);
  for (std::size_t v = 0; v < working.vertices.size(); ++v) vertex_of[working.vertices[v]] = v;
  for (Fill f : filled.fills) {
    if (vertex_of[f.marker] == MarkerSequence::npos) continue;
    f.marker = vertex_of[f.marker];
    result.fills.push_back(f);
  }
  std::ranges::move(filled.warnings, std::back_inserter(result.warnings));
  return filled.take.select(working.vertices);
}

/// A forced edge that is much longer than the distance of markers usually joins the wrong ones.
void warn_of_long_edges(const MarkerSequence& faces, const ConvertOptions& options,
                        ConvertResult& result) {
  const TriangulateResult& t = result.triangulation;
  const double bound = options.triangulate.edge_bound * t.diagnostics.spacing;
  for (const auto& [a, b] : named_constraints(faces, options.triangulate.edges, {}).edges) {
    const float length = (faces.position(t.frame, a) - faces.position(t.frame, b)).norm();
    if (length <= bound) continue;
    result.warnings.push_back("the edge '" + faces.markers()[a].label + "' to '" +
                              faces.markers()[b].label + "', as asked for, is " +
                              format_fixed(length, 0) + " mm long, where markers are " +
                              format_fixed(t.diagnostics.spacing, 0) +
                              " mm apart: check the names, and that the openings are still right");
  }
}

void describe_source(const MarkerSequence& session, AnimatedMesh& mesh) {
  mesh.provenance.source = session.origin.manufacturer;
  mesh.events = session.events;
}

}  // namespace

void ConvertOptions::declare(ParameterSet& p) {
  selection.declare(p);
  p.group("head", "Head motion");
  p.flag("stabilise", stabilise, "remove the head's motion, so that only the face's own is left");
  head.declare(p);
  gaps.declare(p);
  triangulate.declare(p);
  carry.declare(p);
}

void ConvertOptions::validate() const {
  selection.validate();
  validate_options(*this);
  gaps.validate();
  if (!stabilise) {
    refuse_idle(changed_parameters(head), {"rigid", "reference-frame"},
                "the head's motion is not removed", "Add --stabilise, or leave it out");
  }
}

ConvertResult convert_session(const MarkerSequence& session, const ConvertOptions& options,
                              const std::optional<Mesh>& previous, const RunContext& ctx) {
  options.validate();
  if (session.frame_count() == 0) {
    throw NoResultError({.what = "the session has no frames", .file = session.origin.path});
  }
  ConvertResult result;
  result.selection =
      select_markers(session, options.selection, ctx.part(0.0, 0.02, "choosing markers"));
  result.warnings = result.selection.warnings;
  Working working = working_set(session, result.selection);
  refuse_unknown(working.take, options.triangulate);
  if (previous) order_like(*previous, working);
  if (options.stabilise) {
    stabilise(working, options, result, ctx.part(0.02, 0.15, "removing head motion"));
  }
  for (const std::size_t v : working.vertices) {
    result.markers.push_back(working.take.markers()[v]);
    result.gaps.push_back(find_gaps(working.take, v));
    result.gaps.back().marker = result.gaps.size() - 1;
  }
  if (session.frame_count() == 1) {
    result.warnings.emplace_back("the take has one frame only: a still surface, without motion");
  }
  warn_of_twins(result);
  warn_of_subjects(result);
  const MarkerSequence faces = fill(working, options, result, ctx.part(0.15, 0.6, "filling gaps"));
  const RunContext meshing = ctx.part(0.6, 0.9, "triangulating");
  result.triangulation =
      previous ? reuse_topology(*previous, faces, options.triangulate, meshing).triangulation
               : triangulate(faces, options.triangulate, meshing);
  std::ranges::copy(result.triangulation.diagnostics.warnings, std::back_inserter(result.warnings));
  warn_of_long_edges(faces, options, result);
  CarryResult carried =
      carry_topology(result.triangulation.topology, faces, result.triangulation.frame,
                     options.carry, ctx.part(0.9, 1.0, "carrying the topology"));
  result.animation = std::move(carried.animation);
  result.quality = std::move(carried.quality);
  result.summary = carried.summary;
  describe_source(session, result.animation);
  ctx.progress(1.0);
  return result;
}

}  // namespace kinemesh
