#include "capture/quality.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "capture/edit/operation.h"
#include "capture/fill/gaussian_process.h"
#include "capture/repair/local_motion.h"
#include "capture/rigid_markers.h"
#include "capture/stabilise.h"
#include "config/error.h"
#include "config/parallel.h"
#include "config/text.h"

namespace kinemesh {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

double percent(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0.0 : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

std::vector<std::size_t> body_columns(const MarkerSequence& take) {
  std::vector<std::size_t> columns;
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    if (take.markers()[m].kind == MarkerKind::marker) columns.push_back(m);
  }
  return columns;
}

double median_or_unknown(std::vector<double> values) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  return values.empty() ? unknown : repair::median_of(values);
}

double median_residual(const MarkerSequence& take, std::size_t m) {
  std::vector<double> residuals;
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    const float r = take.residuals()[take.sample(f, m)];
    if (measured(take, f, m) && r > 0.0F) residuals.push_back(r);
  }
  return median_or_unknown(std::move(residuals));
}

void look_at_markers(const MarkerSequence& take, const std::vector<std::size_t>& columns,
                     QualityResult& result, const RunContext& ctx) {
  const fill::Trajectories trajectories(take.select(columns));
  const double seconds = take.rate_hz > 0.0 ? 1.0 / take.rate_hz : 0.0;
  result.per_marker.resize(columns.size());
  parallel_for(ctx, columns.size(), 1, [&](std::size_t k) {
    MarkerQuality& marker = result.per_marker[k];
    const MarkerGaps gaps = find_gaps(take, columns[k]);
    marker.label = take.markers()[columns[k]].label;
    marker.visible_percent = 100.0 - gaps.missing_percent;
    marker.longest_gap_s = static_cast<double>(gaps.longest) * seconds;
    const double variance = fill::noise_variance(trajectories, k);
    marker.noise_mm = variance > 0.0 ? std::sqrt(variance) : unknown;
    marker.residual_mm = median_residual(take, columns[k]);
  });
  std::vector<double> noises, residuals;
  for (const MarkerQuality& marker : result.per_marker) {
    noises.push_back(marker.noise_mm);
    residuals.push_back(marker.residual_mm);
  }
  result.noise_mm = median_or_unknown(noises);
  result.residual_mm = median_or_unknown(residuals);
}

/// All markers exactly where they were a frame before.
bool repeats(const MarkerSequence& take, const std::vector<std::size_t>& columns, std::size_t f) {
  std::size_t same = 0;
  for (const std::size_t m : columns) {
    if (!measured(take, f, m) || !measured(take, f - 1, m)) continue;
    if (take.position(f, m) != take.position(f - 1, m)) return false;
    ++same;
  }
  return same > 2;
}

void look_at_frames(const MarkerSequence& take, const std::vector<std::size_t>& columns,
                    QualityResult& result) {
  std::size_t seen_samples = 0;
  std::size_t blind = 0, longest = 0, repeated = 0;
  std::vector<std::size_t> seen_in;
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    std::size_t seen = 0;
    for (const std::size_t m : columns) seen += measured(take, f, m) ? 1 : 0;
    seen_samples += seen;
    result.visible_over_time.push_back(percent(seen, columns.size()));
    blind = 2 * seen < columns.size() ? blind + 1 : 0;
    longest = std::max(longest, blind);
    if (seen > 0) seen_in.push_back(f);
    if (f > 0 && seen > 0 && repeats(take, columns, f)) ++repeated;
  }
  result.visible_percent = percent(seen_samples, take.frame_count() * columns.size());
  if (take.rate_hz > 0.0) result.longest_blind_s = static_cast<double>(longest) / take.rate_hz;
  // A head that rests without any noise is no repeated frame: generated takes have such stretches.
  result.repeated_frames = 2 * repeated > take.frame_count() ? 0 : repeated;
  // Longer without a marker, or at the take's ends: the subject was out of view.
  constexpr std::size_t most_at_once = 10;
  for (std::size_t i = 1; i < seen_in.size(); ++i) {
    const std::size_t empty = seen_in[i] - seen_in[i - 1] - 1;
    if (empty <= most_at_once) result.dropped_frames += empty;
  }
}

