#include "capture/stabilise.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "capture/c3d/point_table.h"
#include "capture/measured.h"
#include "capture/rigid_markers.h"
#include "capture/rotation_data.h"
#include "config/error.h"
#include "config/parallel.h"
#include "config/text.h"

namespace kinemesh {
namespace {

constexpr double thinnest_mm =
    1.0;  // rigid markers closer to one line leave the turn about it open

struct Observed {
  std::vector<Eigen::Vector3d> positions;
  std::vector<bool> visible;
  std::size_t count = 0;
};

Observed observe(const MarkerSequence& take, std::size_t frame,
                 const std::vector<std::size_t>& markers) {
  Observed out;
  for (const std::size_t m : markers) {
    const bool seen = measured(take, frame, m);
    out.visible.push_back(seen);
    out.count += seen ? 1 : 0;
    out.positions.emplace_back(seen ? Eigen::Vector3d(take.position(frame, m).cast<double>())
                                    : Eigen::Vector3d(Eigen::Vector3d::Zero()));
  }
  return out;
}

void fit_all(const std::vector<Observed>& frames, const RigidShape& shape, const RunContext& ctx,
             std::vector<HeadPose>& poses) {
  poses.resize(frames.size());
  parallel_for(ctx, frames.size(), 256, [&](std::size_t f) {
    poses[f] = fit_pose(shape, frames[f].positions, frames[f].visible);
  });
}

/// Mean position of every rigid marker in head coordinates, its RMS residual and new weight.
void update_shape(const std::vector<Observed>& frames, const std::vector<HeadPose>& poses,
                  RigidShape& shape) {
  const std::size_t count = shape.markers.size();
  std::vector<double> variances(count, 0.0);
  for (std::size_t k = 0; k < count; ++k) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double squares = 0.0;
    double seen = 0.0;
    for (std::size_t f = 0; f < frames.size(); ++f) {
      if (!frames[f].visible[k] || poses[f].interpolated) continue;
      const Eigen::Vector3d p = poses[f].to_head(frames[f].positions[k]);
      sum += p;
      squares += (p - shape.positions[k]).squaredNorm();
      seen += 1.0;
    }
    if (seen == 0.0 || shape.weights[k] == 0.0) continue;
    shape.positions[k] = sum / seen;
    variances[k] = squares / seen;
    shape.residuals_mm[k] = std::sqrt(variances[k]);
  }
  std::vector<double> sorted;
  for (std::size_t k = 0; k < count; ++k) {
    if (shape.weights[k] > 0.0) sorted.push_back(variances[k]);
  }
  std::ranges::sort(sorted);
  const double median = sorted[sorted.size() / 2];
  if (median <= 0.0) return;
  double total = 0.0;
  for (std::size_t k = 0; k < count; ++k) {
    if (shape.weights[k] > 0.0) shape.weights[k] = 1.0 / (variances[k] + median);
    total += shape.weights[k];
  }
  for (double& w : shape.weights) w *= static_cast<double>(sorted.size()) / total;
}

/// Gives a place to the markers that have none yet (weight 0) and are seen in a frame whose pose
/// is known: the mean over these frames. False when there is no such marker.
bool place_more(const std::vector<Observed>& frames, const std::vector<HeadPose>& poses,
                RigidShape& shape) {
  bool placed = false;
  for (std::size_t k = 0; k < shape.markers.size(); ++k) {
    if (shape.weights[k] > 0.0) continue;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double seen = 0.0;
    for (std::size_t f = 0; f < frames.size(); ++f) {
      if (!frames[f].visible[k] || poses[f].interpolated) continue;
      sum += poses[f].to_head(frames[f].positions[k]);
      seen += 1.0;
    }
    if (seen == 0.0) continue;
    shape.positions[k] = sum / seen;
    shape.weights[k] = 1.0;
    placed = true;
  }
  return placed;
}

std::size_t choose_reference(const std::vector<Observed>& frames, const MarkerSequence& take,
                             int wanted) {
  if (wanted != 0) {
    const int64_t index = wanted - take.first_frame;
    if (index < 0 || index >= static_cast<int64_t>(frames.size())) {
      throw UsageError(
          {.what = "The reference frame lies outside the take",
           .file = take.origin.path,
           .frame = wanted,
           .remedy = "Give a frame from " + std::to_string(take.first_frame) + " to " +
                     std::to_string(take.first_frame + static_cast<int64_t>(frames.size()) - 1)});
    }
    return static_cast<std::size_t>(index);
  }
  std::size_t best = 0;
  for (std::size_t f = 1; f < frames.size(); ++f) {
    if (frames[f].count > frames[best].count) best = f;
  }
  return best;
}

/// Fills poses that could not be measured from the nearest ones that were.
void interpolate(const Eigen::Vector3d& centre, std::vector<HeadPose>& poses) {
  constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
  std::size_t before = none;
  for (std::size_t f = 0; f < poses.size(); ++f) {
    if (!poses[f].interpolated) {
      before = f;
      continue;
    }
    std::size_t after = f + 1;
    while (after < poses.size() && poses[after].interpolated) ++after;
    const std::size_t a = before != none ? before : after;
    const std::size_t b = after < poses.size() ? after : before;
    const double u = a == b ? 0.0 : static_cast<double>(f - a) / static_cast<double>(b - a);
    const Eigen::Quaterniond turn =
        Eigen::Quaterniond(poses[a].rotation).slerp(u, Eigen::Quaterniond(poses[b].rotation));
    const auto centre_in = [&](const HeadPose& p) -> Eigen::Vector3d {
      return p.rotation * centre + p.translation;
    };
    poses[f].rotation = turn.toRotationMatrix();
    poses[f].translation =
        (1.0 - u) * centre_in(poses[a]) + u * centre_in(poses[b]) - poses[f].rotation * centre;
    poses[f].error_mm = std::numeric_limits<double>::quiet_NaN();
  }
}

/// The shape as it stands in this frame: a marker that is not seen in it has weight 0.
void take_shape_of(const Observed& frame, RigidShape& shape) {
  shape.positions = frame.positions;
  shape.weights.clear();
  for (const bool seen : frame.visible) shape.weights.push_back(seen ? 1.0 : 0.0);
}

/// The shape as it stands in the frame with most markers (not on one line), and the poses by
/// these; markers missing there join, round by round, from frames whose poses are known by then.
void start_shape(const std::vector<Observed>& frames, RigidShape& shape, const RunContext& ctx,
                 std::vector<HeadPose>& poses) {
  const Observed* start = &frames.front();
  for (const Observed& frame : frames) {
    if (frame.count <= start->count && &frame != start) continue;
    take_shape_of(frame, shape);
    if (!fit_pose(shape, frame.positions, frame.visible).interpolated) start = &frame;
  }
  take_shape_of(*start, shape);
  shape.residuals_mm.assign(shape.markers.size(), 0.0);
  do {
    ctx.check_cancelled();
    fit_all(frames, shape, ctx, poses);
  } while (place_more(frames, poses, shape));
}

/// Head coordinates become those of the recording in the reference frame.
void rest_on_reference(StabiliseResult& result) {
  const HeadPose reference = result.poses[result.reference_frame];
  for (std::size_t k = 0; k < result.shape.markers.size(); ++k) {
    Eigen::Vector3d& p = result.shape.positions[k];
    p = reference.rotation * p + reference.translation;
    if (result.shape.weights[k] == 0.0) {
      p.setConstant(std::numeric_limits<double>::quiet_NaN());
      result.shape.residuals_mm[k] = std::numeric_limits<double>::quiet_NaN();
    }
  }
  for (HeadPose& pose : result.poses) {
    pose.rotation = pose.rotation * reference.rotation.transpose();
    pose.translation -= pose.rotation * reference.translation;
  }
}

void move_to_head(const std::vector<HeadPose>& poses, MarkerSequence& take) {
  const double unit_mm = millimetres_in(take.origin.unit).value_or(1.0);
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    const Eigen::Matrix3d turn = poses[f].rotation.transpose();
    move_rotations(take.rotations, f, turn, -(turn * poses[f].translation) / unit_mm);
    for (std::size_t m = 0; m < take.marker_count(); ++m) {
      const bool point = take.markers()[m].kind <= MarkerKind::virtual_point;
      if (!point || !take.valid(f, m)) continue;
      take.position(f, m) =
          poses[f].to_head(take.position(f, m).cast<double>()).template cast<float>();
    }
    const std::vector<uint64_t>& offsets = take.unlabelled.offsets;
    for (std::size_t i = f + 1 < offsets.size() ? offsets[f] : 0;
         f + 1 < offsets.size() && i < offsets[f + 1]; ++i) {
      Eigen::Vector3f& p = take.unlabelled.positions[i];
      p = poses[f].to_head(p.cast<double>()).template cast<float>();
    }
  }
}

