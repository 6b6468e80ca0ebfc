// plan_points() and plan_numbers() of write_plan.h.
#include <algorithm>
#include <cmath>
#include <map>

#include "capture/c3d/number_format.h"
#include "capture/c3d/parameter_access.h"
#include "capture/c3d/point_table.h"
#include "capture/c3d/text_encoding.h"
#include "capture/c3d/write_plan.h"
#include "config/error.h"
#include "config/text.h"

namespace kinemesh {
namespace {

constexpr double max_step = 32'767.0;
constexpr std::size_t max_label = 255;

/// Columns that the points without identity need: the most in one frame.
std::size_t unlabelled_columns(const MarkerSequence& take) {
  const std::vector<uint64_t>& offsets = take.unlabelled.offsets;
  std::size_t most = 0;
  for (std::size_t f = 0; f + 1 < offsets.size(); ++f)
    most = std::max<std::size_t>(most, offsets[f + 1] - offsets[f]);
  return most;
}

/// Cut to 255 bytes without splitting a UTF-8 character.
std::string cut(const std::string& text, const std::string& what, std::vector<C3dLoss>& losses) {
  if (text.size() <= max_label) return text;
  std::size_t end = max_label;
  while (end > 0 && !is_utf8(text.substr(0, end))) --end;
  losses.push_back(
      {.message = what + " is cut to 255 bytes", .place = "marker " + text.substr(0, 40)});
  return text.substr(0, end);
}

struct KindGroup {
  MarkerKind kind;
  const char* list;
  const char* unit;
};
constexpr KindGroup kind_groups[] = {{MarkerKind::virtual_point, "MODELED_MARKERS", nullptr},
                                     {MarkerKind::angle, "ANGLES", "ANGLE_UNITS"},
                                     {MarkerKind::force, "FORCES", "FORCE_UNITS"},
                                     {MarkerKind::moment, "MOMENTS", "MOMENT_UNITS"},
                                     {MarkerKind::power, "POWERS", "POWER_UNITS"},
                                     {MarkerKind::scalar, "SCALARS", "SCALAR_UNITS"}};

void write_kinds(const std::vector<Marker>& markers, const std::vector<std::string>& labels,
                 C3dParameters& tree) {
  for (const KindGroup& group : kind_groups) {
    std::vector<std::string> members;
    std::string unit;
    for (std::size_t m = 0; m < markers.size(); ++m) {
      if (markers[m].kind != group.kind) continue;
      members.push_back(labels[m]);
      unit = markers[m].unit;
    }
    if (members.empty() && tree.find("POINT", group.list) == nullptr) continue;
    update_texts(tree, "POINT", group.list, members);
    if (group.unit != nullptr && !unit.empty())
      update(tree, "POINT", text_parameter(group.unit, unit));
  }
}

std::vector<std::string> kinds_and_units(const PointTable& table) {
  std::vector<std::string> all;
  for (const Marker& m : table.markers) all.push_back(std::string(name_of(m.kind)) + " " + m.unit);
  return all;
}

/// Labels, descriptions and kinds anew from the markers.
void write_labels(const std::vector<Marker>& markers, std::size_t unlabelled, C3dWritePlan& plan) {
  C3dParameters& tree = plan.parameters;
  std::vector<std::string> labels, descriptions;
  bool described = tree.find("POINT", "DESCRIPTIONS") != nullptr;
  for (const Marker& m : markers) {
    labels.push_back(cut(file_label(m, tree), "the label", plan.losses));
    descriptions.push_back(cut(m.description, "the description", plan.losses));
    described = described || !m.description.empty();
  }
  for (std::size_t u = 0; u < unlabelled; ++u)
    labels.push_back("*" + std::to_string(markers.size() + u + 1));
  descriptions.resize(labels.size());
  update_texts(tree, "POINT", "LABELS", labels);
  if (described) update_texts(tree, "POINT", "DESCRIPTIONS", descriptions);
  std::vector<C3dFinding> ignored;
  const PointTable now = decode_points_table(tree, markers.size(), LengthUnit::mm, ignored);
  const std::vector<std::string> wanted = kinds_and_units({.markers = markers});
  if (kinds_and_units(now) != wanted) write_kinds(markers, labels, tree);
}

float largest_coordinate(const MarkerSequence& take, const std::vector<float>& to_mm) {
  float largest = 0.0F;
  for (std::size_t i = 0; i < take.sample_count(); ++i) {
    if ((take.flags()[i] & SampleFlag::valid) == 0) continue;
    const float factor = to_mm[i % take.marker_count()];
    for (std::size_t k = 0; k < 3; ++k)
      largest = std::max(largest, std::abs(take.positions()[3 * i + k]) / factor);
  }
  for (const Eigen::Vector3f& p : take.unlabelled.positions)
    largest = std::max(largest, p.cwiseAbs().maxCoeff() / to_mm.back());
  return largest;
}

/// Steps of the residual that the take's residuals need: its own scale if they are multiples of it.
double residual_step(const MarkerSequence& take, double own, double unit_mm) {
  float largest = 0.0F;
  for (std::size_t i = 0; i < take.sample_count(); ++i) {
    if (take.flags()[i] == SampleFlag::valid) largest = std::max(largest, take.residuals()[i]);
  }
  for (const float r : take.unlabelled.residuals) largest = std::max(largest, r);
  const double needed = largest / unit_mm / 255.0;
  const bool known = !take.origin.path.empty() || !take.parameters.groups.empty();
  if (known && own > 0.0 && std::isfinite(own) && needed <= own * 1.0001) return own;
  const double fine = 0.01 / unit_mm;
  return std::max(fine, needed * 1.0001);
}

double integer_scale(const MarkerSequence& take, double own, double largest,
                     std::vector<C3dLoss>& losses, double wanted) {
  const double finest = largest > 0.0 ? largest / 32'000.0 : 0.01;
  if (wanted > 0.0) {
    if (largest > wanted * max_step) {
      losses.push_back({.message = "coordinates up to " + format_number(largest) +
                                   " do not fit a scale of " + format_number(wanted) +
                                   " and are clipped",
                        .place = "parameter POINT:SCALE"});
    }
    return wanted;
  }
  const bool fits = own > 0.0 && std::isfinite(own) && largest <= own * max_step;
  return fits && (take.origin.storage == Storage::integer || own <= 2.0 * finest) ? own : finest;
}

}  // namespace

void plan_points(const MarkerSequence& take, const C3dWriteOptions& options, C3dWritePlan& plan) {
  plan.unlabelled = unlabelled_columns(take);
  plan.points = take.marker_count() + plan.unlabelled;
  std::vector<C3dFinding> ignored;
  PointTable table =
      decode_points_table(plan.parameters, take.marker_count(),
                          length_unit_of(take.origin.unit).value_or(LengthUnit::mm), ignored);
  const bool labels_fit = plan.unlabelled == 0 && table.markers == take.markers() &&
                          all_strings(plan.parameters, "POINT", "LABELS").size() >= plan.points;
  if (!labels_fit) write_labels(take.markers(), plan.unlabelled, plan);
  const std::string unit = options.unit == "origin" ? take.origin.unit : options.unit;
  const double unit_mm = millimetres_in(unit).value_or(1.0);
  const std::string written = std::string(trim(first_string(plan.parameters, "POINT", "UNITS")));
  const bool units_stay = labels_fit && options.unit == "origin" && table.length_unit == unit &&
                          millimetres_in(written).has_value();
  if (units_stay) {
    plan.to_mm = table.to_mm;
    return;
  }
  const double origin_mm = millimetres_in(take.origin.unit).value_or(1.0);
  if (unit_mm != origin_mm) scale_force_plates(plan.parameters, origin_mm / unit_mm);
  if (plan.points > 0 || !written.empty())
    update(plan.parameters, "POINT", text_parameter("UNITS", unit));
  for (const Marker& m : take.markers())
    plan.to_mm.push_back(m.kind < MarkerKind::angle ? static_cast<float>(unit_mm) : 1.0F);
  plan.to_mm.resize(plan.points, static_cast<float>(unit_mm));
}

void plan_numbers(const MarkerSequence& take, const C3dWriteOptions& options, C3dWritePlan& plan) {
  plan.processor = take.origin.processor;
  for (const Processor p : {Processor::intel, Processor::dec, Processor::sgi}) {
    if (options.processor == name_of(p)) plan.processor = p;
  }
  plan.storage = take.origin.storage;
  if (options.storage == "int") plan.storage = Storage::integer;
  if (options.storage == "float") plan.storage = Storage::real;
  const double origin_mm = millimetres_in(take.origin.unit).value_or(1.0);
  const double unit_mm =
      options.unit == "origin" ? origin_mm : millimetres_in(options.unit).value_or(1.0);
  const double own = std::abs(take.origin.scale) * origin_mm / unit_mm;
  double step = own;
  if (plan.storage == Storage::real) {
    step = options.scale > 0.0 ? options.scale : residual_step(take, own, unit_mm);
  } else {
    const double largest = largest_coordinate(take, plan.to_mm);
    step = integer_scale(take, own, largest, plan.losses, options.scale);
    const bool same_as_stored = take.origin.storage == Storage::integer && step == own;
    if (!same_as_stored && largest > 0.0) {
      plan.losses.push_back(
          {.message = "positions are rounded to steps of " + format_number(step * unit_mm) +
                      " mm; angles, forces and the like to steps of " + format_number(step),
           .place = "parameter POINT:SCALE"});
    }
  }
  // Stored as a 32-bit float: what follows must use that value.
  const double stored = static_cast<double>(static_cast<float>(step));
  plan.scale = plan.storage == Storage::real ? -stored : stored;
}

}  // namespace kinemesh
