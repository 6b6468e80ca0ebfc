#include "tests/support/synthetic_body.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "tests/support/random.h"

namespace kinemesh::test {

namespace {

/// An octahedron's faces divided evenly; vertices are shared through their integer coordinates.
class Octasphere {
 public:
  explicit Octasphere(int divisions) : n_(divisions) {
    for (int octant = 0; octant < 8; ++octant) add_octant(octant);
  }
  std::vector<Eigen::Vector3d> directions;  // unit vectors
  std::vector<Triangle> faces;

 private:
  void add_octant(int octant) {
    const std::array<int, 3> sign{(octant & 1) != 0 ? -1 : 1, (octant & 2) != 0 ? -1 : 1,
                                  (octant & 4) != 0 ? -1 : 1};
    const bool mirrored = sign[0] * sign[1] * sign[2] < 0;
    const auto vertex = [&](int i, int j) {
      return index_of({sign[0] * i, sign[1] * j, sign[2] * (n_ - i - j)});
    };
    const auto add = [&](VertexIndex a, VertexIndex b, VertexIndex c) {
      faces.push_back(mirrored ? Triangle{a, c, b} : Triangle{a, b, c});
    };
    for (int i = 0; i < n_; ++i) {
      for (int j = 0; i + j < n_; ++j) {
        add(vertex(i, j), vertex(i + 1, j), vertex(i, j + 1));
        if (i + j + 1 < n_) add(vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1));
      }
    }
  }
  VertexIndex index_of(const std::array<int, 3>& p) {
    const auto [at, added] = indices_.try_emplace(p, static_cast<VertexIndex>(directions.size()));
    if (added) {
      // sin evens out the triangles' sizes.
      const auto even = [&](int x) { return std::sin(0.5 * std::numbers::pi * x / n_); };
      directions.push_back(Eigen::Vector3d(even(p[0]), even(p[1]), even(p[2])).normalized());
    }
    return at->second;
  }
  int n_;
  std::map<std::array<int, 3>, VertexIndex> indices_;
};

/// Drops the faces that are not kept, and the vertices that no face uses any more.
TrueSurface compact(const std::vector<Eigen::Vector3d>& positions,
                    const std::vector<Triangle>& faces) {
  TrueSurface s;
  std::vector<VertexIndex> image(positions.size(), invalid_index);
  std::vector<Triangle> kept;
  for (Triangle t : faces) {
    for (VertexIndex& v : t) {
      if (image[v] == invalid_index) {
        image[v] = static_cast<VertexIndex>(s.positions.size());
        s.positions.push_back(positions[v]);
      }
      v = image[v];
    }
    kept.push_back(t);
  }
  s.topology = Topology::create(s.positions.size(), std::move(kept));
  return s;
}

}  // namespace

TrueSurface make_sphere(double radius_mm, int divisions) {
  const Octasphere base(divisions);
  std::vector<Eigen::Vector3d> positions;
  for (const Eigen::Vector3d& d : base.directions) positions.emplace_back(radius_mm * d);
  return compact(positions, base.faces);
}

TrueSurface make_blob(uint64_t seed, int divisions) {
  Random random(seed * 2654435761ULL + 5);
  const Octasphere base(divisions);
  std::vector<Eigen::Vector3d> limbs;
  const std::size_t count = 4 + random.below(3);
  while (limbs.size() < count) {
    const Eigen::Vector3d d = random.normal3().normalized();
    if (d.z() < -0.5) continue;  // the bottom stays free for the cut
    const bool apart = std::all_of(limbs.begin(), limbs.end(), [&](const Eigen::Vector3d& other) {
      return d.dot(other) < 0.35;
    });
    if (apart) limbs.push_back(d);
  }
  std::vector<Eigen::Vector3d> positions;
  for (const Eigen::Vector3d& d : base.directions) {
    double radius = 130;
    for (const Eigen::Vector3d& limb : limbs) radius += 130 * std::exp(9 * (d.dot(limb) - 1));
    positions.emplace_back(radius * d);
  }
  return compact(positions, base.faces);
}

