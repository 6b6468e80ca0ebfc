#include "mesh/geodesics/intrinsic_delaunay.h"

#include <cmath>

#include "mesh/geodesics/intrinsic_lengths.h"

namespace kinemesh {
namespace {

/// Triangles flatter than this are mended first: cotangents need more room than distances.
constexpr double least_height = 1e-6, length_slack = 1e-9;

class Flipper {
 public:
  Flipper(const Topology& topology, std::span<const Eigen::Vector3d> positions)
      : lengths_(intrinsic_lengths(topology, positions, least_height, length_slack).lengths) {
    const auto halfedges = static_cast<HalfedgeIndex>(lengths_.size());
    from_.resize(halfedges);
    twins_.resize(halfedges);
    for (HalfedgeIndex h = 0; h < halfedges; ++h) {
      from_[h] = topology.from(h);
      twins_[h] = topology.twin(h);
    }
  }

  void run() {
    std::vector<HalfedgeIndex> stack;
    for (HalfedgeIndex h = 0; h < twins_.size(); ++h) {
      if (twins_[h] != invalid_index && h < twins_[h]) stack.push_back(h);
    }
    // Flips end by themselves; the bound guards against rounding that would flip to and fro.
    std::size_t budget = 100 * stack.size() + 1000;
    while (!stack.empty() && budget-- > 0) {
      const HalfedgeIndex h = stack.back();
      stack.pop_back();
      if (twins_[h] != invalid_index && wants_flip(h)) flip(h, stack);
    }
  }

  IntrinsicTriangulation result() const {
    IntrinsicTriangulation t;
    t.flips = flips_;
    for (HalfedgeIndex h = 0; h < from_.size(); h += 3) {
      t.faces.push_back({from_[h], from_[h + 1], from_[h + 2]});
      t.lengths.push_back({lengths_[h], lengths_[h + 1], lengths_[h + 2]});
    }
    return t;
  }

 private:
  /// Cotangent of the angle opposite h.
  double cotangent(HalfedgeIndex h) const {
    const double a = lengths_[h], b = lengths_[Topology::next(h)],
                 c = lengths_[Topology::previous(h)];
    return (b * b + c * c - a * a) / (2.0 * double_area(a, b, c));
  }

  bool wants_flip(HalfedgeIndex h) const {
    if (h / 3 == twins_[h] / 3) return false;  // a face glued to itself
    const double sum = cotangent(h) + cotangent(twins_[h]);
    return sum < -1e-9;
  }

  /// Apex of the triangle of h over its edge laid on the x axis.
  Eigen::Vector2d apex(HalfedgeIndex h) const {
    const double l = lengths_[h], right = lengths_[Topology::next(h)],
                 left = lengths_[Topology::previous(h)];
    return {0.5 * (l + (left - right) * (left + right) / l), double_area(l, left, right) / l};
  }

  void flip(HalfedgeIndex h, std::vector<HalfedgeIndex>& stack) {
    const HalfedgeIndex t = twins_[h];
    const HalfedgeIndex h1 = Topology::next(h), h2 = Topology::previous(h);
    const HalfedgeIndex t1 = Topology::next(t), t2 = Topology::previous(t);
    const VertexIndex a = from_[h], b = from_[t], c = from_[h2], d = from_[t2];
    const Eigen::Vector2d above = apex(h);
    Eigen::Vector2d below = apex(t);
    below = {lengths_[h] - below.x(), -below.y()};
    const double diagonal = (above - below).norm();
    const std::array<double, 4> sides{lengths_[h1], lengths_[h2], lengths_[t1], lengths_[t2]};
    const std::array<HalfedgeIndex, 4> outer{outside(h1), outside(h2), outside(t1), outside(t2)};
    // Faces (d, c, a) in place of (a, b, c), and (c, d, b) in place of (b, a, d).
    set(h, d, diagonal, t);
    set(h1, c, sides[1], outer[1]);
    set(h2, a, sides[2], outer[2]);
    set(t, c, diagonal, h);
    set(t1, d, sides[3], outer[3]);
    set(t2, b, sides[0], outer[0]);
    // An outer edge may be glued to another of the same two faces.
    const std::array<HalfedgeIndex, 4> old_places{h1, h2, t1, t2}, new_places{t2, h1, h2, t1};
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        if (outer[i] == old_places[j]) twins_[new_places[i]] = new_places[j];
      }
    }
    for (const HalfedgeIndex e : new_places) {
      if (twins_[e] != invalid_index) {
        twins_[twins_[e]] = e;
        stack.push_back(e);
      }
    }
    ++flips_;
  }

  HalfedgeIndex outside(HalfedgeIndex h) const { return twins_[h]; }

  void set(HalfedgeIndex h, VertexIndex from, double length, HalfedgeIndex twin) {
    from_[h] = from;
    lengths_[h] = length;
    twins_[h] = twin;
  }

  std::vector<double> lengths_;
  std::vector<VertexIndex> from_;
  std::vector<HalfedgeIndex> twins_;
  std::size_t flips_ = 0;
};

}  // namespace

IntrinsicTriangulation intrinsic_delaunay(const Topology& topology,
                                          std::span<const Eigen::Vector3d> positions) {
  Flipper flipper(topology, positions);
  flipper.run();
  return flipper.result();
}

}  // namespace kinemesh
