// How much the surface is deformed at each vertex in each frame: principal strain and change of
// curvature (Mykhalchuk 2015, 4.4), d = s + α |κ − κ_rest|.
//
// Strain, by `region`: per triangle from F = Ṽ V⁻¹, averaged over the triangles around a vertex
// (the thesis); or from one F per vertex that fits all vertices within a radius by area-weighted
// least squares. λ₁ is the largest eigenvalue of C = FᵀF in the surface, relative to the rest pose.
// Curvature: the mean over the edges within a radius of dihedral angle times length over the area
// that belongs to the edge (Alliez et al. 2003); its limit is the sum of both principal curvatures
// (1/r on a cylinder, 2/r on a sphere), made dimensionless by √(area of the rest pose) or its mean
// edge.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "analysis/vertex_curves.h"
#include "config/parameter.h"
#include "config/run_context.h"
#include "mesh/animated_mesh.h"

namespace kinemesh {

enum class StrainRegion : uint8_t { triangles, ball };
enum class StrainMeasure : uint8_t {
  lambda,    ///< λ₁, 1 at rest: the thesis
  green,     ///< (λ₁ − 1) / 2
  log,       ///< ½ ln λ₁, not below 0
  root_log,  ///< √(½ ln λ₁ + floor) − √floor
  log_norm   ///< √((½ ln λ₁)² + (½ ln λ₂)²): stretch and shortening alike
};
enum class CurvatureUnit : uint8_t { edge, root_area };
enum class RestPose : uint8_t { frame, mean };

struct DeformationOptions {
  StrainRegion region = StrainRegion::ball;
  double strain_radius = 0.08;  ///< of the ball, in √area of the rest pose
  StrainMeasure measure = StrainMeasure::root_log;
  /// root_log is √(e + floor) − √floor: below the floor it grows with e, not with its root.
  double root_floor = 0.02;
  double curvature_weight = 0.0;   ///< α
  double curvature_radius = 0.03;  ///< in √area of the rest pose
  CurvatureUnit curvature_unit = CurvatureUnit::root_area;
  /// Standard deviation of a Gaussian over time that smooths the positions, as a part of the
  /// duration.
  double position_smoothing = 0.02;
  RestPose rest = RestPose::frame;
  int rest_frame = 0;       ///< 0-based
  bool directions = false;  ///< keep the direction of the largest stretch

  void declare(ParameterSet& p);
  void validate() const { validate_options(*this); }
};

struct DeformationResult {
  VertexCurves values;                ///< d, dimensionless; 0 at vertices without faces
  std::vector<Eigen::Vector3d> rest;  ///< the rest pose, mm
  double root_area_mm = 0.0;          ///< √ of its area
  double mean_edge_mm = 0.0;
  double diagonal_mm = 0.0;  ///< of its bounding box
  /// Empty, or vertices × frames × 3: unit vectors in the rest pose, along the surface, of the
  /// largest stretch; zero where nothing is stretched. Their sign means nothing.
  Buffer<float> directions;
  std::size_t degenerate_faces = 0;  ///< faces without area at rest, left out
  std::size_t isolated_vertices = 0;
  float largest = 0.0F;  ///< of all values
};

/// The rest pose is `options.rest` of the animation, or `rest` (another take of the same subject)
/// when given. Throws InputError naming vertex and frame for positions that are not finite or a
/// rest pose with another number of vertices, UsageError for a rest frame that does not exist,
/// NoResultError for an animation without frames or faces with area.
DeformationResult deformation_of(const AnimatedMesh& animation,
                                 const DeformationOptions& options = {}, const RunContext& ctx = {},
                                 const Mesh* rest = nullptr);

}  // namespace kinemesh
