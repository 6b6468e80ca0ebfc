#include "capture/edit/timeline.h"

#include <algorithm>
#include <cmath>

#include "capture/c3d/point_table.h"
#include "capture/rotation_data.h"
#include "config/error.h"
#include "config/parallel.h"
#include "config/text.h"

namespace kinemesh {
namespace {

/// Seconds from recorded frame 1 to the take's first frame.
double start_time(const MarkerSequence& take) {
  return take.rate_hz > 0.0 ? static_cast<double>(take.first_frame - 1) / take.rate_hz : 0.0;
}

std::size_t analog_per_frame(const MarkerSequence& take) {
  return take.analog.channels.size() * take.analog.samples_per_frame;
}

/// True when the analog values are as many as the frames need.
bool has_analog(const MarkerSequence& take) {
  return analog_per_frame(take) > 0 &&
         take.analog.values.size() >= take.frame_count() * analog_per_frame(take);
}

void copy_unlabelled(const UnlabelledPoints& from, std::size_t frame, UnlabelledPoints& to) {
  if (to.offsets.empty()) to.offsets.push_back(0);
  if (frame + 1 < from.offsets.size()) {
    for (std::size_t i = from.offsets[frame]; i < from.offsets[frame + 1]; ++i) {
      to.positions.push_back(from.positions[i]);
      to.residuals.push_back(i < from.residuals.size() ? from.residuals[i] : 0.0F);
      to.camera_masks.push_back(i < from.camera_masks.size() ? from.camera_masks[i] : uint8_t{0});
    }
  }
  to.offsets.push_back(to.positions.size());
}

/// Second derivatives of the natural cubic spline through equidistant values.
std::vector<double> curvatures(const std::vector<double>& y) {
  const std::size_t n = y.size();
  std::vector<double> m(n, 0.0);
  std::vector<double> upper(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double pivot = 4.0 - upper[i - 1];
    upper[i] = 1.0 / pivot;
    m[i] = (6.0 * (y[i + 1] - 2.0 * y[i] + y[i - 1]) - m[i - 1]) / pivot;
  }
  for (std::size_t i = n - 1; i-- > 1;) m[i] -= upper[i] * m[i + 1];
  return m;
}

/// Where the new frames lie among the old ones.
struct Grid {
  double step;  ///< old frames per new frame
  std::size_t frames;
  double at(std::size_t f) const {
    const double place = step * static_cast<double>(f);
    const double whole = std::round(place);  // a frame that was there is taken as it is
    return std::abs(place - whole) < 1e-9 * (1.0 + place) ? whole : place;
  }
};

void resample_run(const MarkerSequence& take, std::size_t marker, FrameRange run, const Grid& grid,
                  MarkerSequence& out) {
  std::vector<double> values[3], bends[3];
  for (Eigen::Index c = 0; c < 3; ++c) {
    for (std::size_t f = run.begin; f < run.end; ++f) {
      values[c].push_back(take.position(f, marker)[c]);
    }
    bends[c] = curvatures(values[c]);
  }
  auto f = static_cast<std::size_t>(std::max(0.0, std::floor(run.begin / grid.step) - 1.0));
  for (; f < grid.frames && grid.at(f) <= static_cast<double>(run.end - 1); ++f) {
    const double place = grid.at(f) - static_cast<double>(run.begin);
    if (place < 0.0) continue;
    const auto i = static_cast<std::size_t>(place);
    const double u = place - static_cast<double>(i);
    const std::size_t nearest = u < 0.5 ? i : i + 1;
    const std::size_t to = out.sample(f, marker);
    copy_sample(take, take.sample(run.begin + nearest, marker), out, to);
    if (u <= 0.0) continue;
    const std::size_t other = take.sample(run.begin + (u < 0.5 ? i + 1 : i), marker);
    out.flags()[to] |= take.flags()[other] & SampleFlag::filled;
    for (Eigen::Index c = 0; c < 3; ++c) {
      const double v = 1.0 - u;
      out.position(f, marker)[c] = static_cast<float>(
          v * values[c][i] + u * values[c][i + 1] +
          ((v * v * v - v) * bends[c][i] + (u * u * u - u) * bends[c][i + 1]) / 6.0);
    }
  }
}

void resample_analog(const MarkerSequence& take, const Grid& grid, MarkerSequence& out) {
  if (!has_analog(take)) return;
  const std::size_t channels = take.analog.channels.size();
  const double per_frame = take.analog.rate_hz / out.rate_hz;
  const auto samples = static_cast<std::size_t>(std::max(1.0, std::round(per_frame)));
  out.analog.channels = take.analog.channels;
  out.analog.samples_per_frame = samples;
  out.analog.rate_hz = out.rate_hz * static_cast<double>(samples);
  out.analog.values = Buffer<float>(grid.frames * samples * channels);
  const std::size_t count = take.frame_count() * take.analog.samples_per_frame;
  const double step = take.analog.rate_hz / out.analog.rate_hz;
  const Grid fine{std::abs(step - 1.0) < 1e-9 ? 1.0 : step, grid.frames * samples};
  for (std::size_t s = 0; s < fine.frames; ++s) {
    const double place = std::min(fine.at(s), static_cast<double>(count - 1));
    const auto i = static_cast<std::size_t>(place);
    const auto u = static_cast<float>(place - static_cast<double>(i));
    for (std::size_t c = 0; c < channels; ++c) {
      const float a = take.analog.values[i * channels + c];
      const float b = u > 0.0F ? take.analog.values[(i + 1) * channels + c] : a;
      out.analog.values[s * channels + c] = u > 0.0F ? a + u * (b - a) : a;
    }
  }
}

bool same_marker(const Marker& a, const Marker& b) {
  return a.label == b.label && a.subject == b.subject;
}

void join_analog(const MarkerSequence& first, const MarkerSequence& second, std::size_t pause,
                 MarkerSequence& out, std::vector<std::string>* notes) {
  const auto note = [&](const std::string& text) {
    if (notes != nullptr) notes->push_back(text);
  };
  if (!has_analog(first)) {
    if (has_analog(second)) note("the analog data of the second take are left out");
    return;
  }
  out.analog.channels = first.analog.channels;
  out.analog.rate_hz = first.analog.rate_hz;
  out.analog.samples_per_frame = first.analog.samples_per_frame;
  const std::size_t per_frame = analog_per_frame(first);
  out.analog.values = Buffer<float>(out.frame_count() * per_frame, 0.0F);
  std::copy_n(first.analog.values.data(), first.frame_count() * per_frame,
              out.analog.values.data());
  const bool alike = has_analog(second) && analog_per_frame(second) == per_frame &&
                     std::ranges::equal(first.analog.channels, second.analog.channels, {},
                                        &AnalogData::Channel::label, &AnalogData::Channel::label);
  if (!alike) {
    note("the second take has no analog data of the same channels and rate: zeros stand there");
    return;
  }
  std::copy_n(second.analog.values.data(), second.frame_count() * per_frame,
              out.analog.values.data() + (first.frame_count() + pause) * per_frame);
}

}  // namespace

MarkerSequence empty_like(const MarkerSequence& take, std::size_t frames,
                          std::vector<Marker> markers) {
  MarkerSequence out = MarkerSequence::invalid(frames, std::move(markers), take.rate_hz);
  out.first_frame = take.first_frame;
  out.events = take.events;
  out.origin = take.origin;
  out.parameters = take.parameters;
  if (!take.uncertainty().empty()) out.add_uncertainty();
  return out;
}

void copy_sample(const MarkerSequence& from, std::size_t a, MarkerSequence& to, std::size_t b) {
  std::copy_n(from.positions().data() + 3 * a, 3, to.positions().data() + 3 * b);
  to.flags()[b] = from.flags()[a];
  to.residuals()[b] = from.residuals()[a];
  to.camera_masks()[b] = from.camera_masks()[a];
  if (from.uncertainty().empty()) return;
  to.add_uncertainty();
  to.uncertainty()[b] = from.uncertainty()[a];
}

MarkerSequence crop_frames(const MarkerSequence& take, FrameRange frames) {
  MarkerSequence out = empty_like(take, frames.size(), take.markers());
  out.first_frame = 1;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    for (std::size_t m = 0; m < take.marker_count(); ++m) {
      copy_sample(take, take.sample(frames.begin + f, m), out, out.sample(f, m));
    }
    if (!take.unlabelled.offsets.empty()) {
      copy_unlabelled(take.unlabelled, frames.begin + f, out.unlabelled);
    }
  }
  if (has_analog(take)) {
    const std::size_t per_frame = analog_per_frame(take);
    out.analog.channels = take.analog.channels;
    out.analog.rate_hz = take.analog.rate_hz;
    out.analog.samples_per_frame = take.analog.samples_per_frame;
    out.analog.values = Buffer<float>(frames.size() * per_frame);
    std::copy_n(take.analog.values.data() + frames.begin * per_frame, frames.size() * per_frame,
                out.analog.values.data());
  }
  out.rotations = rotations_in(take.rotations, frames);
  if (!(take.rate_hz > 0.0)) return out;
  const double cut = start_time(take) + static_cast<double>(frames.begin) / take.rate_hz;
  const double length = static_cast<double>(frames.size()) / take.rate_hz;
  const double half = 0.5 / take.rate_hz;  // an event between two frames belongs to the nearer
  for (Event& e : out.events) e.time_s -= cut;
  std::erase_if(out.events,
                [&](const Event& e) { return e.time_s < -half || e.time_s > length - half; });
  for (Event& e : out.events) e.time_s = std::max(0.0, e.time_s);
  return out;
}

