// A parametric human-like face with known truth: a fine surface over a planar domain, with lips
// and lids that part, subjects of different proportions, and expressions. Own design: a tapered
// superellipsoid with smooth bumps, skin that slides over it, and a jaw that turns.
//
// Face frame: origin in the head's middle, x to the subject's left, y up, z forward, mm.
// Domain: u to the subject's left, v up, in mm of an average face measured along its surface;
// the same (u, v) is the same anatomical place in every subject.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <string_view>

#include "tests/support/true_surface.h"

namespace kinemesh::test {

/// Elementary expressions; their weights run from 0 (rest) to 1 (strong) and add up.
enum class Expression : uint8_t {
  jaw_open,
  jaw_left,
  smile_left,
  smile_right,
  lips_part,
  pucker,
  brow_raise_left,
  brow_raise_right,
  frown,
  blink_left,
  blink_right,
  eyes_wide,
  nose_wrinkle,
  cheek_puff,
  count
};
inline constexpr std::size_t expression_count = static_cast<std::size_t>(Expression::count);
std::string_view name_of(Expression expression);

struct ExpressionWeights {
  std::array<double, expression_count> values{};
  double& operator[](Expression e) { return values[static_cast<std::size_t>(e)]; }
  double operator[](Expression e) const { return values[static_cast<std::size_t>(e)]; }
};

/// Proportions, as factors or offsets in mm on the average face.
struct FaceShape {
  double width = 1, height = 1, depth = 1;
  double jaw_width = 1, lower_face = 1;
  double mouth_width = 1, lip_fullness = 1, mouth_depth = 0;
  double eye_distance = 1, eye_width = 1, socket = 1;
  double nose_length = 1, nose_width = 1, brow = 1, cheek = 1, chin = 1;
  double asymmetry = 0;  ///< mm of difference between the sides
  double strength = 1;   ///< of all expressions
};

struct FaceSubject {
  uint64_t seed = 1;             ///< seed 0 is the average face
  double vertex_spacing_mm = 2;  ///< of the surface's grid in the domain; 2 gives 11,500 vertices
};

class SyntheticFace {
 public:
  SyntheticFace(const FaceSubject& subject, const FaceShape& shape);

  const FaceShape& shape() const { return shape_; }
  /// The surface at rest: lips closed, lids open.
  const TrueSurface& rest() const { return rest_; }
  const Topology& topology() const { return *rest_.topology; }
  std::size_t vertex_count() const { return rest_.positions.size(); }

  /// The surface with the given expression.
  TrueSurface surface(const ExpressionWeights& weights) const;
  /// One vertex of it, mm.
  Eigen::Vector3d vertex(VertexIndex v, const ExpressionWeights& weights) const;
  /// A point of the surface, mm.
  Eigen::Vector3d point(const SurfacePoint& point, const ExpressionWeights& weights) const;
  /// Its domain coordinates.
  Eigen::Vector2d domain(const SurfacePoint& point) const;
  /// The surface point with these domain coordinates (those on a slit belong to its upper side).
  SurfacePoint locate(const Eigen::Vector2d& domain) const;

 private:
  void build_grid(double spacing);
  FaceShape shape_;
  TrueSurface rest_;
  std::vector<int8_t> side_;  // per vertex: +1 above, -1 below the slit of its row
  std::vector<double> columns_, rows_;
};

/// Proportions drawn from the seed; seed 0 gives the average face.
FaceShape shape_of(uint64_t seed);
std::shared_ptr<const SyntheticFace> make_face(const FaceSubject& subject);

/// The slits in the domain: straight segments at height v from u_begin to u_end.
struct SlitSegment {
  std::string_view name;
  double u_begin, u_end, v;
};
inline constexpr std::array<SlitSegment, 3> slit_segments{
    {{"mouth", -26, 26, -34}, {"left_eye", 16, 44, 32}, {"right_eye", -44, -16, 32}}};
/// Half extents of the domain.
inline constexpr double domain_u = 116, domain_v = 96;

}  // namespace kinemesh::test
