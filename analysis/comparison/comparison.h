// Two performances compared: B's surface and motion brought onto A's vertices and into A's time,
// and what then differs.
//
//   shape difference: B's rest surface, turned and moved onto A's, less A's: signed distance in mm
//                     along A's normals, outwards positive
//   motion difference: displacement from rest (mm) and largest stretch (%) of B less those of A, at
//                     corresponding points and instants; free of the difference in shape
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "analysis/deformation.h"
#include "analysis/full_matching/full_matching.h"
#include "analysis/time_warp.h"
#include "config/parameter.h"
#include "config/run_context.h"
#include "mesh/animated_mesh.h"
#include "mesh/landmarks.h"

namespace kinemesh {

enum class ShapeAlignment : uint8_t { rigid, similarity };

struct ComparisonOptions {
  ShapeAlignment alignment = ShapeAlignment::rigid;
  double rest_window_s = 0.1;  ///< the rest pose is the mean over so long from the first frame
  double doubtful = 0.3;       ///< confidence below which a place is doubtful
  FullMatchingOptions matching;
  TimeWarpOptions warp;
  DeformationOptions deformation;

  void declare(ParameterSet& p);
  void validate() const { validate_options(*this); }
};

/// Values per frame and vertex.
struct Field {
  std::size_t vertex_count = 0;
  std::vector<float> values;  ///< frames × vertices; NaN: none
  float at(std::size_t frame, std::size_t vertex) const {
    return values[frame * vertex_count + vertex];
  }
};

/// What one performance does, on its own vertices and in its own time.
struct Course {
  std::vector<Eigen::Vector3d> rest;  ///< mm
  std::vector<double> areas;          ///< mm² per vertex
  Field displacement;                 ///< mm from rest, 3 values a vertex: vertex_count is 3 × V
  Field strain;                       ///< largest stretch from rest, %
  double rate_hz = 0.0;
  std::size_t frame_count = 0;
  Eigen::Vector3d displacement_at(std::size_t frame, std::size_t vertex) const;
};

/// Somewhere to help the correspondence.
struct DoubtfulPlace {
  VertexIndex source = 0;
  SurfacePoint target;
  double confidence = 0.0;
};

struct Comparison {
  SurfaceMap forward, reverse;          ///< A → B, B → A
  std::string correspondence;           ///< how it was found, one sentence
  bool poor = false;                    ///< nothing below is to be trusted
  std::vector<std::string> warnings;    ///< full sentences, the gravest first
  std::vector<DoubtfulPlace> doubtful;  ///< the worst ones, far from each other
  double mean_confidence = 1.0;         ///< over A's area
  std::optional<TimeWarpResult> warp;   ///< nothing when one of both does not move

  double scale = 1.0;                                  ///< of B in the shape alignment
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();  ///< of B in the shape alignment
  Course a, b;
  std::vector<float> shape_mm;  ///< per vertex of A: signed distance; NaN where unmapped
  /// On A's vertices in A's frames: B's displacement (3 values) and strain brought there, and the
  /// length of the difference of displacements.
  Field b_displacement, b_strain, motion_difference, strain_difference;
  double root_area_mm = 0.0;  ///< of A
};

/// Meshes with the same triangles correspond vertex by vertex; otherwise `map` (A → B) when given,
/// or the surfaces are matched. Throws NoResultError, with the remedy, for what cannot be compared:
/// surfaces that cannot be mapped, sizes that differ more than fivefold under rigid alignment.
Comparison compare_performances(const AnimatedMesh& a, const AnimatedMesh& b,
                                const ComparisonOptions& options = {}, const RunContext& ctx = {},
                                const std::vector<LandmarkPair>& landmarks = {},
                                const SurfaceMap* map = nullptr);

}  // namespace kinemesh
