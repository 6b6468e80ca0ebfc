// One step of an edit list: its parameters and what it does to a take. Internal to editing.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "capture/marker_sequence.h"
#include "config/parameter.h"
#include "config/run_context.h"

namespace kinemesh {

/// What a step needs beside the take.
struct EditContext {
  std::filesystem::path folder;  ///< other files are named relative to it
  RunContext run;
};

class EditOperation {
 public:
  virtual ~EditOperation() = default;
  /// The word of `do`.
  virtual std::string_view name() const = 0;
  virtual void declare(ParameterSet& p) = 0;
  /// Files that it reads, as named in the list.
  virtual std::vector<std::string> files() const { return {}; }
  /// Changes the take and says what was done, in one sentence without a full stop. Throws
  /// UsageError when the step does not fit the take.
  virtual std::string apply(MarkerSequence& take, const EditContext& context) const = 0;
};

/// With default parameters; null for an unknown name.
std::shared_ptr<EditOperation> make_operation(std::string_view name);
std::vector<std::string> operation_names();

// ---- the operations, one file a family ----------------------------------------------------------

/// crop, join, resample.
std::shared_ptr<EditOperation> make_timeline_operation(std::string_view name);
/// rename, swap, delete, move, unite-twins.
std::shared_ptr<EditOperation> make_column_operation(std::string_view name);
/// merge-subjects, anonymise, add-event, units, axes.
std::shared_ptr<EditOperation> make_description_operation(std::string_view name);
/// repair, label, fill, filter, stabilise.
std::shared_ptr<EditOperation> make_stage_operation(std::string_view name);

// ---- what they share ----------------------------------------------------------------------------

/// The marker with this label (marker_meant()), which the step's `parameter` names.
std::size_t marker_named(const MarkerSequence& take, const std::string& label,
                         const std::string& parameter = "marker");

struct FrameSpan {
  std::size_t begin = 0, end = 0;  ///< 0-based, [begin, end)
};
/// From frame numbers as in the file, both included; 0 stands for the first or the last frame.
/// Throws UsageError for frames outside the take or in the wrong order.
FrameSpan frames_between(const MarkerSequence& take, int64_t from, int64_t to);

/// Exchanges all samples of two markers.
void swap_samples(MarkerSequence& take, std::size_t a, std::size_t b, const FrameSpan& span);

/// Declares the parameters `from` and `to`.
void declare_frames(ParameterSet& p, int64_t& from, int64_t& to);

}  // namespace kinemesh
