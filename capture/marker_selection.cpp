#include "capture/marker_selection.h"

#include <algorithm>
#include <array>
#include <set>

#include "config/error.h"
#include "config/text.h"

namespace kinemesh {
namespace {

constexpr std::array all_kinds{
    MarkerKind::marker, MarkerKind::unlabelled, MarkerKind::virtual_point, MarkerKind::angle,
    MarkerKind::force,  MarkerKind::moment,     MarkerKind::power,         MarkerKind::scalar};

std::string full_name(const Marker& marker) {
  return marker.subject.empty() ? marker.label : marker.subject + ":" + marker.label;
}

bool matches(const std::string& pattern, const Marker& marker) {
  return matches_wildcard(pattern, marker.label) ||
         (!marker.subject.empty() && matches_wildcard(pattern, full_name(marker)));
}

bool matches_any(const std::vector<std::string>& patterns, const Marker& marker) {
  return std::ranges::any_of(patterns, [&](const auto& p) { return matches(p, marker); });
}

bool has_wildcard(const std::string& pattern) {
  return pattern.find_first_of("*?") != std::string::npos;
}

bool names_anything(const std::string& pattern) {
  return pattern.find_first_not_of("*?") == std::string::npos;
}

/// Matched by a pattern of `include` that satisfies `when`.
template <class Condition>
bool asked_for(const MarkerSelectionOptions& options, const Marker& marker, Condition when) {
  return std::ranges::any_of(options.include,
                             [&](const auto& p) { return when(p) && matches(p, marker); });
}

std::vector<bool> ever_valid(const MarkerSequence& take) {
  std::vector<bool> valid(take.marker_count(), false);
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    for (std::size_t m = 0; m < take.marker_count(); ++m) {
      if (take.valid(f, m)) valid[m] = true;
    }
  }
  return valid;
}

std::string text_of(SelectionReason reason, const Marker& marker) {
  switch (reason) {
    case SelectionReason::chosen: return "chosen";
    case SelectionReason::other_subject:
      return marker.subject.empty() ? "belongs to no subject"
                                    : "belongs to subject " + marker.subject;
    case SelectionReason::not_included: return "no pattern of --include matches";
    case SelectionReason::excluded: return "a pattern of --exclude matches";
    case SelectionReason::other_kind: {
      const std::string kind(name_of(marker.kind));
      return "kind " + kind + "; choose it with --kind " + kind;
    }
    case SelectionReason::head_rig: return "marker of the head rig; choose it with --head-rig";
    case SelectionReason::never_valid: return "invalid in every frame";
  }
  return {};
}

struct Rules {
  const MarkerSelectionOptions& options;
  std::set<std::string, std::less<>> kinds;
  bool rig_names_count = true;

  SelectionReason judge(const Marker& marker, bool head_rig, bool valid) const {
    if (!options.subjects.empty() && std::ranges::none_of(options.subjects, [&](const auto& p) {
          return matches_wildcard(p, marker.subject);
        })) {
      return SelectionReason::other_subject;
    }
    if (!options.include.empty() && !matches_any(options.include, marker)) {
      return SelectionReason::not_included;
    }
    if (matches_any(options.exclude, marker)) return SelectionReason::excluded;
    if (!kinds.contains(name_of(marker.kind)) &&
        !asked_for(options, marker, [](const auto& p) { return !has_wildcard(p); })) {
      return SelectionReason::other_kind;
    }
    if (head_rig && rig_names_count && !options.head_rig &&
        !asked_for(options, marker, [](const auto& p) { return !names_anything(p); })) {
      return SelectionReason::head_rig;
    }
    return valid ? SelectionReason::chosen : SelectionReason::never_valid;
  }
};

void warn_of_idle_patterns(const MarkerSequence& take, const MarkerSelectionOptions& options,
                           std::vector<std::string>& warnings) {
  const auto check = [&](const std::vector<std::string>& patterns, const char* parameter,
                         const auto& hits) {
    for (const std::string& p : patterns) {
      if (std::ranges::none_of(take.markers(), [&](const Marker& m) { return hits(p, m); })) {
        warnings.push_back("--" + std::string(parameter) + " " + p +
                           " matches nothing in the take.");
      }
    }
  };
  check(options.subjects, "subject",
        [](const auto& p, const Marker& m) { return matches_wildcard(p, m.subject); });
  check(options.include, "include", matches);
  check(options.exclude, "exclude", matches);
}

void warn_of_invalid(const MarkerSequence& take, MarkerSelectionResult& result) {
  constexpr std::size_t most_named = 8;
  std::vector<std::string> names;
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    if (result.decisions[m].reason != SelectionReason::never_valid) continue;
    names.push_back(full_name(take.markers()[m]));
  }
  if (names.size() > most_named) {
    const std::size_t others = names.size() - most_named + 1;
    names.resize(most_named - 1);
    names.push_back(count_of(others, "other"));
    result.warnings.push_back("Markers " + join(names, ", ", " and ") +
                              " are invalid in every frame and are left out: no surface is made "
                              "there. Repeat the take if that place matters.");
    return;
  }
  for (const std::string& name : names) {
    result.warnings.push_back("Marker " + name + " is invalid in every frame and is left out.");
  }
}

