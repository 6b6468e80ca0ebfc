#include "capture/formats/session_export.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "capture/formats/session_csv.h"
#include "capture/formats/table_text.h"
#include "capture/formats/trc.h"
#include "config/error.h"
#include "config/output_file.h"
#include "config/text.h"
#include "mesh/formats/npz.h"

namespace kinemesh {
namespace fs = std::filesystem;
namespace {

fs::path beside(const fs::path& path, const std::string& part) {
  fs::path other = path;
  other.replace_extension(part + path.extension().string());
  return other;
}

/// Seconds since recorded frame 1.
double time_of_frame(const MarkerSequence& take, std::size_t f) {
  return take.rate_hz > 0
             ? static_cast<double>(take.first_frame - 1 + static_cast<int64_t>(f)) / take.rate_hz
             : 0.0;
}

double time_of_sample(const MarkerSequence& take, std::size_t s) {
  const double start = time_of_frame(take, 0);
  return take.analog.rate_hz > 0 ? start + static_cast<double>(s) / take.analog.rate_hz : start;
}

std::size_t analog_sample_count(const MarkerSequence& take) {
  return take.analog.channels.empty() ? 0 : take.analog.values.size() / take.analog.channels.size();
}

/// Appends the shortest text that reads back the same; `otherwise` for no finite number.
void append_finite(std::string& out, float value, std::string_view otherwise) {
  if (!std::isfinite(value)) {
    out += otherwise;
    return;
  }
  append_number(out, value);
}

void write_analog_csv(const MarkerSequence& take, OutputFile& file, const RunContext& ctx) {
  std::string row = "time_s";
  for (const AnalogData::Channel& c : take.analog.channels) {
    row += "," + quote_cell(c.unit.empty() ? c.label : c.label + " (" + c.unit + ")", ',');
  }
  file.write(row + "\n");
  const std::size_t channels = take.analog.channels.size();
  for (std::size_t s = 0; s < analog_sample_count(take); ++s) {
    if (s % 4096 == 0) ctx.check_cancelled();
    row = format_number(time_of_sample(take, s));
    for (std::size_t c = 0; c < channels; ++c) {
      row += ',';
      append_finite(row, take.analog.values[s * channels + c], "");
    }
    file.write(row += '\n');
  }
}

std::string events_csv(const MarkerSequence& take) {
  std::string text = "time_s,label,context,subject\n";
  for (const Event& e : take.events) {
    text += format_number(e.time_s) + "," + quote_cell(e.label, ',') + "," +
            quote_cell(e.context, ',') + "," + quote_cell(e.subject, ',') + "\n";
  }
  return text;
}

void export_csv(const MarkerSequence& take, const fs::path& path, const RunContext& ctx,
                SessionExportResult& result) {
  OutputSet files;
  OutputFile points(path);
  write_session_csv(take, points, ctx);
  files.add(std::move(points));
  if (!take.analog.channels.empty()) {
    OutputFile analog(beside(path, ".analog"));
    write_analog_csv(take, analog, ctx);
    files.add(std::move(analog));
  }
  if (!take.events.empty()) files.add(beside(path, ".events"), events_csv(take));
  result.files = files.paths();
  files.commit();
}

nlohmann::ordered_json describe(const MarkerSequence& take) {
  using Json = nlohmann::ordered_json;
  Json json = {{"format", "kinemesh session 1"},
               {"file", take.origin.path},
               {"unit", "mm"},
               {"rate_hz", take.rate_hz},
               {"first_frame", take.first_frame},
               {"frames", take.frame_count()},
               {"markers", Json::array()},
               {"events", Json::array()}};
  for (const Marker& m : take.markers()) {
    json["markers"].push_back({{"label", m.label},
                               {"subject", m.subject},
                               {"kind", name_of(m.kind)},
                               {"unit", m.unit},
                               {"description", m.description}});
  }
  for (const Event& e : take.events) {
    json["events"].push_back(
        {{"label", e.label}, {"context", e.context}, {"subject", e.subject}, {"time_s", e.time_s}});
  }
  return json;
}

/// Writes `"name": [` row after row `]`, one row a line; `row(i, text)` appends one row.
template <class AppendRow>
void write_rows(OutputFile& file, std::string_view name, std::size_t count, const RunContext& ctx,
                AppendRow&& append_row) {
  file.write(",\n\"" + std::string(name) + "\": [");
  std::string text;
  for (std::size_t i = 0; i < count; ++i) {
    if (i % 1024 == 0) ctx.check_cancelled();
    text = i == 0 ? "\n" : ",\n";
    append_row(i, text);
    file.write(text);
  }
  file.write("]");
}

void write_json(const MarkerSequence& take, OutputFile& file, const RunContext& ctx) {
  // The large arrays are written as text: as a JSON tree they would take many times their size.
  std::string head = describe(take).dump(1, ' ', false, nlohmann::json::error_handler_t::replace);
  head.resize(head.rfind('}'));
  while (head.ends_with('\n')) head.pop_back();
  file.write(head);
  const std::size_t markers = take.marker_count();
  write_rows(file, "times_s", take.frame_count(), ctx, [&](std::size_t f, std::string& text) {
    text += format_number(time_of_frame(take, f));
  });
  write_rows(file, "positions", take.frame_count(), ctx, [&](std::size_t f, std::string& text) {
    text += '[';
    for (std::size_t m = 0; m < markers; ++m) {
      text += m == 0 ? "[" : ",[";
      for (int k = 0; k < 3; ++k) {
        if (k > 0) text += ',';
        append_finite(text, take.valid(f, m) ? take.position(f, m)[k] : NAN, "null");
      }
      text += ']';
    }
    text += ']';
  });
  const std::vector<uint8_t> valid = validity_codes(take);
  write_rows(file, "valid", take.frame_count(), ctx, [&](std::size_t f, std::string& text) {
    text += '[';
    for (std::size_t m = 0; m < markers; ++m) {
      if (m > 0) text += ',';
      text += static_cast<char>('0' + valid[take.sample(f, m)]);
    }
    text += ']';
  });
  write_rows(file, "residuals", take.frame_count(), ctx, [&](std::size_t f, std::string& text) {
    text += '[';
    for (std::size_t m = 0; m < markers; ++m) {
      if (m > 0) text += ',';
      append_finite(text, take.valid(f, m) ? take.residuals()[take.sample(f, m)] : NAN, "null");
    }
    text += ']';
  });
  if (!take.uncertainty().empty()) {
    write_rows(file, "uncertainties", take.frame_count(), ctx,
               [&](std::size_t f, std::string& text) {
                 text += '[';
                 for (std::size_t m = 0; m < markers; ++m) {
                   if (m > 0) text += ',';
                   append_finite(text, take.uncertainty()[take.sample(f, m)], "null");
                 }
                 text += ']';
               });
  }
  nlohmann::ordered_json analog = {{"rate_hz", take.analog.rate_hz},
                                   {"channels", nlohmann::ordered_json::array()}};
  for (const AnalogData::Channel& c : take.analog.channels) {
    analog["channels"].push_back(
        {{"label", c.label}, {"unit", c.unit}, {"description", c.description}});
  }
  std::string analog_head = analog.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  analog_head.pop_back();
  file.write(",\n\"analog\": " + analog_head);
  const std::size_t channels = take.analog.channels.size();
  write_rows(file, "values", analog_sample_count(take), ctx, [&](std::size_t s, std::string& text) {
    text += '[';
    for (std::size_t c = 0; c < channels; ++c) {
      if (c > 0) text += ',';
      append_finite(text, take.analog.values[s * channels + c], "null");
    }
    text += ']';
  });
  file.write("}\n}\n");
}

template <class Items, class Member>
std::vector<std::string> texts_of(const Items& items, Member member) {
  std::vector<std::string> texts;
  texts.reserve(items.size());
  for (const auto& item : items) texts.emplace_back(std::invoke(member, item));
  return texts;
}

void export_npz(const MarkerSequence& take, const fs::path& path) {
  NpzWriter npz;
  const std::size_t frames = take.frame_count();
  const std::size_t markers = take.marker_count();
  const std::vector<uint8_t> valid = validity_codes(take);
  std::vector<float> positions(take.positions().begin(), take.positions().end());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (valid[i / 3] == 0) positions[i] = std::numeric_limits<float>::quiet_NaN();
  }
  std::vector<double> times(frames);
  for (std::size_t f = 0; f < frames; ++f) times[f] = time_of_frame(take, f);
  npz.add("positions", {frames, markers, 3}, std::span<const float>(positions));
  npz.add("valid", {frames, markers}, std::span<const uint8_t>(valid));
  npz.add("residuals", {frames, markers}, take.residuals());
  if (!take.uncertainty().empty()) {
    npz.add("uncertainties", {frames, markers}, take.uncertainty());
  }
  npz.add("camera_masks", {frames, markers}, take.camera_masks());
  npz.add("times_s", {frames}, std::span<const double>(times));
  npz.add("labels", texts_of(take.markers(), &Marker::label));
  npz.add("subjects", texts_of(take.markers(), &Marker::subject));
  npz.add("kinds", texts_of(take.markers(), [](const Marker& m) { return name_of(m.kind); }));
  npz.add("units", texts_of(take.markers(), &Marker::unit));
  npz.add("rate_hz", take.rate_hz);
  npz.add("first_frame", static_cast<double>(take.first_frame));
  const std::size_t samples = analog_sample_count(take);
  npz.add("analog", {samples, take.analog.channels.size()}, take.analog.values.span());
  npz.add("analog_labels", texts_of(take.analog.channels, &AnalogData::Channel::label));
  npz.add("analog_units", texts_of(take.analog.channels, &AnalogData::Channel::unit));
  npz.add("analog_rate_hz", take.analog.rate_hz);
  const RotationData& r = take.rotations;
  if (!r.values.empty()) {
    npz.add("rotations", {take.frame_count() * r.samples_per_frame, r.count, 17}, r.values.span());
  }
  std::vector<double> event_times;
  for (const Event& e : take.events) event_times.push_back(e.time_s);
  npz.add("event_labels", texts_of(take.events, &Event::label));
  npz.add("event_contexts", texts_of(take.events, &Event::context));
  npz.add("event_subjects", texts_of(take.events, &Event::subject));
  npz.add("event_times_s", {event_times.size()}, std::span<const double>(event_times));
  npz.write(path);
}

void list_left_out(const MarkerSequence& take, ExportFormat format, SessionExportResult& result) {
  const std::size_t unlabelled = take.unlabelled.positions.size();
  if (unlabelled > 0)
    result.left_out.push_back(count_of(unlabelled, "point") + " without identity");
  if (!take.rotations.values.empty() && format != ExportFormat::npz)
    result.left_out.push_back(count_of(take.rotations.count, "rotation"));
  const auto not_zero = [](auto value) { return value != 0; };
  if (format == ExportFormat::trc && std::ranges::any_of(take.residuals(), not_zero))
    result.left_out.emplace_back("residuals");
  if (format == ExportFormat::trc && !take.uncertainty().empty())
    result.left_out.emplace_back("the uncertainty of filled samples");
  if (format != ExportFormat::npz && std::ranges::any_of(take.camera_masks(), not_zero))
    result.left_out.emplace_back("camera masks");
  if (format != ExportFormat::trc) return;
  std::size_t others = 0;
  for (const Marker& m : take.markers()) others += m.kind > MarkerKind::virtual_point ? 1 : 0;
  if (others > 0) {
    result.left_out.push_back(
        count_of(others, "angle, force or other column", "angles, forces and other columns"));
  }
  if (!take.analog.channels.empty()) {
    result.left_out.push_back(count_of(take.analog.channels.size(), "analog channel"));
  }
  if (!take.events.empty()) result.left_out.push_back(count_of(take.events.size(), "event"));
}

}  // namespace

