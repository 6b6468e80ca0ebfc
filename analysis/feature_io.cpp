#include "analysis/feature_io.h"

#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "config/error.h"
#include "config/input_file.h"
#include "config/json_text.h"
#include "config/output_file.h"
#include "config/text.h"

namespace kinemesh {
namespace {

using nlohmann::json;

constexpr const char* format_name = "kinemesh features";
constexpr std::size_t histogram_size = 8 * 4 * 8;
constexpr std::size_t most_elements = std::size_t{1} << 31U;

/// The shortest text that reads back as the same float.
void append_float(std::string& text, float value) {
  std::array<char, 32> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  text.append(buffer.data(), end);
}

void append_array(std::string& text, const char* name, const std::vector<float>& values,
                  bool& first) {
  if (values.empty()) return;
  text += std::string(first ? "" : ", ") + "\"" + name + "\": [";
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i > 0) text += ", ";
    append_float(text, values[i]);
  }
  text += "]";
  first = false;
}

void append_feature(std::string& text, const Feature& f) {
  text +=
      "    {\"vertex\": " + std::to_string(f.vertex) + ", \"frame\": " + std::to_string(f.frame) +
      ", \"time_s\": " + format_number(f.time_s) + ", \"sigma_mm\": " + format_number(f.sigma_mm) +
      ", \"tau_s\": " + format_number(f.tau_s) + ", \"response\": " + format_number(f.response) +
      ", \"kind\": \"" + name_of(f.kind) + "\", \"descriptors\": {";
  bool first = true;
  append_array(text, "displacement", f.descriptor.displacement, first);
  append_array(text, "deformation", f.descriptor.deformation, first);
  append_array(text, "anim_mesh_hog", f.descriptor.histogram, first);
  text += "}}";
}

[[noreturn]] void refuse(const std::string& file, const std::string& place,
                         const std::string& what) {
  throw InputError({.what = what,
                    .file = file,
                    .place = place,
                    .remedy = "Give a file that kinemesh features has written"});
}

/// Reads fields of one JSON object with messages that name file and place.
class Fields {
 public:
  Fields(const json& object, const std::string& file, std::string place)
      : object_(object), file_(file), place_(std::move(place)) {
    if (!object.is_object()) refuse(file_, place_, "an object was expected");
  }

  double number(const char* name, double low) const {
    const auto found = object_.find(name);
    if (found == object_.end() || !found->is_number()) {
      refuse(file_, place_, std::string("the number '") + name + "' is missing");
    }
    const double value = found->get<double>();
    if (!std::isfinite(value) || !(value >= low)) {
      refuse(file_, place_, std::string("'") + name + "' is out of range");
    }
    return value;
  }
  std::size_t index(const char* name, std::size_t count) const {
    const double value = number(name, 0.0);
    if (value != std::floor(value) || !(value < static_cast<double>(count))) {
      refuse(file_, place_,
             std::string("'") + name + "' must be a whole number below " + std::to_string(count));
    }
    return static_cast<std::size_t>(value);
  }
  std::string text(const char* name) const {
    const auto found = object_.find(name);
    if (found == object_.end() || !found->is_string()) {
      refuse(file_, place_, std::string("the text '") + name + "' is missing");
    }
    return found->get<std::string>();
  }
  /// Empty when there is none of that name.
  std::vector<float> array(const char* name, std::size_t size) const {
    const auto found = object_.find(name);
    if (found == object_.end()) return {};
    if (!found->is_array() || found->size() != size) {
      refuse(file_, place_,
             std::string("'") + name + "' must be a list of " + std::to_string(size) + " numbers");
    }
    std::vector<float> values;
    for (const json& entry : *found) {
      const double value = entry.is_number() ? entry.get<double>() : std::nan("");
      if (!(std::abs(value) <= 1e30)) {
        refuse(file_, place_, std::string("'") + name + "' holds something that is no number");
      }
      values.push_back(static_cast<float>(value));
    }
    return values;
  }
  const json& child(const char* name) const {
    const auto found = object_.find(name);
    if (found == object_.end()) refuse(file_, place_, std::string("'") + name + "' is missing");
    return *found;
  }

 private:
  const json& object_;
  const std::string& file_;
  std::string place_;
};

