// Diffusion over a surface by implicit steps: (M + t K) u' = M u with vertex areas M and cotangent
// weights K, which neither the shape of the triangles nor the length of the step can make unstable
// (Desbrun et al. 1999). Private to analysis/.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "mesh/topology.h"

namespace kinemesh::diffusion {

/// L Lᵀ = P (M + t K) Pᵀ by columns, for many right-hand sides at once.
class Factor {
 public:
  static constexpr std::size_t lanes = 16;
  /// `values`: one row of `stride` (a multiple of `lanes`) floats per vertex; `scratch` as large.
  void step(float* values, float* scratch, std::size_t stride) const;

 private:
  friend class Operator;
  std::vector<uint32_t> permutation;  ///< row of the factor → row of the values
  std::vector<float> mass;            ///< by row of the values
  std::vector<uint32_t> offsets, rows;
  std::vector<float> entries;           ///< below the diagonal
  std::vector<float> inverse_diagonal;  ///< by row of the factor
};

class Operator {
 public:
  /// `row_of[v]` is the row of vertex v.
  Operator(const Topology& topology, std::span<const Eigen::Vector3d> rest,
           std::span<const uint32_t> row_of);
  Operator(Operator&&) noexcept;
  ~Operator();
  /// Time in mm²; a step adds 2 · time to the variance per axis. Throws NoResultError when the mesh
  /// cannot be factorised.
  std::shared_ptr<const Factor> factor(double time);

 private:
  struct System;
  std::unique_ptr<System> system_;
};

}  // namespace kinemesh::diffusion
