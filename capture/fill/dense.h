// Dense linear algebra of the size that gap filling needs (a few hundred rows), written so that
// the widest vectors of the machine are used and the bytes are the same whichever they are: every
// element is computed by the same operations in the same order.
#pragma once

#include <cstddef>
#include <vector>

namespace kinemesh::fill {

/// Row-major matrix of doubles; rows start at multiples of eight values.
class Dense {
 public:
  Dense() = default;
  Dense(std::size_t rows, std::size_t columns)
      : rows_(rows),
        columns_(columns),
        stride_((columns + 7) / 8 * 8),
        data_(rows * stride_, 0.0) {}
  std::size_t rows() const { return rows_; }
  std::size_t columns() const { return columns_; }
  std::size_t stride() const { return stride_; }
  double* row(std::size_t r) { return data_.data() + r * stride_; }
  const double* row(std::size_t r) const { return data_.data() + r * stride_; }
  double& operator()(std::size_t r, std::size_t c) { return data_[r * stride_ + c]; }
  double operator()(std::size_t r, std::size_t c) const { return data_[r * stride_ + c]; }

 private:
  std::size_t rows_ = 0, columns_ = 0, stride_ = 0;
  std::vector<double> data_;
};

/// Replaces the upper triangle of a symmetric matrix (only that is read) by U with UᵀU = A.
/// False when A is not positive definite; then its content is undefined.
bool cholesky(Dense& a);

/// X with Uᵀ X = B, in place of B. U: upper triangle, as from cholesky().
void solve_transposed(const Dense& u, Dense& b);
/// X with U X = B, in place of B.
void solve(const Dense& u, Dense& b);

/// Upper triangle of U⁻¹; zeros below.
Dense inverse_of_upper(const Dense& u);

/// Upper triangle of AᵀA for A of k × n: n × n; zeros below.
Dense gram(const Dense& a);

}  // namespace kinemesh::fill