ExportFormat export_format_of(const fs::path& path, const std::string& others) {
  const std::string extension = lower(path.extension().string());
  if (extension == ".csv") return ExportFormat::csv;
  if (extension == ".trc") return ExportFormat::trc;
  if (extension == ".json") return ExportFormat::json;
  if (extension == ".npz") return ExportFormat::npz;
  throw UsageError({.what = "'" + path.string() + "' has none of the extensions " + others +
                            ".csv, .trc, .json and .npz, which choose the format",
                    .remedy = "Give the output such an extension"});
}

std::vector<uint8_t> validity_codes(const MarkerSequence& take) {
  std::vector<uint8_t> codes(take.sample_count());
  for (std::size_t i = 0; i < codes.size(); ++i) {
    const uint8_t flags = take.flags()[i];
    if ((flags & SampleFlag::valid) != 0) codes[i] = (flags & SampleFlag::filled) != 0 ? 2 : 1;
  }
  return codes;
}

SessionExportResult export_session(const MarkerSequence& take, const fs::path& path,
                                   const RunContext& ctx) {
  const ExportFormat format = export_format_of(path);
  SessionExportResult result;
  list_left_out(take, format, result);
  if (format == ExportFormat::csv) {
    export_csv(take, path, ctx, result);
    return result;
  }
  result.files = {path};
  if (format == ExportFormat::trc) {
    write_trc(take, path, ctx);
  } else if (format == ExportFormat::json) {
    OutputFile file(path);
    write_json(take, file, ctx);
    file.commit();
  } else {
    export_npz(take, path);
  }
  return result;
}

}  // namespace kinemesh
