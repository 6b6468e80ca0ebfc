// The quality of a recorded take, before anybody spends an hour on it.
#pragma once

#include <string>
#include <vector>

#include "capture/gaps.h"
#include "capture/marker_sequence.h"
#include "capture/repair.h"
#include "config/parameter.h"
#include "config/run_context.h"
#include "report/canvas.h"

namespace kinemesh {

/// Worst limits of a take that is worth cleaning, and what needs no cleaning.
struct QualityOptions {
  double least_visible_percent = 80.0;   ///< of all samples; below: repeat
  double least_marker_percent = 40.0;    ///< of one marker's; below it the marker is lost
  double most_lost_percent = 5.0;        ///< of the markers may be lost; above: repeat
  double longest_blind_s = 0.5;          ///< during which most markers are missing; above: repeat
  double most_noise_mm = 1.0;            ///< median over markers; above: repeat
  double clean_noise_mm = 0.3;           ///< above: smooth
  double most_residual_mm = 3.0;         ///< median of the cameras' residuals; above: repeat
  double most_dropped_percent = 2.0;     ///< of the frames; above: repeat
  double most_swaps_per_minute = 60.0;   ///< above: repeat
  double most_spikes_percent = 1.0;      ///< of all samples; above: repeat
  double most_turn_degrees = 60.0;       ///< of the head; above, the cameras lose the face: repeat
  double most_head_speed_mm_s = 1500.0;  ///< above: repeat
  double clean_turn_degrees = 10.0;      ///< above, the head's motion is to be taken out
  double clean_way_mm = 30.0;            ///< likewise

  void declare(ParameterSet& p);
  void validate() const { validate_options(*this); }
};

/// `unlabelled`: all points are, so that nothing can be judged yet.
enum class Verdict { fit, fit_after_cleaning, repeat, unlabelled };
/// "fit", "fit after cleaning", "repeat the take", "cannot be graded before it is labelled".
std::string_view name_of(Verdict verdict);

struct MarkerQuality {
  std::string label;
  double visible_percent = 0.0;
  double longest_gap_s = 0.0;
  double noise_mm = 0.0;     ///< standard deviation of one coordinate; NaN: not to be told
  double residual_mm = 0.0;  ///< median; NaN when the file has none
  std::size_t spikes = 0;
};

struct HeadMotion {
  bool known = false;                ///< at least three markers move as one body
  std::vector<std::string> markers;  ///< that do
  double turn_degrees = 0.0;         ///< largest rotation from the reference frame
  double way_mm = 0.0;               ///< largest distance of the head's centre from there
  double speed_mm_s = 0.0;           ///< 99th percentile of that centre's
  double error_mm = 0.0;             ///< RMS of the rigid markers
};

struct QualityResult {
  Verdict verdict = Verdict::fit;
  std::vector<std::string> reasons;  ///< the gravest first; without full stops
  std::size_t frames = 0, markers = 0;
  double duration_s = 0.0;
  double visible_percent = 0.0;  ///< of all samples of markers
  std::size_t lost_markers = 0;  ///< seen in less than the least share
  double longest_blind_s = 0.0;  ///< longest time with less than half of the markers
  std::size_t loose_points = 0;  ///< without a label, over all frames
  std::size_t twins = 0;         ///< labels that exist twice
  std::string twins_done;        ///< what was done about it before anything else was looked at
  double noise_mm = 0.0;         ///< median over markers; NaN: not to be told
  double residual_mm = 0.0;      ///< median over samples; NaN when the file has none
  std::vector<LabelSwap> swaps;
  std::vector<Spike> spikes;
  std::vector<Stray> strays;
  std::vector<Jump> jumps;
  std::size_t dropped_frames = 0;   ///< without any marker, few between others
  std::size_t repeated_frames = 0;  ///< the same data as in the frame before
  HeadMotion head;
  std::vector<MarkerQuality> per_marker;
  std::vector<std::string> labels;  ///< of the take's columns, to which spikes and swaps refer
  std::vector<double> visible_over_time;     ///< per frame, percent
  std::vector<double> turn_over_time;        ///< degrees; empty unless the head is known
  std::vector<double> head_error_over_time;  ///< mm, NaN where not measured; likewise
  double rate_hz = 0.0;
  int64_t first_frame = 1;
};

/// Looks at markers of the body. Never throws for what a take contains: a take without frames or
/// markers is to be repeated.
QualityResult assess_take(const MarkerSequence& take, const QualityOptions& options = {},
                          const RunContext& ctx = {});

/// One line: verdict and reasons.
std::string quality_line(const QualityResult& result);
/// The line and the figures, for a person.
std::string quality_text(const QualityResult& result);
/// The document that docs/capture.md describes.
std::string quality_json(const QualityResult& result, const std::string& file);
/// Visibility, head motion and markers on one page.
Canvas draw_quality(const QualityResult& result, const std::string& title);

}  // namespace kinemesh
