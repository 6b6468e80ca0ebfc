// What is wrong, or merely remarkable, in a C3D file: stable codes with their meaning and remedy.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kinemesh {

/// `error`: a tool that trusts the file gets wrong data or none. `warning`: the file breaks the
/// format, but only one reading makes sense. `info`: legal, yet worth knowing.
enum class Severity : uint8_t { info, warning, error };

/// "info", "warning", "error".
std::string_view name_of(Severity severity);

/// One deviation found while reading.
struct C3dFinding {
  std::string code;  ///< stable, as in c3d_finding_kinds(): "C3D101"
  Severity severity = Severity::warning;
  std::string message;  ///< what is so in this file, with its numbers; one sentence, no full stop
  std::string place;    ///< "byte 512", "parameter POINT:RATE", "frame 12", "marker LFHD"
  std::string remedy;   ///< what to do about it
  friend bool operator==(const C3dFinding&, const C3dFinding&) = default;
};

/// One row of the table of all codes. The hundreds digit says where: 1 header, 2 parameter
/// section, 3 layout and frame counts, 4 points and labels, 5 analog, 6 events and subjects, 7 what
/// is read without doubt yet worth a look, 8 the second opinion of ezc3d; 0 is the whole file.
struct C3dFindingKind {
  std::string_view code;
  Severity severity;
  std::string_view meaning;
  std::string_view remedy;
};

/// All codes, ascending. Documentation and tests derive from this table.
std::span<const C3dFindingKind> c3d_finding_kinds();
/// Null when there is no such code.
const C3dFindingKind* c3d_finding_kind(std::string_view code);

/// A finding with severity and remedy as in the table. Throws InternalError for an unknown code.
C3dFinding c3d_finding(std::string_view code, std::string message, std::string place);

/// True when one of them has this code.
bool has_code(std::span<const C3dFinding> findings, std::string_view code);
/// True when one of them is an error.
bool has_errors(std::span<const C3dFinding> findings);

}  // namespace kinemesh
