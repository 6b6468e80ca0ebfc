// repair, label, fill, filter, stabilise: the stages of cleaning as editing steps.
#include <algorithm>

#include "capture/edit/operation.h"
#include "capture/edit/timeline.h"
#include "capture/filter.h"
#include "capture/gap_fill.h"
#include "capture/gaps.h"
#include "capture/label.h"
#include "capture/repair.h"
#include "capture/session.h"
#include "capture/stabilise.h"
#include "config/text.h"

namespace kinemesh {
namespace {

/// Standard deviation in mm from which on an estimate is to be looked at.
constexpr double rough_mm = 1.0;

std::string gap_text(const GapFillResult& filled, const Fill& fill) {
  const int64_t first = filled.take.first_frame + static_cast<int64_t>(fill.frames.begin);
  std::string text = filled.take.markers()[fill.marker].label + ", frame";
  if (fill.frames.size() == 1) return text + " " + std::to_string(first);
  text += "s " + std::to_string(first) + " to ";
  return text + std::to_string(first + static_cast<int64_t>(fill.frames.size()) - 1);
}

/// ", uncertain by 0.12 mm on average, by 0.9 mm at most (LCHK04, frames 12 to 30)"
std::string uncertainty_text(const GapFillResult& filled, std::size_t samples) {
  double sum = 0.0;
  for (const Fill& fill : filled.fills) {
    sum += fill.mean_sd_mm * static_cast<double>(fill.frames.size());
  }
  const Fill& worst = *std::ranges::max_element(filled.fills, {}, &Fill::max_sd_mm);
  return ", uncertain by " + format_fixed(sum / static_cast<double>(samples), 2) +
         " mm on average, by " + format_fixed(worst.max_sd_mm, 2) + " mm at most (" +
         gap_text(filled, worst) + ")";
}

void warn_of_rough(const GapFillResult& filled, const RunContext& run) {
  std::vector<const Fill*> rough;
  for (const Fill& fill : filled.fills) {
    if (fill.mean_sd_mm > rough_mm) rough.push_back(&fill);
  }
  if (rough.empty()) return;
  const Fill& worst = **std::ranges::max_element(rough, {}, &Fill::mean_sd_mm);
  run.warn(count_of(rough.size(), "gap is", "gaps are") + " uncertain by more than " +
           format_number(rough_mm) + " mm, the worst by " + format_fixed(worst.mean_sd_mm, 1) +
           " mm on average over its frames, by " + format_fixed(worst.max_sd_mm, 1) +
           " mm at most (" + gap_text(filled, worst) +
           "): look at these frames in the picture that --picture draws before you use them");
}

/// Of markers that were measured at all.
std::size_t open_gaps(const GapFillResult& filled) {
  std::size_t open = 0;
  for (std::size_t m = 0; m < filled.take.marker_count(); ++m) {
    if (std::ranges::find(filled.never_valid, m) != filled.never_valid.end()) continue;
    open += find_gaps(filled.take, m, GapKind::unusable).gaps.size();
  }
  return open;
}

class FillGaps : public EditOperation {
 public:
  std::string_view name() const override { return "fill"; }
  void declare(ParameterSet& p) override { options_.declare(p); }
  /// Points of the body alone: an unlabelled trajectory is no marker that must be somewhere.
  std::string apply(MarkerSequence& take, const EditContext& context) const override {
    std::vector<std::size_t> body;
    for (std::size_t m = 0; m < take.marker_count(); ++m) {
      if (take.markers()[m].kind == MarkerKind::marker) body.push_back(m);
    }
    const GapFillResult filled = fill_gaps(take.select(body), options_, context.run);
    std::size_t samples = 0;
    for (const Fill& fill : filled.fills) {
      for (std::size_t f = fill.frames.begin; f < fill.frames.end; ++f, ++samples) {
        copy_sample(filled.take, filled.take.sample(f, fill.marker), take,
                    take.sample(f, body[fill.marker]));
      }
    }
    std::string text =
        "filled " + count_of(filled.fills.size(), "gap") + " (" + count_of(samples, "sample") + ")";
    if (!filled.fills.empty()) text += uncertainty_text(filled, samples);
    warn_of_rough(filled, context.run);
    if (const std::size_t open = open_gaps(filled); open > 0) {
      text += "; " + count_of(open, "gap") + " left open, which the method does not fill";
    }
    if (!filled.never_valid.empty()) {
      text +=
          "; " + count_of(filled.never_valid.size(), "marker") + " without any measurement left";
    }
    return text;
  }

