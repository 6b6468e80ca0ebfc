// From a scan and a session to all files that `kinemesh animate` writes; they appear together, or
// none of them.
#pragma once

#include <string>
#include <vector>

#include "capture/session.h"
#include "mesh/formats/options.h"
#include "mesh/formats/registry.h"
#include "reconstruct/animate_scan.h"
#include "report/contact_sheet.h"

namespace kinemesh {

struct AnimateFilesOptions {
  SessionReadOptions reading;
  AnimateOptions animate;
  WriteOptions writing;
  bool pictures = true;
  ContactSheetOptions sheet;

  void declare(ParameterSet& p);
  void validate() const;
};

struct AnimateJob {
  std::string scan, session, output;
  std::string places;  ///< file that says where the markers sit; may be empty
  std::string program, command, options_toml;  ///< for the provenance
};

struct AnimateFilesResult {
  AnimateResult result;
  std::vector<std::string> outputs;
  std::string json;  ///< the summary, as in OUT_summary.json
};

/// Writes OUT, OUT_points.csv (where the markers sit, for --points), OUT_attachment.png (scan and
/// markers with their distances), OUT_frames.png and OUT_summary.json.
AnimateFilesResult animate_files(const FormatRegistry& formats, const AnimateJob& job,
                                 const AnimateFilesOptions& options = {},
                                 const RunContext& ctx = {});

}  // namespace kinemesh
