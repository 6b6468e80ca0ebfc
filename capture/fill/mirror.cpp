#include "capture/fill/mirror.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "capture/rigid_fit.h"

namespace kinemesh::fill {
namespace {

/// Mean of some frames after a rigid fit to the first of them.
std::vector<Eigen::Vector3d> mean_shape(const Trajectories& rough,
                                        const std::vector<std::size_t>& markers) {
  constexpr std::size_t most_frames = 40;
  const std::size_t count = std::min(most_frames, rough.frames());
  std::vector<Eigen::Vector3d> first;
  std::vector<Eigen::Vector3d> sum(markers.size(), Eigen::Vector3d::Zero());
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t frame = i * rough.frames() / count;
    std::vector<Eigen::Vector3d> now;
    for (const std::size_t m : markers) now.emplace_back(rough.at(m, frame));
    if (first.empty()) first = now;
    const RigidFit pose = fit_rigid(first, now);
    for (std::size_t k = 0; k < now.size(); ++k) {
      sum[k] += pose.undo(now[k]) / static_cast<double>(count);
    }
  }
  return sum;
}

/// Of the sphere that fits the points best: |p|² = 2 c·p + d, by least squares.
Eigen::Vector3d sphere_centre(const std::vector<Eigen::Vector3d>& points) {
  const auto n = static_cast<Eigen::Index>(points.size());
  Eigen::MatrixXd a = Eigen::MatrixXd::Ones(n, 4);
  Eigen::VectorXd b(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector3d& p = points[static_cast<std::size_t>(i)];
    a.block<1, 3>(i, 0) = 2.0 * p.transpose();
    b[i] = p.squaredNorm();
  }
  return a.colPivHouseholderQr().solve(b).head<3>();
}

struct Surface {
  std::vector<Eigen::Vector3d> normals;
  double spacing = 0.0;  ///< mean distance to the nearest point, mm
};

/// Normals of the plane through each point's nearest neighbours, away from the sphere's centre.
Surface estimate_surface(const std::vector<Eigen::Vector3d>& points) {
  constexpr std::size_t neighbours = 7;  // the point itself among them
  const Eigen::Vector3d centre = sphere_centre(points);
  Surface surface;
  for (const auto& p : points) {
    std::vector<Eigen::Vector3d> near = points;
    std::ranges::partial_sort(near, near.begin() + neighbours, {},
                              [&](const auto& q) { return (q - p).squaredNorm(); });
    near.resize(neighbours);
    surface.spacing += (near[1] - p).norm() / static_cast<double>(points.size());
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const auto& q : near) middle += q / static_cast<double>(neighbours);
    Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
    for (const auto& q : near) moments += (q - middle) * (q - middle).transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(moments);
    const Eigen::Vector3d normal = solver.eigenvectors().col(0);
    surface.normals.emplace_back(normal.dot(p - centre) < 0.0 ? -normal : normal);
  }
  return surface;
}

}  // namespace

std::optional<Mirror> find_mirror(const Trajectories& rough) {
  constexpr std::size_t least_markers = 8;
  constexpr double most_error = 0.2;  // faces have about .1, .3 and more what is no mirror image
  Mirror mirror;
  for (std::size_t m = 0; m < rough.markers(); ++m) {
    if (rough.measured_count(m) > 0) mirror.known.push_back(m);
  }
  if (mirror.known.size() < least_markers) return std::nullopt;
  const std::vector<Eigen::Vector3d> points = mean_shape(rough, mirror.known);
  const Surface surface = estimate_surface(points);
  mirror.plane = find_mirror_plane(points, surface.normals, surface.spacing);
  if (!(mirror.plane.error < most_error)) return std::nullopt;
  mirror.shape.assign(rough.markers(), Eigen::Vector3d::Zero());
  for (std::size_t k = 0; k < points.size(); ++k) mirror.shape[mirror.known[k]] = points[k];
  return mirror;
}

}  // namespace kinemesh::fill
