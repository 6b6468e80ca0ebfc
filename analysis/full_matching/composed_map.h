// A closed surface A laid over the sphere on which a closed surface B rests: where its vertices
// lie on B, and how they move to lower the energy of the composed map A → B. Private to analysis/.
//
//   E = Σ over A's triangles of the symmetric Dirichlet energy of triangle → its image's corners
//       in space (and a little of that of triangle → sphere), plus Σ over A's vertices of area ·
//       Σ_channel weight · (signal A − signal B)²
//
// No step is taken that turns over a triangle on the sphere: the map stays one-to-one.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "analysis/full_matching/landmark_warp.h"
#include "analysis/full_matching/surface_signals.h"
#include "analysis/spherical/ring_mesh.h"
#include "analysis/spherical/ring_room.h"
#include "analysis/spherical/sphere_locator.h"

namespace kinemesh::full_matching {

/// The surface that rests.
struct Target {
  const ClosedSurface& closed;
  const std::vector<Eigen::Vector3d>& sphere;
  const SurfaceSignals& signals;
  const SphereLocator& locator;
};

class ComposedMap {
 public:
  /// Keeps references. `sphere`: a valid map of A, which moves from here on.
  ComposedMap(const ClosedSurface& closed, const SurfaceSignals& signals,
              std::vector<Eigen::Vector3d> sphere, const Target& target);

  /// Collapses A to `count` vertices, those with `keep` set among them, and lays them out anew
  /// where they would fold; empty: any, as they lie.
  void coarsen(std::size_t count, std::span<const uint8_t> keep, const RunContext& ctx);
  /// Brings back vertices until there are `count`. Throws NoResultError where there is no room.
  void refine(std::size_t count);
  /// Moves vertices of the present mesh onto their places, where they are held from then on;
  /// returns those that cannot be met, by index.
  std::vector<std::size_t> meet(std::span<const Anchor> anchors, const RunContext& ctx);
  std::size_t vertex_count() const { return mesh_.alive_count(); }
  bool complete() const { return mesh_.removed_count() == 0; }

  void set_weights(const Signal& weights, double distortion);
  /// Compares signals as blurred as edges `blur` times as long as those of the present mesh are.
  void set_detail(double blur);
  /// A rotation from A's to B's space, by which A's normals and loops are turned before they are
  /// compared.
  void fit_rotation();
  /// A smooth deformation of A's space (cubic polynomials) that leads A's vertices near where they
  /// lie; from then on images are drawn to where it leads them, with `weight` where it explains
  /// nearly all of B's extent, and with less where it does not.
  void fit_deformation(double weight);
  /// Moves each vertex that is not held; returns by how much the energy fell.
  double sweep();
  double energy();

  const std::vector<Eigen::Vector3d>& sphere() const { return sphere_; }
  const SurfacePoint& image(VertexIndex v) const { return images_[v].place; }
  /// Where that is in space; B's area at rest being 1.
  const Eigen::Vector3d& position(VertexIndex v) const { return images_[v].position; }
  const std::vector<VertexIndex>& alive() const { return mesh_.alive(); }
  /// Signal of A at v (its normal turned) minus that of B at its image.
  Signal difference(VertexIndex v) const { return own_signal(v) - images_[v].signal; }
  /// Symmetric Dirichlet energy around v over its rest area, / 4: 1 where isometric.
  double distortion_at(VertexIndex v);

 private:
  /// Where a point of the sphere lies on B.
  struct Image {
    SurfacePoint place;
    Eigen::Vector3d position;
    Signal signal;
  };
  struct Corner {
    Eigen::Vector3d b, c, normal, image_b, image_c;
    double cot_a, cot_b, cot_c, area, weight, least_square;
  };
  struct Slope {
    Eigen::Vector2d gradient;
    Eigen::Matrix2d hessian;
  };

  Image image_of(const Eigen::Vector3d& p, FaceIndex hint) const;
  Image image_at(const SurfacePoint& place) const;
  Signal own_signal(VertexIndex v) const;
  void gather(VertexIndex v);
  bool in_place(const Eigen::Vector3d& p) const;
  double distortion_energy(const Eigen::Vector3d& q) const;
  double sphere_energy(const Eigen::Vector3d& p) const;
  double energy_at(VertexIndex v, const Eigen::Vector3d& p, const Image& image) const;
  Slope slope_at(VertexIndex v, const Eigen::Vector3d& p,
                 const Eigen::Matrix<double, 3, 2>& basis) const;
  void add_sphere_slope(const Eigen::Vector3d& p, const Eigen::Matrix<double, 3, 2>& basis,
                        Slope& slope) const;
  double descend(VertexIndex v);
  void insert();

  const ClosedSurface& closed_;
  const SurfaceSignals& signals_;
  const Target& target_;
  spherical::RingMesh mesh_;
  std::vector<Eigen::Vector3d> sphere_;
  std::vector<Image> images_;
  std::vector<uint8_t> held_;
  spherical::RingRoom room_;
  std::vector<Eigen::Vector3d> led_;  // where the smooth deformation leads each vertex
  std::vector<double> led_weights_;   // per vertex; empty: none
  Eigen::Matrix3f turn_ = Eigen::Matrix3f::Identity();
  const std::vector<Signal>* own_values_;
  const std::vector<Signal>* rest_values_;
  Signal weights_ = Signal::Zero();
  double distortion_weight_ = 1.0, shortest_ = 0.0;
  std::vector<Corner> corners_;
  double own_area_ = 0.0;  // of the surface around the gathered vertex, a third
};

}  // namespace kinemesh::full_matching
