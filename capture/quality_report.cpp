// Text, JSON and picture of quality.h.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/quality.h"
#include "config/text.h"
#include "report/chart.h"

namespace kinemesh {
namespace {

std::string number(double value, int decimals, const char* unit) {
  return std::isfinite(value) ? format_fixed(value, decimals) + " " + unit : "not known";
}

/// Frame numbers of the file as x.
std::vector<double> frame_axis(const QualityResult& r) {
  std::vector<double> x(r.frames);
  for (std::size_t f = 0; f < r.frames; ++f) {
    x[f] = static_cast<double>(r.first_frame) + static_cast<double>(f);
  }
  return x;
}

double at_frame(const QualityResult& r, std::size_t f) {
  return static_cast<double>(r.first_frame) + static_cast<double>(f);
}

LineChart visibility_chart(const QualityResult& r) {
  LineChart chart;
  chart.title = "Markers seen";
  chart.x = {.label = "frame", .integer = true};
  chart.y = {.label = "seen", .unit = "%", .low = 0.0, .high = 100.0};
  chart.series.push_back(
      {.label = "", .x = frame_axis(r), .y = r.visible_over_time, .colour = series_colour(0)});
  bool stray = false;
  for (const Stray& s : r.strays) {
    chart.bands.push_back({at_frame(r, s.frames.begin) - 0.5, at_frame(r, s.frames.end) - 0.5,
                           missing_colour, stray ? "" : "at another place"});
    stray = true;
  }
  bool named = false;
  for (const Spike& s : r.spikes) {
    chart.bands.push_back({at_frame(r, s.frames.begin) - 0.5, at_frame(r, s.frames.end) - 0.5,
                           filled_colour, named ? "" : "spike"});
    named = true;
  }
  for (const LabelSwap& s : r.swaps) {
    chart.instants.push_back(
        {at_frame(r, s.from), "swap " + r.labels[s.a] + " / " + r.labels[s.b]});
  }
  return chart;
}

LineChart head_chart(const QualityResult& r) {
  LineChart chart;
  chart.title = "Error of the rigid markers, by frame";
  chart.x = {.label = "frame", .integer = true};
  chart.y = {.label = "error", .unit = "mm", .from_zero = true};
  chart.series.push_back(
      {.label = "", .x = frame_axis(r), .y = r.head_error_over_time, .colour = series_colour(1)});
  return chart;
}

LineChart turn_chart(const QualityResult& r) {
  LineChart chart;
  chart.title = "Head rotation from the reference frame";
  chart.x = {.label = "frame", .integer = true};
  chart.y = {.label = "rotation", .unit = "°", .from_zero = true};
  chart.series.push_back(
      {.label = "", .x = frame_axis(r), .y = r.turn_over_time, .colour = series_colour(2)});
  return chart;
}

template <class Value>
BarChart worst_markers(const QualityResult& r, const std::string& title, const std::string& unit,
                       int decimals, Value value) {
  std::vector<BarChart::Bar> bars;
  for (const MarkerQuality& m : r.per_marker) {
    if (std::isfinite(value(m))) bars.push_back({m.label, value(m), series_colour(0)});
  }
  std::ranges::stable_sort(bars, [](const auto& a, const auto& b) { return a.value > b.value; });
  constexpr std::size_t most = 12;
  bars.resize(std::min(most, bars.size()));
  BarChart chart;
  chart.title = title;
  chart.value = {.label = "", .unit = unit, .from_zero = true};
  chart.decimals = decimals;
  chart.bars = std::move(bars);
  return chart;
}

nlohmann::ordered_json or_null(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
}

}  // namespace

namespace {

std::string frames_of(const QualityResult& r, const FrameRange& frames) {
  const auto number = [&](std::size_t f) {
    return std::to_string(r.first_frame + static_cast<int64_t>(f));
  };
  if (frames.size() == 1) return "frame " + number(frames.begin);
  return "frames " + number(frames.begin) + " to " + number(frames.end - 1);
}

/// The line in as many lines as it needs, broken between words.
std::vector<std::string> wrapped(const std::string& text, double width, const TextStyle& style) {
  std::vector<std::string> lines(1);
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    const std::string longer = lines.back().empty() ? word : lines.back() + " " + word;
    if (lines.back().empty() || text_width(longer, style) <= width) {
      lines.back() = longer;
    } else {
      lines.push_back(word);
    }
    begin = end + 1;
  }
  return lines;
}

}  // namespace