namespace {

/// Turned axes would put the second take elsewhere without a word.
void refuse_other_axes(const Origin& first, const Origin& second) {
  const auto said = [](const Origin& origin) {
    return "x to " + std::string(trim(origin.x_screen)) + ", y to " +
           std::string(trim(origin.y_screen));
  };
  const auto known = [](const Origin& origin) {
    return !trim(origin.x_screen).empty() && !trim(origin.y_screen).empty();
  };
  if (!known(first) || !known(second) || said(first) == said(second)) return;
  throw UsageError({.what = "takes whose axes lie differently on the screen (" + said(first) +
                            "; " + said(second) + ") cannot be joined",
                    .remedy = "Join before the step that turns the axes"});
}

/// A few words of a list must not ask for more memory than a machine has.
void refuse_huge(double frames, std::size_t markers, const std::string& how,
                 const std::string& remedy) {
  constexpr double most_samples = 1e8;  // 2.2 GB; an hour of 100 markers at 100 Hz is 4e7
  const double samples = frames * static_cast<double>(std::max<std::size_t>(1, markers));
  if (!(samples > most_samples)) return;
  throw UsageError({.what = how + ", the take would have " + format_fixed(samples / 1e6, 0) +
                            " million samples (frames × markers); 100 million are the most",
                    .remedy = remedy});
}

}  // namespace

