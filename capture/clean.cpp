#include "capture/clean.h"

#include <algorithm>
#include <chrono>

#include "capture/edit/operation.h"
#include "capture/idle_options.h"
#include "config/error.h"
#include "config/text.h"

namespace kinemesh {
namespace {

bool has_loose_points(const MarkerSequence& take) {
  if (!take.unlabelled.positions.empty()) return true;
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    if (take.markers()[m].kind != MarkerKind::unlabelled) continue;
    for (std::size_t f = 0; f < take.frame_count(); ++f) {
      if (take.valid(f, m)) return true;
    }
  }
  return false;
}

std::size_t labelled_markers(const MarkerSequence& take) {
  std::size_t count = 0;
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    if (take.markers()[m].kind != MarkerKind::marker) continue;
    for (std::size_t f = 0; f < take.frame_count(); ++f) {
      if (!take.valid(f, m)) continue;
      ++count;
      break;
    }
  }
  return count;
}

using Values = std::vector<std::pair<std::string, std::vector<std::string>>>;

/// The values of a stage's options that differ from their default, for the edit list.
template <class Options>
Values values_of(const Options& options) {
  Options copy = options;
  Options plain;
  ParameterSet given, defaults;
  copy.declare(given);
  plain.declare(defaults);
  Values values;
  for (const Parameter& p : given.parameters()) {
    if (p.get() != defaults.find(p.name())->get()) values.emplace_back(p.name(), p.get());
  }
  return values;
}

class Cleaner {
 public:
  Cleaner(const MarkerSequence& take, const CleanOptions& options, const RunContext& ctx)
      : options_(options), ctx_(ctx) {
    result_.take = take;
  }

  CleanResult run() {
    MarkerSequence& take = result_.take;
    if (has_twins(take)) step(0.0, 0.01, "unite-twins");
    if (options_.label && has_loose_points(take)) label();
    warn_of_idle_template();
    if (labelled_markers(take) == 0) refuse_without_labels();
    if (take.frame_count() == 1) {
      ctx_.warn(
          "The take has one frame only: without motion nothing is repaired, filled or smoothed. "
          "Record it again, or take a longer one.");
    }
    if (options_.repair) repair();
    if (options_.fill) step(0.4, 0.85, "fill", values_of(options_.gaps));
    if (options_.filter.method != FilterMethod::none) {
      step(0.85, 0.95, "filter", values_of(options_.filter));
    }
    if (options_.stabilise) step(0.95, 1.0, "stabilise", values_of(options_.head));
    ctx_.progress(1.0);
    return std::move(result_);
  }

 private:
  using Clock = std::chrono::steady_clock;

  void took(const std::string& stage, Clock::time_point since) {
    result_.times.push_back({stage, std::chrono::duration<double>(Clock::now() - since).count()});
  }

  /// One step of the list, done and noted.
  void step(double begin, double end, const std::string& name, const Values& values = {}) {
    ctx_.check_cancelled();
    const auto start = Clock::now();
    const auto edit = make_edit(name, values);
    const EditContext context{"", ctx_.part(begin, end, name)};
    result_.done.push_back(edit->apply(result_.take, context));
    result_.edits.steps.push_back(edit);
    took(name, start);
  }

  void warn_of_idle_template() const {
    const auto labels = [](const auto& step) { return step->name() == "label"; };
    if (options_.template_file.empty() || std::ranges::any_of(result_.edits.steps, labels)) return;
    ctx_.warn("--template was not needed: every point of the take has a label.");
  }

  void label() {
    if (!options_.template_file.empty()) {
      step(0.01, 0.3, "label", {{"template", {options_.template_file}}});
      return;
    }
    constexpr std::size_t least = 4;  // labels that make a template
    if (labelled_markers(result_.take) < least) return;
    try {
      step(0.01, 0.3, "label");
    } catch (const NoResultError& e) {  // a few stray points need no label
      ctx_.warn(std::string("Points without identity keep none: ") + e.what());
    }
  }

  void repair() {
    const auto start = Clock::now();
    RepairResult repaired =
        repair_take(result_.take, options_.repairs, ctx_.part(0.3, 0.4, "repair"));
    for (const Jump& jump : repaired.jumps) warn_of(jump);
    result_.take = std::move(repaired.take);
    std::ranges::move(repaired.done, std::back_inserter(result_.done));
    std::ranges::move(repaired.edits.steps, std::back_inserter(result_.edits.steps));
    took("repair", start);
  }

  void warn_of(const Jump& jump) const {
    const MarkerSequence& take = result_.take;
    ctx_.warn(take.markers()[jump.marker].label + " jumps by " + format_fixed(jump.size_mm, 1) +
              " mm in frame " +
              std::to_string(take.first_frame + static_cast<int64_t>(jump.frame)) +
              " and stays there: its label is wrong before or after. Mend it with a swap, move or "
              "delete step in the list of edits.");
  }

  [[noreturn]] void refuse_without_labels() const {
    const std::string& file = result_.take.origin.path;
    if (has_loose_points(result_.take)) {
      throw NoResultError({.what = "all points of the take are unlabelled",
                           .file = file,
                           .remedy = "Give a labelled take of the same subject with --template"});
    }
    if (result_.take.marker_count() == 0) {
      throw NoResultError({.what = "the take has no markers to be cleaned",
                           .file = file,
                           .remedy = "Apply editing steps alone with --edits"});
    }
    throw NoResultError(
        {.what = "the take has no valid marker", .file = file, .remedy = "Record it again"});
  }

  const CleanOptions& options_;
  const RunContext& ctx_;
  CleanResult result_;
};

}  // namespace

void CleanOptions::declare(ParameterSet& p) {
  p.group("labelling", "Labelling");
  p.flag("label", label, "give labels to points that have none");
  p.text("template", template_file,
         {.metavar = "FILE",
          .help = "labelled take of the same subject; by default the take's own labels are used"});
  p.group("repair", "Repair");
  p.flag("repair", repair, "take out spikes and put exchanged labels right");
  repairs.declare(p);
  p.group("gaps", "Gap filling");
  p.flag("fill-gaps", fill, "fill gaps");
  gaps.declare(p);
  filter.declare(p);
  p.group("head", "Head motion");
  p.flag("stabilise", stabilise, "remove the head's motion, so that only the face's own is left");
  head.declare(p);
}

void CleanOptions::validate() const {
  validate_options(*this);
  filter.validate();
  gaps.validate();
  const std::string leave = ", or leave it out";
  if (!stabilise) {
    refuse_idle(changed_parameters(head), {"rigid", "reference-frame"},
                "the head's motion is not removed", "Add --stabilise" + leave);
  }
  if (!fill) {
    refuse_idle(changed_parameters(gaps),
                {"fill", "effort", "max-gap", "donor", "companion", "fill-rest"},
                "gaps are left open (--no-fill-gaps)", "Leave out one of the two");
  }
  if (!label && !template_file.empty()) {
    throw UsageError({.what = "--template does nothing here: no labels are given (--no-label)",
                      .remedy = "Leave out one of the two"});
  }
}

bool has_twins(const MarkerSequence& take) {
  std::vector<std::string> names;
  for (const Marker& m : take.markers()) {
    if (m.kind == MarkerKind::marker) names.push_back(m.subject + ":" + m.label);
  }
  std::ranges::sort(names);
  return std::ranges::adjacent_find(names) != names.end();
}

CleanResult clean_take(const MarkerSequence& take, const CleanOptions& options,
                       const RunContext& ctx) {
  options.validate();
  return Cleaner(take, options, ctx).run();
}

}  // namespace kinemesh
