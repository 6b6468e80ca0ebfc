// Rest triangles for distortion energies: how much a map stretches. Private to analysis/.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

namespace kinemesh::spherical {

/// Cotangents at the three corners and the area. A map with edge lengths l has the symmetric
/// Dirichlet energy (1 + area² / area'²) · ½ Σ cot_i l_i², l_i opposite to corner i.
struct RestTriangle {
  std::array<double, 3> cotangents;
  double area;
};

/// The slenderness below which triangles of a map count as thicker than they are.
inline constexpr double map_slenderness = 0.1;

/// Slivers are made thicker: the height over the longest edge is at least `slenderness` times that
/// edge, which itself counts as at least `shortest`.
inline RestTriangle rest_triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                  const Eigen::Vector3d& c, double slenderness, double shortest) {
  const std::array<Eigen::Vector3d, 3> edges{c - b, a - c, b - a};  // opposite to a, b, c
  std::array<double, 3> squares{edges[0].squaredNorm(), edges[1].squaredNorm(),
                                edges[2].squaredNorm()};
  const std::size_t apex = squares[0] >= squares[1] ? (squares[0] >= squares[2] ? 0 : 2)
                                                    : (squares[1] >= squares[2] ? 1 : 2);
  const std::size_t left = (apex + 1) % 3, right = (apex + 2) % 3;
  RestTriangle rest{};
  const double base_square = squares[apex];
  if (!(base_square > shortest * shortest)) {
    const double equilateral = 1.0 / std::sqrt(3.0);
    return {{equilateral, equilateral, equilateral}, shortest * shortest * std::sqrt(3.0) / 4.0};
  }
  const double base = std::sqrt(base_square);
  // The apex stands over the base at `foot` from the left corner.
  const double foot = (base_square + squares[right] - squares[left]) / (2.0 * base);
  const double height_square = std::max(0.0, squares[right] - foot * foot);
  const double height = std::max(std::sqrt(height_square), slenderness * base);
  const double cot_left = foot / height, cot_right = (base - foot) / height;
  rest.cotangents[left] = cot_left;
  rest.cotangents[right] = cot_right;
  rest.cotangents[apex] = (1.0 - cot_left * cot_right) * height / base;
  rest.area = base * height / 2.0;
  return rest;
}

}  // namespace kinemesh::spherical
