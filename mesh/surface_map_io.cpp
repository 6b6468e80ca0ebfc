#include "mesh/surface_map_io.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "config/error.h"
#include "config/input_file.h"
#include "config/json_text.h"
#include "config/output_file.h"
#include "config/text.h"
#include "mesh/formats/npz.h"

namespace kinemesh {
namespace {

constexpr const char* format_name = "kinemesh surface map";
constexpr const char* csv_columns = "vertex,face,b0,b1,b2,confidence";

[[noreturn]] void refuse(const std::string& file, const std::string& place,
                         const std::string& what) {
  throw InputError({.what = what, .file = file, .place = place});
}

/// Appends one entry after checking it.
void append(SurfaceMap& map, double face, const std::array<double, 3>& weights,
            std::optional<double> confidence, const std::string& file, const std::string& place) {
  SurfacePoint point;
  if (face != -1.0) {
    if (!(face >= 0.0) || face >= invalid_index || face != std::floor(face)) {
      refuse(file, place, "the face must be −1 or a whole number of at least 0");
    }
    double sum = 0.0;
    for (const double w : weights) {
      if (!(w >= -1e-9) || !(w <= 1.0 + 1e-6)) refuse(file, place, "a weight lies outside 0 to 1");
      sum += w;
    }
    if (!(std::abs(sum - 1.0) <= 1e-6)) refuse(file, place, "the weights do not sum to 1");
    point = {static_cast<FaceIndex>(face), weights};
  }
  if (confidence && !(*confidence >= 0.0 && *confidence <= 1.0)) {
    refuse(file, place, "the confidence lies outside 0 to 1");
  }
  const auto mapped = [](const SurfacePoint& p) { return p.valid(); };
  const bool first_confidence = confidence && map.confidence.empty();  // of all points so far
  const bool others_differ = first_confidence ? std::ranges::any_of(map.points, mapped)
                                              : !confidence && !map.confidence.empty();
  if (others_differ && (first_confidence || point.valid())) {
    refuse(file, place, "some points have a confidence and others have none");
  }
  // Points that are mapped nowhere need none: theirs is 0.
  if (first_confidence) map.confidence.assign(map.points.size(), 0.0);
  if (confidence || others_differ) map.confidence.push_back(confidence.value_or(0.0));
  map.points.push_back(point);
}

/// NaN stands for none.
std::optional<double> known(double confidence) {
  return std::isnan(confidence) ? std::nullopt : std::optional(confidence);
}

/// A name on one line.
std::string one_line(const std::string& name) {
  std::string text = name;
  for (char& c : text) c = static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  return text;
}

std::string to_csv(const SurfaceMap& map) {
  std::string text = std::string("# ") + format_name +
                     ", source -> target\n# source: " + one_line(map.source_name) +
                     "\n# target: " + one_line(map.target_name) + "\n" + csv_columns + "\n";
  for (std::size_t v = 0; v < map.points.size(); ++v) {
    const SurfacePoint& p = map.points[v];
    text += std::to_string(v) + "," + (p.valid() ? std::to_string(p.face) : "-1");
    for (const double w : p.weights) text += "," + format_number(p.valid() ? w : 0.0);
    text += map.confidence.empty() ? ",\n" : "," + format_number(map.confidence[v]) + "\n";
  }
  return text;
}

/// The comma-separated fields of one line as numbers; empty ones are NaN.
std::vector<double> fields_of(std::string_view line, const std::string& file,
                              const std::string& place) {
  std::vector<double> fields;
  while (true) {
    const std::size_t comma = line.find(',');
    const std::string_view word = trim(line.substr(0, comma));
    double value = std::nan("");
    if (!word.empty()) {
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
      if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) {
        refuse(file, place, "'" + std::string(word.substr(0, 40)) + "' is no number");
      }
    }
    fields.push_back(value);
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

void read_csv_line(SurfaceMap& map, std::string_view line, const std::string& file,
                   const std::string& place) {
  const std::vector<double> fields = fields_of(line, file, place);
  if (fields.size() != 5 && fields.size() != 6) {
    refuse(file, place, std::string("a line must have the columns ") + csv_columns);
  }
  if (fields[0] != static_cast<double>(map.points.size())) {
    refuse(file, place, "vertex " + std::to_string(map.points.size()) + " should come here");
  }
  const std::optional<double> confidence =
      fields.size() == 6 ? known(fields[5]) : std::optional<double>();
  append(map, fields[1], {fields[2], fields[3], fields[4]}, confidence, file, place);
}

SurfaceMap from_csv(std::string_view text, const std::string& file) {
  SurfaceMap map;
  bool header = false;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = text.find('\n');
    const std::string_view line = trim(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    const std::string place = "line " + std::to_string(number);
    if (line.starts_with("# source:")) {
      map.source_name = trim(line.substr(9));
    } else if (line.starts_with("# target:")) {
      map.target_name = trim(line.substr(9));
    } else if (line.empty() || line.starts_with('#')) {
      continue;
    } else if (!header) {
      if (!line.starts_with("vertex,face,b0,b1,b2")) {
        refuse(file, place, std::string("the columns must be ") + csv_columns);
      }
      header = true;
    } else {
      read_csv_line(map, line, file, place);
    }
  }
  if (!header)
    refuse(file, "", std::string("the line with the columns ") + csv_columns + " is missing");
  return map;
}

std::string to_json(const SurfaceMap& map) {
  nlohmann::ordered_json json{
      {"format", format_name}, {"source", map.source_name}, {"target", map.target_name}};
  nlohmann::ordered_json points = nlohmann::ordered_json::array();
  for (const SurfacePoint& p : map.points) {
    points.push_back(
        {p.valid() ? static_cast<int64_t>(p.face) : -1, p.weights[0], p.weights[1], p.weights[2]});
  }
  json["points"] = std::move(points);
  if (!map.confidence.empty()) json["confidence"] = map.confidence;
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

SurfaceMap from_json(const std::string& text, const std::string& file) try {
  refuse_deep_json(text, file);
  const nlohmann::json json = nlohmann::json::parse(text);
  if (json.at("format") != format_name) refuse(file, "format", "this is no surface map");
  SurfaceMap map{json.value("source", ""), json.value("target", ""), {}, {}};
  const nlohmann::json& points = json.at("points");
  const nlohmann::json confidence = json.value("confidence", nlohmann::json());
  if (!confidence.is_null() && confidence.size() != points.size()) {
    refuse(file, "confidence", "there must be as many as points");
  }
  for (std::size_t v = 0; v < points.size(); ++v) {
    const auto p = points[v].get<std::array<double, 4>>();
    std::optional<double> sure;
    if (!confidence.is_null() && !confidence[v].is_null()) sure = confidence[v].get<double>();
    append(map, p[0], {p[1], p[2], p[3]}, sure, file, "point " + std::to_string(v));
  }
  return map;
} catch (const nlohmann::json::exception& e) {
  throw InputError(
      {.what = std::string("this is no valid surface map in JSON: ") + e.what(), .file = file});
}

void write_npz(const std::filesystem::path& path, const SurfaceMap& map) {
  std::vector<int64_t> faces;
  std::vector<double> weights;
  for (const SurfacePoint& p : map.points) {
    faces.push_back(p.valid() ? static_cast<int64_t>(p.face) : -1);
    weights.insert(weights.end(), p.weights.begin(), p.weights.end());
  }
  NpzWriter writer;
  writer.add("face", {faces.size()}, faces);
  writer.add("weights", {faces.size(), 3}, weights);
  if (!map.confidence.empty()) writer.add("confidence", {faces.size()}, map.confidence);
  writer.add("source", map.source_name);
  writer.add("target", map.target_name);
  writer.write(path);
}

SurfaceMap from_npz(const std::filesystem::path& path) {
  const NpzFile file = read_npz(path);
  const std::string name = path.string();
  const std::vector<double> faces = npz_array(file, "face").numbers();
  const std::vector<double> weights = npz_array(file, "weights").numbers();
  std::vector<double> confidence;
  if (file.contains("confidence")) confidence = npz_array(file, "confidence").numbers();
  if (weights.size() != 3 * faces.size() ||
      (!confidence.empty() && confidence.size() != faces.size())) {
    refuse(name, "", "the arrays face, weights and confidence differ in length");
  }
  SurfaceMap map;
  const auto text_of = [&](const char* key) {
    const auto found = file.find(key);
    return found != file.end() && !found->second.texts.empty() ? found->second.texts[0]
                                                               : std::string();
  };
  map.source_name = text_of("source");
  map.target_name = text_of("target");
  for (std::size_t v = 0; v < faces.size(); ++v) {
    std::optional<double> sure;
    if (!confidence.empty()) sure = known(confidence[v]);
    append(map, faces[v], {weights[3 * v], weights[3 * v + 1], weights[3 * v + 2]}, sure, name,
           "point " + std::to_string(v));
  }
  return map;
}

[[noreturn]] void refuse_extension(const std::filesystem::path& path) {
  throw UsageError({.what = "surface maps are .csv, .json or .npz files", .file = path.string()});
}

}  // namespace

void write_surface_map(const std::filesystem::path& path, const SurfaceMap& map) {
  if (!map.confidence.empty() && map.confidence.size() != map.points.size()) {
    throw InternalError("write_surface_map: as many confidences as points are needed");
  }
  const std::string extension = lower(path.extension().string());
  if (extension == ".csv") {
    write_file(path, to_csv(map));
  } else if (extension == ".json") {
    write_file(path, to_json(map));
  } else if (extension == ".npz") {
    write_npz(path, map);
  } else {
    refuse_extension(path);
  }
}

SurfaceMap read_surface_map(const std::filesystem::path& path) {
  const std::string extension = lower(path.extension().string());
  if (extension == ".csv") return from_csv(read_file(path), path.string());
  if (extension == ".json") return from_json(read_file(path), path.string());
  if (extension == ".npz") return from_npz(path);
  refuse_extension(path);
}

void check_surface_map(const SurfaceMap& map, const Topology& source, const Topology& target) {
  if (map.points.size() != source.vertex_count()) {
    throw InputError(
        {.what = "the map has " + std::to_string(map.points.size()) +
                 " points, but the source mesh has " + std::to_string(source.vertex_count()) +
                 " vertices",
         .remedy = "Check the direction of the map: " + map.source_name + " → " + map.target_name});
  }
  for (std::size_t v = 0; v < map.points.size(); ++v) {
    if (!map.points[v].valid() || map.points[v].face < target.face_count()) continue;
    throw InputError({.what = "vertex " + std::to_string(v) + " maps to face " +
                              std::to_string(map.points[v].face) + ", but the target mesh has " +
                              std::to_string(target.face_count()) + " faces"});
  }
}

}  // namespace kinemesh