void look_at_head(const MarkerSequence& take, const std::vector<std::size_t>& columns,
                  HeadMotion& head, QualityResult& result, const RunContext& ctx) {
  const MarkerSequence body = take.select(columns);
  StabiliseResult steady;
  try {
    const std::vector<std::size_t> rigid = find_rigid_markers(body, ctx).markers;
    if (rigid.size() < 3) return;
    steady = stabilise_head(body, rigid, {}, ctx);
  } catch (const NoResultError&) {
    return;
  }
  head.known = true;
  head.error_mm = steady.rms_error_mm;
  const Eigen::Vector3d centre = steady.shape.centre();
  for (const std::size_t m : steady.shape.markers) head.markers.push_back(body.markers()[m].label);
  std::vector<double> speeds;
  Eigen::Vector3d before = centre;
  for (std::size_t f = 0; f < steady.poses.size(); ++f) {
    const HeadPose& pose = steady.poses[f];
    const double turn =
        std::abs(Eigen::AngleAxisd(pose.rotation).angle()) * 180.0 / std::numbers::pi;
    const Eigen::Vector3d now = pose.rotation * centre + pose.translation;
    head.turn_degrees = std::max(head.turn_degrees, turn);
    head.way_mm = std::max(head.way_mm, (now - centre).norm());
    if (f > 0) speeds.push_back((now - before).norm() * take.rate_hz);
    before = now;
    result.turn_over_time.push_back(turn);
    result.head_error_over_time.push_back(pose.error_mm);
  }
  if (speeds.empty()) return;
  std::ranges::sort(speeds);
  head.speed_mm_s = speeds[(speeds.size() - 1) * 99 / 100];
}

void count_loose(const MarkerSequence& take, const std::vector<std::size_t>& columns,
                 QualityResult& result) {
  result.loose_points = take.unlabelled.positions.size();
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    if (take.markers()[m].kind != MarkerKind::unlabelled) continue;
    for (std::size_t f = 0; f < take.frame_count(); ++f) {
      result.loose_points += take.valid(f, m) ? 1 : 0;
    }
  }
  std::vector<std::string> names;
  for (const std::size_t m : columns) {
    names.push_back(take.markers()[m].subject + ":" + take.markers()[m].label);
  }
  std::ranges::sort(names);
  for (std::size_t i = 1; i < names.size(); ++i) result.twins += names[i] == names[i - 1] ? 1 : 0;
}

/// Collects reasons of one gravity.
class Judge {
 public:
  Judge(const QualityOptions& options, QualityResult& result) : o_(options), r_(result) {}

  void judge() {
    gravest();
    if (!r_.reasons.empty()) {
      const bool to_be_labelled = r_.frames > 1 && r_.markers == 0 && r_.loose_points > 0;
      r_.verdict = to_be_labelled ? Verdict::unlabelled : Verdict::repeat;
      return;
    }
    mendable();
    if (!r_.reasons.empty()) r_.verdict = Verdict::fit_after_cleaning;
  }

 private:
  void say(bool holds, const std::string& reason) {
    if (holds) r_.reasons.push_back(reason);
  }
  static std::string share(double value) { return format_fixed(value, 1) + " %"; }

  void gravest() {
    say(r_.frames == 0, "there are no frames");
    say(r_.frames == 1, "there is one frame only, no motion");
    say(r_.frames > 0 && r_.markers == 0,
        r_.loose_points > 0 ? "all points are unlabelled; label them from another take of the "
                              "subject (kinemesh c3d process --template)"
                            : "there are no markers");
    if (r_.frames < 2 || r_.markers == 0) return;
    constexpr std::size_t fewest = 10;  // neither noise nor motion is told from fewer
    say(r_.frames < fewest,
        "there are " + std::to_string(r_.frames) + " frames only, too few to judge the take by");
    say(r_.markers < 3, count_of(r_.markers, "marker") + " alone: a surface needs three");
    const double minutes = std::max(r_.duration_s, 1.0) / 60.0;
    const std::size_t samples = r_.frames * r_.markers;
    say(r_.visible_percent < o_.least_visible_percent,
        "only " + share(r_.visible_percent) + " of the samples were measured");
    say(percent(r_.lost_markers, r_.markers) > o_.most_lost_percent,
        count_of(r_.lost_markers, "marker") + " of " + std::to_string(r_.markers) +
            " seen in less than " + share(o_.least_marker_percent) + " of the take" + lost_names());
    say(r_.longest_blind_s > o_.longest_blind_s,
        "most markers are missing for " + format_fixed(r_.longest_blind_s, 2) + " s at once");
    say(r_.noise_mm > o_.most_noise_mm, "noise of " + format_fixed(r_.noise_mm, 2) + " mm");
    say(r_.residual_mm > o_.most_residual_mm,
        "the cameras' residual is " + format_fixed(r_.residual_mm, 2) + " mm: calibrate them");
    say(percent(r_.dropped_frames + r_.repeated_frames, r_.frames) > o_.most_dropped_percent,
        dropped());
    const std::size_t swaps = count_swaps(r_.swaps);
    say(static_cast<double>(swaps) / minutes > o_.most_swaps_per_minute && swaps > 3,
        count_of(swaps, "label swap"));
    std::size_t spiky = 0;
    for (const Spike& s : r_.spikes) spiky += s.frames.size();
    say(percent(spiky, samples) > o_.most_spikes_percent,
        "spikes in " + share(percent(spiky, samples)) + " of the samples" + spike_sizes());
    say(r_.head.turn_degrees > o_.most_turn_degrees, "the head turns by up to " +
                                                         format_fixed(r_.head.turn_degrees, 0) +
                                                         "°, away from the cameras");
    say(r_.head.speed_mm_s > o_.most_head_speed_mm_s,
        "the head moves at up to " + format_fixed(r_.head.speed_mm_s, 0) + " mm/s");
  }

