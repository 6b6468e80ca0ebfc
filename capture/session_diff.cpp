#include "capture/session_diff.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "capture/formats/table_text.h"
#include "config/text.h"

namespace kinemesh {
namespace {

std::string rounded(double value) {
  const double size = std::abs(value);
  if (size == 0 || !std::isfinite(value)) return format_number(value);
  const int digits = std::max(0, 3 - static_cast<int>(std::floor(std::log10(size))));
  std::string text = format_fixed(value, std::min(digits, 9));
  if (text.find('.') != std::string::npos) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.ends_with('.')) text.pop_back();
  }
  return text;
}

/// A value of the file in a message; long ones are cut.
std::string shown(const std::string& text) {
  return text.size() <= 60 ? text : text.substr(0, 57) + "…";
}

std::string values_of(const C3dParameter& p) {
  std::vector<std::string> words;
  if (p.type == C3dType::text) {
    for (const std::string& s : p.strings()) words.push_back("'" + s + "'");
  } else {
    for (const double v : p.numbers) words.push_back(format_number(v));
  }
  return words.empty() ? "nothing" : shown(join(words, ", "));
}

/// What is counted while two columns are compared.
struct Tally {
  std::size_t count = 0;
  double largest = 0.0;
  std::size_t frame = 0;
  void add(std::size_t f, double difference) {
    if (count++ == 0 || difference > largest) {
      largest = difference;
      frame = f;
    }
  }
};

class Comparison {
 public:
  Comparison(const MarkerSequence& a, const MarkerSequence& b, const SessionDiffOptions& options,
             const RunContext& ctx)
      : a_(a), b_(b), options_(options), ctx_(ctx) {}

  SessionDiffResult run() {
    compare_frames();
    compare_markers();
    compare_events();
    compare_analog();
    compare_rotations();
    if (options_.parameters) compare_parameters();
    return std::move(result_);
  }

 private:
  void add(DifferenceKind kind, std::string place, std::string message, std::size_t count = 0,
           double largest = 0.0, int64_t frame = 0) {
    result_.differences.push_back(
        {kind, std::move(place), std::move(message), count, largest, frame});
  }

  void compare_frames() {
    const auto last = [](const MarkerSequence& t) {
      return t.first_frame + static_cast<int64_t>(t.frame_count()) - 1;
    };
    const auto range = [&](const MarkerSequence& t) {
      return t.frame_count() == 0
                 ? "no frames"
                 : "frames " + std::to_string(t.first_frame) + " to " + std::to_string(last(t));
    };
    if (a_.first_frame != b_.first_frame || a_.frame_count() != b_.frame_count()) {
      add(DifferenceKind::frames, "", range(a_) + " in A, " + range(b_) + " in B");
    }
    begin_ = std::max(a_.first_frame, b_.first_frame);
    end_ = std::max(begin_, std::min(last(a_), last(b_)) + 1);
    if (std::abs(a_.rate_hz - b_.rate_hz) > 1e-6 * std::max(a_.rate_hz, b_.rate_hz)) {
      add(DifferenceKind::rate, "",
          format_number(a_.rate_hz) + " Hz in A, " + format_number(b_.rate_hz) + " Hz in B", 0,
          std::abs(a_.rate_hz - b_.rate_hz));
    }
  }

  void compare_markers() {
    std::map<std::string, std::vector<std::size_t>> in_b;  // several markers may share a name
    for (std::size_t m = b_.marker_count(); m-- > 0;) in_b[name(b_, m)].push_back(m);
    std::vector<bool> matched(b_.marker_count(), false);
    std::vector<std::pair<std::size_t, std::size_t>> pairs;
    for (std::size_t m = 0; m < a_.marker_count(); ++m) {
      auto& candidates = in_b[name(a_, m)];
      if (candidates.empty()) {
        add(DifferenceKind::marker, "marker " + name(a_, m), "it is only in A");
        continue;
      }
      pairs.emplace_back(m, candidates.back());
      matched[candidates.back()] = true;
      candidates.pop_back();
    }
    for (std::size_t m = 0; m < b_.marker_count(); ++m) {
      if (!matched[m]) add(DifferenceKind::marker, "marker " + name(b_, m), "it is only in B");
    }
    if (!std::ranges::is_sorted(pairs, {}, &std::pair<std::size_t, std::size_t>::second)) {
      add(DifferenceKind::order, "", "the markers come in another order");
    }
    for (const auto& [m, n] : pairs) {
      ctx_.check_cancelled();
      compare_marker(m, n);
    }
  }

