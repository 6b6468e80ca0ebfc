// One vertex of a spherical map moves to lower its distortion. Private to analysis/.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "analysis/spherical/rest_triangle.h"
#include "analysis/spherical/ring_mesh.h"

namespace kinemesh::spherical {

/// Two unit vectors that span the tangent plane at p with it as a right-handed frame.
Eigen::Matrix<double, 3, 2> tangent_basis(const Eigen::Vector3d& p);

/// The descent direction of a 2 × 2 Newton system whose Hessian is made positive definite.
Eigen::Vector2d newton_direction(const Eigen::Vector2d& gradient, const Eigen::Matrix2d& hessian);

class SphereDescent {
 public:
  /// Keeps references. `scale` turns lengths of `rest` into lengths on the sphere.
  SphereDescent(const RingMesh& mesh, std::span<const Eigen::Vector3d> rest,
                std::vector<Eigen::Vector3d>& points, double slenderness, double shortest);
  void set_scale(double scale);
  /// Area of the present triangles on the sphere (as det / 2) over their rest area, under a root.
  double fitting_scale() const;

  /// A spring that pulls a vertex: weight · |p − goal|² is added to its energy.
  struct Pull {
    Eigen::Vector3d goal;
    double weight;
  };
  /// A Newton step with line search; returns by how much the energy fell. No triangle turns over.
  double descend(VertexIndex v, const Pull* pull = nullptr);
  /// Energy and rest area (scaled) of the triangles around v.
  struct Energy {
    double energy, area;
  };
  Energy energy_around(VertexIndex v);

 private:
  /// One triangle (v, b, c) as a function of the position of v.
  struct Corner {
    Eigen::Vector3d b, c, normal;  // normal = b × (c − b): det = (p − b) · normal
    double cot_b, cot_c, base;     // base = cot_v |b − c|² / 2
    double area, least_square;     // (2 area)²; det² / |p − b|² must stay above the last
  };
  void gather(VertexIndex v);
  double energy_at(const Eigen::Vector3d& p, const Pull* pull = nullptr) const;
  void differentiate(const Eigen::Vector3d& p, Eigen::Vector3d& gradient,
                     Eigen::Matrix3d& hessian) const;

  const RingMesh& mesh_;
  std::span<const Eigen::Vector3d> rest_;
  std::vector<Eigen::Vector3d>& points_;
  double slenderness_, shortest_, scale_square_ = 1.0;
  std::vector<Corner> corners_;
};

}  // namespace kinemesh::spherical