Feature feature_of(const json& object, const FeatureSet& set, const std::string& file,
                   std::size_t number) {
  const std::string place = "feature " + std::to_string(number);
  const Fields fields(object, file, place);
  Feature f;
  f.vertex = static_cast<VertexIndex>(fields.index("vertex", set.vertex_count));
  f.frame = static_cast<uint32_t>(fields.index("frame", set.frame_count));
  f.time_s = fields.number("time_s", 0.0);
  f.sigma_mm = fields.number("sigma_mm", 0.0);
  f.tau_s = fields.number("tau_s", 0.0);
  f.response = fields.number("response", -1e300);
  const std::string kind = fields.text("kind");
  if (kind == name_of(FeatureKind::displacement)) {
    f.kind = FeatureKind::displacement;
  } else if (kind != name_of(FeatureKind::deformation)) {
    refuse(file, place, "the kind '" + kind.substr(0, 40) + "' is unknown");
  }
  if (object.contains("descriptors")) {
    const Fields parts(object["descriptors"], file, place);
    f.descriptor.displacement = parts.array("displacement", set.frame_count - 1);
    f.descriptor.deformation = parts.array("deformation", set.frame_count);
    f.descriptor.histogram = parts.array("anim_mesh_hog", histogram_size);
  }
  return f;
}

}  // namespace

const char* name_of(FeatureKind kind) {
  return kind == FeatureKind::displacement ? "displacement" : "deformation";
}

std::string features_json(const FeatureSet& set) {
  const auto strict = json::error_handler_t::replace;  // a file name may be no UTF-8
  std::string text = std::string("{\n  \"format\": \"") + format_name +
                     "\",\n  \"version\": 1,\n  \"animation\": " +
                     json(set.animation).dump(-1, ' ', false, strict) +
                     ",\n  \"vertices\": " + std::to_string(set.vertex_count) +
                     ",\n  \"frames\": " + std::to_string(set.frame_count) +
                     ",\n  \"rate_hz\": " + format_number(set.rate_hz) +
                     ",\n  \"diagonal_mm\": " + format_number(set.diagonal_mm) +
                     ",\n  \"features\": [";
  for (std::size_t i = 0; i < set.features.size(); ++i) {
    text += i == 0 ? "\n" : ",\n";
    append_feature(text, set.features[i]);
  }
  return text + (set.features.empty() ? "]\n}\n" : "\n  ]\n}\n");
}

std::string features_csv(const FeatureSet& set) {
  std::string text = "vertex,frame,time_s,sigma_mm,tau_s,response,kind\n";
  for (const Feature& f : set.features) {
    text += std::to_string(f.vertex) + "," + std::to_string(f.frame) + "," +
            format_number(f.time_s) + "," + format_number(f.sigma_mm) + "," +
            format_number(f.tau_s) + "," + format_number(f.response) + "," + name_of(f.kind) + "\n";
  }
  return text;
}

void write_features(const std::filesystem::path& path, const FeatureSet& set) {
  const bool csv = lower(path.extension().string()) == ".csv";
  write_file(path, csv ? features_csv(set) : features_json(set));
}

FeatureSet read_features(const std::filesystem::path& path) {
  const std::string file = path.string();
  const std::string text = read_file(path, std::size_t{1} << 32U);
  refuse_deep_json(text, file);
  const json document = json::parse(text, nullptr, false);
  if (document.is_discarded()) refuse(file, "", "the file is not JSON");
  const Fields fields(document, file, "the top level");
  if (fields.text("format") != format_name) refuse(file, "format", "this is no file of features");
  FeatureSet set;
  set.animation = fields.text("animation");
  set.vertex_count = fields.index("vertices", most_elements);
  set.frame_count = fields.index("frames", most_elements);
  set.rate_hz = fields.number("rate_hz", 0.0);
  set.diagonal_mm = fields.number("diagonal_mm", 0.0);
  const json& list = fields.child("features");
  if (!list.is_array()) refuse(file, "features", "a list was expected");
  for (const json& entry : list) {
    set.features.push_back(feature_of(entry, set, file, set.features.size()));
  }
  return set;
}

}  // namespace kinemesh
