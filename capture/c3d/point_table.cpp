#include "capture/c3d/point_table.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

#include "capture/c3d/parameter_access.h"
#include "capture/c3d/text_encoding.h"
#include "config/text.h"

namespace kinemesh {
namespace {

constexpr std::size_t max_named = 20;  // findings that name single markers, per kind

// ---- kinds --------------------------------------------------------------------------------------

struct KindList {
  std::string_view word;  // a list's name, or its type in POINT:TYPE_GROUPS, begins with it
  MarkerKind kind;
  std::string_view unit_parameter;
  std::string_view default_unit;
};
constexpr auto kind_lists = std::to_array<KindList>({
    {"angle", MarkerKind::angle, "ANGLE_UNITS", "deg"},
    {"force", MarkerKind::force, "FORCE_UNITS", "N"},
    {"moment", MarkerKind::moment, "MOMENT_UNITS", "Nmm"},
    {"power", MarkerKind::power, "POWER_UNITS", "W"},
    {"scalar", MarkerKind::scalar, "SCALAR_UNITS", ""},
    {"modeled", MarkerKind::virtual_point, "", "mm"},
    {"modelled", MarkerKind::virtual_point, "", "mm"},
    {"virtual", MarkerKind::virtual_point, "", "mm"},
});

const KindList* list_of(std::string_view word) {
  const std::string small = lower(word);
  const auto* const it = std::ranges::find_if(
      kind_lists, [&](const KindList& k) { return small.starts_with(k.word); });
  return it == kind_lists.end() ? nullptr : it;
}

/// Label → list, from POINT:ANGLES, FORCES… and the lists that POINT:TYPE_GROUPS names.
std::map<std::string, const KindList*, std::less<>> listed_labels(const C3dParameters& tree) {
  std::vector<std::pair<std::string, const KindList*>> lists;
  for (const char* name :
       {"ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS", "MODELED_MARKERS", "VIRTUAL_MARKERS"}) {
    lists.emplace_back(name, list_of(name));
  }
  const std::vector<std::string> groups = all_strings(tree, "POINT", "TYPE_GROUPS");
  for (std::size_t i = 0; i + 1 < groups.size(); i += 2) {
    lists.emplace_back(groups[i], list_of(groups[i + 1]));
  }
  std::map<std::string, const KindList*, std::less<>> all;
  for (const auto& [name, list] : lists) {
    if (list == nullptr) continue;
    for (std::string& label : all_strings(tree, "POINT", name)) all.emplace(std::move(label), list);
  }
  return all;
}

bool is_unlabelled(std::string_view label) {
  if (label.empty() || label.front() == '*') return true;
  const std::string small = lower(label);
  for (const std::string_view word : {"unlabeled", "unlabelled", "unidentified", "uname*"}) {
    if (small.starts_with(word)) return true;
  }
  return false;
}

// ---- subjects -----------------------------------------------------------------------------------

struct Subjects {
  std::vector<std::string> names;
  std::vector<std::string> prefixes;  // without the colon
  explicit Subjects(const C3dParameters& tree)
      : names(all_strings(tree, "SUBJECTS", "NAMES")),
        prefixes(all_strings(tree, "SUBJECTS", "LABEL_PREFIXES")) {
    for (std::string& prefix : prefixes) {
      if (prefix.ends_with(':')) prefix.pop_back();
    }
  }
  std::string name_of_prefix(const std::string& prefix) const {
    for (std::size_t i = 0; i < std::min(prefixes.size(), names.size()); ++i) {
      if (prefixes[i] == prefix && !names[i].empty()) return names[i];
    }
    return prefix;
  }
  std::string prefix_of_name(const std::string& name) const {
    for (std::size_t i = 0; i < std::min(prefixes.size(), names.size()); ++i) {
      if (names[i] == name && !prefixes[i].empty()) return prefixes[i];
    }
    return name;
  }
  const std::string* only() const {
    return names.size() == 1 && !names[0].empty() ? &names[0] : nullptr;
  }
};

/// "Subject:Marker" → subject, marker; the subject stays empty without a colon.
std::pair<std::string, std::string> split_label(const std::string& label) {
  const std::size_t colon = label.find(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == label.size()) return {{}, label};
  return {label.substr(0, colon), label.substr(colon + 1)};
}

// ---- units --------------------------------------------------------------------------------------

/// The unit of every point (one entry when all share it), as written in the file.
std::vector<std::string> unit_words(const C3dParameters& tree) {
  std::vector<std::string> words = all_strings(tree, "POINT", "UNITS");
  for (std::string& word : words) word = std::string(trim(word));
  const bool same =
      std::ranges::all_of(words, [&](const std::string& w) { return w == words[0] || w.empty(); });
  if (same && words.size() > 1) words.resize(1);
  return words;
}

class Units {
 public:
  Units(const C3dParameters& tree, std::size_t points, LengthUnit unstated,
        std::vector<C3dFinding>& findings)
      : words_(unit_words(tree)), missing_(name_of(unstated)) {
    if (points == 0) return;
    const std::string place = "parameter POINT:UNITS";
    if (words_.empty() || std::ranges::all_of(words_, &std::string::empty)) {
      words_.clear();
      findings.push_back(c3d_finding(
          "C3D404", "POINT:UNITS is missing or empty; " + missing_ + " is assumed", place));
    } else if (words_.size() == 1 && !millimetres_in(words_[0])) {
      bool converted = false;
      findings.push_back(c3d_finding("C3D405",
                                     "\"" + utf8_from(words_[0], converted) +
                                         "\" is no length unit; " + missing_ + " is assumed",
                                     place));
      words_.clear();
    } else if (words_.size() > 1) {
      findings.push_back(c3d_finding(
          "C3D414", "POINT:UNITS gives " + std::to_string(words_.size()) + " units", place));
    }
  }
  std::string of(std::size_t point) const {
    if (words_.empty()) return missing_;
    const std::string& word = point < words_.size() ? words_[point] : words_[0];
    return word.empty() ? missing_ : word;
  }

