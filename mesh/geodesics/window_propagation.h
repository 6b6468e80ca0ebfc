// Exact polyhedral distances by window propagation. Internal to mesh/geodesics.
//
// A window is a pencil of straight paths from one origin (a source, or a vertex with an angle
// above 2π or on a boundary, which bends paths) that cross an edge within [low, high], seen in the
// frame of the halfedge they enter through. It is handed from edge to edge; nothing is kept of it
// but what waits at the front. Windows are dropped
//   - when a path over a vertex of the edge, or over the vertex behind it, is as short (Xin & Wang
//     2009), and
//   - on one side of a vertex which they reach later than another window has reached it through the
//     same edge ("one angle, one split", Chen & Han 1990; the position at which the earlier
//     window's path to the vertex crosses the edge tells which side).
// Vertices bend paths only into the sector behind them, not all around. A flat vertex bends none,
// but hands a path that runs straight along its edges on to the next vertex: the pencils on both
// sides may miss that by rounding. At the end, a vertex that is further away than its neighbour and
// the edge between them say was missed all the same; it is reached along that edge, bends paths all
// around, and the search goes on.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "config/run_context.h"
#include "mesh/geodesics/geodesics.h"
#include "mesh/geodesics/unfolded_mesh.h"

namespace kinemesh::geodesics {

inline constexpr double infinity = std::numeric_limits<double>::infinity();
/// A vertex this close to a window's end (over the edge's length) is seen by the window. Two
/// windows that share an end at a vertex would else both miss it; the error is of second order.
inline constexpr double end_tolerance = 1e-9;
/// The same for paths that meet the edge at a small angle: how far beside the vertex they may
/// pass, over their length.
inline constexpr double aside_tolerance = 1e-13;

struct Window {
  double low, high;        ///< interval on the edge, from v1 of the halfedge's frame
  double x, y;             ///< the origin, unfolded, lies at (x, −y) in that frame
  double offset;           ///< distance of the origin from its source
  HalfedgeIndex halfedge;  ///< invalid_index: a vertex whose turn it is to bend paths
  uint32_t origin;         ///< inner vertex, or vertex count + index of a source inside a face
};

/// Windows in buckets of equal width by distance. The order within a bucket does not matter for
/// the result.
class WindowQueue {
 public:
  void reset(double bucket_width);
  void push(const Window& window, double key) {
    // The bound keeps the conversion defined for any ratio of distance to bucket width.
    const auto wanted = static_cast<int64_t>(std::min(key * per_width_, 1e18));
    const int64_t index = std::max(wanted, current_);
    ++waiting_;
    if (index - current_ < bucket_count) {
      buckets_[static_cast<std::size_t>(index) % bucket_count].push_back(window);
    } else {
      defer(window, index);
    }
  }
  /// Swaps the nearest bucket that is not empty into `bucket`. False when nothing waits. The same
  /// bucket comes again when windows were pushed into it meanwhile.
  bool take_bucket(std::vector<Window>& bucket);
  std::size_t waiting() const { return waiting_; }
  std::size_t peak() const { return peak_; }

 private:
  static constexpr int64_t bucket_count = 1024;
  struct Distant {
    Window window;
    int64_t index;
  };
  void defer(const Window& window, int64_t index);
  void call_distant();

  std::vector<std::vector<Window>> buckets_{bucket_count};
  std::vector<Distant> distant_;  ///< more than bucket_count buckets ahead
  int64_t nearest_distant_ = std::numeric_limits<int64_t>::max();
  int64_t current_ = 0;
  double per_width_ = 1.0;
  std::size_t waiting_ = 0, peak_ = 0;
};

class WindowPropagation {
 public:
  explicit WindowPropagation(const UnfoldedMesh& mesh);

  /// Sources and targets: points with inner face indices and weights that sum to 1.
  void run(std::span<const SurfacePoint> sources, std::span<const SurfacePoint> targets,
           double radius, const RunContext* ctx = nullptr);

  /// Of the last run. Vertices by inner index.
  double distance(VertexIndex v) const { return distances_[v]; }
  const GeodesicArrival& arrival(VertexIndex v) const { return arrivals_[v]; }
  const std::vector<VertexIndex>& reached() const { return reached_; }
  double target_distance(std::size_t t) const { return target_distances_[t]; }
  const GeodesicArrival& target_arrival(std::size_t t) const { return target_arrivals_[t]; }
  /// The vertex a source lies on, or invalid_index for one inside a face or on an edge.
  VertexIndex source_vertex(std::size_t s) const { return source_vertices_[s]; }
  std::size_t windows() const { return windows_; }
  std::size_t peak_windows() const { return queue_.peak(); }

 private:
  /// A source or target inside a face or on an edge of it.
  struct Spot {
    FaceIndex face;
    uint32_t index;
    bool is_source;
    std::array<double, 3> weights;
  };
  /// The shortest path so far that reaches the third vertex through a halfedge, and where it
  /// crosses the edge.
  struct Occupant {
    double distance = infinity;
    double crossing = 0.0;
  };

  void forget();
  void place_source(const SurfacePoint& point, uint32_t index);
  void start_in_face(const SurfacePoint& point, uint32_t origin);
  void place_spots(std::span<const SurfacePoint> targets);
  void finish_targets(std::span<const SurfacePoint> targets);
  bool meets_source(const Window& window);
  void reach_targets(const Window& window);
  void reach_target(uint32_t target, double distance, const GeodesicArrival& arrival);

  void empty_queue(const RunContext* ctx);
  void refuse_excess() const;
  bool reach_missed_vertices();
  bool reach_missed(VertexIndex from, VertexIndex to, double length);
  bool reach_missed_around(VertexIndex v);
  void propagate_bucket();
  void propagate(const Window& window);
  void meet_apex(const Window& window, const Frame& frame, double crossing, double tolerance,
                 bool& left, bool& right);
  void leave(const Window& window, const Frame& frame, double crossing, unsigned side);

  void reach(VertexIndex v, double distance, double direction, const GeodesicArrival& arrival);
  void bend_paths(VertexIndex v, double distance);
  void bend_into(VertexIndex v, double from, double to, double distance, bool windows);
  void bend_everywhere(VertexIndex v, double distance);
  void send_along_edge(VertexIndex from, VertexIndex to, double distance, double direction);
  void send_window(HalfedgeIndex corner, double from, double to, VertexIndex v, double distance);
  double direction_back_along(HalfedgeIndex h) const;
  void push(const Window& window, double key) {
    if (key <= radius_) queue_.push(window, key);
  }

  const UnfoldedMesh& mesh_;
  WindowQueue queue_;
  std::vector<Window> bucket_;  ///< being propagated
  double radius_ = infinity;
  std::vector<double> distances_;   ///< per vertex, then per source
  std::vector<double> directions_;  ///< angle at the vertex at which its path arrives; < 0: any
  std::vector<GeodesicArrival> arrivals_;
  std::vector<Occupant> occupants_;  ///< per halfedge
  std::vector<VertexIndex> reached_;
  std::vector<HalfedgeIndex> occupied_;
  std::vector<Spot> spots_;  ///< by face
  bool has_spots_ = false;
  std::vector<uint8_t> spotted_faces_;
  std::vector<VertexIndex> source_vertices_;
  std::vector<double> target_distances_;
  std::vector<GeodesicArrival> target_arrivals_;
  std::size_t windows_ = 0;
};

}  // namespace kinemesh::geodesics
