#include "tests/support/synthetic_face.h"

#include <algorithm>
#include <cmath>

#include "config/error.h"
#include "tests/support/face_geometry.h"
#include "tests/support/random.h"

namespace kinemesh::test {

namespace {

std::vector<double> grid_lines(double half, double spacing) {
  const auto steps = static_cast<int>(std::lround(half / spacing));
  std::vector<double> lines;
  for (int k = -steps; k <= steps; ++k) lines.push_back(k * spacing);
  return lines;
}

/// Index of the cell that holds x, and where in it.
std::pair<std::size_t, double> cell_of(const std::vector<double>& lines, double x) {
  const double at = (x - lines.front()) / (lines[1] - lines[0]);
  const double last = static_cast<double>(lines.size() - 2);
  const double cell = std::clamp(std::floor(at), 0.0, last);
  return {static_cast<std::size_t>(cell), std::clamp(at - cell, 0.0, 1.0)};
}

}  // namespace

std::string_view name_of(Expression expression) {
  static constexpr std::array<std::string_view, expression_count> names{
      "jaw_open",    "jaw_left",        "smile_left",       "smile_right", "lips_part",
      "pucker",      "brow_raise_left", "brow_raise_right", "frown",       "blink_left",
      "blink_right", "eyes_wide",       "nose_wrinkle",     "cheek_puff"};
  return names.at(static_cast<std::size_t>(expression));
}

FaceShape shape_of(uint64_t seed) {
  FaceShape s;
  if (seed == 0) return s;
  Random random(seed * 7919 + 13);
  const auto around = [&](double& factor, double spread) {
    factor = 1 + spread * std::clamp(random.normal(), -1.8, 1.8);
  };
  around(s.width, 0.05);
  around(s.height, 0.05);
  around(s.depth, 0.05);
  around(s.jaw_width, 0.3);
  around(s.lower_face, 0.06);
  around(s.mouth_width, 0.10);
  around(s.lip_fullness, 0.25);
  s.mouth_depth = std::clamp(2 * random.normal(), -3.0, 3.0);
  around(s.eye_distance, 0.05);
  around(s.eye_width, 0.08);
  around(s.socket, 0.2);
  around(s.nose_length, 0.15);
  around(s.nose_width, 0.10);
  around(s.brow, 0.3);
  around(s.cheek, 0.3);
  around(s.chin, 0.3);
  s.asymmetry = std::clamp(random.normal(), -1.5, 1.5);
  around(s.strength, 0.12);
  return s;
}

std::shared_ptr<const SyntheticFace> make_face(const FaceSubject& subject) {
  return std::make_shared<const SyntheticFace>(subject, shape_of(subject.seed));
}

SyntheticFace::SyntheticFace(const FaceSubject& subject, const FaceShape& shape) : shape_(shape) {
  if (subject.vertex_spacing_mm != 1 && subject.vertex_spacing_mm != 2) {
    throw UsageError({.what = "The grid of a synthetic face must have a spacing of 1 or 2 mm"});
  }
  build_grid(subject.vertex_spacing_mm);
  rest_ = surface({});
}

void SyntheticFace::build_grid(double spacing) {
  columns_ = grid_lines(domain_u, spacing);
  rows_ = grid_lines(domain_v, spacing);
  const auto at = [&](std::size_t i, std::size_t j) {
    return static_cast<VertexIndex>(j * columns_.size() + i);
  };
  for (const double v : rows_) {
    for (const double u : columns_) {
      rest_.domain.emplace_back(u, v);
      side_.push_back((v < 0 ? v >= -34 : v >= 32) ? 1 : -1);
    }
  }
  std::vector<VertexIndex> below(rest_.domain.size());  // what faces under a row refer to
  for (VertexIndex v = 0; v < below.size(); ++v) below[v] = v;
  for (const SlitSegment& segment : slit_segments) {
    Slit slit{std::string(segment.name), {}, {}};
    for (VertexIndex v = 0; v < columns_.size() * rows_.size(); ++v) {
      const Eigen::Vector2d d = rest_.domain[v];
      if (d.y() != segment.v || d.x() < segment.u_begin || d.x() > segment.u_end) continue;
      if (d.x() > segment.u_begin && d.x() < segment.u_end) {
        below[v] = static_cast<VertexIndex>(rest_.domain.size());
        rest_.domain.push_back(d);
        side_.push_back(-1);
      }
      slit.upper.push_back(v);
      slit.lower.push_back(below[v]);
    }
    rest_.slits.push_back(std::move(slit));
  }
  std::vector<Triangle> faces;
  for (std::size_t j = 0; j + 1 < rows_.size(); ++j) {
    for (std::size_t i = 0; i + 1 < columns_.size(); ++i) {
      const VertexIndex a = at(i, j), b = at(i + 1, j);
      const VertexIndex c = below[at(i + 1, j + 1)], d = below[at(i, j + 1)];
      // The diagonal mirrors at the face's middle.
      if (columns_[i] < 0) {
        faces.push_back({a, b, c});
        faces.push_back({a, c, d});
      } else {
        faces.push_back({a, b, d});
        faces.push_back({b, c, d});
      }
    }
  }
  rest_.topology = Topology::create(rest_.domain.size(), std::move(faces));
}

Eigen::Vector3d SyntheticFace::vertex(VertexIndex v, const ExpressionWeights& weights) const {
  return face_point(shape_, rest_.domain[v], side_[v], weights);
}

TrueSurface SyntheticFace::surface(const ExpressionWeights& weights) const {
  TrueSurface surface = rest_;
  surface.positions.resize(rest_.domain.size());
  for (VertexIndex v = 0; v < surface.positions.size(); ++v) {
    surface.positions[v] = vertex(v, weights);
  }
  return surface;
}

Eigen::Vector3d SyntheticFace::point(const SurfacePoint& point,
                                     const ExpressionWeights& weights) const {
  const Triangle& face = topology().faces()[point.face];
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int corner = 0; corner < 3; ++corner) {
    sum += point.weights[corner] * vertex(face[corner], weights);
  }
  return sum;
}

Eigen::Vector2d SyntheticFace::domain(const SurfacePoint& point) const {
  const Triangle& face = topology().faces()[point.face];
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (int corner = 0; corner < 3; ++corner) {
    sum += point.weights[corner] * rest_.domain[face[corner]];
  }
  return sum;
}

SurfacePoint SyntheticFace::locate(const Eigen::Vector2d& domain) const {
  const auto [i, x] = cell_of(columns_, domain.x());
  const auto [j, y] = cell_of(rows_, domain.y());
  const auto cell = static_cast<FaceIndex>(2 * (j * (columns_.size() - 1) + i));
  if (columns_[i] < 0) {
    if (x >= y) return {cell, {1 - x, x - y, y}};
    return {cell + 1, {1 - y, x, y - x}};
  }
  if (x + y <= 1) return {cell, {1 - x - y, x, y}};
  return {cell + 1, {1 - y, x + y - 1, 1 - x}};
}

}  // namespace kinemesh::test
