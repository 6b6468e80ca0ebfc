#include "capture/edit/operation.h"

#include "capture/marker_name.h"
#include "config/error.h"

namespace kinemesh {

std::vector<std::string> operation_names() {
  return {"crop", "join",        "resample",       "rename",    "swap",      "delete",
          "move", "unite-twins", "merge-subjects", "anonymise", "add-event", "units",
          "axes", "repair",      "label",          "fill",      "filter",    "stabilise"};
}

std::shared_ptr<EditOperation> make_operation(std::string_view name) {
  for (const auto& make : {make_timeline_operation, make_column_operation,
                           make_description_operation, make_stage_operation}) {
    if (auto operation = make(name)) return operation;
  }
  return nullptr;
}

std::size_t marker_named(const MarkerSequence& take, const std::string& label,
                         const std::string& parameter) {
  if (label.empty()) {
    throw UsageError({.what = "'" + parameter + "' names a marker of the take, and is missing",
                      .remedy = "Add a line such as " + parameter + " = \"CHIN\""});
  }
  return marker_meant(take.markers(), label, "the step names");
}

FrameSpan frames_between(const MarkerSequence& take, int64_t from, int64_t to) {
  const int64_t first = take.first_frame;
  const int64_t last = first + static_cast<int64_t>(take.frame_count()) - 1;
  const int64_t begin = from == 0 ? first : from;
  const int64_t end = to == 0 ? last : to;
  if (from != 0 && to != 0 && begin > end) {
    throw UsageError({.what = "'from' is " + std::to_string(begin) + " and 'to' is " +
                              std::to_string(end) + ", which comes before it",
                      .remedy = "Exchange the two"});
  }
  if (begin < first || end > last || begin > end) {
    throw UsageError({.what = "frames " + std::to_string(begin) + " to " + std::to_string(end) +
                              " are no part of the take, which has " + std::to_string(first) +
                              " to " + std::to_string(last),
                      .remedy = "Frame numbers are those after the steps before"});
  }
  return {static_cast<std::size_t>(begin - first), static_cast<std::size_t>(end - first) + 1};
}

void declare_frames(ParameterSet& p, int64_t& from, int64_t& to) {
  p.number("from", from, {.min = 0, .max = 4e9, .help = "first frame; 0 for the take's first"});
  p.number("to", to, {.min = 0, .max = 4e9, .help = "last frame; 0 for the take's last"});
}

}  // namespace kinemesh
