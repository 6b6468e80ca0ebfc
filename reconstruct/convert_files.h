// From a session's file to all files that a conversion writes: the animated mesh, pictures, the
// record of quality, the summary and the report. They appear together, or none of them.
#pragma once

#include <string>
#include <vector>

#include "capture/session.h"
#include "mesh/formats/options.h"
#include "mesh/formats/registry.h"
#include "reconstruct/convert.h"
#include "reconstruct/convert_summary.h"
#include "report/contact_sheet.h"

namespace kinemesh {

struct ConvertFilesOptions {
  SessionReadOptions reading;
  ConvertOptions convert;
  WriteOptions writing;
  bool pictures = true;    ///< the mesh at a few frames, the gaps over time
  bool report = true;      ///< the HTML page
  bool anonymous = false;  ///< names of subjects and files are left out of all that is written
  ContactSheetOptions sheet;

  void declare(ParameterSet& p);
  void validate() const;
};

/// One conversion: where from, where to, and what is to be said about how it was made.
struct ConvertJob {
  std::string session;
  std::string output;    ///< of the mesh; the other files lie beside it
  std::string previous;  ///< mesh whose triangulation is used again; may be empty
  std::string edits;     ///< list of steps that the session is edited by first; may be empty
  std::string program;   ///< these three for the provenance
  std::string command;
  std::string options_toml;
};

struct ConvertFilesResult {
  MarkerSequence session;
  ConvertResult conversion;
  WrittenMesh written;
  double report_error_mm = 0.0;  ///< largest error of the animation in the report
};

/// The session's name with `extension`: a name, never a pattern of numbered files, so that '#' and
/// '%' in it become '-'.
std::string default_output(const std::string& session, const std::string& extension);

/// Throws UsageError naming what is set in `options` that holds for sessions only and says nothing
/// about a mesh.
void refuse_session_options(const ConvertFilesOptions& options, const std::string& mesh);

/// Throws as read_session, convert_session and write_animation; then nothing is left.
ConvertFilesResult convert_files(const FormatRegistry& formats, const ConvertJob& job,
                                 const ConvertFilesOptions& options = {},
                                 const RunContext& ctx = {});

}  // namespace kinemesh
