#include "reconstruct/marker_places.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>

#include "config/error.h"
#include "config/input_file.h"
#include "config/text.h"
#include "mesh/closest_point.h"

namespace kinemesh {
namespace {

std::vector<std::string> split(std::string_view line) {
  std::vector<std::string> cells;
  while (true) {
    const std::size_t comma = line.find(',');
    cells.emplace_back(trim(line.substr(0, comma)));
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

class PlacesReader {
 public:
  PlacesReader(const std::filesystem::path& path, const Mesh& scan, double scale)
      : path_(path), scan_(scan), scale_(scale) {}

  std::vector<AttachedMarker> read(double stand_off_mm) {
    const std::string text = read_file(path_, std::size_t{64} << 20);
    std::vector<AttachedMarker> markers;
    std::string_view rest = text;
    while (!rest.empty()) {
      const std::size_t end = rest.find('\n');
      const std::string_view line = trim(rest.substr(0, end));
      rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
      ++line_;
      if (line.empty() || line.front() == '#') continue;
      const std::vector<std::string> cells = split(line);
      if (columns_.empty()) {
        read_header(cells);
        continue;
      }
      if (cells.size() != columns_.size()) fail("has another number of cells than the header");
      markers.push_back(marker_of(cells, stand_off_mm));
    }
    if (markers.empty()) fail("no marker follows");
    return markers;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw InputError({.what = "line " + std::to_string(line_) + ": " + what,
                      .file = path_.string(),
                      .place = "line " + std::to_string(line_),
                      .remedy = "The columns are label,face,b0,b1,b2 or label,vertex or "
                                "label,x,y,z; indices count from 0"});
  }
  void read_header(const std::vector<std::string>& cells) {
    for (std::size_t i = 0; i < cells.size(); ++i) columns_[lower(cells[i])] = i;
    const auto has = [&](const char* name) { return columns_.contains(name); };
    by_face_ = has("face") && has("b0") && has("b1") && has("b2");
    by_place_ = has("x") && has("y") && has("z");
    if (columns_.size() != cells.size() || !has("label") ||
        !(by_face_ || by_place_ || has("vertex"))) {
      fail("is no header of marker places");
    }
  }
  double number(const std::vector<std::string>& cells, const char* column) const {
    const std::string& cell = cells[columns_.at(column)];
    double value = 0.0;
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value)) {
      fail("'" + cell + "' is no number");
    }
    return value;
  }
  std::size_t index(const std::vector<std::string>& cells, const char* column,
                    std::size_t count) const {
    const double value = number(cells, column);
    if (value < 0.0 || value >= static_cast<double>(count) || value != std::floor(value)) {
      fail(std::string("the scan has no ") + column + " " + cells[columns_.at(column)]);
    }
    return static_cast<std::size_t>(value);
  }
  SurfacePoint point_of(const std::vector<std::string>& cells) {
    const Topology& topology = *scan_.topology;
    if (by_face_) {
      SurfacePoint p{static_cast<FaceIndex>(index(cells, "face", topology.face_count())),
                     {number(cells, "b0"), number(cells, "b1"), number(cells, "b2")}};
      const double sum = p.weights[0] + p.weights[1] + p.weights[2];
      const bool inside = std::ranges::all_of(p.weights, [](double w) { return w >= -1e-6; });
      if (!inside || std::abs(sum - 1.0) > 1e-6) fail("the weights are not within the face");
      return p;
    }
    if (!by_place_) {
      const auto v = static_cast<VertexIndex>(index(cells, "vertex", topology.vertex_count()));
      const auto around = topology.faces_of(v);
      if (around.empty()) fail("vertex " + std::to_string(v) + " belongs to no face");
      SurfacePoint p{around.front()};
      const Triangle& face = topology.faces()[p.face];
      p.weights.at(static_cast<std::size_t>(std::ranges::find(face, v) - face.begin())) = 1.0;
      return p;
    }
    if (!search_) {
      std::vector<Eigen::Vector3d> positions;
      for (const auto& q : scan_.positions) positions.push_back(q.cast<double>());
      search_.emplace(positions, topology.faces());
    }
    const Eigen::Vector3d place(number(cells, "x"), number(cells, "y"), number(cells, "z"));
    const ClosestHit hit = search_->closest(scale_ * place);
    if (hit.distance > 20.0) {
      fail("the point lies " + format_fixed(hit.distance, 0) + " mm off the scan");
    }
    return hit.point;
  }
  AttachedMarker marker_of(const std::vector<std::string>& cells, double stand_off_mm) {
    AttachedMarker marker{cells[columns_.at("label")], point_of(cells), stand_off_mm};
    if (marker.label.empty()) fail("the marker has no label");
    if (columns_.contains("stand_off")) marker.stand_off_mm = number(cells, "stand_off");
    if (!labels_.emplace(marker.label, line_).second) {
      fail("the label '" + marker.label + "' was placed before");
    }
    return marker;
  }

  const std::filesystem::path& path_;
  const Mesh& scan_;
  double scale_;
  std::size_t line_ = 0;
  std::map<std::string, std::size_t> columns_, labels_;
  bool by_face_ = false, by_place_ = false;
  std::optional<ClosestPointSearch> search_;
};

}  // namespace

std::vector<AttachedMarker> read_marker_places(const std::filesystem::path& path, const Mesh& scan,
                                               double scale, double stand_off_mm) {
  return PlacesReader(path, scan, scale).read(stand_off_mm);
}

std::vector<AttachedMarker> with_corners_of(std::vector<AttachedMarker> markers,
                                            const Topology& from, const Topology& to) {
  for (AttachedMarker& marker : markers) {
    const Triangle &old = from.faces()[marker.point.face], &now = to.faces()[marker.point.face];
    std::array<double, 3> weights{};
    for (std::size_t c = 0; c < 3; ++c) {
      const auto corner = static_cast<std::size_t>(std::ranges::find(now, old.at(c)) - now.begin());
      if (corner == 3) throw InternalError("the faces have other vertices");
      weights.at(corner) = marker.point.weights.at(c);
    }
    marker.point.weights = weights;
  }
  return markers;
}

std::string marker_places_csv(const std::vector<AttachedMarker>& markers) {
  std::string csv = "label,face,b0,b1,b2,stand_off\n";
  for (const AttachedMarker& m : markers) {
    csv += m.label + "," + std::to_string(m.point.face);
    for (const double w : m.point.weights) csv += "," + format_number(w);
    csv += "," + format_number(m.stand_off_mm) + "\n";
  }
  return csv;
}

}  // namespace kinemesh
