// Which markers head stabilisation takes for rigid: those named, a head rig's, or those that move
// as one body.
#include <algorithm>
#include <cmath>
#include <limits>

#include "capture/measured.h"
#include "capture/rigid_markers.h"
#include "capture/stabilise.h"
#include "config/error.h"
#include "config/text.h"

namespace kinemesh {
namespace {

/// Some markers always change their distances least; a skull is told by how little they do.
void refuse_soft_body(const MarkerSequence& take, const RigidMarkersResult& found) {
  constexpr double least_mm = 2.0;  // noise, and markers that sit loosely
  constexpr double share = 0.03;    // of the body's size
  std::size_t fullest = 0;
  std::ptrdiff_t most = -1;
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    const auto seen =
        std::ranges::count_if(found.markers, [&](std::size_t m) { return measured(take, f, m); });
    if (seen > most) fullest = f;
    most = std::max(most, seen);
  }
  double size = 0.0;
  for (const std::size_t a : found.markers) {
    for (const std::size_t b : found.markers) {
      if (!measured(take, fullest, a) || !measured(take, fullest, b)) continue;
      size = std::max(size, static_cast<double>(
                                (take.position(fullest, a) - take.position(fullest, b)).norm()));
    }
  }
  if (found.residual_mm <= std::max(least_mm, share * size)) return;
  if (!std::isfinite(found.residual_mm)) {
    no_rigid_markers(
        take, "No markers span a rigid body: they lie within a few millimetres or on one line");
  }
  no_rigid_markers(take, "No markers move as one rigid body: those that come closest to it are " +
                             format_fixed(found.residual_mm, 1) +
                             " mm off their places (RMS), over a body of " + format_fixed(size, 0) +
                             " mm");
}

/// True when half of the frames at least show three of these markers.
bool is_seen(const MarkerSequence& take, const std::vector<std::size_t>& markers) {
  std::size_t frames = 0;
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    const auto seen =
        std::ranges::count_if(markers, [&](std::size_t m) { return measured(take, f, m); });
    frames += seen >= 3 ? 1 : 0;
  }
  return frames > 0 && 2 * frames >= take.frame_count();
}

bool pattern_names(const std::string& pattern, const Marker& marker) {
  return marker.kind == MarkerKind::marker &&
         (matches_wildcard(pattern, marker.label) ||
          matches_wildcard(pattern, marker.subject + ":" + marker.label));
}

/// Rigid markers by pattern; empty when none matches.
std::vector<std::size_t> named(const MarkerSequence& take,
                               const std::vector<std::string>& patterns) {
  std::vector<std::size_t> out;
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    const auto hit = [&](const std::string& p) { return pattern_names(p, take.markers()[m]); };
    if (std::ranges::any_of(patterns, hit)) out.push_back(m);
  }
  return out;
}

/// Those of --rigid that match no marker, and what they may have meant: " (LFDH: did you mean
/// LFHD?)"; empty when each matches.
std::string idle_patterns(const MarkerSequence& take, const std::vector<std::string>& patterns) {
  std::vector<std::string> labels, idle;
  for (const Marker& m : take.markers()) labels.push_back(m.label);
  for (const std::string& p : patterns) {
    if (std::ranges::any_of(take.markers(), [&](const Marker& m) { return pattern_names(p, m); }))
      continue;
    const std::string near = nearest_word(p, labels);
    idle.push_back(p);
    if (!near.empty()) idle.back().append(" (did you mean ").append(near).append("?)");
  }
  return join(idle, ", ");
}

/// The markers of --rigid.
std::vector<std::size_t> rigid_by_name(const MarkerSequence& take,
                                       const std::vector<std::string>& patterns,
                                       std::string& idle) {
  std::vector<std::size_t> rigid = named(take, patterns);
  idle = idle_patterns(take, patterns);
  if (rigid.empty()) {
    throw UsageError({.what = "--rigid matches no marker: " + idle,
                      .remedy = "See the labels with \"kinemesh c3d info\""});
  }
  if (rigid.size() < 3) {
    no_rigid_markers(take, "Head stabilisation needs three rigid markers, and --rigid names " +
                               std::to_string(rigid.size()) + " of the take" +
                               (idle.empty() ? "" : "; no marker is called " + idle));
  }
  return rigid;
}

}  // namespace

void no_rigid_markers(const MarkerSequence& take, const std::string& what) {
  throw NoResultError({.what = what,
                       .file = take.origin.path,
                       .remedy = "Name at least three markers that are fixed to the head with "
                                 "--rigid, or keep the head's motion"});
}

void StabiliseOptions::declare(ParameterSet& p) {
  p.group("stabilise", "Head stabilisation");
  p.list("rigid", rigid,
         {.metavar = "PATTERN",
          .help = "markers fixed to the head; by default those with a head rig's usual names, or "
                  "else those that move as one body"});
  p.number("reference-frame", reference_frame,
           {.min = 0,
            .max = std::numeric_limits<int>::max(),
            .help = "frame whose head position is kept; 0 for the first with all rigid markers"});
}

StabiliseResult stabilise_head(const MarkerSequence& take, const StabiliseOptions& options,
                               const RunContext& ctx) {
  options.validate();
  if (!options.rigid.empty()) {
    std::string idle;
    StabiliseResult result =
        stabilise_head(take, rigid_by_name(take, options.rigid, idle), options, ctx);
    if (!idle.empty()) {
      result.warnings.push_back("--rigid names what is no marker of the take: " + idle + ".");
      ctx.warn(result.warnings.back());
    }
    return result;
  }
  const std::vector<std::size_t> rig = named(take, options.rig_names);
  if (is_seen(take, rig)) return stabilise_head(take, rig, options, ctx);
  const RigidMarkersResult found = find_rigid_markers(take, ctx);
  if (found.markers.size() < 3) {
    no_rigid_markers(take, take.frame_count() < 2
                               ? "One frame does not show which markers move as one rigid body"
                               : "No markers move as one rigid body");
  }
  refuse_soft_body(take, found);
  StabiliseResult result = stabilise_head(take, found.markers, options, ctx);
  result.chosen_from_motion = true;
  std::vector<std::string> labels;
  for (const std::size_t m : found.markers) labels.push_back(take.markers()[m].label);
  result.warnings.push_back(
      std::string(rig.empty() ? "No marker has a head rig's name"
                              : "Most frames show fewer than three of the head rig's markers") +
      "; taken as rigid from their motion: " + join(labels, ", ", " and ") + ".");
  ctx.warn(result.warnings.back());
  return result;
}

}  // namespace kinemesh