TrueSurface make_open_blob(uint64_t seed, int divisions) {
  const TrueSurface blob = make_blob(seed, divisions);
  std::vector<Triangle> faces;
  for (const Triangle& t : blob.topology->faces()) {
    const auto& p = blob.positions;
    if ((p[t[0]] + p[t[1]] + p[t[2]]).z() / 3 > -85) faces.push_back(t);
  }
  return compact(blob.positions, faces);
}

TrueSurface make_bent_tube(double radius_mm, double length_mm, double bend_degrees) {
  const double bend = bend_degrees * std::numbers::pi / 180;
  const int around = 72;
  const double step = 2 * std::numbers::pi * radius_mm / around;
  const int along = static_cast<int>(length_mm / step), dome = around / 4;
  // Point at arc length s beyond the open end (over the dome at the far end), angle a.
  const auto place = [&](int k, int i) -> Eigen::Vector3d {
    const double a = 2 * std::numbers::pi * i / around;
    const double polar = k > along ? 0.5 * std::numbers::pi * (k - along) / dome : 0;
    const double s = std::min(k, along) * length_mm / along, r = radius_mm * std::cos(polar);
    const double turn = bend * s / length_mm, curve = length_mm / std::max(bend, 1e-9);
    const Eigen::Vector3d centre(curve * (1 - std::cos(turn)), 0, curve * std::sin(turn));
    const Eigen::Vector3d across(std::cos(turn), 0, -std::sin(turn)), up(0, 1, 0);
    const Eigen::Vector3d forward(std::sin(turn), 0, std::cos(turn));
    return centre + r * (std::cos(a) * across + std::sin(a) * up) +
           radius_mm * std::sin(polar) * forward;
  };
  std::vector<Eigen::Vector3d> positions;
  std::vector<Triangle> faces;
  const int last = along + dome - 1;
  for (int k = 0; k <= last; ++k) {
    for (int i = 0; i < around; ++i) positions.push_back(place(k, i));
  }
  positions.push_back(place(along + dome, 0));
  const auto at = [&](int k, int i) { return static_cast<VertexIndex>(k * around + i % around); };
  for (int k = 0; k < last; ++k) {
    for (int i = 0; i < around; ++i) {
      faces.push_back({at(k, i), at(k, i + 1), at(k + 1, i + 1)});
      faces.push_back({at(k, i), at(k + 1, i + 1), at(k + 1, i)});
    }
  }
  const auto tip = static_cast<VertexIndex>(positions.size() - 1);
  for (int i = 0; i < around; ++i) faces.push_back({at(last, i), at(last, i + 1), tip});
  return compact(positions, faces);
}

std::vector<SurfacePoint> scatter_markers(const TrueSurface& surface, double spacing_mm,
                                          uint64_t seed) {
  Random random(seed * 179424673 + 29);
  const auto& faces = surface.topology->faces();
  const auto& p = surface.positions;
  std::vector<double> areas{0};
  for (const Triangle& t : faces) {
    areas.push_back(areas.back() + (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]).norm());
  }
  std::vector<SurfacePoint> points;
  std::vector<Eigen::Vector3d> placed;
  for (int attempt = 0; attempt < 20000; ++attempt) {
    const auto at = std::upper_bound(areas.begin(), areas.end(), random.uniform(0, areas.back()));
    double a = random.uniform(), b = random.uniform();
    if (a + b > 1) {
      a = 1 - a;
      b = 1 - b;
    }
    const auto face = static_cast<FaceIndex>(at - areas.begin() - 1);
    const SurfacePoint point{std::min<FaceIndex>(face, static_cast<FaceIndex>(faces.size() - 1)),
                             {1 - a - b, a, b}};
    const Eigen::Vector3d q = position_of(point, *surface.topology, p);
    const bool free = std::none_of(placed.begin(), placed.end(), [&](const Eigen::Vector3d& o) {
      return (o - q).squaredNorm() < spacing_mm * spacing_mm;
    });
    if (!free) continue;
    points.push_back(point);
    placed.push_back(q);
  }
  return points;
}

std::vector<Eigen::Vector3d> positions_of(const TrueSurface& surface,
                                          std::span<const SurfacePoint> points) {
  std::vector<Eigen::Vector3d> positions;
  for (const SurfacePoint& p : points) {
    positions.push_back(position_of(p, *surface.topology, surface.positions));
  }
  return positions;
}

}  // namespace kinemesh::test
