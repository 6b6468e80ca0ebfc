#include "capture/c3d/check.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "capture/c3d/ezc3d_process.h"
#include "capture/c3d/ezc3d_reader.h"
#include "capture/c3d/lint.h"
#include "capture/session_diff.h"
#include "config/error.h"
#include "config/text.h"

namespace kinemesh {
namespace {

bool has(const std::vector<C3dFinding>& findings, std::string_view code) {
  return std::ranges::any_of(findings, [&](const C3dFinding& f) { return f.code == code; });
}

/// Why ezc3d is known to be wrong where it differs in this way; empty when it is not known.
std::string known_fault(const Difference& difference, const std::vector<C3dFinding>& findings) {
  switch (difference.kind) {
    case DifferenceKind::residual:
    case DifferenceKind::camera_mask: return "ezc3d exchanges residual and camera mask";
    case DifferenceKind::position:
    case DifferenceKind::validity:
      if (has(findings, "C3D409") || has(findings, "C3D410")) {
        return "ezc3d does not know 65535 as the mark of a gap";
      }
      return "";
    case DifferenceKind::analog:
      if (has(findings, "C3D503")) return "ezc3d takes unsigned offsets as signed";
      return "";
    default: return "";
  }
}

/// Differences of one kind are one finding: which markers, and the largest of them.
struct Group {
  std::string fault;
  Difference largest;
  std::vector<std::string> places;
};

void add_differences(const SessionDiffResult& diff, C3dCheckResult& result) {
  std::vector<std::pair<DifferenceKind, Group>> groups;
  for (const Difference& d : diff.differences) {
    const std::string fault = known_fault(d, result.findings);
    auto it = std::ranges::find_if(
        groups, [&](const auto& g) { return g.first == d.kind && g.second.fault == fault; });
    if (it == groups.end()) {
      groups.push_back({d.kind, {fault, d, {}}});
      it = std::prev(groups.end());
    }
    it->second.places.push_back(d.place);
    if (d.largest > it->second.largest.largest) it->second.largest = d;
  }
  for (const auto& [kind, group] : groups) {
    const std::size_t more = group.places.size() - 1;
    std::string message = "with Kinemesh as A and ezc3d as B, " + group.largest.message;
    if (more > 0) {
      message +=
          "; likewise " + count_of(more, "more marker or channel", "more markers or channels");
    }
    if (!group.fault.empty()) message += "; ezc3d is wrong: " + group.fault;
    if (group.fault.empty()) result.second_opinion = SecondOpinion::differs;
    result.findings.push_back(
        c3d_finding(group.fault.empty() ? "C3D803" : "C3D802", message, group.largest.place));
  }
}

void ask_ezc3d(const std::filesystem::path& path, const C3dCheckOptions& options,
               const C3dReadResult& own, C3dCheckResult& result, const RunContext& ctx) {
  if (const std::string unsuited = ezc3d_refusal(own); !unsuited.empty()) {
    result.findings.push_back(c3d_finding("C3D801", "ezc3d was not asked: " + unsuited, ""));
    return;
  }
  C3dReadResult other{.take = own.take, .header = own.header, .layout = own.layout};
  const std::string why = reread_with_ezc3d_apart(path, options.read.c3d, other, ctx);
  if (!why.empty()) {
    result.second_opinion = SecondOpinion::refused;
    result.findings.push_back(c3d_finding("C3D804", why, ""));
    return;
  }
  compare_readers(own.take, other.take, result, ctx);
}

void check_c3d(const std::filesystem::path& path, const C3dCheckOptions& options,
               C3dCheckResult& result, const RunContext& ctx) {
  C3dReadOptions read = options.read.c3d;
  read.reader = C3dReader::own;
  const C3dReadResult own = read_c3d(path, read, ctx.part(0.0, 0.5, "reading"));
  result.readable = true;
  result.findings = own.findings;
  for (C3dFinding& f : lint_session(own.take, &own.layout, ctx)) {
    result.findings.push_back(std::move(f));
  }
  if (options.second_opinion) ask_ezc3d(path, options, own, result, ctx);
}

std::string headline(const C3dCheckResult& result) {
  std::size_t counts[3] = {0, 0, 0};
  for (const C3dFinding& f : result.findings) ++counts[static_cast<std::size_t>(f.severity)];
  std::vector<std::string> parts;
  if (counts[2] > 0) parts.push_back(count_of(counts[2], "error"));
  if (counts[1] > 0) parts.push_back(count_of(counts[1], "warning"));
  if (parts.empty()) parts.emplace_back("healthy");
  if (counts[0] > 0) parts.push_back(count_of(counts[0], "note"));
  return join(parts, ", ");
}

}  // namespace

void C3dCheckOptions::declare(ParameterSet& p) {
  read.declare(p);
  p.group("check", "Checking");
  p.flag("second-opinion", second_opinion,
         "Let the library ezc3d read healthy files too, and name every difference");
}

void C3dCheckOptions::validate() const { validate_options(*this); }

std::string_view name_of(SecondOpinion opinion) {
  switch (opinion) {
    case SecondOpinion::agrees: return "agrees";
    case SecondOpinion::differs: return "differs";
    case SecondOpinion::refused: return "refused";
    case SecondOpinion::not_asked: return "not_asked";
  }
  return "not_asked";
}

C3dCheckResult check_session(const std::filesystem::path& path, const C3dCheckOptions& options,
                             const RunContext& ctx) {
  options.validate();
  C3dCheckResult result{.file = path.string()};
  try {
    if (detect_session_format(path) == SessionFormat::c3d) {
      check_c3d(path, options, result, ctx);
    } else {
      const MarkerSequence take = read_session(path, options.read, ctx);
      result.readable = true;
      result.findings = lint_session(take, nullptr, ctx);
    }
  } catch (const InputError& e) {
    C3dFinding finding = c3d_finding("C3D001", e.details().what, e.details().place);
    if (!e.details().remedy.empty()) finding.remedy = e.details().remedy;
    result.findings.push_back(std::move(finding));
  }
  return result;
}

void compare_readers(const MarkerSequence& own, const MarkerSequence& other, C3dCheckResult& result,
                     const RunContext& ctx) {
  result.second_opinion = SecondOpinion::agrees;
  SessionDiffOptions diff;
  diff.parameters = false;
  add_differences(diff_sessions(own, other, diff, ctx), result);
}

std::string check_text(const C3dCheckResult& result) {
  std::string text = result.file + ": " + headline(result) + "\n";
  for (std::size_t i = 0; i < result.findings.size(); ++i) {
    const C3dFinding& f = result.findings[i];
    std::string severity(f.severity == Severity::info ? "note" : name_of(f.severity));
    severity.resize(7, ' ');
    text += "  " + severity + "  " + f.code + "  " + (f.place.empty() ? "" : f.place + ": ") +
            f.message + "\n";
    // What to do is said once, behind the last of several findings with the same remedy.
    const bool last = i + 1 == result.findings.size() || result.findings[i + 1].remedy != f.remedy;
    if (last && f.severity != Severity::info && !f.remedy.empty()) {
      text += "           " + f.remedy + "\n";
    }
  }
  return text;
}

std::string check_json(const std::vector<C3dCheckResult>& results) {
  using Json = nlohmann::ordered_json;
  Json files = Json::array();
  bool errors = false;
  for (const C3dCheckResult& r : results) {
    Json findings = Json::array();
    for (const C3dFinding& f : r.findings) {
      findings.push_back({{"code", f.code},
                          {"severity", name_of(f.severity)},
                          {"place", f.place},
                          {"message", f.message},
                          {"remedy", f.remedy}});
    }
    files.push_back({{"file", r.file},
                     {"readable", r.readable},
                     {"errors", r.has_errors()},
                     {"second_opinion", name_of(r.second_opinion)},
                     {"findings", std::move(findings)}});
    errors = errors || r.has_errors();
  }
  return Json{{"errors", errors}, {"files", std::move(files)}}.dump(2, ' ', false,
                                                                    Json::error_handler_t::replace);
}

}  // namespace kinemesh