/// True when the take was recorded, but nobody gave its points their names.
bool only_unlabelled(const MarkerSequence& take) {
  const auto count = [&](MarkerKind kind) {
    return std::ranges::count(take.markers(), kind, &Marker::kind);
  };
  return count(MarkerKind::unlabelled) > 0 && count(MarkerKind::marker) == 0;
}

[[noreturn]] void nothing_left(const MarkerSequence& take, const MarkerSelectionResult& result) {
  std::vector<std::string> reasons;
  for (const MarkerDecision& d : result.decisions) {
    if (std::ranges::find(reasons, d.text) == reasons.end()) reasons.push_back(d.text);
  }
  if (reasons.size() > 4) reasons.resize(4);
  if (only_unlabelled(take)) {
    throw NoResultError(
        {.what = "None of the take's " + count_of(take.marker_count(), "point") +
                 " has a label, so that no marker is chosen",
         .file = take.origin.path,
         .remedy =
             "Label them after another take of the subject with \"kinemesh c3d process TAKE.c3d "
             "--template LABELLED.c3d -o labelled.c3d\", or take them as they are with "
             "--kind unlabelled"});
  }
  throw NoResultError(
      {.what = take.marker_count() == 0
                   ? "The take has no markers"
                   : "None of the take's " + count_of(take.marker_count(), "marker") +
                         " is chosen (" + join(reasons, "; ") + ")",
       .file = take.origin.path,
       .remedy = "See the markers with \"kinemesh c3d info\" and choose with --subject, --include, "
                 "--exclude, --kind and --head-rig"});
}

void judge_all(const MarkerSequence& take, const Rules& rules, const std::vector<bool>& valid,
               MarkerSelectionResult& result) {
  result.chosen.clear();
  result.head_rig.clear();
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    const Marker& marker = take.markers()[m];
    MarkerDecision& d = result.decisions[m];
    d.head_rig = rules.rig_names_count && marker.kind == MarkerKind::marker &&
                 matches_any(rules.options.head_rig_patterns, marker);
    d.reason = rules.judge(marker, d.head_rig, valid[m]);
    d.chosen = d.reason == SelectionReason::chosen;
    d.text = text_of(d.reason, marker);
    if (d.chosen) result.chosen.push_back(m);
    if (d.head_rig && valid[m] && d.reason != SelectionReason::other_subject) {
      result.head_rig.push_back(m);
    }
  }
}

}  // namespace

std::vector<std::string> usual_head_rig_patterns() {
  return {"root*", "head*", "LFHD", "RFHD", "LBHD", "RBHD", "ARIEL", "helmet*", "skull*"};
}

void MarkerSelectionOptions::declare(ParameterSet& p) {
  p.group("markers", "Choice of markers");
  p.list("subject", subjects,
         {.metavar = "PATTERN", .help = "only markers of these subjects (* and ? are wildcards)"});
  p.list("include", include,
         {.metavar = "PATTERN", .help = "only markers whose name matches one of these patterns"});
  p.list("exclude", exclude,
         {.metavar = "PATTERN", .help = "no markers whose name matches one of these patterns"});
  p.list("kind", kinds,
         {.metavar = "KIND",
          .help = "kinds of points to take: marker, unlabelled, virtual, angle, force, moment, "
                  "power, scalar"});
  p.flag("head-rig", head_rig, "take the markers of the head rig as vertices, too");
  p.list("head-rig-patterns", head_rig_patterns,
         {.metavar = "PATTERN", .help = "names by which markers of a head rig are known"});
}

void MarkerSelectionOptions::validate() const {
  validate_options(*this);
  std::vector<std::string> words;
  for (const MarkerKind kind : all_kinds) words.emplace_back(name_of(kind));
  for (const std::string& kind : kinds) {
    if (std::ranges::find(words, lower(kind)) == words.end()) {
      throw UsageError({.what = "--kind must be one of " + join(words, ", ", " or ") + ", not \"" +
                                kind + "\""});
    }
  }
}

MarkerSelectionResult select_markers(const MarkerSequence& take,
                                     const MarkerSelectionOptions& options, const RunContext& ctx) {
  options.validate();
  Rules rules{.options = options, .kinds = {}};
  for (const std::string& kind : options.kinds) rules.kinds.insert(lower(kind));
  MarkerSelectionResult result;
  result.decisions.resize(take.marker_count());
  const std::vector<bool> valid = ever_valid(take);
  judge_all(take, rules, valid, result);
  warn_of_idle_patterns(take, options, result.warnings);
  const auto only_rig = [](const MarkerDecision& d) {
    return d.reason == SelectionReason::head_rig;
  };
  if (result.chosen.empty() && std::ranges::any_of(result.decisions, only_rig)) {
    rules.rig_names_count = false;
    judge_all(take, rules, valid, result);
    result.warnings.push_back(
        "All markers left have names of a head rig; they are taken as vertices, and no marker is "
        "taken as rigid.");
  }
  warn_of_invalid(take, result);
  for (const std::string& warning : result.warnings) ctx.warn(warning);
  if (result.chosen.empty()) nothing_left(take, result);
  return result;
}

}  // namespace kinemesh