  static std::string name(const MarkerSequence& take, std::size_t m) {
    return qualified_label(take.markers()[m].subject, take.markers()[m].label);
  }

  void compare_marker(std::size_t m, std::size_t n) {
    const Marker& x = a_.markers()[m];
    const Marker& y = b_.markers()[n];
    const std::string place = "marker " + name(a_, m);
    if (x.kind != y.kind) {
      add(DifferenceKind::marker, place,
          "it is of kind " + std::string(name_of(x.kind)) + " in A, " +
              std::string(name_of(y.kind)) + " in B");
    }
    if (x.unit != y.unit) {
      add(DifferenceKind::marker, place,
          "its unit is '" + x.unit + "' in A, '" + y.unit + "' in B");
    }
    Tally position;
    Tally only_a;
    Tally only_b;
    Tally residual;
    Tally mask;
    for (int64_t frame = begin_; frame < end_; ++frame) {
      const auto f = static_cast<std::size_t>(frame - a_.first_frame);
      const auto g = static_cast<std::size_t>(frame - b_.first_frame);
      const bool in_a = a_.valid(f, m);
      const bool in_b = b_.valid(g, n);
      if (in_a != in_b) (in_a ? only_a : only_b).add(static_cast<std::size_t>(frame), 0.0);
      if (!in_a || !in_b) continue;
      const double distance =
          (a_.position(f, m).cast<double>() - b_.position(g, n).cast<double>()).norm();
      if (!(distance <= options_.tolerance_mm))
        position.add(static_cast<std::size_t>(frame), distance);
      const std::size_t i = a_.sample(f, m);
      const std::size_t j = b_.sample(g, n);
      const double residuals = std::abs(static_cast<double>(a_.residuals()[i]) - b_.residuals()[j]);
      if (!(residuals <= options_.tolerance_mm))
        residual.add(static_cast<std::size_t>(frame), residuals);
      if (a_.camera_masks()[i] != b_.camera_masks()[j])
        mask.add(static_cast<std::size_t>(frame), 1.0);
    }
    report(place, x.unit, position, only_a, only_b, residual, mask);
  }

  void report(const std::string& place, const std::string& unit, const Tally& position,
              const Tally& only_a, const Tally& only_b, const Tally& residual, const Tally& mask) {
    const std::string of = " of " + count_of(static_cast<std::size_t>(end_ - begin_), "frame");
    const auto frame = [](const Tally& t) { return static_cast<int64_t>(t.frame); };
    if (position.count > 0) {
      add(DifferenceKind::position, place,
          "it lies up to " + rounded(position.largest) + " " + unit + " apart (frame " +
              std::to_string(position.frame) + "), in " + std::to_string(position.count) + of,
          position.count, position.largest, frame(position));
    }
    for (const auto& [tally, word] : {std::pair{&only_a, "A"}, std::pair{&only_b, "B"}}) {
      if (tally->count == 0) continue;
      add(DifferenceKind::validity, place,
          std::string("it is measured only in ") + word + " in " + std::to_string(tally->count) +
              of + " (first in frame " + std::to_string(tally->frame) + ")",
          tally->count, 0.0, frame(*tally));
    }
    if (residual.count > 0) {
      add(DifferenceKind::residual, place,
          "its residual differs by up to " + rounded(residual.largest) + " mm (frame " +
              std::to_string(residual.frame) + "), in " + std::to_string(residual.count) + of,
          residual.count, residual.largest, frame(residual));
    }
    if (mask.count > 0) {
      add(DifferenceKind::camera_mask, place,
          "the cameras that saw it differ in " + std::to_string(mask.count) + of +
              " (first in frame " + std::to_string(mask.frame) + ")",
          mask.count, 0.0, frame(mask));
    }
  }

