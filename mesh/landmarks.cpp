#include "mesh/landmarks.h"

#include <charconv>
#include <cmath>

#include "config/error.h"
#include "config/input_file.h"
#include "config/text.h"

namespace kinemesh {
namespace {

struct Line {
  std::vector<std::string_view> words;
  std::string place;
};

bool blank(char c) { return c == ',' || c == ';' || c == ' ' || c == '\t'; }

/// The first `most` words of a line; what follows is one more word.
std::vector<std::string_view> words_of(std::string_view line, std::size_t most) {
  std::vector<std::string_view> words;
  while (true) {
    while (!line.empty() && blank(line.front())) line.remove_prefix(1);
    if (line.empty()) return words;
    if (words.size() == most) {
      words.push_back(trim(line));
      return words;
    }
    std::size_t end = 0;
    while (end < line.size() && !blank(line[end])) ++end;
    words.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
}

/// Lines with words, without comments and the names of columns.
std::vector<Line> lines_of(std::string_view text, std::size_t most) {
  std::vector<Line> lines;
  bool first = true;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = text.find('\n');
    const std::string_view line = trim(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (line.empty() || line.starts_with('#')) continue;
    const char c = line.front();
    const bool heading = first && ((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'));
    first = false;
    if (!heading) lines.push_back({words_of(line, most), "line " + std::to_string(number)});
  }
  return lines;
}

std::optional<double> number_of(std::string_view word) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) return {};
  return value;
}

std::optional<uint32_t> index_of(std::string_view word, double base, std::size_t count) {
  const std::optional<double> value = number_of(word);
  if (!value || *value != std::floor(*value) || *value < base ||
      *value - base >= static_cast<double>(count)) {
    return {};
  }
  return static_cast<uint32_t>(*value - base);
}

[[noreturn]] void refuse(const std::filesystem::path& path, const std::string& place,
                         const std::string& what, const std::string& remedy = {}) {
  throw InputError({.what = what, .file = path.string(), .place = place, .remedy = remedy});
}

SurfacePoint place_of(const std::filesystem::path& path, const Line& line, std::size_t word,
                      const Topology& topology, const char* which) {
  const std::optional<SurfacePoint> place = parse_place(line.words[word], topology);
  if (place) return *place;
  refuse(path, line.place,
         "'" + std::string(line.words[word].substr(0, 40)) + "' names no point of the " + which +
             ", which has " + count_of(topology.vertex_count(), "vertex", "vertices"),
         "Give a vertex by its number from 0, or a point as FACE:B0:B1:B2");
}

}  // namespace

std::optional<SurfacePoint> parse_place(std::string_view text, const Topology& topology) {
  if (text.find(':') == std::string_view::npos) {
    const std::optional<uint32_t> v = index_of(text, 0.0, topology.vertex_count());
    if (!v || topology.faces_of(*v).empty()) return {};
    const FaceIndex face = topology.faces_of(*v).front();
    SurfacePoint point{face, {0.0, 0.0, 0.0}};
    for (std::size_t c = 0; c < 3; ++c) point.weights[c] = topology.faces()[face][c] == *v ? 1 : 0;
    return point;
  }
  SurfacePoint point;
  double sum = 0.0;
  for (std::size_t k = 0; k < 4; ++k) {
    const std::size_t end = text.find(':');
    if ((end == std::string_view::npos) != (k == 3)) return {};
    const std::string_view word = text.substr(0, end);
    text.remove_prefix(k == 3 ? text.size() : end + 1);
    if (k == 0) {
      const std::optional<uint32_t> face = index_of(word, 0.0, topology.face_count());
      if (!face) return {};
      point.face = *face;
      continue;
    }
    const std::optional<double> weight = number_of(word);
    if (!weight || *weight < 0.0) return {};
    point.weights[k - 1] = *weight;
    sum += *weight;
  }
  if (!(std::abs(sum - 1.0) <= 1e-3)) return {};
  for (double& w : point.weights) w /= sum;
  return point;
}

std::vector<VertexIndex> read_vertex_list(const std::filesystem::path& path,
                                          std::size_t vertex_count) {
  const double base = lower(path.extension().string()) == ".vts" ? 1.0 : 0.0;
  const std::string text = read_file(path);
  std::vector<VertexIndex> list;
  for (const Line& line : lines_of(text, 1)) {
    const std::optional<uint32_t> v =
        line.words.size() == 1 ? index_of(line.words[0], base, vertex_count) : std::nullopt;
    if (!v) {
      refuse(path, line.place,
             "a vertex from " + format_fixed(base, 0) + " to " +
                 format_fixed(base + static_cast<double>(vertex_count) - 1.0, 0) +
                 " should stand here",
             "Check that the list belongs to this mesh");
    }
    list.push_back(*v);
  }
  if (list.empty()) refuse(path, "", "the list of vertices is empty");
  return list;
}

std::vector<LandmarkPair> read_landmark_pairs(const std::filesystem::path& path,
                                              const Topology& source, const Topology& target) {
  const std::string text = read_file(path);
  std::vector<LandmarkPair> pairs;
  for (const Line& line : lines_of(text, 2)) {
    if (line.words.size() < 2) {
      refuse(path, line.place, "a line must name a place on the source and one on the target");
    }
    pairs.push_back({place_of(path, line, 0, source, "source"),
                     place_of(path, line, 1, target, "target"),
                     line.words.size() > 2 ? std::string(line.words[2]) : std::string()});
  }
  if (pairs.empty()) refuse(path, "", "the file holds no pairs of landmarks");
  return pairs;
}

}  // namespace kinemesh
