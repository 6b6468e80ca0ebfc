#include "report/rasteriser.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace kinemesh::raster {
namespace {

using Eigen::Vector3f;

std::array<uint8_t, 4> bytes_of(const Rgb& colour) {
  std::array<uint8_t, 4> out{0, 0, 0, 255};
  for (int c = 0; c < 3; ++c) {
    out[static_cast<std::size_t>(c)] =
        static_cast<uint8_t>(std::clamp(colour[c], 0.0F, 1.0F) * 255.0F + 0.5F);
  }
  return out;
}

// The part of [low, high] that lies in the tile, as samples whose middles are inside.
struct Span {
  int begin, end;
};
Span span_of(float low, float high, int origin, int length) {
  const auto first = std::ceil(std::max(low - 0.5F - static_cast<float>(origin), 0.0F));
  const auto last = std::floor(
      std::min(high - 0.5F - static_cast<float>(origin), static_cast<float>(length - 1)));
  return {static_cast<int>(first), static_cast<int>(last) + 1};
}

// Everything that is constant over one triangle.
struct TriangleSetup {
  std::array<Vector3f, 3> p;
  std::array<VertexIndex, 3> corners{};
  // Barycentric weight i at (x, y) is dx[i] · x + dy[i] · y + c[i]; double against cracks.
  std::array<double, 3> dx{}, dy{}, c{};
  std::array<float, 3> to_side{};  // weight i × this: distance in samples from the side opposite
  std::array<float, 3> reach{};    // half width in samples of the line along that side
  bool back = false;
  float flat_shade = 0.0F;
  std::array<float, 3> values{};
  float value_slope = 0.0F;  // per sample
};

void set_up_sides(TriangleSetup& t, const MeshData& mesh, uint32_t face, double twice_area) {
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d from = t.p[(i + 1) % 3].cast<double>();
    const Eigen::Vector3d to = t.p[(i + 2) % 3].cast<double>();
    t.dx[i] = -(to.y() - from.y()) / twice_area;
    t.dy[i] = (to.x() - from.x()) / twice_area;
    t.c[i] = -(t.dx[i] * from.x() + t.dy[i] * from.y());
    t.to_side[i] = static_cast<float>(1.0 / std::hypot(t.dx[i], t.dy[i]));
    const std::size_t halfedge = 3 * static_cast<std::size_t>(face) + (i + 1) % 3;
    // A rim has no neighbour to draw the other half of its line.
    t.reach[i] = mesh.edges.half_width * (mesh.boundary[halfedge] != 0 ? 2.0F : 1.0F);
  }
}

bool set_up(TriangleSetup& t, const MeshData& mesh, uint32_t face, const Shading& shading) {
  t.corners = mesh.mesh->topology->faces()[face];
  for (std::size_t i = 0; i < 3; ++i) t.p[i] = mesh.points[t.corners[i]];
  const Vector3f u = t.p[1] - t.p[0];
  const Vector3f v = t.p[2] - t.p[0];
  const double twice_area = static_cast<double>(u.x()) * v.y() - static_cast<double>(u.y()) * v.x();
  if (!std::isfinite(twice_area) || twice_area == 0.0) return false;
  t.back = twice_area > 0.0;  // y points down: counter-clockwise faces have negative area
  set_up_sides(t, mesh, face, twice_area);
  if (mesh.normals.empty()) {
    const float s = mesh.samples_per_mm;
    const Vector3f u_mm(u.x() / s, -u.y() / s, u.z());
    const Vector3f v_mm(v.x() / s, -v.y() / s, v.z());
    const Vector3f normal = u_mm.cross(v_mm).normalized() * (t.back ? -1.0F : 1.0F);
    t.flat_shade = shading(normal);
  }
  if (!mesh.table.empty()) {
    double gx = 0.0;
    double gy = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      t.values[i] = mesh.mesh->values[t.corners[i]];
      gx += t.dx[i] * t.values[i];
      gy += t.dy[i] * t.values[i];
    }
    t.value_slope = static_cast<float>(std::hypot(gx, gy));
  }
  return true;
}

using Weights = std::array<float, 3>;

Rgb value_colour(const MeshData& mesh, const TriangleSetup& t, float value) {
  const ColourScale& scale = mesh.mesh->scale;
  if (!std::isfinite(value)) return mesh.table.back();
  const double span = scale.high - scale.low;
  const double at = span > 0.0 ? (value - scale.low) / span : value > scale.high ? 1.0 : 0.0;
  const std::size_t last = mesh.table.size() - 2;  // the one after it is for "no value"
  Rgb colour =
      mesh.table[static_cast<std::size_t>(std::clamp(at, 0.0, 1.0) * static_cast<double>(last))];
  const double spacing = mesh.mesh->contour_spacing;
  if (spacing > 0.0 && t.value_slope > 0.0F) {
    const double off = std::abs(value - spacing * std::round(value / spacing));
    if (off < t.value_slope * std::max(mesh.edges.half_width, 1.5F)) colour *= 0.35F;
  }
  return colour;
}

Rgb surface_colour(const MeshData& mesh, const TriangleSetup& t, const Weights& w) {
  if (!mesh.table.empty()) {
    return value_colour(mesh, t, w[0] * t.values[0] + w[1] * t.values[1] + w[2] * t.values[2]);
  }
  if (!mesh.colours.empty()) {
    return w[0] * mesh.colours[t.corners[0]] + w[1] * mesh.colours[t.corners[1]] +
           w[2] * mesh.colours[t.corners[2]];
  }
  return t.back ? mesh.back : mesh.front;
}