MarkerSequence join_takes(const MarkerSequence& first, const MarkerSequence& second,
                          std::size_t pause, std::vector<std::string>* notes) {
  refuse_other_axes(first.origin, second.origin);
  if (std::abs(first.rate_hz - second.rate_hz) > 1e-6 * first.rate_hz) {
    throw UsageError({.what = "takes of " + format_number(first.rate_hz) + " and " +
                              format_number(second.rate_hz) + " Hz cannot be joined",
                      .remedy = "Resample one of them to the rate of the other first"});
  }
  std::vector<Marker> markers = first.markers();
  std::vector<std::size_t> column;
  for (const Marker& m : second.markers()) {
    // Of markers that exist twice the first goes to the first, the second to the second.
    const auto it = std::ranges::find_if(markers, [&](const Marker& other) {
      const auto k = static_cast<std::size_t>(&other - markers.data());
      return same_marker(m, other) && std::ranges::find(column, k) == column.end();
    });
    const auto k = static_cast<std::size_t>(it - markers.begin());
    if (it == markers.end()) markers.push_back(m);
    column.push_back(k);
  }
  if (notes != nullptr && markers.size() > first.marker_count()) {
    notes->push_back(count_of(markers.size() - first.marker_count(), "marker") +
                     " of it had none of the same subject and label in the take");
  }
  const std::size_t shift = first.frame_count() + pause;
  refuse_huge(static_cast<double>(shift) + static_cast<double>(second.frame_count()),
              markers.size(), "joined with a pause of " + count_of(pause, "frame"),
              "Give a shorter 'pause', or crop the takes first");
  MarkerSequence out = empty_like(first, shift + second.frame_count(), markers);
  const bool loose = !first.unlabelled.offsets.empty() || !second.unlabelled.offsets.empty();
  for (std::size_t f = 0; f < out.frame_count(); ++f) {
    const bool late = f >= shift;
    const MarkerSequence& from = late ? second : first;
    const std::size_t g = late ? f - shift : f;
    const bool there = late || f < first.frame_count();
    for (std::size_t m = 0; there && m < from.marker_count(); ++m) {
      copy_sample(from, from.sample(g, m), out, out.sample(f, late ? column[m] : m));
    }
    if (loose) {
      static const UnlabelledPoints none;
      copy_unlabelled(there ? from.unlabelled : none, g, out.unlabelled);
    }
  }
  join_analog(first, second, pause, out, notes);
  RotationData behind = second.rotations;
  scale_rotations(behind, millimetres_in(second.origin.unit).value_or(1.0) /
                              millimetres_in(first.origin.unit).value_or(1.0));
  out.rotations = joined_rotations(first.rotations, first.frame_count(), behind, pause);
  const bool turning = !first.rotations.values.empty() || !second.rotations.values.empty();
  if (turning && out.rotations.values.empty() && notes != nullptr) {
    notes->push_back(
        "the rotations are left out, because the takes differ in their number or rate");
  }
  if (first.rate_hz > 0.0) {
    const double later =
        start_time(first) - start_time(second) + static_cast<double>(shift) / first.rate_hz;
    for (Event e : second.events) {
      e.time_s += later;
      out.events.push_back(std::move(e));
    }
  }
  return out;
}