[[noreturn]] void no_rigid_markers(const MarkerSequence& take, const std::string& what) {
  throw NoResultError({.what = what,
                       .file = take.origin.path,
                       .remedy = "Name at least three markers that are fixed to the head with "
                                 "--rigid, or keep the head's motion"});
}

void summarise(StabiliseResult& result, const RunContext& ctx) {
  double squares = 0.0;
  for (const HeadPose& pose : result.poses) {
    if (pose.interpolated) {
      ++result.interpolated_frames;
    } else {
      squares += pose.error_mm * pose.error_mm;
    }
  }
  const std::size_t fitted = result.poses.size() - result.interpolated_frames;
  result.rms_error_mm = std::sqrt(squares / static_cast<double>(fitted));
  if (result.interpolated_frames > 0) {
    result.warnings.push_back("The head's pose is interpolated in " +
                              count_of(result.interpolated_frames, "frame") +
                              " with fewer than three usable rigid markers.");
    ctx.warn(result.warnings.back());
  }
  std::vector<std::string> left_out;
  for (std::size_t k = 0; k < result.shape.markers.size(); ++k) {
    const std::size_t m = result.shape.markers[k];
    if (result.shape.weights[k] == 0.0) left_out.push_back(result.take.markers()[m].label);
  }
  if (left_out.empty()) return;
  result.warnings.push_back(
      "Left out of the head's pose, because never seen together with three "
      "others whose places on the head are known: " +
      join(left_out, ", ", " and ") + ".");
  ctx.warn(result.warnings.back());
}

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

