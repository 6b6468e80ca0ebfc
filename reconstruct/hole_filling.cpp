// fill_loop(), fill_holes(): see surface_repair.h.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "reconstruct/surface_repair.h"

namespace kinemesh {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// Least-cost triangulation of a polygon by dynamic programming (Klincsek, Annals of Discrete
/// Mathematics 9, 1980); the cost of a triangle is the sum of its squared edge lengths.
class PolygonFill {
 public:
  PolygonFill(const EditMesh& mesh, const Points& points, const std::vector<VertexIndex>& loop,
              double longest)
      : mesh_(mesh),
        points_(points),
        loop_(loop),
        longest_(longest),
        cost_(loop.size() * loop.size(), 0.0),
        split_(loop.size() * loop.size(), 0) {
    const std::size_t n = loop.size();
    for (std::size_t width = 2; width < n; ++width) {
      for (std::size_t i = 0; i + width < n; ++i) choose_split(i, i + width);
    }
  }

  bool possible() const { return std::isfinite(cost_[loop_.size() - 1]); }

  std::vector<Triangle> triangles() const {
    std::vector<Triangle> faces;
    collect(0, loop_.size() - 1, faces);
    return faces;
  }

 private:
  double squared(std::size_t i, std::size_t j) const {
    return (points_[loop_[i]] - points_[loop_[j]]).squaredNorm();
  }

  /// A chord of the polygon that may become an edge.
  bool allowed(std::size_t i, std::size_t j) const {
    if (j == i + 1 || (i == 0 && j + 1 == loop_.size())) return true;
    return squared(i, j) <= longest_ * longest_ && !mesh_.has_edge(loop_[i], loop_[j]);
  }

  void choose_split(std::size_t i, std::size_t j) {
    const std::size_t n = loop_.size();
    double best = infinite;
    if (allowed(i, j)) {
      for (std::size_t k = i + 1; k < j; ++k) {
        const double sum =
            cost_[i * n + k] + cost_[k * n + j] + squared(i, k) + squared(k, j) + squared(i, j);
        if (sum < best) {
          best = sum;
          split_[i * n + j] = k;
        }
      }
    }
    cost_[i * n + j] = best;
  }

  void collect(std::size_t i, std::size_t j, std::vector<Triangle>& faces) const {
    if (j < i + 2) return;
    const std::size_t k = split_[i * loop_.size() + j];
    faces.push_back(
        {loop_[i], loop_[j], loop_[k]});  // against the loop: the surface is on its left
    collect(i, k, faces);
    collect(k, j, faces);
  }

  const EditMesh& mesh_;
  const Points& points_;
  const std::vector<VertexIndex>& loop_;
  double longest_;
  std::vector<double> cost_;
  std::vector<std::size_t> split_;
};

Eigen::Vector3d normal(const Points& p, VertexIndex a, VertexIndex b, VertexIndex c) {
  return (p[b] - p[a]).cross(p[c] - p[a]).normalized();
}

/// No triangle of the fill is folded back by more than 100° against the face beyond its loop edge.
bool continues_surface(const EditMesh& mesh, const Points& p, const std::vector<Triangle>& fill) {
  constexpr double least_cosine = -0.17;
  for (const auto& t : fill) {
    for (int i = 0; i < 3; ++i) {
      const VertexIndex a = t[i];
      const VertexIndex b = t[(i + 1) % 3];
      const VertexIndex beyond = mesh.opposite(b, a);
      if (beyond == invalid_index) continue;
      if (normal(p, t[0], t[1], t[2]).dot(normal(p, b, a, beyond)) < least_cosine) return false;
    }
  }
  return true;
}

bool fill(EditMesh& mesh, const Points& points, const std::vector<VertexIndex>& loop,
          double longest, bool must_continue_surface) {
  constexpr std::size_t most_vertices = 200;  // time grows with the third power
  if (loop.size() < 3 || loop.size() > most_vertices) return false;
  const PolygonFill polygon(mesh, points, loop, longest);
  if (!polygon.possible()) return false;
  const auto faces = polygon.triangles();
  if (must_continue_surface && !continues_surface(mesh, points, faces)) return false;
  EditMesh filled = mesh;
  for (const auto& [a, b, c] : faces) {
    if (!filled.add_face(a, b, c)) return false;
  }
  mesh = std::move(filled);
  return true;
}

double perimeter(const Points& p, const std::vector<VertexIndex>& loop) {
  double sum = 0.0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    sum += (p[loop[i]] - p[loop[(i + 1) % loop.size()]]).norm();
  }
  return sum;
}

}  // namespace

bool fill_loop(EditMesh& mesh, const Points& points, const std::vector<VertexIndex>& loop,
               double longest) {
  return fill(mesh, points, loop, longest, false);
}

std::size_t fill_holes(EditMesh& mesh, const Points& points, double longest) {
  const auto loops = mesh.boundary_loops();
  if (loops.empty()) return 0;
  std::size_t rim = 0;
  for (std::size_t i = 1; i < loops.size(); ++i) {
    if (perimeter(points, loops[i]) > perimeter(points, loops[rim])) rim = i;
  }
  std::size_t filled = 0;
  for (std::size_t i = 0; i < loops.size(); ++i) {
    filled += fill(mesh, points, loops[i], longest, i == rim) ? 1 : 0;
  }
  return filled;
}

}  // namespace kinemesh