MarkerSequence resample_take(const MarkerSequence& take, double rate_hz, const RunContext& ctx) {
  if (!(take.rate_hz > 0.0)) {
    throw UsageError({.what = "the take has no frame rate and cannot be resampled"});
  }
  const double step = take.rate_hz / rate_hz;
  Grid grid{step, 0};
  if (take.frame_count() > 0) {
    const double last = static_cast<double>(take.frame_count() - 1) / step;
    refuse_huge(last, take.marker_count(), "resampled to " + format_number(rate_hz) + " Hz",
                "Give a lower 'rate'");
    grid.frames = static_cast<std::size_t>(std::floor(last * (1.0 + 1e-12) + 1e-9)) + 1;
  }
  MarkerSequence out = empty_like(take, grid.frames, take.markers());
  out.rate_hz = rate_hz;
  out.first_frame = 1 + std::llround(static_cast<double>(take.first_frame - 1) / step);
  for (Event& e : out.events) e.time_s += start_time(out) - start_time(take);
  parallel_for(ctx, take.marker_count(), 1, [&](std::size_t m) {
    const auto usable = [&](std::size_t f) {
      return take.valid(f, m) && take.position(f, m).allFinite();
    };
    for (std::size_t f = 0; f < take.frame_count(); ++f) {
      if (!usable(f)) continue;
      FrameRange run{f, f};
      while (run.end < take.frame_count() && usable(run.end)) ++run.end;
      resample_run(take, m, run, grid, out);
      f = run.end;
    }
  });
  for (std::size_t f = 0; f < grid.frames && !take.unlabelled.offsets.empty(); ++f) {
    copy_unlabelled(take.unlabelled, static_cast<std::size_t>(std::lround(grid.at(f))),
                    out.unlabelled);
  }
  resample_analog(take, grid, out);
  return out;
}

}  // namespace kinemesh