  static std::string describe(const Event& e) {
    std::string text = "'" + e.label + "'";
    if (!e.context.empty()) text += ", " + e.context;
    if (!e.subject.empty()) text += ", " + e.subject;
    return text + " at " + format_fixed(e.time_s, 3) + " s";
  }

  void compare_events() {
    std::vector<bool> matched(b_.events.size(), false);
    for (const Event& e : a_.events) {
      std::size_t best = b_.events.size();
      for (std::size_t i = 0; i < b_.events.size(); ++i) {
        const Event& o = b_.events[i];
        if (matched[i] || o.label != e.label || o.context != e.context || o.subject != e.subject)
          continue;
        if (best == b_.events.size() ||
            std::abs(o.time_s - e.time_s) < std::abs(b_.events[best].time_s - e.time_s)) {
          best = i;
        }
      }
      if (best == b_.events.size()) {
        add(DifferenceKind::event, "event " + e.label, describe(e) + " is only in A");
        continue;
      }
      matched[best] = true;
      const double apart = std::abs(b_.events[best].time_s - e.time_s);
      if (!(apart <= options_.event_tolerance_s)) {
        add(DifferenceKind::event, "event " + e.label,
            describe(e) + " in A comes at " + format_fixed(b_.events[best].time_s, 3) + " s in B",
            0, apart);
      }
    }
    for (std::size_t i = 0; i < b_.events.size(); ++i) {
      if (!matched[i]) {
        add(DifferenceKind::event, "event " + b_.events[i].label,
            describe(b_.events[i]) + " is only in B");
      }
    }
  }

  void compare_analog() {
    const AnalogData& x = a_.analog;
    const AnalogData& y = b_.analog;
    if (x.channels.size() != y.channels.size()) {
      add(DifferenceKind::analog, "",
          count_of(x.channels.size(), "analog channel") + " in A, " +
              std::to_string(y.channels.size()) + " in B");
      return;
    }
    if (x.channels.empty()) return;
    if (std::abs(x.rate_hz - y.rate_hz) > 1e-6 * std::max(x.rate_hz, y.rate_hz)) {
      add(DifferenceKind::analog, "",
          "sampled at " + format_number(x.rate_hz) + " Hz in A, at " + format_number(y.rate_hz) +
              " Hz in B");
    }
    for (std::size_t c = 0; c < x.channels.size(); ++c) compare_channel(c);
  }

  void compare_channel(std::size_t c) {
    const AnalogData& x = a_.analog;
    const AnalogData& y = b_.analog;
    const std::string place = "analog channel " + x.channels[c].label;
    if (x.channels[c].label != y.channels[c].label || x.channels[c].unit != y.channels[c].unit) {
      add(DifferenceKind::analog, place,
          "it is '" + y.channels[c].label + "' in " +
              (y.channels[c].unit.empty() ? "no unit" : y.channels[c].unit) + " in B");
    }
    if (x.samples_per_frame != y.samples_per_frame) return;
    const auto offset = [&](const MarkerSequence& t) {
      return static_cast<std::size_t>(begin_ - t.first_frame) * x.samples_per_frame;
    };
    const std::size_t count = static_cast<std::size_t>(end_ - begin_) * x.samples_per_frame;
    const std::size_t width = x.channels.size();
    const auto value = [&](const AnalogData& d, std::size_t s) {
      const std::size_t i = s * width + c;
      return i < d.values.size() ? static_cast<double>(d.values[i]) : 0.0;
    };
    double size = 0.0;
    for (std::size_t s = 0; s < count; ++s)
      size = std::max(size, std::abs(value(x, offset(a_) + s)));
    Tally tally;
    for (std::size_t s = 0; s < count; ++s) {
      const double v = value(x, offset(a_) + s);
      const double w = value(y, offset(b_) + s);
      const bool both_nan = std::isnan(v) && std::isnan(w);
      if (!both_nan && !(std::abs(v - w) <= options_.analog_tolerance * size)) {
        tally.add(static_cast<std::size_t>(begin_) + s / x.samples_per_frame, std::abs(v - w));
      }
    }
    if (tally.count > 0) {
      add(DifferenceKind::analog, place,
          "its values differ by up to " + rounded(tally.largest) + " " + x.channels[c].unit +
              " (frame " + std::to_string(tally.frame) + "), in " + std::to_string(tally.count) +
              " of " + count_of(count, "sample"),
          tally.count, tally.largest, static_cast<int64_t>(tally.frame));
    }
  }

