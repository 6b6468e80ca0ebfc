#include "capture/c3d/event_group.h"

#include <algorithm>
#include <cmath>

#include "capture/c3d/parameter_access.h"
#include "capture/c3d/point_table.h"
#include "config/text.h"

namespace kinemesh {
namespace {

constexpr std::size_t max_header_events = 18;
constexpr std::size_t max_per_parameter = 255;

std::string numbered(const char* name, std::size_t part) {
  return part == 0 ? name : name + std::to_string(part + 1);
}

/// Seconds of every event: EVENT:TIMES holds pairs of minutes and seconds, some files only seconds.
std::vector<double> event_times(const C3dParameters& tree) {
  std::vector<double> times;
  const auto used = first_count(tree, "EVENT", "USED");
  for (std::size_t part = 0; part < 256; ++part) {
    const C3dParameter* p = tree.find("EVENT", numbered("TIMES", part));
    if (p == nullptr) break;
    const bool pairs = p->dimensions.size() >= 2
                           ? p->dimensions[0] == 2
                           : used && *used > 0 && p->numbers.size() == 2 * *used;
    if (pairs) {
      for (std::size_t i = 0; i + 1 < p->numbers.size(); i += 2)
        times.push_back(60.0 * p->numbers[i] + p->numbers[i + 1]);
    } else {
      times.insert(times.end(), p->numbers.begin(), p->numbers.end());
    }
  }
  return times;
}

std::vector<Event> group_events(const C3dParameters& tree, std::vector<C3dFinding>& findings) {
  const auto used = first_count(tree, "EVENT", "USED");
  const std::vector<double> times = event_times(tree);
  const std::vector<std::string> labels = all_strings(tree, "EVENT", "LABELS");
  const std::vector<std::string> contexts = all_strings(tree, "EVENT", "CONTEXTS");
  const std::vector<std::string> subjects = all_strings(tree, "EVENT", "SUBJECTS");
  const std::size_t wanted =
      used ? static_cast<std::size_t>(*used) : std::max(times.size(), labels.size());
  const std::size_t count =
      std::min({wanted, times.size(), std::max(labels.size(), contexts.size())});
  std::vector<Event> events;
  std::size_t unusable = 0;
  bool converted = false;
  for (std::size_t e = 0; e < count; ++e) {
    if (!std::isfinite(times[e]) || std::abs(times[e]) > 1e9) {
      ++unusable;
      continue;
    }
    events.push_back({.label = e < labels.size() ? utf8_from(labels[e], converted) : "",
                      .context = e < contexts.size() ? utf8_from(contexts[e], converted) : "",
                      .subject = e < subjects.size() ? utf8_from(subjects[e], converted) : "",
                      .time_s = times[e]});
  }
  if (count < wanted || unusable > 0) {
    findings.push_back(c3d_finding("C3D601",
                                   std::to_string(events.size()) + " of " + std::to_string(wanted) +
                                       " events have label and time",
                                   "parameter EVENT:TIMES"));
  }
  return events;
}

bool same_event(const Event& event, const C3dHeaderEvent& header) {
  return std::abs(event.time_s - header.time_s) < 1e-3 &&
         (header.label.empty() || lower(event.label).starts_with(lower(header.label)));
}

C3dParameter* first_of(C3dParameters& tree, const char* name) { return tree.find("EVENT", name); }

/// Values of the old arrays in the order of the new events; what has no old event gets zeros or
/// blanks. `from[e]` is the old index or npos.
constexpr std::size_t npos = static_cast<std::size_t>(-1);
void reorder(C3dParameter& p, const std::vector<std::size_t>& from) {
  if (p.dimensions.empty()) return;
  std::size_t width = 1;
  for (std::size_t d = 0; d + 1 < p.dimensions.size(); ++d) width *= p.dimensions[d];
  const auto pick = [&](const auto& old, const auto blank) {
    auto fresh = old;
    fresh.assign(width * from.size(), blank);
    for (std::size_t e = 0; e < from.size(); ++e) {
      if (from[e] == npos || (from[e] + 1) * width > old.size()) continue;
      std::copy_n(old.begin() + static_cast<std::ptrdiff_t>(from[e] * width), width,
                  fresh.begin() + static_cast<std::ptrdiff_t>(e * width));
    }
    return fresh;
  };
  p.dimensions.back() = static_cast<uint8_t>(from.size());
  if (p.type == C3dType::text) {
    p.characters = pick(p.characters, ' ');
  } else {
    p.numbers = pick(p.numbers, 0.0);
  }
}

/// Which old event, if any, each new one is.
std::vector<std::size_t> matches(const std::vector<Event>& events, const std::vector<Event>& old) {
  std::vector<std::size_t> from;
  std::vector<bool> used(old.size(), false);
  for (const Event& event : events) {
    std::size_t found = npos;
    for (std::size_t o = 0; o < old.size() && found == npos; ++o) {
      if (!used[o] && old[o] == event) found = o;
    }
    if (found != npos) used[found] = true;
    from.push_back(found);
  }
  return from;
}

void keep_attributes(const std::vector<Event>& events, const std::vector<Event>& old,
                     C3dParameters& tree) {
  const bool fits = events.size() <= max_per_parameter && old.size() <= max_per_parameter;
  for (const char* name : {"ICON_IDS", "DESCRIPTIONS", "GENERIC_FLAGS"}) {
    C3dParameter* p = first_of(tree, name);
    if (p != nullptr && fits) reorder(*p, matches(events, old));
  }
}

/// True when the header block holds them completely.
bool all_fit_the_header(const std::vector<Event>& events) {
  return events.size() <= max_header_events && std::ranges::all_of(events, [](const Event& e) {
           return e.label.size() <= 4 && e.context.empty() && e.subject.empty() &&
                  e.time_s >= 0.0 && static_cast<double>(static_cast<float>(e.time_s)) == e.time_s;
         });
}

void erase_numbered(C3dParameters& tree, const char* name) {
  C3dGroup* group = tree.group("EVENT");
  if (group == nullptr) return;
  for (std::size_t part = 0; part < 256; ++part) {
    std::erase_if(group->parameters, [&](const C3dParameter& p) {
      return part > 0 && lower(p.name) == lower(numbered(name, part));
    });
  }
}

}  // namespace

std::vector<Event> decode_event_list(const C3dParameters& tree,
                                     const std::vector<C3dHeaderEvent>& header_events,
                                     std::vector<C3dFinding>& findings) {
  std::vector<Event> events = group_events(tree, findings);
  const std::size_t of_group = events.size();
  if (of_group > 0 && !header_events.empty()) {
    findings.push_back(c3d_finding("C3D106",
                                   std::to_string(header_events.size()) + " header events beside " +
                                       std::to_string(of_group) + " of the EVENT group",
                                   "byte 298"));
  }
  bool converted = false;
  for (const C3dHeaderEvent& h : header_events) {
    const bool known =
        std::any_of(events.begin(), events.begin() + static_cast<std::ptrdiff_t>(of_group),
                    [&](const Event& e) { return same_event(e, h); });
    if (!known) events.push_back({.label = utf8_from(h.label, converted), .time_s = h.time_s});
  }
  return events;
}

void encode_event_list(const std::vector<Event>& events, C3dParameters& tree) {
  std::vector<C3dFinding> ignored;
  const std::vector<Event> old = group_events(tree, ignored);
  if (old == events || (tree.group("EVENT") == nullptr && all_fit_the_header(events)) ||
      (events.empty() && tree.group("EVENT") == nullptr))
    return;
  keep_attributes(events, old, tree);
  for (const char* name : {"LABELS", "CONTEXTS", "SUBJECTS", "TIMES"}) erase_numbered(tree, name);
  tree.set("EVENT", integer_parameter("USED", {static_cast<double>(events.size())}));
  for (std::size_t part = 0; part * max_per_parameter < std::max<std::size_t>(events.size(), 1);
       ++part) {
    const std::size_t begin = part * max_per_parameter;
    const std::size_t count = std::min(max_per_parameter, events.size() - begin);
    std::vector<std::string> labels, contexts, subjects;
    std::vector<double> times;
    for (std::size_t e = begin; e < begin + count; ++e) {
      labels.push_back(events[e].label);
      contexts.push_back(events[e].context);
      subjects.push_back(events[e].subject);
      const double minutes = std::floor(events[e].time_s / 60.0);
      times.insert(times.end(), {minutes, events[e].time_s - 60.0 * minutes});
    }
    tree.set("EVENT", texts_parameter(numbered("LABELS", part), labels));
    tree.set("EVENT", texts_parameter(numbered("CONTEXTS", part), contexts));
    tree.set("EVENT", texts_parameter(numbered("SUBJECTS", part), subjects));
    tree.set("EVENT",
             real_parameter(numbered("TIMES", part), times, {2, static_cast<uint8_t>(count)}));
  }
}

std::vector<C3dHeaderEvent> header_events_of(const std::vector<Event>& events) {
  std::vector<C3dHeaderEvent> all;
  for (const Event& e : events) {
    if (all.size() == max_header_events) break;
    all.push_back({.label = e.label.substr(0, 4), .time_s = e.time_s});
  }
  return all;
}

}  // namespace kinemesh
