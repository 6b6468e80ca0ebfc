// Editing without touching the original: a list of steps in TOML, applied in order, so that a
// session can be processed again, and each step taken back by removing it from the list.
//
//   [[edit]]
//   do = "crop"
//   from = 101
//   to = 900
//
// docs/editing.md lists the steps and their parameters. Frame numbers are those of the take as the
// steps before have left it.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "capture/marker_sequence.h"
#include "config/run_context.h"

namespace kinemesh {

class EditOperation;

struct EditList {
  std::vector<std::shared_ptr<const EditOperation>> steps;
  std::filesystem::path folder;  ///< other files are named relative to it; empty: where we are
};

/// Throws UsageError naming file, line and remedy for an unknown step or parameter.
EditList parse_edits(std::string_view toml, const std::string& file_name);
/// Throws also InputError when the file cannot be read.
EditList read_edits(const std::filesystem::path& path);
/// The list as a TOML document that parse_edits() reads back. Parameters at their default are left
/// out.
std::string edits_toml(const EditList& edits);

/// The files that its steps read.
std::vector<std::filesystem::path> files_read(const EditList& edits);

/// A step made in a program: its name and values as a user would type them. Throws UsageError.
std::shared_ptr<const EditOperation> make_edit(
    std::string_view operation,
    const std::vector<std::pair<std::string, std::vector<std::string>>>& values = {});

struct EditResult {
  MarkerSequence take;
  std::vector<std::string> done;  ///< one sentence a step
};

/// Applies all steps to a copy. Throws UsageError that names the step when one does not fit.
EditResult apply_edits(const MarkerSequence& take, const EditList& edits,
                       const RunContext& ctx = {});

}  // namespace kinemesh
