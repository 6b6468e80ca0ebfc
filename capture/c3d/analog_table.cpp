#include "capture/c3d/analog_table.h"

#include <algorithm>
#include <cmath>

#include "capture/c3d/parameter_access.h"
#include "capture/c3d/point_table.h"
#include "config/text.h"

namespace kinemesh {
namespace {

std::string analog_place(const char* name) { return std::string("parameter ANALOG:") + name; }

std::vector<double> all_numbers(const C3dParameters& tree, const std::string& name) {
  std::vector<double> all;
  for (int part = 1; part <= 257; ++part) {
    const C3dParameter* p = tree.find("ANALOG", part == 1 ? name : name + std::to_string(part));
    if (p == nullptr) break;
    all.insert(all.end(), p->numbers.begin(), p->numbers.end());
  }
  return all;
}

double general_scale(const C3dParameters& tree, std::vector<C3dFinding>& findings) {
  const auto value = first_number(tree, "ANALOG", "GEN_SCALE");
  if (!value || *value == 0.0) {
    findings.push_back(c3d_finding(
        "C3D507", value ? "ANALOG:GEN_SCALE is 0" : "there is no usable ANALOG:GEN_SCALE",
        analog_place("GEN_SCALE")));
    return 1.0;
  }
  if (*value < 0.0) {
    findings.push_back(c3d_finding("C3D506", "ANALOG:GEN_SCALE is " + format_number(*value),
                                   analog_place("GEN_SCALE")));
  }
  return *value;
}

/// True when the samples lie closer to the offsets taken as unsigned than as signed ones.
bool closer_as_unsigned(const std::vector<double>& offsets, std::span<const float> samples,
                        Storage storage) {
  const std::size_t channels = offsets.size();
  double with_sign = 0.0;
  double without_sign = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double offset = offsets[i % channels];
    const double sample = samples[i];
    if (offset >= 0.0 || !std::isfinite(sample)) continue;
    const double unsigned_sample = storage == Storage::integer ? as_unsigned(sample) : sample;
    with_sign += std::abs(sample - offset);
    without_sign += std::abs(unsigned_sample - as_unsigned(offset));
  }
  return without_sign < with_sign;
}

void decode_offsets(const C3dParameters& tree, const C3dLayout& layout,
                    std::span<const float> samples, AnalogTable& table,
                    std::vector<C3dFinding>& findings) {
  const C3dParameter* stored = tree.find("ANALOG", "OFFSET");
  const bool integers = stored != nullptr && stored->type == C3dType::integer;
  table.offsets = all_numbers(tree, "OFFSET");
  table.offsets.resize(layout.analog_channels, 0.0);
  for (double& offset : table.offsets) offset = std::isfinite(offset) ? offset : 0.0;
  const std::string format = lower(trim(first_string(tree, "ANALOG", "FORMAT")));
  const bool negative = std::ranges::any_of(table.offsets, [](double o) { return o < 0.0; });
  bool unsigned_offsets = format == "unsigned";
  table.unsigned_samples = unsigned_offsets;
  const bool undecided = format != "signed" || layout.storage == Storage::real;
  if (!unsigned_offsets && undecided && integers && negative && !samples.empty()) {
    unsigned_offsets = closer_as_unsigned(table.offsets, samples, layout.storage);
    table.unsigned_samples = unsigned_offsets && layout.storage == Storage::integer;
  }
  if (!unsigned_offsets || !integers || !negative) return;
  for (double& offset : table.offsets) offset = as_unsigned(offset);
  findings.push_back(
      c3d_finding("C3D503", "ANALOG:OFFSET holds values over 32767", analog_place("OFFSET")));
}

void decode_factors(const C3dParameters& tree, const C3dLayout& layout, AnalogTable& table,
                    std::vector<C3dFinding>& findings) {
  const double general = general_scale(tree, findings);
  const std::vector<double> scales = all_numbers(tree, "SCALE");
  for (std::size_t c = 0; c < layout.analog_channels; ++c) {
    const double scale = c < scales.size() && std::isfinite(scales[c]) ? scales[c] : 1.0;
    table.factors.push_back(scale * general);
  }
  const std::size_t offsets = all_numbers(tree, "OFFSET").size();
  if (scales.size() < layout.analog_channels || offsets < layout.analog_channels) {
    findings.push_back(
        c3d_finding("C3D505",
                    std::to_string(scales.size()) + " scales and " + std::to_string(offsets) +
                        " offsets for " + std::to_string(layout.analog_channels) + " channels",
                    analog_place(scales.size() < layout.analog_channels ? "SCALE" : "OFFSET")));
  }
}

}  // namespace

AnalogTable decode_analog_table(const C3dParameters& tree, const C3dLayout& layout,
                                std::span<const float> first_samples,
                                std::vector<C3dFinding>& findings) {
  AnalogTable table;
  if (layout.analog_channels == 0) return table;
  const std::vector<std::string> labels = all_strings(tree, "ANALOG", "LABELS");
  const std::vector<std::string> units = all_strings(tree, "ANALOG", "UNITS");
  const std::vector<std::string> descriptions = all_strings(tree, "ANALOG", "DESCRIPTIONS");
  bool converted = false;
  const auto text = [&converted](const std::vector<std::string>& all, std::size_t i) {
    return i < all.size() ? utf8_from(all[i], converted) : std::string();
  };
  for (std::size_t c = 0; c < layout.analog_channels; ++c) {
    table.channels.push_back(
        {.label = c < labels.size() ? text(labels, c) : "analog" + std::to_string(c + 1),
         .unit = std::string(trim(text(units, c))),
         .description = text(descriptions, c)});
  }
  if (labels.size() < layout.analog_channels) {
    findings.push_back(c3d_finding("C3D504",
                                   std::to_string(labels.size()) + " labels for " +
                                       std::to_string(layout.analog_channels) + " channels",
                                   analog_place("LABELS")));
  }
  if (converted) {
    findings.push_back(c3d_finding("C3D406", "analog labels, units or descriptions are not UTF-8",
                                   analog_place("LABELS")));
  }
  decode_factors(tree, layout, table, findings);
  decode_offsets(tree, layout, first_samples, table, findings);
  return table;
}

double analog_rate(const C3dParameters& tree, const C3dLayout& layout,
                   std::vector<C3dFinding>& findings) {
  if (layout.analog_channels == 0) return 0.0;
  const double rate = layout.rate_hz * static_cast<double>(layout.analog_samples);
  const auto named = first_number(tree, "ANALOG", "RATE");
  if (!named || *named <= 0.0) {
    findings.push_back(c3d_finding("C3D501",
                                   "there is no usable ANALOG:RATE; " + format_number(rate) +
                                       " Hz follows from the samples per frame",
                                   analog_place("RATE")));
  } else if (std::abs(*named - rate) > 1e-3 * rate) {
    findings.push_back(c3d_finding("C3D502",
                                   "ANALOG:RATE is " + format_number(*named) + " Hz, but " +
                                       std::to_string(layout.analog_samples) +
                                       " samples per frame make " + format_number(rate) + " Hz",
                                   analog_place("RATE")));
  }
  return rate;
}

}  // namespace kinemesh
