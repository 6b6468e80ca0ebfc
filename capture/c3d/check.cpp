#include "capture/c3d/check.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "capture/c3d/lint.h"
#include "capture/c3d/second_opinion.h"
#include "config/error.h"
#include "config/text.h"

namespace kinemesh {
namespace {

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
  if (options.second_opinion) ask_ezc3d(path, options.read.c3d, own, result, ctx);
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
