#include "analysis/diffusion.h"

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <algorithm>
#include <cmath>

#include "analysis/surface_balls.h"
#include "config/error.h"
#include "config/multiversion.h"

namespace kinemesh::diffusion {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
constexpr std::size_t lanes = Factor::lanes;

KINEMESH_MULTIVERSION void solve(const uint32_t* offsets, const uint32_t* rows,
                                 const float* entries, const float* inverse_diagonal, float* x,
                                 std::size_t count, std::size_t stride) {
  for (std::size_t j = 0; j < count; ++j) {
    for (std::size_t b = 0; b < stride; b += lanes) {
      float* own = x + j * stride + b;
      float value[lanes];
      for (std::size_t f = 0; f < lanes; ++f) own[f] = value[f] = own[f] * inverse_diagonal[j];
      for (uint32_t i = offsets[j]; i < offsets[j + 1]; ++i) {
        float* other = x + rows[i] * stride + b;
        for (std::size_t f = 0; f < lanes; ++f) other[f] -= entries[i] * value[f];
      }
    }
  }
  for (std::size_t j = count; j-- > 0;) {
    for (std::size_t b = 0; b < stride; b += lanes) {
      float* own = x + j * stride + b;
      float sum[lanes];
      for (std::size_t f = 0; f < lanes; ++f) sum[f] = own[f];
      for (uint32_t i = offsets[j]; i < offsets[j + 1]; ++i) {
        const float* other = x + rows[i] * stride + b;
        for (std::size_t f = 0; f < lanes; ++f) sum[f] -= entries[i] * other[f];
      }
      for (std::size_t f = 0; f < lanes; ++f) own[f] = sum[f] * inverse_diagonal[j];
    }
  }
}

}  // namespace

void Factor::step(float* values, float* scratch, std::size_t stride) const {
  const std::size_t count = permutation.size();
  for (std::size_t j = 0; j < count; ++j) {
    const float* from = values + permutation[j] * stride;
    const float m = mass[permutation[j]];
    for (std::size_t f = 0; f < stride; ++f) scratch[j * stride + f] = m * from[f];
  }
  solve(offsets.data(), rows.data(), entries.data(), inverse_diagonal.data(), scratch, count,
        stride);
  for (std::size_t j = 0; j < count; ++j) {
    std::copy_n(scratch + j * stride, stride, values + permutation[j] * stride);
  }
}

struct Operator::System {
  Sparse stiffness;
  Eigen::VectorXd mass;
  Eigen::SimplicialLLT<Sparse> solver;
  bool analysed = false;
};

Operator::Operator(const Topology& topology, std::span<const Eigen::Vector3d> rest,
                   std::span<const uint32_t> row_of)
    : system_(std::make_unique<System>()) {
  const auto count = static_cast<Eigen::Index>(row_of.size());
  std::vector<Eigen::Triplet<double>> triplets;
  for (const Triangle& face : topology.faces()) {
    for (std::size_t c = 0; c < 3; ++c) {
      const VertexIndex a = face[(c + 1) % 3], b = face[(c + 2) % 3];
      const Eigen::Vector3d u = rest[a] - rest[face[c]], v = rest[b] - rest[face[c]];
      const double area = u.cross(v).norm(), dot = u.dot(v);
      const double cotangent = area > 1e-12 * (u.squaredNorm() + v.squaredNorm())
                                   ? std::clamp(dot / area, -20.0, 20.0)
                                   : 0.0;
      triplets.emplace_back(row_of[a], row_of[b], 0.5 * cotangent);
      triplets.emplace_back(row_of[b], row_of[a], 0.5 * cotangent);
    }
  }
  Sparse weights(count, count);
  weights.setFromTriplets(triplets.begin(), triplets.end());
  triplets.clear();
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(count);
  for (Eigen::Index column = 0; column < weights.outerSize(); ++column) {
    for (Sparse::InnerIterator it(weights, column); it; ++it) {
      const double w = std::max(it.value(), 1e-6);  // negative ones would make new maxima
      triplets.emplace_back(static_cast<int>(it.row()), static_cast<int>(column), -w);
      sums[column] += w;
    }
  }
  for (Eigen::Index i = 0; i < count; ++i) {
    triplets.emplace_back(static_cast<int>(i), static_cast<int>(i), sums[i]);
  }
  system_->stiffness.resize(count, count);
  system_->stiffness.setFromTriplets(triplets.begin(), triplets.end());
  const std::vector<double> areas = vertex_areas(topology, rest);
  double mean = 0.0;
  for (const double a : areas) mean += a / static_cast<double>(areas.size());
  system_->mass.resize(count);
  for (std::size_t v = 0; v < areas.size(); ++v) {
    system_->mass[row_of[v]] = std::max(areas[v], 1e-6 * mean);
  }
}

Operator::Operator(Operator&&) noexcept = default;
Operator::~Operator() = default;

std::shared_ptr<const Factor> Operator::factor(double time) {
  System& s = *system_;
  Sparse matrix = time * s.stiffness;
  matrix.diagonal() += s.mass;
  if (!s.analysed) s.solver.analyzePattern(matrix);
  s.analysed = true;
  s.solver.factorize(matrix);
  if (s.solver.info() != Eigen::Success) {
    throw NoResultError({.what = "diffusion over this mesh could not be solved",
                         .remedy = "Remesh it, or use --filter ring"});
  }
  auto factor = std::make_shared<Factor>();
  const auto count = static_cast<std::size_t>(s.mass.size());
  factor->permutation.resize(count);
  factor->mass.resize(count);
  factor->inverse_diagonal.resize(count);
  const auto& indices = s.solver.permutationP().indices();
  for (std::size_t i = 0; i < count; ++i) {
    factor->permutation[static_cast<std::size_t>(indices[static_cast<Eigen::Index>(i)])] =
        static_cast<uint32_t>(i);
    factor->mass[i] = static_cast<float>(s.mass[static_cast<Eigen::Index>(i)]);
  }
  const Sparse& lower = s.solver.matrixL().nestedExpression();
  factor->offsets.push_back(0);
  for (Eigen::Index column = 0; column < lower.outerSize(); ++column) {
    for (Sparse::InnerIterator it(lower, column); it; ++it) {
      if (it.row() == column) {
        factor->inverse_diagonal[static_cast<std::size_t>(column)] =
            static_cast<float>(1.0 / it.value());
      } else {
        factor->rows.push_back(static_cast<uint32_t>(it.row()));
        factor->entries.push_back(static_cast<float>(it.value()));
      }
    }
    factor->offsets.push_back(static_cast<uint32_t>(factor->rows.size()));
  }
  return factor;
}

}  // namespace kinemesh::diffusion
