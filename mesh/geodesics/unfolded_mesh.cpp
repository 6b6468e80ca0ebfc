#include "mesh/geodesics/unfolded_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace kinemesh::geodesics {
namespace {

constexpr double two_pi = 2.0 * std::numbers::pi;
/// Corner angles come from positions rounded to a float; a vertex of a plane must not count as a
/// saddle for the rounding of their sum.
constexpr double angle_tolerance = 1e-12;
/// In thin triangles rounding, also that of the positions, turns edges and paths by this much.
constexpr double flat_tolerance = 1e-5;
/// Over an edge this short (over the mean) distances differ by so little that they do not tell from
/// where a path arrives.
constexpr double least_edge = 1e-6;

/// Spreads the low 21 bits of x to every third bit.
uint64_t spread_bits(uint64_t x) {
  x &= 0x1FFFFF;
  x = (x | x << 32) & 0x1F00000000FFFF;
  x = (x | x << 16) & 0x1F0000FF0000FF;
  x = (x | x << 8) & 0x100F00F00F00F00F;
  x = (x | x << 4) & 0x10C30C30C30C30C3;
  return (x | x << 2) & 0x1249249249249249;
}

/// Position of every point along a Morton curve through their bounding box.
class MortonCurve {
 public:
  explicit MortonCurve(const Topology& topology, std::span<const Eigen::Vector3d> positions) {
    for (VertexIndex v = 0; v < topology.vertex_count(); ++v) {
      if (topology.faces_of(v).empty()) continue;
      low_ = low_.cwiseMin(positions[v]);
      high_ = high_.cwiseMax(positions[v]);
    }
    const double extent = (high_ - low_).maxCoeff();
    scale_ = extent > 0.0 ? 2e6 / extent : 0.0;
  }
  uint64_t operator()(const Eigen::Vector3d& p) const {
    uint64_t code = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double cell = std::clamp((p[axis] - low_[axis]) * scale_, 0.0, 2e6);
      code |= spread_bits(static_cast<uint64_t>(cell)) << axis;
    }
    return code;
  }

 private:
  Eigen::Vector3d low_ = Eigen::Vector3d::Constant(1e300);
  Eigen::Vector3d high_ = Eigen::Vector3d::Constant(-1e300);
  double scale_ = 0.0;
};

/// Indices 0 … count − 1 in ascending order of key, ties by index.
template <class Key>
std::vector<uint32_t> order_by(std::size_t count, Key&& key) {
  std::vector<uint64_t> keys(count);
  for (uint32_t i = 0; i < count; ++i) keys[i] = key(i);
  std::vector<uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(),
            [&](uint32_t a, uint32_t b) { return keys[a] != keys[b] ? keys[a] < keys[b] : a < b; });
  return order;
}

std::vector<uint32_t> inverse(const std::vector<uint32_t>& order) {
  std::vector<uint32_t> rank(order.size());
  for (uint32_t i = 0; i < order.size(); ++i) rank[order[i]] = i;
  return rank;
}

/// Cosine and sine of the angle between sides a and b of a triangle, opposite c, of which the area
/// is known: without cancellation also where one side is a million million times shorter.
Eigen::Vector2d corner(double a, double b, double c, double twice_area) {
  const double larger = std::max(a, b), smaller = std::min(a, b);
  const Eigen::Vector2d scaled(0.5 * ((larger - c) * (larger + c) + smaller * smaller), twice_area);
  return scaled.normalized();
}