  /// Rotations by their numbers; where one was not measured (reliability -1) by that alone.
  void compare_rotations() {
    const RotationData& x = a_.rotations;
    const RotationData& y = b_.rotations;
    if (x.count != y.count || x.samples_per_frame != y.samples_per_frame) {
      add(DifferenceKind::rotation, "",
          count_of(x.count, "rotation") + " of " + count_of(x.samples_per_frame, "sample") +
              " a frame in A, " + std::to_string(y.count) + " of " +
              std::to_string(y.samples_per_frame) + " in B");
      return;
    }
    const std::size_t numbers = 17;
    const std::size_t row = x.count * x.samples_per_frame * numbers;
    for (std::size_t r = 0; r < x.count; ++r) {
      Tally tally;
      for (int64_t frame = begin_; frame < end_; ++frame) {
        const auto f = static_cast<std::size_t>(frame - a_.first_frame) * row;
        const auto g = static_cast<std::size_t>(frame - b_.first_frame) * row;
        for (std::size_t s = 0; s < x.samples_per_frame; ++s) {
          const std::size_t at = (s * x.count + r) * numbers;
          const double apart =
              rotation_distance(x.values.data() + f + at, y.values.data() + g + at);
          if (!(apart <= 1e-6)) tally.add(static_cast<std::size_t>(frame), apart);
        }
      }
      if (tally.count == 0) continue;
      add(DifferenceKind::rotation, "rotation " + std::to_string(r + 1),
          "it differs by up to " + rounded(tally.largest) + " in one of its numbers (frame " +
              std::to_string(tally.frame) + "), in " + count_of(tally.count, "sample"),
          tally.count, tally.largest, static_cast<int64_t>(tally.frame));
    }
  }

  static double rotation_distance(const float* x, const float* y) {
    const bool missing = x[16] < 0.0F;
    if (missing != (y[16] < 0.0F)) return 1.0;
    double largest = 0.0;
    for (std::size_t k = missing ? 16 : 0; k < 17; ++k) {
      const bool both_nan = std::isnan(x[k]) && std::isnan(y[k]);
      if (both_nan) continue;
      if (std::isnan(x[k]) != std::isnan(y[k])) return 1.0;
      largest = std::max(largest, std::abs(static_cast<double>(x[k]) - static_cast<double>(y[k])));
    }
    return largest;
  }

  void compare_parameters() {
    const auto only = [this](const C3dParameters& x, const C3dParameters& y, const char* where) {
      for (const C3dGroup& g : x.groups) {
        if (y.group(g.name) == nullptr) {
          add(DifferenceKind::parameter, "parameter group " + g.name,
              std::string("it is only in ") + where);
          continue;
        }
        for (const C3dParameter& p : g.parameters) {
          if (y.find(g.name, p.name) != nullptr) continue;
          add(DifferenceKind::parameter, "parameter " + g.name + ":" + p.name,
              std::string("it is only in ") + where + ": " + values_of(p));
        }
      }
    };
    if (a_.parameters.groups.empty() != b_.parameters.groups.empty()) {
      add(DifferenceKind::parameter, "",
          std::string("only ") + (a_.parameters.groups.empty() ? "B" : "A") + " has parameters");
      return;
    }
    only(a_.parameters, b_.parameters, "A");
    only(b_.parameters, a_.parameters, "B");
    for (const C3dGroup& g : a_.parameters.groups) {
      for (const C3dParameter& p : g.parameters) {
        const C3dParameter* q = b_.parameters.find(g.name, p.name);
        if (q != nullptr) compare_parameter("parameter " + g.name + ":" + p.name, p, *q);
      }
    }
  }