 private:
  std::vector<std::string> words_;
  std::string missing_;
};

// ---- labels -------------------------------------------------------------------------------------

std::vector<std::string> point_labels(const C3dParameters& tree, std::size_t points,
                                      std::vector<C3dFinding>& findings) {
  std::vector<std::string> labels = all_strings(tree, "POINT", "LABELS");
  const std::string place = "parameter POINT:LABELS";
  if (labels.size() < points) {
    findings.push_back(c3d_finding(
        "C3D401",
        std::to_string(labels.size()) + " labels for " + std::to_string(points) + " points",
        place));
  } else if (labels.size() > points && points > 0) {
    findings.push_back(c3d_finding(
        "C3D402",
        std::to_string(labels.size()) + " labels for " + std::to_string(points) + " points",
        place));
  }
  for (std::size_t p = labels.size(); p < points; ++p) {
    labels.push_back("point" + std::to_string(p + 1));
  }
  labels.resize(points);
  return labels;
}

void note_duplicates(const PointTable& table, std::vector<C3dFinding>& findings) {
  std::map<std::pair<std::string_view, std::string_view>, std::size_t> counts;
  for (const Marker& m : table.markers) {
    if (m.kind != MarkerKind::unlabelled) ++counts[{m.subject, m.label}];
  }
  std::size_t named = 0;
  for (const auto& [key, count] : counts) {
    if (count > 1 && ++named <= max_named) {
      findings.push_back(c3d_finding(
          "C3D403", std::to_string(count) + " points are called " + std::string(key.second),
          "marker " + std::string(key.second)));
    }
  }
}

}  // namespace

std::optional<double> millimetres_in(std::string_view unit) {
  const std::string small = lower(trim(unit));
  constexpr auto lengths = std::to_array<std::pair<std::string_view, double>>({{"mm", 1.0},
                                                                               {"mill", 1.0},
                                                                               {"cm", 10.0},
                                                                               {"cent", 10.0},
                                                                               {"dm", 100.0},
                                                                               {"deci", 100.0},
                                                                               {"m", 1000.0},
                                                                               {"mete", 1000.0},
                                                                               {"metr", 1000.0},
                                                                               {"in", 25.4},
                                                                               {"inch", 25.4},
                                                                               {"ft", 304.8},
                                                                               {"foot", 304.8},
                                                                               {"feet", 304.8},
                                                                               {"um", 1e-3}});
  for (const auto& [word, factor] : lengths) {
    // Words of four letters stand for all that begin with them: many files cut units there.
    if (small == word || (word.size() == 4 && small.starts_with(word))) return factor;
  }
  return std::nullopt;
}

std::string utf8_from(const std::string& text, bool& converted) {
  if (is_utf8(text)) return text;
  converted = true;
  return utf8_from_windows_1252(text);
}

PointTable decode_points_table(const C3dParameters& tree, std::size_t points, LengthUnit unstated,
                               std::vector<C3dFinding>& findings) {
  PointTable table;
  const std::vector<std::string> labels = point_labels(tree, points, findings);
  const std::vector<std::string> descriptions = all_strings(tree, "POINT", "DESCRIPTIONS");
  const auto lists = listed_labels(tree);
  const Subjects subjects(tree);
  const Units units(tree, points, unstated, findings);
  bool converted = false;
  std::size_t empty = 0;
  table.markers.reserve(points);
  for (std::size_t p = 0; p < points; ++p) {
    Marker m;
    const auto split = split_label(labels[p]);
    const std::string& prefix = split.first;
    const std::string& rest = split.second;
    const auto listed = [&] {
      const auto whole = lists.find(labels[p]);
      return whole != lists.end() ? whole : lists.find(rest);
    }();
    m.label = utf8_from(rest, converted);
    if (!prefix.empty()) {
      m.subject = utf8_from(subjects.name_of_prefix(prefix), converted);
    } else if (const std::string* only = subjects.only()) {
      m.subject = utf8_from(*only, converted);
    }
    if (p < descriptions.size()) m.description = utf8_from(descriptions[p], converted);
    const std::string unit = units.of(p);
    double factor = millimetres_in(unit).value_or(1.0);
    if (listed != lists.end() && listed->second->kind != MarkerKind::virtual_point) {
      const KindList& list = *listed->second;
      m.kind = list.kind;
      m.unit = std::string(trim(first_string(tree, "POINT", std::string(list.unit_parameter))));
      if (m.unit.empty()) m.unit = list.default_unit;
      m.unit = utf8_from(m.unit, converted);
      factor = 1.0;
    } else if (!millimetres_in(unit)) {
      m.kind = lower(unit).starts_with("deg") || lower(unit).starts_with("rad")
                   ? MarkerKind::angle
                   : MarkerKind::scalar;
      m.unit = utf8_from(unit, converted);
    } else if (listed != lists.end()) {
      m.kind = listed->second->kind;
    } else if (is_unlabelled(m.label)) {
      m.kind = MarkerKind::unlabelled;
      if (prefix.empty()) m.subject.clear();
    }
    if (m.label.empty()) {
      m.label = "*" + std::to_string(p + 1);
      ++empty;
    }
    table.to_mm.push_back(static_cast<float>(factor));
    table.zero_is_value.push_back(m.kind >= MarkerKind::angle ? 1 : 0);
    table.uniform = table.uniform && factor == 1.0;
    table.markers.push_back(std::move(m));
  }
  if (points > 0) {
    for (std::size_t p = 0; p < points; ++p) {
      if (table.zero_is_value[p] != 0) continue;
      table.length_unit = units.of(p);
      break;
    }
    if (!millimetres_in(table.length_unit)) table.length_unit = name_of(unstated);
  }
  if (converted) {
    findings.push_back(
        c3d_finding("C3D406", "labels or descriptions are not UTF-8", "parameter POINT:LABELS"));
  }
  if (empty > 0) {
    findings.push_back(c3d_finding("C3D411",
                                   count_of(empty, "point has", "points have") + " no label",
                                   "parameter POINT:LABELS"));
  }
  note_duplicates(table, findings);
  return table;
}

std::string file_label(const Marker& marker, const C3dParameters& tree) {
  if (marker.subject.empty()) return marker.label;
  const Subjects subjects(tree);
  const std::vector<std::string> labels = all_strings(tree, "POINT", "LABELS");
  const bool prefixed = std::ranges::any_of(
      labels, [](const std::string& l) { return !split_label(l).first.empty(); });
  const std::string* only = subjects.only();
  if (only != nullptr && *only == marker.subject && !prefixed) return marker.label;
  return subjects.prefix_of_name(marker.subject) + ":" + marker.label;
}

}  // namespace kinemesh