std::string quality_line(const QualityResult& r) {
  const std::string line(name_of(r.verdict));
  return r.reasons.empty() ? line : line + ": " + join(r.reasons, "; ");
}

std::string quality_text(const QualityResult& r) {
  std::string out = "verdict       " + quality_line(r) + "\n";
  const auto row = [&](const std::string& name, const std::string& value) {
    out += name + std::string(14 - std::min<std::size_t>(13, name.size()), ' ') + value + "\n";
  };
  row("take", count_of(r.markers, "marker") + ", " + count_of(r.frames, "frame") + ", " +
                  format_fixed(r.duration_s, 2) + " s");
  row("visible", format_fixed(r.visible_percent, 2) + " % of the samples; " +
                     count_of(r.lost_markers, "marker") + " lost");
  row("noise", number(r.noise_mm, 3, "mm (median over markers, one coordinate)"));
  row("residuals", number(r.residual_mm, 3, "mm (median)"));
  row("swaps", std::to_string(count_swaps(r.swaps)));
  for (const LabelSwap& s : r.swaps) {
    row("", r.labels[s.a] + " and " + r.labels[s.b] +
                (s.until ? ", " + frames_of(r, {s.from, *s.until})
                         : " from " + frames_of(r, {s.from, s.from + 1})) +
                (s.of > 2 ? ", of " + std::to_string(s.of) + " labels that went round" : ""));
  }
  constexpr std::size_t most = 10;
  row("strays", std::to_string(r.strays.size()));
  for (std::size_t i = 0; i < std::min(most, r.strays.size()); ++i) {
    const Stray& s = r.strays[i];
    row("", r.labels[s.marker] + ", " + frames_of(r, s.frames) + ", " + format_fixed(s.off_mm, 1) +
                " mm from its place" + (s.owner ? ", at that of " + r.labels[*s.owner] : ""));
  }
  if (r.strays.size() > most) row("", "… and " + std::to_string(r.strays.size() - most) + " more");
  row("jumps", std::to_string(r.jumps.size()));
  for (std::size_t i = 0; i < std::min(most, r.jumps.size()); ++i) {
    row("", r.labels[r.jumps[i].marker] + " in frame " +
                std::to_string(r.first_frame + static_cast<int64_t>(r.jumps[i].frame)) + ", " +
                format_fixed(r.jumps[i].size_mm, 1) + " mm, and stays there");
  }
  if (r.jumps.size() > most) row("", "… and " + std::to_string(r.jumps.size() - most) + " more");
  row("spikes", std::to_string(r.spikes.size()));
  for (std::size_t i = 0; i < std::min(most, r.spikes.size()); ++i) {
    const Spike& s = r.spikes[i];
    row("", r.labels[s.marker] + " in frame " +
                std::to_string(r.first_frame + static_cast<int64_t>(s.frames.begin)) + ", " +
                format_fixed(s.deviation_mm, 1) + " mm");
  }
  if (r.spikes.size() > most) row("", "… and " + std::to_string(r.spikes.size() - most) + " more");
  row("dropped", count_of(r.dropped_frames, "frame") + "; " + count_of(r.repeated_frames, "frame") +
                     " repeated");
  row("head", r.head.known ? "turns by up to " + format_fixed(r.head.turn_degrees, 1) +
                                 "°, moves by up to " + format_fixed(r.head.way_mm, 0) +
                                 " mm, up to " + format_fixed(r.head.speed_mm_s, 0) + " mm/s; " +
                                 count_of(r.head.markers.size(), "rigid marker") + ", error " +
                                 format_fixed(r.head.error_mm, 2) + " mm"
                           : "not known: no three markers move as one body");
  return out;
}