  void compare_parameter(const std::string& place, const C3dParameter& p, const C3dParameter& q) {
    if (p.type == C3dType::text && q.type == C3dType::text ? p.strings() != q.strings()
                                                           : p.numbers != q.numbers) {
      add(DifferenceKind::parameter, place, values_of(p) + " in A, " + values_of(q) + " in B");
    } else if (p.type != q.type) {
      add(DifferenceKind::parameter, place, "its type differs");
    } else if (p.type != C3dType::text && p.dimensions != q.dimensions) {
      add(DifferenceKind::parameter, place, "its dimensions differ");
    } else if (p.description != q.description) {
      add(DifferenceKind::parameter, place,
          "its description is '" + shown(p.description) + "' in A, '" + shown(q.description) +
              "' in B");
    }
  }

  const MarkerSequence& a_;
  const MarkerSequence& b_;
  const SessionDiffOptions& options_;
  const RunContext& ctx_;
  int64_t begin_ = 1;  // frames that both have
  int64_t end_ = 1;
  SessionDiffResult result_;
};

}  // namespace

void SessionDiffOptions::declare(ParameterSet& p) {
  p.group("diff", "Comparison");
  p.number("tolerance", tolerance_mm,
           {.unit = "mm",
            .min = 0,
            .max = 1e6,
            .help = "Positions and residuals that are closer than this count as equal"});
  p.number("event-tolerance", event_tolerance_s,
           {.unit = "s",
            .min = 0,
            .max = 1e6,
            .help = "Events that are closer than this count as equal"});
  p.number("analog-tolerance", analog_tolerance,
           {.min = 0,
            .max = 1,
            .help = "Analog values that are closer than this share of the channel's largest value "
                    "count as equal"});
  p.flag("parameters", parameters, "Compare the parameters of C3D files too");
}

void SessionDiffOptions::validate() const { validate_options(*this); }

std::string_view name_of(DifferenceKind kind) {
  switch (kind) {
    case DifferenceKind::frames: return "frames";
    case DifferenceKind::rate: return "rate";
    case DifferenceKind::marker: return "marker";
    case DifferenceKind::order: return "order";
    case DifferenceKind::position: return "position";
    case DifferenceKind::validity: return "validity";
    case DifferenceKind::residual: return "residual";
    case DifferenceKind::camera_mask: return "camera_mask";
    case DifferenceKind::event: return "event";
    case DifferenceKind::analog: return "analog";
    case DifferenceKind::rotation: return "rotation";
    case DifferenceKind::parameter: return "parameter";
  }
  return "frames";
}

SessionDiffResult diff_sessions(const MarkerSequence& a, const MarkerSequence& b,
                                const SessionDiffOptions& options, const RunContext& ctx) {
  options.validate();
  return Comparison(a, b, options, ctx).run();
}

std::string diff_text(const SessionDiffResult& result, const std::string& a, const std::string& b) {
  std::string text = "A: " + a + "\nB: " + b + "\n";
  if (result.identical()) return text + "The two hold the same.\n";
  text += "They differ in " + count_of(result.differences.size(), "respect") + ":\n";
  for (const Difference& d : result.differences) {
    text +=
        "  " + (d.place.empty() ? std::string(name_of(d.kind)) : d.place) + ": " + d.message + "\n";
  }
  return text;
}

std::string diff_json(const SessionDiffResult& result, const std::string& a, const std::string& b) {
  using Json = nlohmann::ordered_json;
  Json json = {
      {"a", a}, {"b", b}, {"identical", result.identical()}, {"differences", Json::array()}};
  for (const Difference& d : result.differences) {
    json["differences"].push_back({{"kind", name_of(d.kind)},
                                   {"place", d.place},
                                   {"message", d.message},
                                   {"count", d.count},
                                   {"largest", std::isfinite(d.largest) ? Json(d.largest) : Json()},
                                   {"frame", d.frame == 0 ? Json() : Json(d.frame)}});
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

}  // namespace kinemesh
