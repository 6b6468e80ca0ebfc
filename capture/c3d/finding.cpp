#include "capture/c3d/finding.h"

#include <algorithm>
#include <array>

#include "config/error.h"

namespace kinemesh {
namespace {

constexpr auto info = Severity::info;
constexpr auto warning = Severity::warning;
constexpr auto error = Severity::error;
constexpr std::string_view repair = "kinemesh c3d check --repair -o OUT writes a consistent file";
constexpr std::string_view nothing = "Nothing needs to be done";

constexpr auto kinds = std::to_array<C3dFindingKind>({
    // The whole file
    {"C3D001", error, "The file cannot be read",
     "Give another copy of the file; --repair cannot help where nothing can be read"},
    // Header
    {"C3D101", warning, "The second byte of the header is not 80, the key of C3D files", repair},
    {"C3D102", error, "Zero bytes precede the header", repair},
    {"C3D103", error, "The header's pointer to the parameter section is wrong", repair},
    {"C3D104", error, "There is no parameter section: labels and units are unknown", repair},
    {"C3D105", warning, "The header's first frame is 0, though frames count from 1", repair},
    {"C3D106", info, "The file holds header events beside the EVENT group", nothing},
    {"C3D107", warning, "A header event has no usable time and is left out",
     "Set the event again in the software that recorded it"},
    // Parameter section
    {"C3D201", warning, "The parameter section is longer than its block count says", repair},
    {"C3D202", error, "The processor byte is none of 84, 85 and 86", repair},
    {"C3D203", error, "The chain of parameter records breaks off", repair},
    {"C3D204", error, "A parameter's dimensions claim more data than its record holds", repair},
    {"C3D205", error, "A parameter has an unknown type and is left out", repair},
    {"C3D206", warning, "A parameter belongs to a group that is not declared", repair},
    {"C3D207", error, "A parameter record lacks the byte that holds its description's length",
     repair},
    {"C3D208", warning,
     "Two groups, or two parameters of a group, have the same name; the first counts",
     "Rename or remove one of them"},
    {"C3D209", warning, "A description is longer than its record", repair},
    {"C3D210", error, "The parameter section runs into the data section", repair},
    {"C3D211", warning, "A record's pointer skips bytes behind its end", repair},
    {"C3D212", warning, "The parameter section is absurdly long; reading it stopped", repair},
    {"C3D213", warning, "The last record's pointer leads out of the section", repair},
    {"C3D214", error, "A parameter has more entries than its dimensions, of 8 bits, can say",
     repair},
    // Layout and frame counts
    {"C3D301", error, "Header and parameters disagree on the number of frames", repair},
    {"C3D302", error, "The file ends before its last frame",
     "Copy the file again from its source; otherwise --repair keeps the complete frames"},
    {"C3D303", error, "Header and POINT:DATA_START disagree on where the data begin", repair},
    {"C3D304", error, "Header and POINT:USED disagree on the number of points", repair},
    {"C3D305", error, "Header and the ANALOG group disagree on the analog data", repair},
    {"C3D306", warning, "POINT:RATE is missing; the header's, or that of ANALOG, is used", repair},
    {"C3D307", warning, "Header and POINT:RATE disagree on the frame rate", repair},
    {"C3D308", error, "Header and POINT:SCALE disagree on whether the data are floats", repair},
    {"C3D309", warning, "Header and POINT:SCALE disagree on the scale", repair},
    {"C3D310", error, "The scale is 0 or no number; 1 is used", repair},
    {"C3D311", info, "Bytes follow the last frame beyond the padding of a block", nothing},
    {"C3D312", warning,
     "The frame count does not fit its 16-bit fields; frames are counted to the end of the file",
     repair},
    {"C3D313", info, "The number of frames, or of the last one, is more than 16 bits can hold",
     nothing},
    {"C3D314", info, "The file has no points", nothing},
    {"C3D315", info, "The file holds rotations, which are kept, but not used", nothing},
    {"C3D316", error, "No frame rate is given; 1 Hz is used",
     "Say it with --rate, or set POINT:RATE in the software that wrote the file"},
    {"C3D317", error, "The data section would begin outside the file", repair},
    {"C3D318", error, "POINT:USED or ANALOG:USED is missing; the header's count is used", repair},
    {"C3D319", error, "Rotations are cut off, or not where ROTATION:DATA_START says",
     "Copy the file again from its source; otherwise --repair keeps the complete ones"},
    {"C3D320", warning, "POINT:FRAMES is missing; the header's count is used", repair},
    // Points and labels
    {"C3D401", warning, "There are fewer labels than points; the others are named by number",
     repair},
    {"C3D402", info, "There are more labels than points; the last ones are unused", nothing},
    {"C3D403", warning, "Several points have the same label", "Rename all but one of them"},
    {"C3D404", warning, "The length unit is not given; millimetres are assumed",
     "Set POINT:UNITS, or say so with --unit"},
    {"C3D405", warning, "The length unit is unknown; millimetres are assumed",
     "Set POINT:UNITS to mm, cm or m, or say so with --unit"},
    {"C3D406", warning, "Text is not UTF-8; it is read as Windows-1252", repair},
    {"C3D407", info, "Points at (0, 0, 0) with a residual of 0 or more are taken as gaps",
     "If they are measured points, read with --zero-points valid"},
    {"C3D408", warning,
     "Coordinates are no finite numbers though the residual says valid; they are taken as gaps",
     repair},
    {"C3D409", info, "Gaps are marked by 65535, an unsigned -1", nothing},
    {"C3D410", warning, "Residual words do not fit 16 bits; their points are taken as gaps",
     repair},
    {"C3D411", info, "Points have no label", nothing},
    {"C3D412", info, "Points at (-16512, -16512, -16512) are taken as gaps", nothing},
    {"C3D413", warning, "Coordinates are over 1 km from the origin",
     "Look at the frames named; the data may be damaged"},
    {"C3D414", info, "Points have different units", nothing},
    // Analog
    {"C3D501", warning, "ANALOG:RATE is missing; the header's samples per frame are used", repair},
    {"C3D502", warning, "ANALOG:RATE is not the frame rate times the samples per frame", repair},
    {"C3D503", info, "ANALOG:OFFSET is unsigned", nothing},
    {"C3D504", warning,
     "There are fewer analog labels than channels; the others are named by number", repair},
    {"C3D505", warning, "There are fewer analog scales or offsets than channels; 1 and 0 are used",
     repair},
    {"C3D506", info, "ANALOG:GEN_SCALE is negative", nothing},
    {"C3D507", warning, "ANALOG:GEN_SCALE is missing, 0 or no number; 1 is used", repair},
    {"C3D508", warning, "Analog values are no finite numbers", "Look at the channels named"},
    // Events and subjects
    {"C3D601", warning, "The EVENT group's arrays differ in length; incomplete events are left out",
     repair},
    {"C3D602", warning, "An event lies outside the recording", "Check its time"},
    {"C3D603", warning, "The SUBJECTS group's arrays differ in length", repair},
    // Worth a second look, though read without doubt
    {"C3D701", warning, "Markers are not measured in any frame",
     "Check the labelling; leave these markers out of what follows"},
    {"C3D702", info, "Markers are missing in more than half of the frames",
     "Check the labelling; gap filling has little to go by"},
    {"C3D703", info,
     "All residuals are 0: the positions were interpolated, edited or generated, or the software "
     "does not write residuals",
     nothing},
    {"C3D704", warning, "The frame rate is unusual", "Check POINT:RATE against the recording"},
    {"C3D705", warning, "The extent of the markers does not fit the length unit",
     "Check POINT:UNITS; where it is missing, say the unit with --unit"},
    {"C3D706", warning, "Positions lie at the limit of what the integers can hold",
     "Export the file again with a larger scale or as floats"},
    {"C3D707", info, "The integer step is coarser than 0.5 mm",
     "Export the file again as floats where more precision is needed"},
    {"C3D708", info, "Markers repeat exactly one position for a second or longer",
     "Check that these frames were measured"},
    {"C3D709", warning, "An event stands twice in the file", "Remove one of the two"},
    {"C3D710", warning, "The FORCE_PLATFORM group describes fewer plates than it says",
     "Export the file again with the force plates' calibration"},
    {"C3D711", warning, "The FORCE_PLATFORM group names analog channels that do not exist",
     "Export the file again with its analog data"},
    // Second opinion
    {"C3D801", info, "ezc3d does not support this kind of file and was not asked", nothing},
    {"C3D802", info, "ezc3d reads something differently, and is known to be wrong there", nothing},
    {"C3D803", warning,
     "ezc3d reads something differently, and neither reader is known to be wrong there",
     "Look at the values named in both programs"},
    {"C3D804", warning, "ezc3d refuses the file, though nothing wrong was found",
     "Programs that use ezc3d will not read this file"},
});

}  // namespace

std::string_view name_of(Severity severity) {
  switch (severity) {
    case Severity::info: return "info";
    case Severity::warning: return "warning";
    case Severity::error: return "error";
  }
  return "error";
}

std::span<const C3dFindingKind> c3d_finding_kinds() { return kinds; }

const C3dFindingKind* c3d_finding_kind(std::string_view code) {
  const auto* const it = std::ranges::find(kinds, code, &C3dFindingKind::code);
  return it == kinds.end() ? nullptr : it;
}

C3dFinding c3d_finding(std::string_view code, std::string message, std::string place) {
  const C3dFindingKind* kind = c3d_finding_kind(code);
  if (kind == nullptr) throw InternalError("no finding has the code " + std::string(code));
  return {.code = std::string(code),
          .severity = kind->severity,
          .message = std::move(message),
          .place = std::move(place),
          .remedy = std::string(kind->remedy)};
}

bool has_code(std::span<const C3dFinding> findings, std::string_view code) {
  return std::ranges::any_of(findings, [&](const C3dFinding& f) { return f.code == code; });
}

bool has_errors(std::span<const C3dFinding> findings) {
  return std::ranges::any_of(findings,
                             [](const C3dFinding& f) { return f.severity == Severity::error; });
}

}  // namespace kinemesh
