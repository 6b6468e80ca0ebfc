#include "reconstruct/face_frame.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "reconstruct/delaunay_flips.h"

namespace kinemesh {

FaceFrame find_face_frame(const EditMesh& mesh, const Points& points, double spacing) {
  const Points normals = vertex_normals(mesh, points);
  FaceFrame frame{find_mirror_plane(points, normals, spacing), Eigen::Vector3d::Zero(), spacing};
  for (const auto& n : normals) frame.front += n;
  const double norm = frame.front.norm();
  frame.front =
      norm > 0 ? Eigen::Vector3d(frame.front / norm) : frame.plane.normal.unitOrthogonal();
  return frame;
}

Eigen::Vector3d FaceFrame::up(const Points& points, const std::optional<Eigen::Vector3d>& mouth,
                              const Eigen::Vector3d& eyes) const {
  const Eigen::Vector3d axis = front.cross(plane.normal).normalized();
  double upwards = 0.0;
  if (mouth) {
    for (const auto& p : points) upwards += axis.dot(p - *mouth);
  } else {
    std::vector<std::pair<double, double>> nose;  // how far it stands out, how far below the eyes
    for (const auto& p : points) {
      if (std::abs(plane.side(p)) < 1.5 * spacing)
        nose.emplace_back(front.dot(p), axis.dot(eyes - p));
    }
    std::sort(nose.rbegin(), nose.rend());
    for (std::size_t i = 0; i < std::min<std::size_t>(3, nose.size()); ++i)
      upwards += nose[i].second;
  }
  return upwards >= 0 ? axis : Eigen::Vector3d(-axis);
}

}  // namespace kinemesh
