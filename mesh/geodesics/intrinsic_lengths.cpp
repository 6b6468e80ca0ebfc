#include "mesh/geodesics/intrinsic_lengths.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "config/error.h"

namespace kinemesh {
namespace {

void check_finite(const Topology& topology, std::span<const Eigen::Vector3d> positions) {
  for (VertexIndex v = 0; v < topology.vertex_count(); ++v) {
    if (!topology.faces_of(v).empty() && !positions[v].allFinite()) {
      throw InputError({.what = "the position of vertex " + std::to_string(v) +
                                " (0-based) is not a finite number",
                        .remedy = "Fill or remove such vertices before measuring distances"});
    }
  }
}

/// Lengthens edges until every queued face satisfies the triangle inequality with its slack.
class Mender {
 public:
  Mender(const Topology& topology, IntrinsicLengths& result, double relative_slack)
      : topology_(topology), result_(result), relative_slack_(relative_slack) {}

  void mend(std::vector<FaceIndex> queue) {
    // Lengths only grow, by amounts a million times below the edges; chains of degenerate
    // triangles settle within a few rounds. Should they not, all edges grow alike, which always
    // mends every triangle.
    std::size_t budget = 1000 + 100 * queue.size();
    while (!queue.empty() && budget-- > 0) {
      const FaceIndex f = queue.back();
      queue.pop_back();
      mend_face(f, queue);
    }
    if (!queue.empty()) lengthen_all();
  }

 private:
  double slack(FaceIndex f) const {
    const double* l = &result_.lengths[3 * std::size_t{f}];
    const double longest = std::max({l[0], l[1], l[2]});
    return relative_slack_ * std::max(longest, 1e-6 * result_.mean_length);
  }

  void mend_face(FaceIndex f, std::vector<FaceIndex>& queue) {
    const double needed = slack(f);
    for (int corner = 0; corner < 3; ++corner) {
      const HalfedgeIndex longest = 3 * f + corner;
      const HalfedgeIndex one = Topology::next(longest), other = Topology::previous(longest);
      const std::vector<double>& l = result_.lengths;
      const double missing = needed - ((l[one] - l[longest]) + l[other]);
      if (missing <= 0.0) continue;
      for (const HalfedgeIndex h : {one, other}) lengthen(h, 0.75 * missing, queue);
    }
  }

  void lengthen(HalfedgeIndex h, double amount, std::vector<FaceIndex>& queue) {
    result_.lengths[h] += amount;
    result_.changed_faces[h / 3] = true;
    result_.largest_change = std::max(result_.largest_change, amount);
    const HalfedgeIndex twin = topology_.twin(h);
    if (twin == invalid_index) return;
    result_.lengths[twin] = result_.lengths[h];
    result_.changed_faces[twin / 3] = true;
    queue.push_back(twin / 3);
  }

  void lengthen_all() {
    const double amount = relative_slack_ * result_.longest;
    for (double& length : result_.lengths) length += amount;
    result_.changed_faces.assign(result_.changed_faces.size(), true);
  }

  const Topology& topology_;
  IntrinsicLengths& result_;
  double relative_slack_;
};

}  // namespace

double double_area(double a, double b, double c) {
  std::array<double, 3> l{a, b, c};
  std::sort(l.begin(), l.end(), std::greater<>());
  const double product = (l[0] + (l[1] + l[2])) * (l[2] - (l[0] - l[1])) * (l[2] + (l[0] - l[1])) *
                         (l[0] + (l[1] - l[2]));
  return product > 0.0 ? 0.5 * std::sqrt(product) : 0.0;
}

IntrinsicLengths intrinsic_lengths(const Topology& topology,
                                   std::span<const Eigen::Vector3d> positions, double least_height,
                                   double relative_slack) {
  if (positions.size() != topology.vertex_count()) {
    throw InternalError("intrinsic_lengths: as many positions as vertices are needed");
  }
  check_finite(topology, positions);
  IntrinsicLengths result;
  const auto halfedges = static_cast<HalfedgeIndex>(3 * topology.face_count());
  result.lengths.resize(halfedges);
  result.changed_faces.assign(topology.face_count(), false);
  double sum = 0.0;
  for (HalfedgeIndex h = 0; h < halfedges; ++h) {
    result.lengths[h] = (positions[topology.to(h)] - positions[topology.from(h)]).norm();
    result.longest = std::max(result.longest, result.lengths[h]);
    sum += result.lengths[h];
  }
  if (halfedges == 0) return result;
  result.mean_length = sum / halfedges;
  if (!(result.longest > 0.0)) {
    throw InputError({.what = "all vertices of the mesh lie at the same place"});
  }
  std::vector<FaceIndex> degenerate;
  for (FaceIndex f = 0; f < topology.face_count(); ++f) {
    const Triangle& t = topology.faces()[f];
    const double* l = &result.lengths[3 * std::size_t{f}];
    const double longest = std::max({l[0], l[1], l[2]});
    const double area =
        (positions[t[1]] - positions[t[0]]).cross(positions[t[2]] - positions[t[0]]).norm();
    if (!(area > least_height * longest * longest)) degenerate.push_back(f);
  }
  result.degenerate_faces = degenerate.size();
  for (const FaceIndex f : degenerate) result.changed_faces[f] = true;
  Mender(topology, result, relative_slack).mend(std::move(degenerate));
  return result;
}

}  // namespace kinemesh
