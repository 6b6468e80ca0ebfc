#include "capture/c3d/second_opinion.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "capture/c3d/analog_table.h"
#include "capture/c3d/event_group.h"
#include "capture/c3d/ezc3d_process.h"
#include "capture/c3d/parameter_access.h"
#include "capture/c3d/point_table.h"
#include "capture/session_diff.h"
#include "config/text.h"

namespace kinemesh {
namespace {

bool any_parameter(const C3dParameters& tree, const auto& is) {
  return std::ranges::any_of(tree.groups, [&](const C3dGroup& g) {
    return std::ranges::any_of(g.parameters, [&](const C3dParameter& p) { return is(p); });
  });
}

// ---- parameters ---------------------------------------------------------------------------------

std::string without_nuls(std::string text) {
  std::erase(text, '\0');
  return std::string(trim(text));
}

std::vector<std::string> plain_texts(const C3dParameter& p) {
  std::vector<std::string> texts = p.strings();
  for (std::string& t : texts) t = without_nuls(std::move(t));
  while (!texts.empty() && texts.back().empty()) texts.pop_back();
  return texts;
}

/// Signed or unsigned alike.
double as_stored(const C3dParameter& p, double value) {
  if (p.type == C3dType::real) return value;
  const double range = p.type == C3dType::byte ? 256.0 : 65536.0;
  return value < 0.0 ? value + range : value;
}

/// The same but for signs, padding, NULs, and the one dimension that ezc3d gives a scalar.
bool same_parameter(const C3dParameter& p, const C3dParameter& q) {
  if (without_nuls(p.description) != without_nuls(q.description)) return false;
  if (p.type != q.type) return false;
  if (p.type == C3dType::text) return plain_texts(p) == plain_texts(q);
  const auto same_number = [&](double x, double y) {
    return as_stored(p, x) == as_stored(q, y) || (std::isnan(x) && std::isnan(y));
  };
  return std::ranges::equal(p.numbers, q.numbers, same_number) &&
         (p.dimensions == q.dimensions || p.numbers.size() <= 1);
}

/// ezc3d's parameters, those that say the same in our words, without those that it adds to every
/// file; these are listed in `added`.
C3dParameters comparable(const C3dParameters& own, const C3dParameters& other,
                         std::vector<std::string>& added) {
  C3dParameters result;
  for (const C3dGroup& g : other.groups) {
    C3dGroup group = g;
    const bool makes_up = g.name == "POINT" || g.name == "ANALOG" || g.name == "FORCE_PLATFORM";
    group.parameters.clear();
    for (const C3dParameter& q : g.parameters) {
      const C3dParameter* p = own.find(g.name, q.name);
      if (p == nullptr && makes_up) {
        added.push_back(g.name + ":" + q.name);
        continue;
      }
      group.parameters.push_back(p != nullptr && same_parameter(*p, q) ? *p : q);
    }
    if (own.group(g.name) != nullptr || !makes_up) result.groups.push_back(std::move(group));
  }
  return result;
}

/// Counts and rates that ezc3d replaces by what it found while reading.
bool is_replaced(const std::string& place) {
  constexpr std::array<const char*, 5> all = {"POINT:USED", "POINT:FRAMES", "POINT:RATE",
                                              "ANALOG:USED", "ANALOG:RATE"};
  return std::ranges::any_of(
      all, [&](const char* name) { return place == std::string("parameter ") + name; });
}

// ---- which of the two is wrong ------------------------------------------------------------------

std::string analog_fault(const C3dReadResult& own) {
  if (own.layout.analog_unsigned) return "ezc3d takes unsigned samples and offsets as signed";
  const C3dParameters& tree = own.take.parameters;
  bool negative = false;
  for (const char* name : {"OFFSET", "OFFSET2", "OFFSET3"}) {
    const C3dParameter* p = tree.find("ANALOG", name);
    negative = negative ||
               (p != nullptr && std::ranges::any_of(p->numbers, [](double v) { return v < 0.0; }));
  }
  if (negative || has_code(own.findings, "C3D503")) return "ezc3d drops the sign of ANALOG:OFFSET";
  return "";
}

/// Why ezc3d is known to be wrong where it differs in this way; empty when it is not known.
std::string known_fault(const Difference& difference, const C3dReadResult& own) {
  switch (difference.kind) {
    case DifferenceKind::residual:
    case DifferenceKind::camera_mask: return "ezc3d exchanges residual and camera mask";
    case DifferenceKind::position:
    case DifferenceKind::validity:
      return has_code(own.findings, "C3D409") || has_code(own.findings, "C3D410")
                 ? "ezc3d does not know 65535 as the mark of a gap"
                 : "";
    case DifferenceKind::analog: return analog_fault(own);
    case DifferenceKind::rate:
      return has_code(own.findings, "C3D306") || has_code(own.findings, "C3D316")
                 ? "ezc3d takes 0 Hz where neither header nor POINT:RATE gives a rate"
                 : "";
    case DifferenceKind::parameter:
      return is_replaced(difference.place) ? "ezc3d replaces it by what it found while reading"
                                           : "";
    default: return "";
  }
}

/// A parameter that ezc3d wants to be of another number type, which the format leaves open.
std::string unexpected_type(const C3dParameters& tree) {
  struct Expected {
    const char *group, *name;
    bool real;
  };
  constexpr std::array<Expected, 6> all = {{{"POINT", "FRAMES", false},
                                            {"POINT", "USED", false},
                                            {"ANALOG", "USED", false},
                                            {"POINT", "RATE", true},
                                            {"POINT", "SCALE", true},
                                            {"ANALOG", "RATE", true}}};
  for (const Expected& e : all) {
    const C3dParameter* p = tree.find(e.group, e.name);
    if (p == nullptr || p->type == C3dType::text || (p->type == C3dType::real) == e.real) continue;
    return std::string("ezc3d expects ") + e.group + ":" + e.name + " to be " +
           (e.real ? "a real number" : "an integer");
  }
  return "";
}

/// Why ezc3d refuses a sound file, where that is known.
std::string known_refusal(const C3dReadResult& own, const std::string& why) {
  const C3dParameters& tree = own.take.parameters;
  if (why.starts_with("ezc3d crashes") || why.starts_with("ezc3d takes"))
    return "no file must lead to that";
  if (any_parameter(tree, [](const C3dParameter& p) { return p.description.size() > 127; })) {
    return "ezc3d takes the length of descriptions over 127 bytes as negative";
  }
  if (std::string type = unexpected_type(tree); !type.empty()) return type;
  if (std::ranges::none_of(tree.groups, [](const C3dGroup& g) { return g.name == "POINT"; }))
    return "ezc3d knows the names of groups in capitals only";
  if (has_code(own.findings, "C3D211") || has_code(own.findings, "C3D201") ||
      has_code(own.findings, "C3D213")) {
    return "ezc3d expects the parameter records without gaps and within their block count";
  }
  return "";
}

// ---- findings -----------------------------------------------------------------------------------

void add_finding(const std::string& message, const std::string& fault, const std::string& place,
                 C3dCheckResult& result) {
  if (fault.empty()) result.second_opinion = SecondOpinion::differs;
  result.findings.push_back(
      c3d_finding(fault.empty() ? "C3D803" : "C3D802",
                  message + (fault.empty() ? "" : "; ezc3d is wrong: " + fault), place));
}

/// Differences of one kind are one finding: which places, and the largest of them.
struct Group {
  DifferenceKind kind;
  std::string fault;
  Difference largest;
  std::vector<std::string> places;
};

void add_differences(const SessionDiffResult& diff, const C3dReadResult& own,
                     C3dCheckResult& result) {
  std::vector<Group> groups;
  for (const Difference& d : diff.differences) {
    const std::string fault = known_fault(d, own);
    auto it = std::ranges::find_if(
        groups, [&](const Group& g) { return g.kind == d.kind && g.fault == fault; });
    if (it == groups.end()) {
      groups.push_back({d.kind, fault, d, {}});
      it = std::prev(groups.end());
    }
    it->places.push_back(d.place);
    if (d.largest > it->largest.largest) it->largest = d;
  }
  for (const Group& group : groups) {
    std::string message = "with Kinemesh as A and ezc3d as B, " + group.largest.message;
    std::vector<std::string> more;
    for (const std::string& place : group.places) {
      if (place != group.largest.place) more.push_back(place);
    }
    // What is known to be wrong needs no list of all its places.
    const std::size_t named = group.fault.empty() ? more.size() : 8;
    const std::size_t left = more.size() - std::min(more.size(), named);
    more.resize(more.size() - left);
    if (!more.empty()) message += "; likewise " + join(more, ", ");
    if (left > 0) message += " and " + std::to_string(left) + " more";
    add_finding(message, group.fault, group.largest.place, result);
  }
}

std::vector<C3dHeaderEvent> trimmed(std::vector<C3dHeaderEvent> events) {
  for (C3dHeaderEvent& e : events) e.label = without_nuls(std::move(e.label));
  return events;
}

/// What the header alone says: events whose key or time is missing, and the first frame.
void compare_heads(const C3dReadResult& own, const Ezc3dHead& head, MarkerSequence& other,
                   C3dCheckResult& result) {
  const bool more_events = head.header_events.size() > own.header.events.size();
  if (more_events) {
    add_finding("Kinemesh finds " + count_of(own.header.events.size(), "header event") +
                    ", ezc3d " + std::to_string(head.header_events.size()),
                "it minds neither the key 12345 before them nor times that are no numbers",
                "byte 300", result);
  }
  std::vector<C3dFinding> ignored;
  other.events = decode_event_list(
      other.parameters, more_events ? own.header.events : trimmed(head.header_events), ignored);
  if (head.first_frame != own.take.first_frame) {
    const bool trial = own.take.first_frame != own.header.first_frame;
    add_finding("the first frame is " + std::to_string(own.take.first_frame) + " to Kinemesh, " +
                    std::to_string(head.first_frame) + " to ezc3d",
                trial ? "it ignores TRIAL:ACTUAL_START_FIELD" : "", "byte 6", result);
  }
}

/// Labels, kinds, units and channels by ezc3d's parameters.
void decode_names(const C3dReadResult& own, MarkerSequence& other) {
  std::vector<C3dFinding> ignored;
  const PointTable table =
      decode_points_table(other.parameters, other.marker_count(),
                          length_unit_of(own.take.origin.unit).value_or(LengthUnit::mm), ignored);
  std::ranges::copy(table.markers, other.markers().begin());
  const AnalogTable analog = decode_analog_table(other.parameters, own.layout, {}, ignored);
  if (analog.channels.size() == other.analog.channels.size())
    other.analog.channels = analog.channels;
}

}  // namespace

void compare_readers(const C3dReadResult& own, MarkerSequence other, const Ezc3dHead& head,
                     C3dCheckResult& result, const RunContext& ctx) {
  result.second_opinion = SecondOpinion::agrees;
  std::vector<std::string> added;
  other.parameters = comparable(own.take.parameters, head.parameters, added);
  if (!added.empty()) {
    add_finding("ezc3d gives " + join(added, ", ") + ", which the file does not have",
                "it adds empty parameters that it takes for mandatory", "", result);
  }
  decode_names(own, other);
  compare_heads(own, head, other, result);
  other.first_frame = own.take.first_frame;
  other.rate_hz = head.rate_hz;
  if (own.take.frame_count() == 0) other.rate_hz = own.take.rate_hz;
  SessionDiffOptions diff;
  float largest = 0.0F;
  for (std::size_t i = 0; i < own.take.sample_count(); ++i) {
    if ((own.take.flags()[i] & SampleFlag::valid) == 0) continue;
    for (std::size_t k = 0; k < 3; ++k)
      largest = std::max(largest, std::abs(own.take.positions()[3 * i + k]));
  }
  // Both round to floats, in another order.
  diff.tolerance_mm = std::max(diff.tolerance_mm, 5e-7 * static_cast<double>(largest));
  add_differences(diff_sessions(own.take, other, diff, ctx), own, result);
}

void ask_ezc3d(const std::filesystem::path& path, const C3dReadOptions& options,
               const C3dReadResult& own, C3dCheckResult& result, const RunContext& ctx) {
  if (const std::string unsuited = ezc3d_refusal(own); !unsuited.empty()) {
    result.findings.push_back(c3d_finding("C3D801", "ezc3d was not asked: " + unsuited, ""));
    return;
  }
  C3dReadResult other{.take = own.take, .header = own.header, .layout = own.layout};
  Ezc3dHead head;
  const std::string why = read_with_ezc3d_apart(path, options, other, head, ctx);
  if (!why.empty()) {
    result.second_opinion = SecondOpinion::refused;
    const std::string fault = known_refusal(own, why);
    result.findings.push_back(
        c3d_finding("C3D804", why + (fault.empty() ? "" : "; ezc3d is wrong: " + fault), ""));
    return;
  }
  compare_readers(own, std::move(other.take), head, result, ctx);
}

}  // namespace kinemesh
