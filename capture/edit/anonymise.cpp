#include "capture/edit/anonymise.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <set>

#include "capture/c3d/write_plan.h"
#include "config/text.h"

namespace kinemesh {
namespace {

constexpr std::array kept_groups = {"POINT",         "ANALOG",   "FORCE_PLATFORM",
                                    "EVENT",         "ROTATION", "MANUFACTURER",
                                    "EVENT_CONTEXT", "SUBJECTS", "TRIAL"};

/// Replaces every occurrence, any case; `words`: none that is a part of a longer word.
std::string replaced(const std::string& text, const std::string& name, const std::string& by,
                     bool words) {
  const auto in_word = [&](std::size_t i) {
    return i < text.size() && (std::isalnum(static_cast<unsigned char>(text[i])) != 0 ||
                               static_cast<unsigned char>(text[i]) >= 0x80);
  };
  const std::string low = lower(text);
  const std::string wanted = lower(name);
  std::string out;
  std::size_t at = 0;
  for (;;) {
    const std::size_t hit = low.find(wanted, at);
    if (hit == std::string::npos) return out + text.substr(at);
    const std::size_t end = hit + wanted.size();
    const bool part = words && ((hit > 0 && in_word(hit - 1)) || in_word(end));
    out.append(text, at, hit - at).append(part ? text.substr(hit, wanted.size()) : by);
    at = end;
  }
}

using Names = std::vector<std::pair<std::string, std::string>>;

std::string without_names(std::string text, const Names& names) {
  constexpr std::size_t least = 3;  // shorter names occur within other words
  for (const auto& [old, now] : names) {
    text = replaced(text, old, now, old.size() < least);
  }
  return text;
}

void clean_parameter(C3dParameter& p, const Names& names) {
  p.description = without_names(p.description, names);
  if (p.type != C3dType::text) return;
  std::vector<std::string> texts = p.strings();
  bool changed = false;
  for (std::string& t : texts) {
    const std::string clean = without_names(t, names);
    changed = changed || clean != t;
    t = clean;
  }
  if (!changed) return;
  std::size_t width = 1;
  for (const std::string& t : texts) width = std::max(width, t.size());
  width = std::min<std::size_t>(width, 255);
  p.characters.clear();
  for (std::string& t : texts) {
    t.resize(width, ' ');
    p.characters += t;
  }
  if (p.dimensions.empty()) p.dimensions = {1};
  p.dimensions[0] = static_cast<uint8_t>(width);
}

/// A label that would become another marker's gets a number.
void anonymise_labels(MarkerSequence& take, const Names& names) {
  std::set<std::string> used;
  for (Marker& m : take.markers()) {
    m.description = without_names(m.description, names);
    const std::string label = without_names(m.label, names);
    const auto whole = [&](const std::string& l) { return m.subject + ":" + l; };
    if (label == m.label) {
      used.insert(whole(label));
      continue;
    }
    m.label = label;
    for (int k = 2; !used.insert(whole(m.label)).second; ++k) {
      m.label = label + "_" + std::to_string(k);
    }
  }
}

}  // namespace

void rename_subjects(MarkerSequence& take, const Names& names) {
  const auto renamed = [&](std::string& subject) {
    const auto it = std::ranges::find(names, subject, &Names::value_type::first);
    if (it != names.end()) subject = it->second;
  };
  for (Marker& m : take.markers()) renamed(m.subject);
  for (Event& e : take.events) renamed(e.subject);
  if (take.parameters.group("SUBJECTS") == nullptr) return;
  std::vector<std::string> subjects;
  for (const Marker& m : take.markers()) {
    if (!m.subject.empty() && std::ranges::find(subjects, m.subject) == subjects.end()) {
      subjects.push_back(m.subject);
    }
  }
  std::vector<std::string> prefixes;
  for (const std::string& s : subjects) prefixes.push_back(s + ":");
  const auto used = static_cast<double>(subjects.size());
  C3dGroup* group = take.parameters.group("SUBJECTS");
  std::erase_if(group->parameters, [](const C3dParameter& p) {
    const std::string name = upper(p.name);  // MARKER_SETS and the like no longer fit the subjects
    return name != "USES_PREFIXES" && name != "IS_STATIC";
  });
  take.parameters.set("SUBJECTS", {.name = "USED", .type = C3dType::integer, .numbers = {used}});
  update_texts(take.parameters, "SUBJECTS", "NAMES", subjects);
  update_texts(take.parameters, "SUBJECTS", "LABEL_PREFIXES", prefixes);
}

std::size_t anonymise_take(MarkerSequence& take) {
  Names names;
  const auto add = [&](const std::string& subject) {
    if (subject.empty()) return;
    if (std::ranges::find(names, subject, &Names::value_type::first) != names.end()) return;
    names.emplace_back(subject, "S" + std::to_string(names.size() + 1));
  };
  for (const Marker& m : take.markers()) add(m.subject);
  for (const Event& e : take.events) add(e.subject);
  if (const C3dParameter* p = take.parameters.find("SUBJECTS", "NAMES")) {
    for (const std::string& s : p->strings()) add(s);
  }
  std::erase_if(take.parameters.groups, [](const C3dGroup& g) {
    return std::ranges::none_of(kept_groups,
                                [&](const char* kept) { return upper(g.name) == kept; });
  });
  rename_subjects(take, names);
  for (C3dGroup& g : take.parameters.groups) {
    g.description = without_names(g.description, names);
    if (upper(g.name) == "TRIAL") {
      std::erase_if(g.parameters, [](const C3dParameter& p) { return p.type == C3dType::text; });
    }
    for (C3dParameter& p : g.parameters) clean_parameter(p, names);
  }
  anonymise_labels(take, names);
  for (Event& e : take.events) {
    e.label = without_names(e.label, names);
    e.context = without_names(e.context, names);
  }
  for (AnalogData::Channel& c : take.analog.channels) {
    c.label = without_names(c.label, names);
    c.description = without_names(c.description, names);
  }
  take.origin.path.clear();
  return names.size();
}

}  // namespace kinemesh