 private:
  GapFillOptions options_;
};

class Repair : public EditOperation {
 public:
  std::string_view name() const override { return "repair"; }
  void declare(ParameterSet& p) override { options_.declare(p); }
  std::string apply(MarkerSequence& take, const EditContext& context) const override {
    RepairResult repaired = repair_take(take, options_, context.run);
    take = std::move(repaired.take);
    return repaired.done.empty() ? "found nothing to repair" : join(repaired.done, "; ");
  }

 private:
  RepairOptions options_;
};

class Label : public EditOperation {
 public:
  std::string_view name() const override { return "label"; }
  std::vector<std::string> files() const override { return {file_}; }
  void declare(ParameterSet& p) override {
    p.text("template", file_,
           {.metavar = "FILE",
            .help = "labelled take of the same subject; by default the take's own labels"});
  }
  std::string apply(MarkerSequence& take, const EditContext& context) const override {
    const MarkerSequence other =
        file_.empty() ? take : read_session(context.folder / file_, {}, context.run);
    LabelResult labelled = label_points(take, learn_template(other, context.run), context.run);
    take = std::move(labelled.take);
    return "labelled " + std::to_string(labelled.labelled) + " of " +
           count_of(labelled.points, "point") + " without identity, in " +
           count_of(labelled.trajectories, "trajectory", "trajectories");
  }

 private:
  std::string file_;
};

class Smooth : public EditOperation {
 public:
  std::string_view name() const override { return "filter"; }
  void declare(ParameterSet& p) override { options_.declare(p); }
  std::string apply(MarkerSequence& take, const EditContext& context) const override {
    FilterResult filtered = filter_take(take, options_, context.run);
    take = std::move(filtered.take);
    std::string text = "smoothed by " + std::string(name_of(options_.method));
    if (options_.method == FilterMethod::butterworth) {
      std::vector<double> cutoffs;
      std::ranges::copy_if(filtered.cutoffs_hz, std::back_inserter(cutoffs),
                           [](double c) { return c > 0.0; });
      std::ranges::sort(cutoffs);
      if (!cutoffs.empty()) {
        text += " at " + format_fixed(cutoffs.front(), 1);
        if (cutoffs.back() > cutoffs.front()) text += " to " + format_fixed(cutoffs.back(), 1);
        text += " Hz";
      }
    }
    return text + ", moving samples by " + format_fixed(filtered.rms_change_mm, 3) + " mm RMS";
  }

 private:
  FilterOptions options_;
};

class Stabilise : public EditOperation {
 public:
  std::string_view name() const override { return "stabilise"; }
  void declare(ParameterSet& p) override { options_.declare(p); }
  std::string apply(MarkerSequence& take, const EditContext& context) const override {
    StabiliseResult steady = stabilise_head(take, options_, context.run);
    take = std::move(steady.take);
    std::vector<std::string> labels;
    for (const std::size_t m : steady.shape.markers) labels.push_back(take.markers()[m].label);
    return "took out the head's motion by " + join(labels, ", ", " and ") + ", error " +
           format_fixed(steady.rms_error_mm, 2) + " mm RMS";
  }

 private:
  StabiliseOptions options_;
};

}  // namespace

std::shared_ptr<EditOperation> make_stage_operation(std::string_view name) {
  if (name == "repair") return std::make_shared<Repair>();
  if (name == "label") return std::make_shared<Label>();
  if (name == "fill") return std::make_shared<FillGaps>();
  if (name == "filter") return std::make_shared<Smooth>();
  if (name == "stabilise") return std::make_shared<Stabilise>();
  return nullptr;
}

}  // namespace kinemesh
