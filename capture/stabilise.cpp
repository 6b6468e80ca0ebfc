#include "capture/stabilise.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

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

/// Markers that no frame shows with those that have a place, but three or more with each other, as
/// those of a second subject who follows: they get places by the pose that is interpolated for the
/// frame that shows most of them. Returns that frame; nothing when there is none.
std::optional<std::size_t> place_apart(const std::vector<Observed>& frames,
                                       const std::vector<HeadPose>& poses, RigidShape& shape) {
  std::optional<std::size_t> best;
  std::size_t most = 2;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    if (frames[f].count <= most || poses[f].visible > 0) continue;
    RigidShape alone = shape;
    take_shape_of(frames[f], alone);
    if (fit_pose(alone, frames[f].positions, frames[f].visible).interpolated) continue;
    best = f;
    most = frames[f].count;
  }
  if (!best) return best;
  std::vector<HeadPose> between = poses;
  interpolate(shape.centre(), between);
  for (std::size_t k = 0; k < shape.markers.size(); ++k) {
    if (!frames[*best].visible[k]) continue;
    shape.positions[k] = between[*best].to_head(frames[*best].positions[k]);
    shape.weights[k] = 1.0;
  }
  return best;
}

/// The shape as it stands in the frame with most markers (not on one line), and the poses by
/// these; markers missing there join, round by round, from frames whose poses are known by then.
/// Returns the frames by which others were placed that are never seen with these.
std::vector<std::size_t> start_shape(const std::vector<Observed>& frames, RigidShape& shape,
                                     const RunContext& ctx, std::vector<HeadPose>& poses) {
  const Observed* start = &frames.front();
  for (const Observed& frame : frames) {
    if (frame.count <= start->count && &frame != start) continue;
    take_shape_of(frame, shape);
    if (!fit_pose(shape, frame.positions, frame.visible).interpolated) start = &frame;
  }
  take_shape_of(*start, shape);
  shape.residuals_mm.assign(shape.markers.size(), 0.0);
  std::vector<std::size_t> apart;
  for (;;) {
    ctx.check_cancelled();
    fit_all(frames, shape, ctx, poses);
    if (place_more(frames, poses, shape)) continue;
    const bool known =
        std::ranges::any_of(poses, [](const HeadPose& p) { return !p.interpolated; });
    const auto frame = known ? place_apart(frames, poses, shape) : std::nullopt;
    if (!frame) return apart;
    apart.push_back(*frame);
  }
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

/// Where one body takes over from another nothing says how the two lie to each other.
void warn_of_apart(const std::vector<std::size_t>& frames, StabiliseResult& result,
                   const RunContext& ctx) {
  for (const std::size_t f : frames) {
    result.warnings.push_back(
        "The rigid markers seen in frame " +
        std::to_string(result.take.first_frame + static_cast<int64_t>(f)) +
        " are never seen together with those before them (another subject?): the head's motion is "
        "taken out by them, too, but how it lies to the other frames is not known.");
    ctx.warn(result.warnings.back());
  }
}

/// Markers of two subjects that are seen at the same time and do not move as one are two heads.
void refuse_two_heads(const StabiliseResult& result) {
  const MarkerSequence& take = result.take;
  const std::vector<std::size_t>& rigid = result.shape.markers;
  const std::string& one = take.markers()[rigid.front()].subject;
  for (const std::size_t m : rigid) {
    const std::string& other = take.markers()[m].subject;
    if (other == one) continue;
    for (std::size_t f = 0; f < take.frame_count(); ++f) {
      if (!measured(take, f, m) || !measured(take, f, rigid.front())) continue;
      std::string what = "The rigid markers are those of two heads, of ";
      what.append(one).append(" and ").append(other).append(", which do not move as one");
      throw NoResultError({.what = what,
                           .file = take.origin.path,
                           .remedy = "Name the markers of one of them with --rigid SUBJECT:LABEL, "
                                     "or part the subjects first"});
    }
  }
}

/// What moves with the face, or slides on the head, spoils the pose.
void warn_of_soft(StabiliseResult& result, const RunContext& ctx) {
  constexpr double most_mm = 3.0;  // in nine of ten frames: jumps are no matter here
  std::vector<std::string> soft;
  for (std::size_t k = 0; k < result.shape.markers.size(); ++k) {
    const std::size_t m = result.shape.markers[k];
    std::vector<double> off;
    for (std::size_t f = 0; f < result.poses.size() && result.shape.weights[k] > 0.0; ++f) {
      if (result.poses[f].interpolated || !measured(result.take, f, m)) continue;
      off.push_back((result.take.position(f, m).cast<double>() - result.shape.positions[k]).norm());
    }
    if (off.empty()) continue;
    const auto tenth = off.begin() + static_cast<std::ptrdiff_t>(off.size() * 9 / 10);
    std::ranges::nth_element(off, tenth);
    if (*tenth <= most_mm) continue;
    soft.push_back(result.take.markers()[m].label + " (" + format_fixed(*tenth, 1) + " mm)");
  }
  if (soft.empty()) return;
  refuse_two_heads(result);
  constexpr std::size_t most_names = 8;
  if (soft.size() > most_names) {
    soft.resize(most_names);
    soft.emplace_back("…");
  }
  result.warnings.push_back(
      "Taken as rigid, but off their places on the head in a tenth of the frames: " +
      join(soft, ", ") + ". Name others with --rigid if the head is not steady enough.");
  ctx.warn(result.warnings.back());
}

}  // namespace

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

  const std::vector<std::size_t> apart = start_shape(frames, shape, ctx, result.poses);
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
  warn_of_apart(apart, result, ctx);
  warn_of_soft(result, ctx);
  return result;
}

}  // namespace kinemesh