std::string quality_json(const QualityResult& r, const std::string& file) {
  using Json = nlohmann::ordered_json;
  const auto frame = [&](std::size_t f) { return r.first_frame + static_cast<int64_t>(f); };
  Json json = {{"file", file},
               {"verdict", name_of(r.verdict)},
               {"reasons", r.reasons},
               {"frames", r.frames},
               {"markers", r.markers},
               {"duration_s", r.duration_s},
               {"visible_percent", r.visible_percent},
               {"lost_markers", r.lost_markers},
               {"longest_blind_s", r.longest_blind_s},
               {"points_without_label", r.loose_points},
               {"labels_used_twice", r.twins},
               {"noise_mm", or_null(r.noise_mm)},
               {"residual_mm", or_null(r.residual_mm)},
               {"dropped_frames", r.dropped_frames},
               {"repeated_frames", r.repeated_frames},
               {"swaps", Json::array()},
               {"strays", Json::array()},
               {"jumps", Json::array()},
               {"spikes", Json::array()},
               {"head", nullptr},
               {"per_marker", Json::array()}};
  for (const LabelSwap& s : r.swaps) {
    json["swaps"].push_back({{"a", r.labels[s.a]},
                             {"b", r.labels[s.b]},
                             {"from_frame", frame(s.from)},
                             {"to_frame", s.until ? Json(frame(*s.until - 1)) : Json()},
                             {"of_labels", s.of},
                             {"error_mm", s.error_mm},
                             {"mended_mm", s.mended_mm}});
  }
  for (const Stray& s : r.strays) {
    json["strays"].push_back({{"marker", r.labels[s.marker]},
                              {"first_frame", frame(s.frames.begin)},
                              {"last_frame", frame(s.frames.end - 1)},
                              {"off_mm", s.off_mm},
                              {"belongs_to", s.owner ? Json(r.labels[*s.owner]) : Json()}});
  }
  for (const Jump& j : r.jumps) {
    json["jumps"].push_back(
        {{"marker", r.labels[j.marker]}, {"frame", frame(j.frame)}, {"size_mm", j.size_mm}});
  }
  for (const Spike& s : r.spikes) {
    json["spikes"].push_back({{"marker", r.labels[s.marker]},
                              {"first_frame", frame(s.frames.begin)},
                              {"last_frame", frame(s.frames.end - 1)},
                              {"deviation_mm", s.deviation_mm}});
  }
  if (r.head.known) {
    json["head"] = {{"turn_degrees", r.head.turn_degrees},
                    {"way_mm", r.head.way_mm},
                    {"speed_mm_s", r.head.speed_mm_s},
                    {"error_mm", r.head.error_mm},
                    {"rigid_markers", r.head.markers}};
  }
  for (const MarkerQuality& m : r.per_marker) {
    json["per_marker"].push_back({{"label", m.label},
                                  {"visible_percent", m.visible_percent},
                                  {"longest_gap_s", m.longest_gap_s},
                                  {"noise_mm", or_null(m.noise_mm)},
                                  {"residual_mm", or_null(m.residual_mm)},
                                  {"spikes", m.spikes}});
  }
  return json.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

Canvas draw_quality(const QualityResult& r, const std::string& title) {
  const bool head = r.head.known;
  BarChart missing = worst_markers(r, "Least seen: missing", "%", 1, [](const MarkerQuality& m) {
    return 100.0 - m.visible_percent;
  });
  const BarChart noise =
      worst_markers(r, "Noisiest", "mm", 3, [](const MarkerQuality& m) { return m.noise_mm; });
  std::erase_if(missing.bars, [](const auto& bar) { return bar.value <= 0.0; });
  constexpr double width = 1200.0, row = 230.0, margin = 16.0, line = 20.0;
  TextStyle style{.size = 14.0, .bold = true};
  const std::vector<std::string> verdict = wrapped(quality_line(r), width - 2.0 * margin, style);
  const double top = 56.0 + line * static_cast<double>(verdict.size());
  const double bars = std::max({120.0, missing.natural_height(), noise.natural_height()});
  Canvas canvas(width, top + (head ? 3.0 : 1.0) * row + bars + 2.0 * margin);
  const Colour colours[] = {colour_from_hex(0x1a7f37), colour_from_hex(0xb35900), missing_colour,
                            colour_from_hex(0xb35900)};
  canvas.text({margin, 28.0}, title, {.size = 18.0, .bold = true});
  style.colour = colours[static_cast<int>(r.verdict)];
  for (std::size_t i = 0; i < verdict.size(); ++i) {
    canvas.text({margin, 54.0 + line * static_cast<double>(i)}, verdict[i], style);
  }
  const auto place = [&](int i) {
    return Box{margin, top + i * row, width - 2.0 * margin, row - margin};
  };
  if (r.frames > 0) visibility_chart(r).draw(canvas, place(0));
  if (head) {
    turn_chart(r).draw(canvas, place(1));
    head_chart(r).draw(canvas, place(2));
  }
  const double y = top + (head ? 3.0 : 1.0) * row;
  const double half = 0.5 * width - 1.5 * margin;
  if (!missing.bars.empty()) missing.draw(canvas, {margin, y, half, missing.natural_height()});
  if (!noise.bars.empty()) {
    noise.draw(canvas, {2.0 * margin + half, y, half, noise.natural_height()});
  }
  return canvas;
}

}  // namespace kinemesh
