#include "capture/session.h"

#include <algorithm>
#include <array>

#include "capture/formats/motive_csv.h"
#include "capture/formats/qtm_tsv.h"
#include "capture/formats/session_csv.h"
#include "capture/formats/trc.h"
#include "config/error.h"
#include "config/input_file.h"
#include "config/text.h"

namespace kinemesh {
namespace {

/// The first line that is not blank, without a UTF-8 mark.
std::string_view first_line(std::string_view text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
  return text.substr(0, text.find_first_of("\r\n"));
}

bool looks_like_trc(std::string_view line) { return line.starts_with("PathFileType"); }

C3dReadResult read_c3d_session(const std::filesystem::path& path, const SessionReadOptions& options,
                               const RunContext& ctx) {
  C3dReadResult result = read_c3d(path, options.c3d, ctx);
  constexpr std::size_t most = 5;
  std::size_t shown = 0;
  std::size_t left = 0;
  for (const C3dFinding& finding : result.findings) {
    if (finding.severity == Severity::info) continue;
    if (++shown > most) {
      ++left;
      continue;
    }
    ctx.warn(path.string() + ": " + finding.code + ": " + finding.place +
             (finding.place.empty() ? "" : ": ") + finding.message);
  }
  if (left > 0) {
    ctx.warn(path.string() + ": " + count_of(left, "more finding") + "; see 'kinemesh c3d check'");
  }
  return result;
}

}  // namespace

std::string_view name_of(SessionFormat format) {
  switch (format) {
    case SessionFormat::c3d: return "C3D";
    case SessionFormat::trc: return "TRC";
    case SessionFormat::csv: return "Kinemesh CSV";
    case SessionFormat::motive: return "Motive CSV";
    case SessionFormat::qtm: return "QTM TSV";
  }
  return "C3D";
}

void SessionReadOptions::declare(ParameterSet& p) { c3d.declare(p); }

void SessionReadOptions::validate() const { validate_options(*this); }

SessionFormat detect_session_format(const std::filesystem::path& path) {
  const InputFile file(path);
  std::array<char, 4096> buffer{};
  const std::string_view head(buffer.data(), file.read_at(0, buffer.data(), buffer.size()));
  const std::string extension = lower(path.extension().string());
  const bool text = head.find('\0') == std::string_view::npos && !head.empty();
  if (text) {
    const std::string_view line = first_line(head);
    if (looks_like_trc(line)) return SessionFormat::trc;
    if (looks_like_motive_csv(line)) return SessionFormat::motive;
    if (looks_like_qtm(line)) return SessionFormat::qtm;
    if (looks_like_session_csv(line)) return SessionFormat::csv;
  }
  if (extension == ".trc") return SessionFormat::trc;
  if (head.starts_with("\x89PNG")) {  // its second byte is that of a C3D file
    throw InputError({.what = "this is a picture (PNG), no session",
                      .file = path.string(),
                      .remedy = "Give the recording itself"});
  }
  if (extension == ".c3d") return SessionFormat::c3d;
  // A C3D file under another name: its second byte is 80; leading zero bytes occur.
  const std::size_t start = std::min(head.find_first_not_of('\0'), head.size());
  if (!text && start + 1 < head.size() && head[start + 1] == 'P') return SessionFormat::c3d;
  throw InputError(
      {.what = extension == ".csv" || extension == ".tsv" || extension == ".txt"
                   ? "this table is no session that Kinemesh knows: its first line is neither that "
                     "of a Kinemesh, Motive or QTM export nor of a TRC file"
                   : "this is no session that Kinemesh reads",
       .file = path.string(),
       .place = extension == ".csv" || extension == ".tsv" ? "line 1" : "",
       .remedy = "Give a C3D file, a TRC file, or a CSV or TSV export of Kinemesh, Motive or QTM "
                 "with its header"});
}

namespace {

MarkerSequence read_table(const std::filesystem::path& path, SessionFormat format,
                          const SessionReadOptions& options, const RunContext& ctx) {
  const TableText text(read_file(path), path.string());
  const TableReadOptions table{.zero_is_gap = options.c3d.zero_points == ZeroPolicy::gap,
                               .unstated = options.c3d.unstated};
  MarkerSequence take = [&] {
    switch (format) {
      case SessionFormat::trc: return read_trc(text, table, ctx);
      case SessionFormat::motive: return read_motive_csv(text, table, ctx);
      case SessionFormat::qtm: return read_qtm(text, table, ctx);
      default: return read_session_csv(text, table, ctx);
    }
  }();
  take.origin.path = path.string();
  return take;
}

}  // namespace

MarkerSequence read_session(const std::filesystem::path& path, const SessionReadOptions& options,
                            const RunContext& ctx) {
  options.validate();
  const SessionFormat format = detect_session_format(path);
  if (format == SessionFormat::c3d) return read_c3d_session(path, options, ctx).take;
  return read_table(path, format, options, ctx);
}

SessionSummaryResult summarise_session(const std::filesystem::path& path,
                                       const SessionReadOptions& options, const RunContext& ctx) {
  options.validate();
  const SessionFormat format = detect_session_format(path);
  if (format != SessionFormat::c3d) {
    return {
        summarise(read_table(path, format, options, ctx), nullptr, std::string(name_of(format))),
        {}};
  }
  C3dReadResult result = read_c3d_session(path, options, ctx);
  return {summarise(result.take, &result.layout), std::move(result.findings)};
}

}  // namespace kinemesh
