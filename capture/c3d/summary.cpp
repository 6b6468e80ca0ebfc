#include "capture/c3d/summary.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/c3d/number_format.h"
#include "capture/formats/table_text.h"
#include "capture/gaps.h"
#include "config/text.h"

namespace kinemesh {
namespace {

/// Columns of a table, padded to the widest cell; numbers to the right.
std::string table(const std::vector<std::vector<std::string>>& rows,
                  const std::vector<bool>& to_the_right) {
  // Width in characters, not in bytes: labels may be UTF-8.
  const auto width_of = [](const std::string& text) {
    return static_cast<std::size_t>(std::ranges::count_if(
        text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
  };
  std::vector<std::size_t> widths(to_the_right.size());
  for (const auto& row : rows) {
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], width_of(row[c]));
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line = " ";
    for (std::size_t c = 0; c < row.size(); ++c) {
      const std::string padding(widths[c] - width_of(row[c]), ' ');
      line += " " + (to_the_right[c] ? padding + row[c] : row[c] + padding) + " ";
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

std::string points_line(const C3dSummary& s) {
  std::vector<std::string> kinds;
  for (const std::string_view kind :
       {"marker", "unlabelled", "virtual", "angle", "force", "moment", "power", "scalar"}) {
    const auto count = static_cast<std::size_t>(
        std::ranges::count_if(s.markers, [&](const MarkerSummary& m) { return m.kind == kind; }));
    if (count == 0) continue;
    const bool invariable = kind == "unlabelled" || kind == "virtual";
    kinds.push_back(invariable ? std::to_string(count) + " " + std::string(kind)
                               : count_of(count, kind));
  }
  return kinds.empty() ? "none" : join(kinds, ", ");
}

std::string stored_as(const C3dSummary& s) {
  if (s.processor.empty()) return s.format;
  const std::string processor = s.processor == "intel" ? "Intel (PC)"
                                : s.processor == "dec" ? "DEC (VAX)"
                                                       : "SGI (MIPS)";
  if (s.storage == "float") return s.format + ", " + processor + ", floating-point numbers";
  return s.format + ", " + processor + ", integers in steps of " +
         format_number(std::round(s.scale * 1e6) / 1e6) + " mm";
}

std::string axes_line(const C3dSummary& s) {
  if (s.x_screen.empty() && s.y_screen.empty()) return "not given";
  const auto word = [](const std::string& axis) { return axis.empty() ? "not given" : axis; };
  return "to the right " + word(s.x_screen) + ", up " + word(s.y_screen);
}

std::string gap_table(const C3dSummary& s) {
  std::vector<std::vector<std::string>> rows = {{"Marker", "Kind", "Missing", "Gaps", "Longest"}};
  std::size_t complete = 0;
  for (const MarkerSummary& m : s.markers) {
    if (m.gaps == 0) {
      ++complete;
      continue;
    }
    rows.push_back({qualified_label(m.subject, m.label), m.kind,
                    format_fixed(m.missing_percent, 1) + " %", std::to_string(m.gaps),
                    format_fixed(m.longest_gap_s, 2) + " s"});
  }
  if (s.markers.empty() || s.frames == 0) return "";
  if (rows.size() == 1) return "\nNo gaps: every point is there in every frame.\n";
  std::string text = "\nGaps\n" + table(rows, {false, false, true, true, true});
  if (complete > 0) {
    text += "  " +
            std::string(complete == 1 ? "1 point has" : std::to_string(complete) + " points have") +
            " no gap.\n";
  }
  return text;
}

}  // namespace

C3dSummary summarise(const MarkerSequence& take, const C3dLayout* layout,
                     const std::string& format) {
  C3dSummary s;
  s.file = take.origin.path;
  s.format = format;
  s.points = take.marker_count();
  s.frames = take.frame_count();
  s.first_frame = take.first_frame;
  s.rate_hz = take.rate_hz;
  s.duration_s = take.rate_hz > 0 ? static_cast<double>(s.frames) / take.rate_hz : 0.0;
  s.unit = take.origin.unit;
  s.x_screen = take.origin.x_screen;
  s.y_screen = take.origin.y_screen;
  s.manufacturer = take.origin.manufacturer;
  if (layout != nullptr) {
    s.processor = name_of(layout->processor);
    s.storage = name_of(layout->storage);
    const double millimetres = millimetres_per(take.origin.unit).value_or(1.0);
    s.scale = layout->storage == Storage::integer ? std::abs(layout->scale) * millimetres : 0.0;
  }
  s.rotations = take.rotations.count;
  s.analog_channels = take.analog.channels.size();
  s.analog_rate_hz = s.analog_channels > 0 ? take.analog.rate_hz : 0.0;
  for (const AnalogData::Channel& c : take.analog.channels) s.analog_labels.push_back(c.label);
  s.events = take.events;
  for (const MarkerGaps& gaps : find_gaps(take)) {
    const Marker& marker = take.markers()[gaps.marker];
    if (!marker.subject.empty() &&
        std::ranges::find(s.subjects, marker.subject) == s.subjects.end()) {
      s.subjects.push_back(marker.subject);
    }
    s.markers.push_back(
        {.label = marker.label,
         .subject = marker.subject,
         .kind = std::string(name_of(marker.kind)),
         .unit = marker.unit,
         .valid_frames = s.frames - gaps.missing,
         .gaps = gaps.gaps.size(),
         .missing_percent = gaps.missing_percent,
         .longest_gap_s = take.rate_hz > 0 ? static_cast<double>(gaps.longest) / take.rate_hz : 0.0,
         .longest_gap_frames = gaps.longest});
    if (marker.kind == MarkerKind::marker) {
      s.missing_samples += gaps.missing;
      s.marker_samples += s.frames;
    }
  }
  return s;
}

std::string summary_text(const C3dSummary& s) {
  const auto last_frame = s.first_frame + static_cast<int64_t>(s.frames) - 1;
  std::vector<std::vector<std::string>> rows = {
      {"Recorded with", s.manufacturer.empty() ? "not given" : s.manufacturer},
      {"Subjects", s.subjects.empty() ? "none named" : join(s.subjects, ", ")},
      {"Points", points_line(s)},
      {"Frames", s.frames == 0 ? "none"
                               : std::to_string(s.frames) + " (" + std::to_string(s.first_frame) +
                                     " to " + std::to_string(last_frame) + ")"},
      {"Rate", format_number(std::round(s.rate_hz * 1e4) / 1e4) + " Hz"},
      {"Duration", format_fixed(s.duration_s, 2) + " s"},
      {"Unit", s.unit.empty() ? "not given" : s.unit},
      {"Axes", axes_line(s)},
      {"Analog", s.analog_channels == 0
                     ? "none"
                     : count_of(s.analog_channels, "channel") + " at " +
                           format_number(std::round(s.analog_rate_hz * 1e4) / 1e4) + " Hz"},
      {"Stored as", stored_as(s)}};
  if (s.rotations > 0) rows.push_back({"Rotations", std::to_string(s.rotations)});
  if (s.marker_samples > 0) {
    const double share =
        100.0 * static_cast<double>(s.missing_samples) / static_cast<double>(s.marker_samples);
    rows.push_back({"Missing", format_fixed(share, 1) + " % of all marker positions"});
  }
  std::string text = s.file + "\n" + table(rows, {false, false});
  if (s.events.empty()) {
    text += "  Events         none\n";
  } else {
    text += "\nEvents\n";
    std::vector<std::vector<std::string>> events;
    std::vector<Event> in_time = s.events;
    std::ranges::stable_sort(in_time, {}, &Event::time_s);
    for (const Event& e : in_time) {
      events.push_back({format_fixed(e.time_s, 3) + " s", e.label, e.context, e.subject});
    }
    text += table(events, {true, false, false, false});
  }
  return text + gap_table(s);
}

std::string summary_json(const C3dSummary& s) {
  using Json = nlohmann::ordered_json;
  const auto or_null = [](const std::string& text) { return text.empty() ? Json() : Json(text); };
  Json json = {{"file", s.file},
               {"format", s.format},
               {"manufacturer", s.manufacturer},
               {"subjects", s.subjects},
               {"points", s.points},
               {"frames", s.frames},
               {"first_frame", s.first_frame},
               {"rate_hz", s.rate_hz},
               {"duration_s", s.duration_s},
               {"unit", s.unit},
               {"axes", {{"x_screen", or_null(s.x_screen)}, {"y_screen", or_null(s.y_screen)}}},
               {"processor", or_null(s.processor)},
               {"storage", or_null(s.storage)},
               {"integer_step_mm", s.storage == "int" ? Json(s.scale) : Json()},
               {"analog_channels", s.analog_channels},
               {"analog_rate_hz", s.analog_rate_hz},
               {"analog_labels", s.analog_labels},
               {"rotations", s.rotations},
               {"missing_samples", s.missing_samples},
               {"marker_samples", s.marker_samples},
               {"events", Json::array()},
               {"markers", Json::array()}};
  for (const Event& e : s.events) {
    json["events"].push_back(
        {{"label", e.label}, {"context", e.context}, {"subject", e.subject}, {"time_s", e.time_s}});
  }
  for (const MarkerSummary& m : s.markers) {
    json["markers"].push_back({{"label", m.label},
                               {"subject", m.subject},
                               {"kind", m.kind},
                               {"unit", m.unit},
                               {"valid_frames", m.valid_frames},
                               {"gaps", m.gaps},
                               {"longest_gap_s", m.longest_gap_s},
                               {"longest_gap_frames", m.longest_gap_frames},
                               {"missing_percent", m.missing_percent}});
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

}  // namespace kinemesh