  void mendable() {
    say(!r_.swaps.empty(), count_of(count_swaps(r_.swaps), "label swap"));
    say(!r_.jumps.empty(),
        count_of(r_.jumps.size(), "jump") + " to another place, to be mended by hand");
    say(!r_.strays.empty(),
        count_of(r_.strays.size(), "stretch", "stretches") + " at another place");
    say(!r_.spikes.empty(), count_of(r_.spikes.size(), "spike") + spike_sizes());
    say(r_.twins > 0, count_of(r_.twins, "label") + " used twice, " + r_.twins_done);
    say(r_.lost_markers > 0, count_of(r_.lost_markers, "marker") + " hardly seen" + lost_names());
    say(r_.visible_percent < 100.0,
        "gaps in " + share(std::max(0.1, 100.0 - r_.visible_percent)) + " of the samples");
    say(r_.loose_points > 0, count_of(r_.loose_points, "point") + " without a label");
    say(r_.dropped_frames + r_.repeated_frames > 0, dropped());
    say(r_.noise_mm > o_.clean_noise_mm,
        "noise of " + format_fixed(r_.noise_mm, 2) + " mm, to be smoothed");
    say(r_.residual_mm > 0.5 * o_.most_residual_mm, "the cameras' residual is " +
                                                        format_fixed(r_.residual_mm, 2) +
                                                        " mm: calibrate them before the next take");
    say(!r_.head.known, "no three markers move as one body, so that the head's motion stays");
    say(r_.head.turn_degrees > o_.clean_turn_degrees || r_.head.way_mm > o_.clean_way_mm,
        "the head turns by up to " + format_fixed(r_.head.turn_degrees, 0) + "° and moves by " +
            format_fixed(r_.head.way_mm, 0) + " mm, to be taken out");
  }

  std::string dropped() const {
    std::vector<std::string> parts;
    if (r_.dropped_frames > 0) {
      parts.push_back(count_of(r_.dropped_frames, "frame") + " dropped");
    }
    if (r_.repeated_frames > 0) {
      parts.push_back(count_of(r_.repeated_frames, "frame") + " that repeat" +
                      (r_.repeated_frames == 1 ? "s" : "") + " the one before");
    }
    return join(parts, " and ");
  }

  /// How large they are; what no head does is said.
  std::string spike_sizes() const {
    constexpr double absurd_mm = 1000.0;
    double most = 0.0;
    for (const Spike& s : r_.spikes) most = std::max(most, s.deviation_mm);
    if (most < absurd_mm) return " of up to " + format_fixed(most, 1) + " mm";
    return " of up to " + format_fixed(most / 1000.0, 1) +
           " m: no marker was there, look at the calibration and the file";
  }

  std::string lost_names() const {
    constexpr std::size_t most = 5;
    std::vector<std::string> names;
    for (const MarkerQuality& m : r_.per_marker) {
      if (m.visible_percent >= o_.least_marker_percent) continue;
      if (names.size() == most) {
        names.emplace_back("…");
        break;
      }
      names.push_back(m.label);
    }
    return names.empty() ? "" : " (" + join(names, ", ") + ")";
  }

  const QualityOptions& o_;
  QualityResult& r_;
};

}  // namespace

std::string_view name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::fit: return "fit";
    case Verdict::fit_after_cleaning: return "fit after cleaning";
    case Verdict::repeat: return "repeat the take";
    case Verdict::unlabelled: return "cannot be graded before it is labelled";
  }
  return "fit";
}

