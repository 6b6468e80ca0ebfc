#include "tests/support/test_shapes.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "tests/support/random.h"

namespace kinemesh::test {
namespace {

using Points = std::vector<Eigen::Vector3d>;
using Faces = std::vector<Triangle>;

Surface make(std::string name, Points positions, Faces faces) {
  const std::size_t count = positions.size();
  return {std::move(name), Topology::create(count, std::move(faces)), std::move(positions)};
}

/// Vertices at equal places become one.
class Welder {
 public:
  VertexIndex at(const Eigen::Vector3i& place) {
    const auto [found, fresh] = vertices_.try_emplace({place.x(), place.y(), place.z()},
                                                      static_cast<VertexIndex>(points.size()));
    if (fresh) points.emplace_back(place.cast<double>());
    return found->second;
  }
  /// Two triangles for a quad whose corners run counter-clockwise.
  void quad(const std::array<Eigen::Vector3i, 4>& corners) {
    const VertexIndex a = at(corners[0]), b = at(corners[1]), c = at(corners[2]),
                      d = at(corners[3]);
    faces.push_back({a, b, c});
    faces.push_back({a, c, d});
  }
  Points points;
  Faces faces;

 private:
  std::map<std::array<int, 3>, VertexIndex> vertices_;
};

}  // namespace

Mesh Surface::mesh() const {
  Mesh result{topology, {}, {}};
  for (const Eigen::Vector3d& p : positions) result.positions.emplace_back(p.cast<float>());
  return result;
}

Surface plane_grid(int n, double jitter, uint64_t seed) {
  Surface s = plane_with_hole(n, 0, 0);
  Random random(seed);
  for (int row = 0; row <= n; ++row) {
    for (int column = 0; column <= n; ++column) {
      Eigen::Vector3d& p = s.positions[row * (n + 1) + column];
      const bool rim = row == 0 || column == 0 || row == n || column == n;
      if (!rim) p += jitter * Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), 0.0);
    }
  }
  s.name = "plane";
  return s;
}

Surface rectangle(const std::vector<double>& x, const std::vector<double>& y, uint64_t seed) {
  Random random(seed);
  Points positions;
  const auto columns = static_cast<VertexIndex>(x.size());
  for (const double row : y) {
    for (const double column : x) positions.emplace_back(column, row, 0.0);
  }
  Faces faces;
  for (VertexIndex a = 0; a + columns < positions.size(); ++a) {
    if (a % columns + 1 == columns) continue;
    const VertexIndex b = a + 1, c = a + columns + 1, d = a + columns;
    if (random.below(2) == 0) {
      faces.insert(faces.end(), {{a, b, c}, {a, c, d}});
    } else {
      faces.insert(faces.end(), {{a, b, d}, {b, c, d}});
    }
  }
  return make("rectangle", std::move(positions), std::move(faces));
}

Surface plane_with_hole(int n, int from, int to) {
  Welder welder;
  for (int row = 0; row <= n; ++row) {
    for (int column = 0; column <= n; ++column) {
      const bool inside = row > from && row < to && column > from && column < to;
      if (!inside) welder.at({column, row, 0});
    }
  }
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column < n; ++column) {
      if (row >= from && row < to && column >= from && column < to) continue;
      welder.quad({Eigen::Vector3i(column, row, 0),
                   {column + 1, row, 0},
                   {column + 1, row + 1, 0},
                   {column, row + 1, 0}});
    }
  }
  return make("plane with hole", std::move(welder.points), std::move(welder.faces));
}

Surface voxels(int nx, int ny, int nz, bool (*full)(int, int, int)) {
  Welder welder;
  const auto filled = [&](const Eigen::Vector3i& v) {
    return v.minCoeff() >= 0 && v.x() < nx && v.y() < ny && v.z() < nz && full(v.x(), v.y(), v.z());
  };
  for (int x = 0; x < nx; ++x) {
    for (int y = 0; y < ny; ++y) {
      for (int z = 0; z < nz; ++z) {
        const Eigen::Vector3i here(x, y, z);
        if (!filled(here)) continue;
        for (int axis = 0; axis < 3; ++axis) {
          const Eigen::Vector3i along = Eigen::Vector3i::Unit(axis);
          const Eigen::Vector3i u = Eigen::Vector3i::Unit((axis + 1) % 3);
          const Eigen::Vector3i v = Eigen::Vector3i::Unit((axis + 2) % 3);
          const Eigen::Vector3i top = here + along;
          if (!filled(top)) welder.quad({top, top + u, top + u + v, top + v});
          if (!filled(here - along)) welder.quad({here, here + v, here + u + v, here + u});
        }
      }
    }
  }
  return make("voxels", std::move(welder.points), std::move(welder.faces));
}

