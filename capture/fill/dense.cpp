#include "capture/fill/dense.h"

#include <algorithm>
#include <cmath>

#include "config/multiversion.h"

namespace kinemesh::fill {
namespace {

/// target[j] −= Σ factors[k] rows[k][j] for eight rows `stride` apart, one after the other.
inline void subtract_eight(double* __restrict target, const double* __restrict first,
                           std::size_t stride, const double* factors, std::size_t count) {
  const double* r1 = first + stride;
  const double* r2 = r1 + stride;
  const double* r3 = r2 + stride;
  const double* r4 = r3 + stride;
  const double* r5 = r4 + stride;
  const double* r6 = r5 + stride;
  const double* r7 = r6 + stride;
  for (std::size_t j = 0; j < count; ++j) {
    double value = target[j];
    value -= factors[0] * first[j];
    value -= factors[1] * r1[j];
    value -= factors[2] * r2[j];
    value -= factors[3] * r3[j];
    value -= factors[4] * r4[j];
    value -= factors[5] * r5[j];
    value -= factors[6] * r6[j];
    value -= factors[7] * r7[j];
    target[j] = value;
  }
}

inline void subtract_one(double* __restrict target, const double* __restrict row, double factor,
                         std::size_t count) {
  for (std::size_t j = 0; j < count; ++j) target[j] -= factor * row[j];
}

/// target[from..n) −= Σₖ factor(k) · row k, for k in [begin, end), of a row-major array.
template <class Factor>
inline void subtract_rows(double* target, const double* data, std::size_t stride, std::size_t begin,
                          std::size_t end, std::size_t from, std::size_t n, Factor factor) {
  std::size_t k = begin;
  for (; k + 8 <= end; k += 8) {
    double factors[8];
    for (std::size_t i = 0; i < 8; ++i) factors[i] = factor(k + i);
    subtract_eight(target + from, data + k * stride + from, stride, factors, n - from);
  }
  for (; k < end; ++k) {
    subtract_one(target + from, data + k * stride + from, factor(k), n - from);
  }
}

KINEMESH_MULTIVERSION bool factorise(double* a, std::size_t n, std::size_t stride) {
  constexpr std::size_t block = 8;
  for (std::size_t k0 = 0; k0 < n; k0 += block) {
    const std::size_t k1 = std::min(n, k0 + block);
    for (std::size_t r = k0; r < k1; ++r) {
      double* row = a + r * stride;
      for (std::size_t k = k0; k < r; ++k) {
        const double* above = a + k * stride;
        subtract_one(row + r, above + r, above[r], n - r);
      }
      if (!(row[r] > 0.0)) return false;
      const double scale = 1.0 / std::sqrt(row[r]);
      for (std::size_t j = r; j < n; ++j) row[j] *= scale;
    }
    for (std::size_t i = k1; i < n; ++i) {
      subtract_rows(a + i * stride, a, stride, k0, k1, i, n,
                    [&](std::size_t k) { return a[k * stride + i]; });
    }
  }
  return true;
}

KINEMESH_MULTIVERSION void forward(const double* u, std::size_t stride, double* b,
                                   std::size_t b_stride, std::size_t n, std::size_t columns) {
  for (std::size_t r = 0; r < n; ++r) {
    double* row = b + r * b_stride;
    subtract_rows(row, b, b_stride, 0, r, 0, columns,
                  [&](std::size_t k) { return u[k * stride + r]; });
    const double scale = 1.0 / u[r * stride + r];
    for (std::size_t j = 0; j < columns; ++j) row[j] *= scale;
  }
}

KINEMESH_MULTIVERSION void backward(const double* u, std::size_t stride, double* b,
                                    std::size_t b_stride, std::size_t n, std::size_t columns) {
  for (std::size_t r = n; r-- > 0;) {
    double* row = b + r * b_stride;
    subtract_rows(row, b, b_stride, r + 1, n, 0, columns,
                  [&](std::size_t k) { return u[r * stride + k]; });
    const double scale = 1.0 / u[r * stride + r];
    for (std::size_t j = 0; j < columns; ++j) row[j] *= scale;
  }
}

KINEMESH_MULTIVERSION void invert(const double* u, double* w, std::size_t n, std::size_t stride) {
  for (std::size_t r = n; r-- > 0;) {
    double* row = w + r * stride;
    row[r] = 1.0;
    // Row k of the inverse begins at column k; eight rows at a time, from where the first begins.
    for (std::size_t k = r + 1; k < n; k += 8) {
      subtract_rows(row, w, stride, k, std::min(n, k + 8), k, n,
                    [&](std::size_t i) { return u[r * stride + i]; });
    }
    const double scale = 1.0 / u[r * stride + r];
    for (std::size_t j = r; j < n; ++j) row[j] *= scale;
  }
}

KINEMESH_MULTIVERSION void products(const double* a, std::size_t stride, std::size_t count,
                                    double* g, std::size_t g_stride, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    subtract_rows(g + i * g_stride, a, stride, 0, count, i, n,
                  [&](std::size_t k) { return -a[k * stride + i]; });
  }
}

}  // namespace

bool cholesky(Dense& a) { return factorise(a.row(0), a.rows(), a.stride()); }

void solve_transposed(const Dense& u, Dense& b) {
  forward(u.row(0), u.stride(), b.row(0), b.stride(), u.rows(), b.columns());
}

void solve(const Dense& u, Dense& b) {
  backward(u.row(0), u.stride(), b.row(0), b.stride(), u.rows(), b.columns());
}

Dense inverse_of_upper(const Dense& u) {
  Dense w(u.rows(), u.columns());
  invert(u.row(0), w.row(0), u.rows(), u.stride());
  return w;
}

Dense gram(const Dense& a) {
  Dense g(a.columns(), a.columns());
  products(a.row(0), a.stride(), a.rows(), g.row(0), g.stride(), a.columns());
  return g;
}

}  // namespace kinemesh::fill