/// Angles and apex from the positions: exact to rounding also for slivers and needles, since what
/// is measured from an end is computed from there.
void place_apex(Frame& frame, const Eigen::Vector3d& v1, const Eigen::Vector3d& v2,
                const Eigen::Vector3d& v3) {
  const Eigen::Vector3d base = v2 - v1, left = v3 - v1, right = v3 - v2;
  const double from_v1 = base.dot(left) / frame.length, to_v2 = -base.dot(right) / frame.length;
  const bool near_v1 = frame.sides[0].length < frame.sides[1].length;
  frame.px = near_v1 ? from_v1 : frame.length - to_v2;
  frame.py = base.cross(near_v1 ? left : right).norm() / frame.length;
  frame.sides[0].cos = from_v1 / frame.sides[0].length;
  frame.sides[0].sin = frame.py / frame.sides[0].length;
  frame.sides[1].cos = to_v2 / frame.sides[1].length;
  frame.sides[1].sin = frame.py / frame.sides[1].length;
}

/// The same from the lengths, for faces whose edges were lengthened.
void place_apex(Frame& frame) {
  const double a = frame.sides[0].length, b = frame.sides[1].length, l = frame.length;
  const double twice_area = double_area(l, a, b);
  const Eigen::Vector2d left = corner(l, a, b, twice_area), right = corner(l, b, a, twice_area);
  frame.sides[0].cos = left.x();
  frame.sides[0].sin = left.y();
  frame.sides[1].cos = right.x();
  frame.sides[1].sin = right.y();
  frame.px = a < b ? a * left.x() : l - b * right.x();
  frame.py = twice_area / l;
}

}  // namespace

UnfoldedMesh::UnfoldedMesh(const Topology& topology, std::span<const Eigen::Vector3d> positions) {
  const IntrinsicLengths intrinsic = intrinsic_lengths(topology, positions);
  mean_length_ = intrinsic.mean_length;
  degenerate_faces_ = intrinsic.degenerate_faces;
  renumber(topology, positions);
  build_frames(topology, positions, intrinsic);
  build_fans();
  list_irregular_corners();
  list_edges();
}

void UnfoldedMesh::renumber(const Topology& topology, std::span<const Eigen::Vector3d> positions) {
  const MortonCurve curve(topology, positions);
  original_vertices_ = order_by(topology.vertex_count(), [&](VertexIndex v) {
    return topology.faces_of(v).empty() ? ~uint64_t{0} : curve(positions[v]);
  });
  inner_vertices_ = inverse(original_vertices_);
  original_faces_ = order_by(topology.face_count(), [&](FaceIndex f) {
    const Triangle& t = topology.faces()[f];
    return curve((positions[t[0]] + positions[t[1]] + positions[t[2]]) / 3.0);
  });
  inner_faces_ = inverse(original_faces_);
}

void UnfoldedMesh::build_frames(const Topology& topology,
                                std::span<const Eigen::Vector3d> positions,
                                const IntrinsicLengths& intrinsic) {
  const auto halfedges = static_cast<HalfedgeIndex>(3 * topology.face_count());
  frames_.resize(halfedges);
  twins_.resize(halfedges);
  corner_angles_.resize(halfedges);
  const auto inner = [&](HalfedgeIndex h) {
    return h == invalid_index ? h : 3 * inner_faces_[h / 3] + h % 3;
  };
  for (HalfedgeIndex h = 0; h < halfedges; ++h) {
    const HalfedgeIndex next = Topology::next(h), previous = Topology::previous(h);
    Frame& frame = frames_[inner(h)];
    frame.length = intrinsic.lengths[h];
    frame.sides[1].length = intrinsic.lengths[next];
    frame.sides[0].length = intrinsic.lengths[previous];
    const VertexIndex v1 = topology.from(h), v2 = topology.to(h), v3 = topology.to(next);
    if (intrinsic.changed_faces[h / 3]) {
      place_apex(frame);
    } else {
      place_apex(frame, positions[v1], positions[v2], positions[v3]);
    }
    frame.beyond[0] = inner(topology.twin(previous));
    frame.beyond[1] = inner(topology.twin(next));
    frame.ends[0] = inner_vertices_[v1];
    frame.ends[1] = inner_vertices_[v2];
    frame.apex = inner_vertices_[v3];
    twins_[inner(h)] = inner(topology.twin(h));
    corner_angles_[inner(h)] = std::atan2(frame.sides[0].sin, frame.sides[0].cos);
  }
}