float shade_at(const MeshData& mesh, const TriangleSetup& t, const Weights& w,
               const Shading& shading) {
  if (mesh.normals.empty()) return t.flat_shade;
  const Vector3f sum = w[0] * mesh.normals[t.corners[0]] + w[1] * mesh.normals[t.corners[1]] +
                       w[2] * mesh.normals[t.corners[2]];
  const float length = sum.norm();
  if (!(length > 0.0F)) return shading.ambient;
  return shading(sum * ((t.back ? -1.0F : 1.0F) / length));
}

bool on_a_side(const TriangleSetup& t, const Weights& w) {
  return w[0] * t.to_side[0] < t.reach[0] || w[1] * t.to_side[1] < t.reach[1] ||
         w[2] * t.to_side[2] < t.reach[2];
}

}  // namespace

Tile::Tile(int x, int y, int width, int height, const Colour& background)
    : x_(x), y_(y), width_(width), height_(height) {
  const Rgb colour(static_cast<float>(background.r), static_cast<float>(background.g),
                   static_cast<float>(background.b));
  Sample empty{-std::numeric_limits<float>::infinity(), bytes_of(colour)};
  empty.rgba[3] = static_cast<uint8_t>(std::clamp(background.a, 0.0, 1.0) * 255.0 + 0.5);
  samples_.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), empty);
}

void paint(Tile& tile, const MeshData& mesh, uint32_t face, const Shading& shading) {
  TriangleSetup t;
  if (!set_up(t, mesh, face, shading)) return;
  const auto [x_low, x_high] = std::minmax({t.p[0].x(), t.p[1].x(), t.p[2].x()});
  const auto [y_low, y_high] = std::minmax({t.p[0].y(), t.p[1].y(), t.p[2].y()});
  const Span columns = span_of(x_low, x_high, tile.x(), tile.width());
  const Span rows = span_of(y_low, y_high, tile.y(), tile.height());
  for (int row = rows.begin; row < rows.end; ++row) {
    const double y = tile.y() + row + 0.5;
    for (int column = columns.begin; column < columns.end; ++column) {
      const double x = tile.x() + column + 0.5;
      const double w0 = t.dx[0] * x + t.dy[0] * y + t.c[0];
      const double w1 = t.dx[1] * x + t.dy[1] * y + t.c[1];
      const double w2 = t.dx[2] * x + t.dy[2] * y + t.c[2];
      // Both triangles take a sample on their common side: better twice than a crack.
      constexpr double slack = -1e-9;
      if (w0 < slack || w1 < slack || w2 < slack) continue;
      const Weights w = {static_cast<float>(w0), static_cast<float>(w1), static_cast<float>(w2)};
      const float z = w[0] * t.p[0].z() + w[1] * t.p[1].z() + w[2] * t.p[2].z();
      Sample& sample = tile.at(column, row);
      if (!(z > sample.z)) continue;
      Rgb colour = surface_colour(mesh, t, w) * shade_at(mesh, t, w, shading);
      if (mesh.edges.half_width > 0.0F && on_a_side(t, w)) {
        colour += mesh.edges.opacity * (mesh.edges.colour - colour);
      }
      sample = {z, bytes_of(colour)};
    }
  }
}

void paint(Tile& tile, const SphereData& sphere, const Shading& shading) {
  const float r = sphere.radius;
  const Vector3f& c = sphere.centre;
  const Span columns = span_of(c.x() - r, c.x() + r, tile.x(), tile.width());
  const Span rows = span_of(c.y() - r, c.y() + r, tile.y(), tile.height());
  for (int row = rows.begin; row < rows.end; ++row) {
    const float dy = static_cast<float>(tile.y() + row) + 0.5F - c.y();
    for (int column = columns.begin; column < columns.end; ++column) {
      const float dx = static_cast<float>(tile.x() + column) + 0.5F - c.x();
      const float left = r * r - dx * dx - dy * dy;
      if (left < 0.0F) continue;
      const float height = std::sqrt(left);
      const float z = c.z() + height / sphere.samples_per_mm;
      Sample& sample = tile.at(column, row);
      if (!(z > sample.z)) continue;
      sample = {z, bytes_of(sphere.colour * shading(Vector3f(dx, -dy, height) / r))};
    }
  }
}

void paint(Tile& tile, const SegmentData& segment) {
  const float r = segment.half_width;
  const auto [x_low, x_high] = std::minmax(segment.from.x(), segment.to.x());
  const auto [y_low, y_high] = std::minmax(segment.from.y(), segment.to.y());
  const Span columns = span_of(x_low - r, x_high + r, tile.x(), tile.width());
  const Span rows = span_of(y_low - r, y_high + r, tile.y(), tile.height());
  const Eigen::Vector2f along = (segment.to - segment.from).head<2>();
  const float squared = along.squaredNorm();
  for (int row = rows.begin; row < rows.end; ++row) {
    for (int column = columns.begin; column < columns.end; ++column) {
      const Eigen::Vector2f at(static_cast<float>(tile.x() + column) + 0.5F,
                               static_cast<float>(tile.y() + row) + 0.5F);
      const Eigen::Vector2f off = at - segment.from.head<2>();
      const float t = squared > 0.0F ? std::clamp(off.dot(along) / squared, 0.0F, 1.0F) : 0.0F;
      if ((off - t * along).squaredNorm() > r * r) continue;
      const float z = segment.from.z() + t * (segment.to.z() - segment.from.z());
      Sample& sample = tile.at(column, row);
      if (!(z > sample.z)) continue;
      Rgb below;
      for (int c = 0; c < 3; ++c) {
        below[c] = static_cast<float>(sample.rgba[static_cast<std::size_t>(c)]) / 255.0F;
      }
      sample = {z, bytes_of(below + segment.opacity * (segment.colour - below))};
    }
  }
}

}  // namespace kinemesh::raster