/// Rigid markers by pattern; empty when none matches.
std::vector<std::size_t> named(const MarkerSequence& take,
                               const std::vector<std::string>& patterns) {
  std::vector<std::size_t> out;
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    const Marker& marker = take.markers()[m];
    const auto hit = [&](const std::string& p) {
      return matches_wildcard(p, marker.label) ||
             matches_wildcard(p, marker.subject + ":" + marker.label);
    };
    if (marker.kind == MarkerKind::marker && std::ranges::any_of(patterns, hit)) out.push_back(m);
  }
  return out;
}

}  // namespace

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

Eigen::Vector3d RigidShape::centre() const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (std::size_t k = 0; k < markers.size(); ++k) {
    if (weights[k] == 0.0) continue;
    sum += positions[k];
    count += 1.0;
  }
  return sum / count;
}

HeadPose fit_pose(const RigidShape& shape, std::span<const Eigen::Vector3d> measured_positions,
                  const std::vector<bool>& visible) {
  std::vector<Eigen::Vector3d> from;
  std::vector<Eigen::Vector3d> to;
  std::vector<double> weights;
  for (std::size_t k = 0; k < shape.markers.size(); ++k) {
    if (!visible[k] || shape.weights[k] == 0.0) continue;
    from.push_back(shape.positions[k]);
    to.push_back(measured_positions[k]);
    weights.push_back(shape.weights[k]);
  }
  HeadPose pose;
  pose.visible = from.size();
  pose.interpolated = true;
  pose.error_mm = std::numeric_limits<double>::quiet_NaN();
  if (from.size() < 3) return pose;
  const RigidFit fit = fit_rigid(from, to, weights);
  if (fit.spread < thinnest_mm) return pose;
  pose.interpolated = false;
  pose.rotation = fit.rotation;
  pose.translation = fit.translation;
  double squares = 0.0;
  for (std::size_t k = 0; k < from.size(); ++k)
    squares += (fit.apply(from[k]) - to[k]).squaredNorm();
  pose.error_mm = std::sqrt(squares / static_cast<double>(from.size()));
  return pose;
}

StabiliseResult stabilise_head(const MarkerSequence& take, std::span<const std::size_t> rigid,
                               const StabiliseOptions& options, const RunContext& ctx) {
  options.validate();
  StabiliseResult result;
  RigidShape& shape = result.shape;
  shape.markers.assign(rigid.begin(), rigid.end());
  if (rigid.size() < 3) {
    no_rigid_markers(take, "Head stabilisation needs three rigid markers, and the take has " +
                               std::to_string(rigid.size()));
  }
  std::vector<Observed> frames;
  frames.reserve(take.frame_count());
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    frames.push_back(observe(take, f, shape.markers));
  }
  if (frames.empty()) no_rigid_markers(take, "The take has no frames");
  result.reference_frame = choose_reference(frames, take, options.reference_frame);

  start_shape(frames, shape, ctx, result.poses);
  const auto fitted = [](const HeadPose& p) { return !p.interpolated; };
  if (std::ranges::none_of(result.poses, fitted)) {
    no_rigid_markers(take, "No frame shows three rigid markers that do not stand on one line");
  }
  update_shape(frames, result.poses, shape);
  constexpr int rounds = 8;  // the mean shape settles to below a thousandth of its noise in three
  for (int round = 0; round < rounds; ++round) {
    ctx.check_cancelled();
    fit_all(frames, shape, ctx, result.poses);
    update_shape(frames, result.poses, shape);
  }
  fit_all(frames, shape, ctx, result.poses);
  interpolate(shape.centre(), result.poses);
  rest_on_reference(result);
  result.take = take;
  move_to_head(result.poses, result.take);
  summarise(result, ctx);
  return result;
}

StabiliseResult stabilise_head(const MarkerSequence& take, const StabiliseOptions& options,
                               const RunContext& ctx) {
  options.validate();
  if (!options.rigid.empty()) {
    const std::vector<std::size_t> rigid = named(take, options.rigid);
    if (rigid.empty()) {
      throw UsageError({.what = "--rigid " + join(options.rigid, " ") + " matches no marker",
                        .remedy = "See the labels with \"kinemesh c3d info\""});
    }
    return stabilise_head(take, rigid, options, ctx);
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
