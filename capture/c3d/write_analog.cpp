// plan_analog() of write_plan.h.
#include <algorithm>
#include <cmath>

#include "capture/c3d/parameter_access.h"
#include "capture/c3d/write_plan.h"
#include "config/text.h"

namespace kinemesh {
namespace {

/// What the samples of one channel would be as stored numbers.
struct StoredRange {
  double low = 0.0;
  double high = 0.0;
  bool whole = true;  ///< all are integers, but for rounding
  bool usable = true;
};

StoredRange stored_range(const AnalogData& analog, std::size_t channel, double offset,
                         double factor) {
  StoredRange range;
  bool first = true;
  for (std::size_t i = channel; i < analog.values.size(); i += analog.channels.size()) {
    const double value = analog.values[i];
    if (!std::isfinite(value)) continue;
    if (factor == 0.0) {
      range.usable = range.usable && value == 0.0;
      continue;
    }
    const double raw = value / factor + offset;
    range.low = first ? raw : std::min(range.low, raw);
    range.high = first ? raw : std::max(range.high, raw);
    first = false;
    // Values are floats: their last bit may be half a unit of the raw number away.
    range.whole =
        range.whole && std::abs(raw - std::round(raw)) < 1e-3 + 1e-6 * std::abs(raw - offset);
  }
  return range;
}

bool fits(const StoredRange& r, bool as_unsigned) {
  const double low = as_unsigned ? -0.4 : -32768.4;
  const double high = as_unsigned ? 65535.4 : 32767.4;
  return r.usable && r.low >= low && r.high <= high;
}

void write_texts(const AnalogData& analog, C3dParameters& tree) {
  std::vector<std::string> labels, units, descriptions;
  bool described = tree.find("ANALOG", "DESCRIPTIONS") != nullptr;
  for (const AnalogData::Channel& c : analog.channels) {
    labels.push_back(c.label);
    units.push_back(c.unit);
    descriptions.push_back(c.description);
    described = described || !c.description.empty();
  }
  update_texts(tree, "ANALOG", "LABELS", labels);
  update_texts(tree, "ANALOG", "UNITS", units);
  if (described) update_texts(tree, "ANALOG", "DESCRIPTIONS", descriptions);
}

void write_scaling(const std::vector<double>& offsets, const std::vector<double>& scales,
                   C3dParameters& tree) {
  update_numbers(tree, "ANALOG", "SCALE", C3dType::real, scales);
  const bool integers = std::ranges::all_of(
      offsets, [](double o) { return o == std::round(o) && std::abs(o) <= 65'535.0; });
  update_numbers(tree, "ANALOG", "OFFSET", integers ? C3dType::integer : C3dType::real, offsets);
}

/// Integer storage: channels whose values are no multiples of their scale get a scale of their own.
void fit_integers(const AnalogData& analog, AnalogTable& table, double general,
                  C3dWritePlan& plan) {
  C3dParameters& tree = plan.parameters;
  const bool format_given = !trim(first_string(tree, "ANALOG", "FORMAT")).empty();
  const auto all_fit = [&](bool as_unsigned_samples) {
    for (std::size_t c = 0; c < table.channels.size(); ++c) {
      const double offset = as_unsigned_samples ? as_unsigned(table.offsets[c]) : table.offsets[c];
      if (!fits(stored_range(analog, c, offset, table.factors[c]), as_unsigned_samples))
        return false;
    }
    return true;
  };
  if (!table.unsigned_samples && !all_fit(false) && all_fit(true)) {
    table.unsigned_samples = true;
    for (double& offset : table.offsets) offset = as_unsigned(offset);
    update(tree, "ANALOG", text_parameter("FORMAT", "UNSIGNED"));
  }
  bool changed = false;
  for (std::size_t c = 0; c < table.channels.size(); ++c) {
    const StoredRange range = stored_range(analog, c, table.offsets[c], table.factors[c]);
    if (fits(range, table.unsigned_samples) && range.whole) continue;
    double largest = 0.0;
    for (std::size_t i = c; i < analog.values.size(); i += analog.channels.size()) {
      if (std::isfinite(analog.values[i]))
        largest = std::max(largest, std::abs(static_cast<double>(analog.values[i])));
    }
    table.offsets[c] = table.unsigned_samples ? 32'768.0 : 0.0;
    const double factor = largest > 0.0 ? largest / 32'000.0 : 1.0;
    table.factors[c] = static_cast<double>(static_cast<float>(factor / general)) * general;
    changed = true;
    plan.losses.push_back(
        {.message = "values are rounded to steps of " +
                    format_number(static_cast<double>(static_cast<float>(factor))) + " " +
                    table.channels[c].unit,
         .place = "analog channel " + table.channels[c].label});
  }
  if (!changed) return;
  if (format_given && !table.unsigned_samples)
    update(tree, "ANALOG", text_parameter("FORMAT", "SIGNED"));
  std::vector<double> scales;
  for (const double factor : table.factors)
    scales.push_back(static_cast<double>(static_cast<float>(factor / general)));
  write_scaling(table.offsets, scales, tree);
}

}  // namespace

void plan_analog(const MarkerSequence& take, C3dWritePlan& plan) {
  C3dParameters& tree = plan.parameters;
  const AnalogData& analog = take.analog;
  const std::size_t channels = analog.samples_per_frame == 0 ? 0 : analog.channels.size();
  if (channels == 0) {
    if (tree.group("ANALOG") != nullptr) update(tree, "ANALOG", integer_parameter("USED", {0.0}));
    return;
  }
  C3dLayout layout;
  layout.storage = plan.storage;
  layout.analog_channels = channels;
  layout.analog_samples = analog.samples_per_frame;
  std::vector<C3dFinding> ignored;
  AnalogTable table = decode_analog_table(tree, layout, {}, ignored);
  const bool same =
      table.channels == analog.channels && all_strings(tree, "ANALOG", "LABELS").size() >= channels;
  if (!same) {
    write_texts(analog, tree);
    table.channels = analog.channels;
  }
  double general = first_number(tree, "ANALOG", "GEN_SCALE").value_or(1.0);
  if (general == 0.0 || !first_number(tree, "ANALOG", "GEN_SCALE")) {
    general = 1.0;
    update(tree, "ANALOG", real_parameter("GEN_SCALE", {1.0}));
  }
  const C3dParameter* scale = tree.find("ANALOG", "SCALE");
  const C3dParameter* offset = tree.find("ANALOG", "OFFSET");
  const bool complete =
      scale != nullptr && offset != nullptr &&
      (channels > 255 || (scale->numbers.size() >= channels && offset->numbers.size() >= channels));
  bool usable = true;
  for (std::size_t c = 0; c < channels; ++c)
    usable = usable && stored_range(analog, c, table.offsets[c], table.factors[c]).usable;
  if (!complete || !same || !usable) {
    std::vector<double> scales;
    for (std::size_t c = 0; c < channels; ++c) {
      if (!same || table.factors[c] == 0.0) table.factors[c] = general;
      if (!same) table.offsets[c] = 0.0;
      scales.push_back(static_cast<double>(static_cast<float>(table.factors[c] / general)));
    }
    write_scaling(table.offsets, scales, tree);
  }
  update(tree, "ANALOG", integer_parameter("USED", {static_cast<double>(channels)}));
  update(
      tree, "ANALOG",
      real_parameter("RATE", {static_cast<double>(static_cast<float>(
                                 take.rate_hz * static_cast<double>(analog.samples_per_frame)))}));
  if (plan.storage == Storage::integer) fit_integers(analog, table, general, plan);
  // As a reader will find it.
  plan.analog = decode_analog_table(tree, layout, {}, ignored);
}

}  // namespace kinemesh