void QualityOptions::declare(ParameterSet& p) {
  p.group("quality", "Limits of a take that need not be repeated");
  const auto share = [&](const char* name, double& field, const char* help) {
    p.number(name, field, {.unit = "%", .min = 0.0, .max = 100.0, .help = help});
  };
  const auto length = [&](const char* name, double& field, const char* help) {
    p.number(name, field, {.unit = "mm", .min = 0.0, .max = 1000.0, .help = help});
  };
  share("least-visible", least_visible_percent, "measured samples, at least");
  share("least-marker", least_marker_percent, "a marker seen less is lost");
  share("most-lost", most_lost_percent, "lost markers, at most");
  p.number("longest-blind", longest_blind_s,
           {.unit = "s", .min = 0.0, .max = 3600.0, .help = "time without most markers, at most"});
  length("most-noise", most_noise_mm, "median noise of a coordinate, at most");
  length("clean-noise", clean_noise_mm, "noise that needs no smoothing");
  length("most-residual", most_residual_mm, "median residual of the cameras, at most");
  share("most-dropped", most_dropped_percent, "dropped frames, at most");
  p.number("most-swaps", most_swaps_per_minute,
           {.unit = "1/min", .min = 0.0, .max = 1e6, .help = "label swaps, at most"});
  share("most-spikes", most_spikes_percent, "samples within spikes, at most");
  const auto angle = [&](const char* name, double& field, const char* help) {
    p.number(name, field, {.unit = "°", .min = 0.0, .max = 180.0, .help = help});
  };
  angle("most-turn", most_turn_degrees, "rotation of the head from the reference frame, at most");
  p.number("most-head-speed", most_head_speed_mm_s,
           {.unit = "mm/s", .min = 0.0, .max = 1e6, .help = "speed of the head, at most"});
  angle("clean-turn", clean_turn_degrees, "rotation of the head that need not be taken out");
  length("clean-way", clean_way_mm, "way of the head that need not be taken out");
}

namespace {

/// Markers that exist twice become one, or get names of their own, as everywhere else.
MarkerSequence without_twins(const MarkerSequence& take, QualityResult& result,
                             const RunContext& ctx) {
  MarkerSequence united = take;
  result.twins_done = make_operation("unite-twins")->apply(united, {"", ctx});
  return united;
}

void assess(const MarkerSequence& take, const QualityOptions& options, QualityResult& result,
            const RunContext& ctx) {
  const std::vector<std::size_t> columns = body_columns(take);
  result.markers = columns.size();
  for (const Marker& m : take.markers()) result.labels.push_back(m.label);
  if (result.frames == 0 || result.markers == 0) return;
  look_at_markers(take, columns, result, ctx);
  look_at_frames(take, columns, result);
  result.lost_markers = static_cast<std::size_t>(std::ranges::count_if(
      result.per_marker,
      [&](const MarkerQuality& m) { return m.visible_percent < options.least_marker_percent; }));
  RepairResult repaired = repair_take(take, {}, ctx.part(0.2, 0.7, "looking for faults"));
  result.swaps = std::move(repaired.swaps);
  result.strays = std::move(repaired.strays);
  result.spikes = std::move(repaired.spikes);
  result.jumps = std::move(repaired.jumps);
  for (const Spike& s : result.spikes) {
    const auto at = std::ranges::find(columns, s.marker) - columns.begin();
    ++result.per_marker[static_cast<std::size_t>(at)].spikes;
  }
  look_at_head(repaired.take, columns, result.head, result, ctx.part(0.7, 1.0, "head motion"));
}

}  // namespace

QualityResult assess_take(const MarkerSequence& take, const QualityOptions& options,
                          const RunContext& ctx) {
  options.validate();
  QualityResult result;
  result.frames = take.frame_count();
  result.rate_hz = take.rate_hz;
  result.first_frame = take.first_frame;
  result.noise_mm = result.residual_mm = unknown;
  if (take.rate_hz > 0.0) result.duration_s = static_cast<double>(result.frames) / take.rate_hz;
  count_loose(take, body_columns(take), result);
  if (result.twins > 0) {
    assess(without_twins(take, result, ctx.part(0.0, 0.1, "twins")), options, result,
           ctx.part(0.1, 1.0, "looking"));
  } else {
    assess(take, options, result, ctx);
  }
  Judge(options, result).judge();
  ctx.progress(1.0);
  return result;
}

}  // namespace kinemesh
