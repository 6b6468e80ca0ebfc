#include "mesh/closest_point.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

namespace kinemesh {
namespace {

constexpr uint32_t leaf_size = 6;

bool finite(const Triangle& t, std::span<const Eigen::Vector3d> positions) {
  return std::ranges::all_of(t, [&](VertexIndex v) { return positions[v].allFinite(); });
}

}  // namespace

Eigen::Vector3d closest_weights(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const Eigen::Vector3d ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  const Eigen::Vector3d bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    const double t = d1 / (d1 - d3);
    return {1 - t, t, 0};
  }
  const Eigen::Vector3d cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    const double t = d2 / (d2 - d6);
    return {1 - t, 0, t};
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1 - t, t};
  }
  const double sum = va + vb + vc;
  return {va / sum, vb / sum, vc / sum};
}

ClosestPointSearch::ClosestPointSearch(std::span<const Eigen::Vector3d> positions,
                                       std::vector<Triangle> faces)
    : positions_(positions.begin(), positions.end()), faces_(std::move(faces)) {
  std::vector<Eigen::Vector3d> centres(faces_.size(), Eigen::Vector3d::Zero());
  for (FaceIndex f = 0; f < faces_.size(); ++f) {
    if (!finite(faces_[f], positions_)) continue;
    for (const VertexIndex v : faces_[f]) centres[f] += positions_[v] / 3.0;
    order_.push_back(f);
  }
  if (!order_.empty()) build(0, static_cast<uint32_t>(order_.size()), centres);
}

uint32_t ClosestPointSearch::build(uint32_t first, uint32_t count,
                                   const std::vector<Eigen::Vector3d>& centres) {
  const auto index = static_cast<uint32_t>(nodes_.size());
  Node node{Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()),
            Eigen::Vector3d::Constant(-std::numeric_limits<double>::infinity())};
  Eigen::Vector3d low = node.low, high = node.high;  // of the centres
  for (uint32_t i = first; i < first + count; ++i) {
    for (const VertexIndex v : faces_[order_[i]]) {
      node.low = node.low.cwiseMin(positions_[v]);
      node.high = node.high.cwiseMax(positions_[v]);
    }
    low = low.cwiseMin(centres[order_[i]]);
    high = high.cwiseMax(centres[order_[i]]);
  }
  nodes_.push_back(node);
  if (count <= leaf_size) {
    nodes_[index].first = first;
    nodes_[index].count = count;
    return index;
  }
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  const uint32_t half = count / 2;
  std::nth_element(order_.begin() + first, order_.begin() + first + half,
                   order_.begin() + first + count, [&](FaceIndex a, FaceIndex b) {
                     return centres[a][axis] < centres[b][axis] ||
                            (centres[a][axis] == centres[b][axis] && a < b);
                   });
  build(first, half, centres);
  const uint32_t right = build(first + half, count - half, centres);
  nodes_[index].right = right;
  return index;
}

ClosestHit ClosestPointSearch::closest(const Eigen::Vector3d& p, double within,
                                       const Eigen::Vector3d* normal) const {
  ClosestHit hit;
  if (nodes_.empty() || !p.allFinite()) return hit;
  double best = within * within;
  std::array<uint32_t, 128> stack{};
  std::size_t depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const uint32_t index = stack[--depth];
    const Node& node = nodes_[index];
    if (node.squared_distance(p) > best) continue;
    for (uint32_t i = node.first; i < node.first + node.count; ++i) {
      const Triangle& t = faces_[order_[i]];
      const auto &a = positions_[t[0]], &b = positions_[t[1]], &c = positions_[t[2]];
      if (normal != nullptr && (b - a).cross(c - a).dot(*normal) <= 0.0) continue;
      const Eigen::Vector3d w = closest_weights(p, a, b, c);
      const Eigen::Vector3d q = w[0] * a + w[1] * b + w[2] * c;
      const double squared = (q - p).squaredNorm();
      if (squared > best || (squared == best && hit.point.valid())) continue;
      best = squared;
      hit = {{order_[i], {w[0], w[1], w[2]}}, std::sqrt(squared), q};
    }
    if (node.count > 0) continue;
    const uint32_t left = index + 1, right = node.right;
    const bool left_first = nodes_[left].squared_distance(p) <= nodes_[right].squared_distance(p);
    stack[depth++] = left_first ? right : left;
    stack[depth++] = left_first ? left : right;
  }
  return hit;
}

}  // namespace kinemesh
