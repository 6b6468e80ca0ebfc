#include "analysis/surface_balls.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <numbers>
#include <numeric>

#include "config/parallel.h"
#include "mesh/surface_measures.h"

namespace kinemesh {
namespace {

constexpr double longest_detour = 1.3;
constexpr std::size_t grain = 256;

/// Shortest paths along edges from one vertex, with a workspace that is kept for the next.
class BallSearch {
 public:
  BallSearch(const Topology& topology, std::span<const Eigen::Vector3d> positions)
      : topology_(topology),
        positions_(positions),
        distance_(topology.vertex_count(), std::numeric_limits<float>::infinity()) {}

  void append(VertexIndex centre, double radius, std::vector<VertexIndex>& items) {
    const auto limit = static_cast<float>(longest_detour * radius);
    const double square = radius * radius;
    offer(centre, 0.0F);
    while (!queue_.empty()) {
      std::pop_heap(queue_.begin(), queue_.end(), std::greater<>());
      const auto [path, v] = queue_.back();
      queue_.pop_back();
      if (path > distance_[v]) continue;
      items.push_back(v);
      for (const VertexIndex n : topology_.neighbours_of(v)) {
        const float next = path + static_cast<float>((positions_[n] - positions_[v]).norm());
        const bool near =
            next <= limit && (positions_[n] - positions_[centre]).squaredNorm() <= square;
        if (near || v == centre) offer(n, next);
      }
    }
    for (const VertexIndex v : touched_) distance_[v] = std::numeric_limits<float>::infinity();
    touched_.clear();
  }

 private:
  void offer(VertexIndex v, float path) {
    if (!(path < distance_[v])) return;
    if (distance_[v] == std::numeric_limits<float>::infinity()) touched_.push_back(v);
    distance_[v] = path;
    queue_.emplace_back(path, v);
    std::push_heap(queue_.begin(), queue_.end(), std::greater<>());
  }

  const Topology& topology_;
  std::span<const Eigen::Vector3d> positions_;
  std::vector<float> distance_;
  std::vector<VertexIndex> touched_;
  std::vector<std::pair<float, VertexIndex>> queue_;
};

/// Balls of the vertices with all that `keep` wants, and their centres.
template <class Keep>
VertexLists balls_of(const Topology& topology, std::span<const Eigen::Vector3d> positions,
                     double radius_mm, Keep keep, const RunContext& ctx) {
  const std::size_t count = topology.vertex_count();
  // Few chunks, so that each search's workspace serves many vertices.
  const std::size_t chunk = std::max<std::size_t>(grain, (count + 31) / 32);
  std::vector<std::vector<VertexIndex>> parts((count + chunk - 1) / chunk);
  VertexLists lists;
  lists.offsets.assign(count + 1, 0);
  parallel_chunks(ctx, count, chunk, [&](std::size_t begin, std::size_t end) {
    BallSearch search(topology, positions);
    std::vector<VertexIndex>& items = parts[begin / chunk];
    for (std::size_t v = begin; v < end; ++v) {
      const std::size_t before = items.size();
      search.append(static_cast<VertexIndex>(v), radius_mm, items);
      const auto first = items.begin() + static_cast<std::ptrdiff_t>(before);
      items.erase(
          std::remove_if(first, items.end(), [&](VertexIndex u) { return u != v && !keep(u); }),
          items.end());
      lists.offsets[v + 1] = items.size() - before;
    }
  });
  std::partial_sum(lists.offsets.begin(), lists.offsets.end(), lists.offsets.begin());
  lists.items.reserve(lists.offsets.back());
  for (const auto& part : parts) lists.items.insert(lists.items.end(), part.begin(), part.end());
  return lists;
}

/// Well-mixed bits of a vertex' index, so that a sample follows no order of the vertices.
uint32_t mixed(uint32_t x) {
  x = (x ^ (x >> 16U)) * 0x7feb352dU;
  x = (x ^ (x >> 15U)) * 0x846ca68bU;
  return x ^ (x >> 16U);
}

}  // namespace

VertexLists surface_balls(const Topology& topology, std::span<const Eigen::Vector3d> positions,
                          double radius_mm, const RunContext& ctx) {
  return balls_of(
      topology, positions, radius_mm, [](VertexIndex) { return true; }, ctx);
}

VertexLists sampled_balls(const Topology& topology, std::span<const Eigen::Vector3d> positions,
                          double radius_mm, const RunContext& ctx) {
  constexpr double wanted = 200.0;
  double area = 0.0;
  for (const double a : vertex_areas(topology, positions)) area += a;
  const double density = area > 0.0 ? static_cast<double>(topology.vertex_count()) / area : 0.0;
  const double inside = std::numbers::pi * radius_mm * radius_mm * density;
  const auto step = static_cast<uint32_t>(std::max(1.0, std::round(inside / wanted)));
  return balls_of(
      topology, positions, radius_mm, [step](VertexIndex u) { return mixed(u) % step == 0; }, ctx);
}

}  // namespace kinemesh
