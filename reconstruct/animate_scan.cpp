#include "reconstruct/animate_scan.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "config/error.h"
#include "config/text.h"
#include "mesh/closest_point.h"
#include "reconstruct/prepare_scan.h"
#include "reconstruct/reference_frame.h"

namespace kinemesh {
namespace {

using Eigen::Vector3d;
using PointList = std::vector<Vector3d>;

constexpr std::size_t most_frames_compared = 160, most_frames_averaged = 30;

/// The face's markers without head motion and gaps.
struct Steady {
  MarkerSequence take;
  std::vector<HeadPose> poses;
};

Steady steady_take(const MarkerSequence& session, const AnimateOptions& options,
                   AnimateResult& result, const RunContext& ctx) {
  const MarkerSelectionResult chosen = select_markers(session, options.selection, ctx);
  std::ranges::copy(chosen.warnings, std::back_inserter(result.notes));
  std::vector<std::size_t> kept = chosen.chosen;
  kept.insert(kept.end(), chosen.head_rig.begin(), chosen.head_rig.end());
  std::ranges::sort(kept);
  kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
  Steady steady{session.select(kept), {}};
  try {
    StabiliseResult head = stabilise_head(steady.take, options.head, ctx.part(0.0, 0.3, "head"));
    steady.take = std::move(head.take);
    steady.poses = std::move(head.poses);
    std::ranges::move(head.warnings, std::back_inserter(result.notes));
  } catch (const NoResultError& error) {
    result.notes.push_back(std::string("The head's motion could not be told from the face's: ") +
                           error.what());
  }
  steady.take = fill_gaps(steady.take, options.gaps, ctx.part(0.3, 1.0, "filling gaps")).take;
  std::vector<std::size_t> columns;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (std::ranges::binary_search(chosen.chosen, kept[i])) columns.push_back(i);
  }
  steady.take = steady.take.select(columns);
  return steady;
}

PointList points_at(const MarkerSequence& take, std::size_t frame) {
  PointList points;
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    points.push_back(take.position(frame, m).cast<double>());
  }
  return points;
}

double rms_between(const PointList& a, const PointList& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, a.size())));
}

/// The mean of the frames that look like `frame`: less noise.
PointList averaged(const MarkerSequence& take, std::size_t frame) {
  const PointList reference = points_at(take, frame);
  PointList sum = reference;
  std::size_t count = 1;
  for (std::size_t f = 0; f < take.frame_count() && count < most_frames_averaged; ++f) {
    if (f == frame) continue;
    const PointList points = points_at(take, f);
    if (rms_between(points, reference) > 0.6) continue;
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += points[i];
    ++count;
  }
  for (Vector3d& p : sum) p /= static_cast<double>(count);
  return sum;
}

/// The frame whose markers lie closest to where `distance` wants them.
template <class Distance>
std::size_t best_frame(const MarkerSequence& take, const Distance& distance) {
  const std::size_t step = std::max<std::size_t>(1, take.frame_count() / most_frames_compared);
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t f = 0; f < take.frame_count(); f += step) {
    const double d = distance(points_at(take, f));
    if (d >= least) continue;
    least = d;
    best = f;
  }
  return best;
}

void scale_scan(AnimateResult& result, const MarkerSequence& take, std::size_t frame) {
  result.scale = scan_scale(result.scan, points_at(take, frame));
  if (result.scale == 1.0) return;
  for (auto& p : result.scan.positions) p *= static_cast<float>(result.scale);
  result.notes.push_back("The scan was scaled by " + format_number(result.scale) +
                         " to millimetres, judged by the size of the face; say --unit to set it");
}

/// Registration in the best of the frames, found in two rounds.
void register_found(const MarkerSequence& take, const AnimateOptions& options, std::size_t& frame,
                    AnimateResult& result, const RunContext& ctx) {
  result.registration = register_markers(result.scan, averaged(take, frame), result.labels,
                                         options.attach, ctx.part(0.0, 0.6, "registering"));
  if (options.neutral >= 0) return;
  PointList positions;
  for (const auto& p : result.scan.positions) positions.push_back(p.cast<double>());
  const ClosestPointSearch search(positions, result.scan.topology->faces());
  const Registration& first = result.registration;
  const std::size_t better = best_frame(take, [&](const PointList& points) {
    double sum = 0.0;
    for (const std::size_t m : first.kept) {
      const double d = search.closest(first.pose.apply(points[m]), 50.0).distance -
                       options.attach.marker_radius_mm;
      sum += std::min(d * d, 25.0);
    }
    return sum;
  });
  if (better == frame) return;
  Registration again = register_markers(result.scan, averaged(take, better), result.labels,
                                        options.attach, ctx.part(0.6, 1.0, "registering"));
  if (again.rms_mm < result.registration.rms_mm) {
    result.registration = std::move(again);
    frame = better;
  }
}

void register_given(const MarkerSequence& take, const std::vector<AttachedMarker>& places,
                    const AnimateOptions& options, std::size_t& frame, AnimateResult& result) {
  if (options.neutral < 0) {
    frame = best_frame(take, [&](const PointList& points) {
      RegisterOptions any = options.attach;
      any.farthest_mm = 100.0;
      try {
        return register_at(result.scan, places, points, result.labels, any).rms_mm;
      } catch (const NoResultError&) {
        return 1e9;
      }
    });
  }
  result.registration =
      register_at(result.scan, places, averaged(take, frame), result.labels, options.attach);
}