Surface cube(int n, double size) {
  Surface s = voxels(n, n, n, [](int, int, int) { return true; });
  for (Eigen::Vector3d& p : s.positions) p *= size / n;
  s.name = "cube";
  return s;
}

Surface double_ring() {
  Surface s = voxels(11, 7, 2, [](int x, int y, int) {
    const bool hole = y >= 2 && y <= 4 && ((x >= 2 && x <= 4) || (x >= 6 && x <= 8));
    return !hole;
  });
  s.name = "genus 2";
  return s;
}

Surface sphere(int levels, double radius) {
  const double g = std::numbers::phi;
  Points points{{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  Faces faces{{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
              {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
              {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::array<VertexIndex, 2>, VertexIndex> middles;
    const auto middle = [&](VertexIndex a, VertexIndex b) {
      const auto [found, fresh] = middles.try_emplace({std::min(a, b), std::max(a, b)},
                                                      static_cast<VertexIndex>(points.size()));
      if (fresh) points.push_back(0.5 * (points[a] + points[b]));
      return found->second;
    };
    Faces finer;
    for (const auto& [a, b, c] : faces) {
      const VertexIndex x = middle(a, b), y = middle(b, c), z = middle(c, a);
      finer.insert(finer.end(), {{a, x, z}, {x, b, y}, {z, y, c}, {x, y, z}});
    }
    faces = std::move(finer);
    for (Eigen::Vector3d& p : points) p.normalize();
  }
  for (Eigen::Vector3d& p : points) p = radius * p.normalized();
  return make("sphere", std::move(points), std::move(faces));
}

Surface torus(int m, int n, double big, double small, double jitter, uint64_t seed) {
  Points points;
  Faces faces;
  Random random(seed);
  for (int i = 0; i < m; ++i) {
    for (int j = 0; j < n; ++j) {
      const double a = 2 * std::numbers::pi * i / m, b = 2 * std::numbers::pi * j / n;
      const double ring = big + small * std::cos(b);
      points.push_back(
          Eigen::Vector3d(ring * std::cos(a), ring * std::sin(a), small * std::sin(b)) +
          jitter * random.normal3());
      const auto at = [&](int k, int l) { return static_cast<VertexIndex>((k % m) * n + l % n); };
      faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      faces.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return make("torus", std::move(points), std::move(faces));
}

Surface with_slivers(const Surface& surface, double height, uint64_t seed) {
  Random random(seed);
  Points points = surface.positions;
  Faces faces;
  for (const Triangle& t : surface.topology->faces()) {
    if (random.uniform() < 0.5) {
      faces.push_back(t);
      continue;
    }
    // A vertex close to an edge, in the plane of the triangle.
    const int c = static_cast<int>(random.below(3));
    const VertexIndex a = t[c], b = t[(c + 1) % 3], d = t[(c + 2) % 3];
    const double along = random.uniform(0.1, 0.9);
    const auto fresh = static_cast<VertexIndex>(points.size());
    const Eigen::Vector3d on_edge = (1 - along) * points[a] + along * points[b];
    points.push_back(on_edge + height * (points[d] - on_edge));
    faces.insert(faces.end(), {{a, b, fresh}, {b, d, fresh}, {d, a, fresh}});
  }
  return make(surface.name + " with slivers", std::move(points), std::move(faces));
}

Surface bumpy(const Surface& surface, double amplitude, double wavelength) {
  Points points = surface.positions;
  const double k = 2 * std::numbers::pi / wavelength;
  for (Eigen::Vector3d& p : points) {
    const Eigen::Vector3d q = p;
    p += amplitude * Eigen::Vector3d(std::sin(k * q.y() + 1.0) * std::cos(k * q.z()),
                                     std::sin(k * q.z() + 2.0) * std::cos(k * q.x()),
                                     std::sin(k * q.x()) * std::cos(k * q.y() + 0.5));
  }
  return make("bumpy " + surface.name, std::move(points), surface.topology->faces());
}

}  // namespace kinemesh::test