void UnfoldedMesh::build_fans() {
  const std::size_t vertices = inner_vertices_.size();
  outgoing_.assign(vertices, invalid_index);
  total_angles_.assign(vertices, 0.0);
  kinds_.assign(vertices, VertexKind::convex);
  corner_starts_.assign(frames_.size(), 0.0);
  std::vector<uint32_t> corner_counts(vertices, 0);
  for (HalfedgeIndex h = 0; h < frames_.size(); ++h) {
    const VertexIndex v = frames_[h].ends[0];
    ++corner_counts[v];
    if (outgoing_[v] == invalid_index || twins_[h] == invalid_index) outgoing_[v] = h;
  }
  for (VertexIndex v = 0; v < vertices; ++v) {
    HalfedgeIndex h = outgoing_[v];
    if (h == invalid_index) continue;
    uint32_t corners = 0;
    do {
      corner_starts_[h] = total_angles_[v];
      total_angles_[v] += corner_angles_[h];
      ++corners;
      h = twins_[Topology::previous(h)];
    } while (h != invalid_index && h != outgoing_[v]);
    if (corners != corner_counts[v]) {
      kinds_[v] = VertexKind::irregular;
    } else if (h == invalid_index) {
      kinds_[v] = VertexKind::boundary;
    } else if (total_angles_[v] > two_pi + angle_tolerance) {
      kinds_[v] = VertexKind::saddle;
    } else if (total_angles_[v] > two_pi - flat_tolerance) {
      kinds_[v] = VertexKind::flat;
    }
  }
}

void UnfoldedMesh::list_irregular_corners() {
  for (const Frame& frame : frames_) {
    if (frame.length > least_edge * mean_length_) continue;
    for (const VertexIndex v : frame.ends) kinds_[v] = VertexKind::irregular;
  }
  for (HalfedgeIndex h = 0; h < frames_.size(); ++h) {
    const VertexIndex v = frames_[h].ends[0];
    if (kinds_[v] == VertexKind::irregular) irregular_corners_[v].push_back(h);
  }
}

void UnfoldedMesh::list_edges() {
  edges_.reserve(frames_.size() / 2);
  for (HalfedgeIndex h = 0; h < frames_.size(); ++h) {
    if (twins_[h] != invalid_index && twins_[h] < h) continue;
    edges_.push_back({frames_[h].length, frames_[h].ends});
  }
}

Eigen::Vector2d UnfoldedMesh::in_frame(HalfedgeIndex h,
                                       const std::array<double, 3>& weights) const {
  const Frame& frame = frames_[h];
  const double w2 = weights[Topology::next(h) % 3], w3 = weights[Topology::previous(h) % 3];
  return {w2 * frame.length + w3 * frame.px, w3 * frame.py};
}

SurfacePoint UnfoldedMesh::to_surface_point(HalfedgeIndex h, const Eigen::Vector2d& point) const {
  const Frame& frame = frames_[h];
  const double w3 = std::clamp(point.y() / frame.py, 0.0, 1.0);
  const double w2 = std::clamp((point.x() - w3 * frame.px) / frame.length, 0.0, 1.0 - w3);
  SurfacePoint result;
  result.face = original_faces_[h / 3];
  result.weights[h % 3] = std::max(1.0 - w2 - w3, 0.0);
  result.weights[Topology::next(h) % 3] = w2;
  result.weights[Topology::previous(h) % 3] = w3;
  return result;
}

SurfacePoint UnfoldedMesh::vertex_point(VertexIndex v) const {
  const HalfedgeIndex h = outgoing_[v];
  SurfacePoint result;
  result.face = original_faces_[h / 3];
  result.weights[h % 3] = 1.0;
  return result;
}

}  // namespace kinemesh::geodesics
