// The lint behind `kinemesh c3d check`: what reading a session found, what deserves a second look,
// and whether ezc3d reads the same.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "capture/c3d/finding.h"
#include "capture/session.h"
#include "config/parameter.h"
#include "config/run_context.h"

namespace kinemesh {

struct C3dCheckOptions {
  SessionReadOptions read;
  bool second_opinion = true;  ///< let ezc3d read the file too, where it can

  void declare(ParameterSet& p);
  /// Throws UsageError.
  void validate() const;
};

/// What became of the second opinion.
enum class SecondOpinion : uint8_t {
  agrees,     ///< ezc3d reads the same, but for what it is known to get wrong
  differs,    ///< it reads something else, and neither is known to be wrong
  refused,    ///< it refuses the file
  not_asked,  ///< not supported there, the file is damaged, or it was not wanted
};
/// "agrees", "differs", "refused", "not_asked".
std::string_view name_of(SecondOpinion opinion);

struct C3dCheckResult {
  std::string file;
  bool readable = false;
  std::vector<C3dFinding> findings;  ///< reading, then lint, then second opinion
  SecondOpinion second_opinion = SecondOpinion::not_asked;
  bool has_errors() const { return kinemesh::has_errors(findings); }
};

/// Never throws for what the file holds: a file that cannot be read is finding C3D001. Tables of
/// other programs (TRC, CSV, TSV) are linted too; nothing about their bytes is.
C3dCheckResult check_session(const std::filesystem::path& path, const C3dCheckOptions& options = {},
                             const RunContext& ctx = {});

/// For a person: one heading a file, one line a finding, and what to do about it.
std::string check_text(const C3dCheckResult& result);
/// The document that docs/c3d.md describes.
std::string check_json(const std::vector<C3dCheckResult>& results);

}  // namespace kinemesh