MarkerSequence in_scan_coordinates(const MarkerSequence& take, const Registration& registration) {
  MarkerSequence moved = take.select(registration.kept);
  for (std::size_t f = 0; f < moved.frame_count(); ++f) {
    for (std::size_t m = 0; m < moved.marker_count(); ++m) {
      moved.position(f, m) =
          registration.pose.apply(moved.position(f, m).cast<double>()).cast<float>();
    }
  }
  return moved;
}

/// Refuses what would not fit into memory: the animation, and the weights while they are made.
void refuse_too_large(std::size_t frames, std::size_t vertices, std::size_t markers,
                      double memory_gb) {
  const double positions = 12.0 * static_cast<double>(frames) * static_cast<double>(vertices);
  const double weights = 16.0 * static_cast<double>(markers) * static_cast<double>(vertices);
  const double needed = 1e-9 * (positions + weights);
  if (needed <= memory_gb) return;
  throw NoResultError(
      {.what = "the animated scan would take " + format_fixed(needed, 1) + " GB of memory: " +
               count_of(frames, "frame") + " of " + count_of(vertices, "vertex", "vertices"),
       .remedy = "Cut the session or lower its rate (kinemesh c3d process --edits, steps crop and "
                 "resample), decimate the scan, or allow more with --memory"});
}

/// The frames asked for and those between them, to the last that was named: what is written chooses
/// among them by the same words.
FrameChoice driven_frames(const std::string& text, const MarkerSequence& take) {
  FrameChoice range = chosen_frames(text, take.first_frame, take.frame_count());
  range.count = std::min(range.count * range.step, take.frame_count() - range.first);
  range.step = 1;
  return range;
}

void say_what_was_solved(const AnimateResult& result, const RunContext& ctx) {
  const std::size_t faces = result.scan.topology->face_count();
  if (result.drive.solved_faces == faces) return;
  ctx.info("The scan's " + count_of(faces, "face") + " were decimated to " +
           std::to_string(result.drive.solved_faces) +
           " for the solve (shortest edges first, boundaries kept); the motion is carried to all "
           "its vertices");
}

/// From the scan's coordinates to the session's, with the head where it was.
void put_head_motion_back(AnimatedMesh& mesh, const RigidFit& pose,
                          const std::vector<HeadPose>& poses, std::size_t first) {
  for (std::size_t f = 0; f < mesh.frame_count(); ++f) {
    const std::size_t frame = first + f;
    for (VertexIndex v = 0; v < mesh.vertex_count(); ++v) {
      Vector3d p = pose.undo(mesh.position(f, v).cast<double>());
      if (frame < poses.size()) p = poses[frame].rotation * p + poses[frame].translation;
      mesh.position(f, v) = p.cast<float>();
    }
  }
}

}  // namespace

void AnimateOptions::declare(ParameterSet& p) {
  selection.declare(p);
  p.group("head", "Head motion");
  p.flag(
      "head-motion", head_motion,
      "put the head's motion back, in the session's coordinates; otherwise the face moves in the "
      "scan's");
  head.declare(p);
  gaps.declare(p);
  attach.declare(p);
  p.number("neutral", neutral,
           {.min = -1,
            .max = 1e12,
            .help = "number of the frame that shows the scan's expression; -1: the one that fits "
                    "best"});
  drive.declare(p);
  p.number("memory", memory_gb,
           {.unit = "GB",
            .min = 0.01,
            .max = 1e5,
            .help = "memory that the animated scan may take, all frames together"});
}

void AnimateOptions::validate() const {
  selection.validate();
  validate_options(*this);
}

AnimateResult animate_scan(const Mesh& scan, const MarkerSequence& session,
                           const PlacesSource& places, const AnimateOptions& options,
                           const RunContext& ctx) {
  options.validate();
  if (session.frame_count() == 0) {
    throw NoResultError({.what = "the session has no frames", .file = session.origin.path});
  }
  AnimateResult result;
  PreparedScan prepared = prepare_scan(scan);
  result.notes = std::move(prepared.notes);
  result.scan = std::move(prepared.mesh);
  const Steady steady =
      steady_take(session, options, result, ctx.part(0.0, 0.3, "preparing the markers"));
  for (const Marker& m : steady.take.markers()) result.labels.push_back(m.label);
  DriveOptions drive = options.drive;
  drive.frames = driven_frames(options.frames, steady.take);
  refuse_too_large(drive.frames.count, result.scan.positions.size(), result.labels.size(),
                   options.memory_gb);
  std::size_t frame = choose_reference_frame(steady.take, options.neutral).frame;
  scale_scan(result, steady.take, frame);
  const ScanOpenings openings = scan_openings(result.scan);
  result.openings = openings.count;
  if (!openings.note.empty()) result.notes.push_back(openings.note);
  const RunContext registering = ctx.part(0.3, 0.6, "registering");
  if (places) {
    register_given(steady.take, places(result.scan, result.scale), options, frame, result);
  } else {
    register_found(steady.take, options, frame, result, registering);
  }
  std::ranges::copy(result.registration.notes, std::back_inserter(result.notes));
  result.neutral_frame = steady.take.first_frame + static_cast<int64_t>(frame);
  for (const Vector3d& p : averaged(steady.take, frame)) {
    result.neutral.push_back(result.registration.pose.apply(p));
  }
  result.drive = drive_scan(result.scan, result.registration.markers,
                            in_scan_coordinates(steady.take, result.registration), drive,
                            ctx.part(0.6, 1.0, "driving"));
  say_what_was_solved(result, ctx);
  if (options.head_motion) {
    put_head_motion_back(result.drive.animation, result.registration.pose, steady.poses,
                         drive.frames.first);
  }
  for (const std::string& note : result.notes) ctx.warn(note);
  return result;
}

}  // namespace kinemesh
