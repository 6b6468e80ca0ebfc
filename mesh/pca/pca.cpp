#include "mesh/pca/pca.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <random>

#include "config/error.h"
#include "config/parallel.h"

namespace kinemesh {
namespace {

using Matrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr Eigen::Index largest_exact = 800;
constexpr int oversampling = 8;
constexpr int power_iterations = 2;

/// Frames × coordinates, the mean taken off.
struct Centred {
  Matrix x;
  Eigen::VectorXf mean;
  double total_variance = 0;  // mean over frames of the squared norm of a row
};

Centred centred(const AnimatedMesh& mesh, const RunContext& ctx) {
  const auto frames = static_cast<Eigen::Index>(mesh.frame_count());
  const auto columns = static_cast<Eigen::Index>(3 * mesh.vertex_count());
  const Eigen::Map<const Matrix> all(mesh.positions().data(), frames, columns);
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(columns);
  for (Eigen::Index f = 0; f < frames; ++f) sum += all.row(f).cast<double>().transpose();
  Centred c;
  c.mean = (sum / static_cast<double>(frames)).cast<float>();
  c.x.resize(frames, columns);
  std::vector<double> squares(static_cast<std::size_t>(frames));
  parallel_for(ctx, squares.size(), 64, [&](std::size_t i) {
    const auto f = static_cast<Eigen::Index>(i);
    c.x.row(f) = all.row(f) - c.mean.transpose();
    squares[i] = c.x.row(f).cast<double>().squaredNorm();
  });
  for (const double s : squares) c.total_variance += s / static_cast<double>(frames);
  return c;
}

/// a · b, a block of rows at a time.
Matrix product(const Matrix& a, const Matrix& b, const RunContext& ctx) {
  Matrix out(a.rows(), b.cols());
  parallel_chunks(ctx, static_cast<std::size_t>(a.rows()), 128,
                  [&](std::size_t begin, std::size_t end) {
                    const auto first = static_cast<Eigen::Index>(begin),
                               count = static_cast<Eigen::Index>(end - begin);
                    out.middleRows(first, count).noalias() = a.middleRows(first, count) * b;
                  });
  return out;
}

/// aᵀ · b, a block of a's columns at a time.
Matrix transposed_product(const Matrix& a, const Matrix& b, const RunContext& ctx) {
  Matrix out(a.cols(), b.cols());
  parallel_chunks(
      ctx, static_cast<std::size_t>(a.cols()), 512, [&](std::size_t begin, std::size_t end) {
        const auto first = static_cast<Eigen::Index>(begin),
                   count = static_cast<Eigen::Index>(end - begin);
        out.middleRows(first, count).noalias() = a.middleCols(first, count).transpose() * b;
      });
  return out;
}

/// Sum over rows in double of the products of two columns: bᵀ · b.
Eigen::MatrixXd gram(const Matrix& b) {
  Eigen::MatrixXd g = Eigen::MatrixXd::Zero(b.cols(), b.cols());
  for (Eigen::Index begin = 0; begin < b.rows(); begin += 512) {
    const Eigen::MatrixXd block =
        b.middleRows(begin, std::min<Eigen::Index>(512, b.rows() - begin)).cast<double>();
    g.selfadjointView<Eigen::Lower>().rankUpdate(block.transpose());
  }
  return g.selfadjointView<Eigen::Lower>();
}

/// An orthonormal basis of the columns of y, made twice so that float rounding is out.
void orthonormalise(Matrix& y) {
  for (int pass = 0; pass < 2; ++pass) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(gram(y));
    const double largest = std::max(eigen.eigenvalues().maxCoeff(), 1e-300);
    Eigen::MatrixXd scale = eigen.eigenvectors();
    for (Eigen::Index k = 0; k < scale.cols(); ++k) {
      const double value = eigen.eigenvalues()[k];
      scale.col(k) *= value > 1e-12 * largest ? 1.0 / std::sqrt(value) : 0.0;
    }
    y = (y.cast<double>() * scale).cast<float>();
  }
}

/// Modes as columns, and the squared norms of their scores over all frames, strongest first.
struct Basis {
  Eigen::MatrixXf modes;
  Eigen::VectorXd energies;
};

/// The strongest eigenvectors, up to `count`, of those that are more than rounding.
Basis strongest(const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>& eigen, Eigen::Index count) {
  const Eigen::VectorXd values = eigen.eigenvalues().reverse();
  Eigen::Index used = 0;
  while (used < count && values[used] > 1e-11 * values[0]) ++used;
  return {eigen.eigenvectors().rightCols(used).rowwise().reverse().cast<float>(),
          values.head(used)};
}

void normalise_columns(Eigen::MatrixXf& modes) {
  for (Eigen::Index k = 0; k < modes.cols(); ++k) {
    const double length = modes.col(k).cast<double>().norm();
    modes.col(k) *= static_cast<float>(length > 0 ? 1.0 / length : 0.0);
  }
}

/// From the eigenvectors of the smaller Gram matrix.
Basis exact_basis(const Matrix& x, Eigen::Index count, const RunContext& ctx) {
  if (x.rows() >= x.cols()) {
    return strongest(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(gram(x)), count);
  }
  const Matrix turned = x.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(gram(turned));
  Basis basis = strongest(eigen, count);
  const Eigen::Index used = basis.energies.size();
  // In double: weak modes are small differences of large products.
  const Eigen::MatrixXd vectors = eigen.eigenvectors().rightCols(used).rowwise().reverse();
  basis.modes.resize(turned.rows(), used);
  parallel_chunks(ctx, static_cast<std::size_t>(turned.rows()), 512,
                  [&](std::size_t begin, std::size_t end) {
                    const auto first = static_cast<Eigen::Index>(begin);
                    const auto rows = static_cast<Eigen::Index>(end - begin);
                    basis.modes.middleRows(first, rows) =
                        (turned.middleRows(first, rows).cast<double>() * vectors).cast<float>();
                  });
  normalise_columns(basis.modes);
  return basis;
}

/// By the randomised range finder.
Basis randomised_basis(const Matrix& x, Eigen::Index count, const RunContext& ctx) {
  const Eigen::Index sketch =
      std::min<Eigen::Index>(count + oversampling, std::min(x.rows(), x.cols()));
  std::mt19937_64 random(ctx.seed() + 0x9E3779B97F4A7C15U);
  Matrix y(x.cols(), sketch);
  // Any distribution with independent signs spans the range; this one is the same everywhere.
  for (Eigen::Index i = 0; i < y.size(); ++i) y.data()[i] = (random() >> 63U) != 0 ? 1.0F : -1.0F;
  for (int pass = 0; pass <= power_iterations; ++pass) {
    Matrix z = product(x, y, ctx);
    orthonormalise(z);
    y = transposed_product(x, z, ctx);
    if (pass < power_iterations) orthonormalise(y);
  }
  // y = xᵀ·z with orthonormal z: its left singular vectors are the modes.
  Basis basis = strongest(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(gram(y)), count);
  basis.modes = product(y, basis.modes, ctx);
  normalise_columns(basis.modes);
  return basis;
}

void fix_signs(Eigen::MatrixXf& modes) {
  for (Eigen::Index k = 0; k < modes.cols(); ++k) {
    Eigen::Index largest = 0;
    modes.col(k).cwiseAbs().maxCoeff(&largest);
    if (modes(largest, k) < 0) modes.col(k) *= -1.0F;
  }
}

PcaResult with_modes(const Centred& c, Eigen::Index count, const RunContext& ctx) {
  const bool exact = std::min(c.x.rows(), c.x.cols()) <= largest_exact;
  PcaResult result;
  result.mean = c.mean;
  result.total_variance = c.total_variance;
  result.vertex_count = static_cast<std::size_t>(c.mean.size() / 3);
  Basis basis = exact ? exact_basis(c.x, count, ctx) : randomised_basis(c.x, count, ctx);
  result.modes = std::move(basis.modes);
  fix_signs(result.modes);
  result.scores = product(c.x, result.modes, ctx).cast<double>();
  result.variances = basis.energies / static_cast<double>(c.x.rows());
  return result;
}

/// The fewest modes that reach the error, or all there are.
std::size_t modes_needed(const PcaResult& pca, double rms_error_mm) {
  std::size_t k = 0;
  while (k < pca.mode_count() && pca.rms_error_mm(k) > rms_error_mm) ++k;
  return k;
}

void keep(PcaResult& pca, std::size_t count) {
  const auto k = static_cast<Eigen::Index>(count);
  pca.modes.conservativeResize(Eigen::NoChange, k);
  pca.scores.conservativeResize(Eigen::NoChange, k);
  pca.variances.conservativeResize(k);
}

}  // namespace

void PcaOptions::declare(ParameterSet& p) {
  p.group("pca", "Principal components");
  p.number("modes", modes,
           {.min = 0, .max = 100000, .help = "most modes; 0 takes as many as the error asks for"});
  p.number("pca-error", rms_error_mm,
           {.unit = "mm",
            .min = 0,
            .max = 1e6,
            .help = "modes are added until the RMS error of the vertices is below this"});
}

double PcaResult::rms_error_mm(std::size_t count) const {
  const double kept = variances.head(static_cast<Eigen::Index>(count)).sum();
  return std::sqrt(std::max(0.0, total_variance - kept) / static_cast<double>(vertex_count));
}

double PcaResult::explained(std::size_t count) const {
  if (!(total_variance > 0)) return 1.0;
  return std::min(1.0, variances.head(static_cast<Eigen::Index>(count)).sum() / total_variance);
}

PcaResult pca_of(const AnimatedMesh& mesh, const PcaOptions& options, const RunContext& ctx) {
  options.validate();
  if (mesh.frame_count() == 0 || mesh.vertex_count() == 0) {
    throw InputError(
        {.what = "there is nothing to analyse: the mesh has no frames or no vertices"});
  }
  const Centred c = centred(mesh, ctx);
  const Eigen::Index all = std::min(c.x.rows() - 1, c.x.cols());
  Eigen::Index count = options.modes > 0 ? std::min<Eigen::Index>(options.modes, all) : all;
  const bool exact = std::min(c.x.rows(), c.x.cols()) <= largest_exact;
  if (exact || options.modes > 0) {
    PcaResult result = with_modes(c, count, ctx);
    keep(result, modes_needed(result, options.rms_error_mm));
    return result;
  }
  // The number of modes is not known beforehand: try, and double it.
  for (Eigen::Index tried = std::min<Eigen::Index>(32, all);; tried = std::min(2 * tried, all)) {
    PcaResult result = with_modes(c, tried, ctx);
    const std::size_t needed = modes_needed(result, options.rms_error_mm);
    if (result.rms_error_mm(needed) <= options.rms_error_mm || tried == all) {
      keep(result, needed);
      return result;
    }
  }
}

Eigen::VectorXf reconstruct(const PcaResult& pca, std::span<const double> scores) {
  const Eigen::Map<const Eigen::VectorXd> s(scores.data(),
                                            static_cast<Eigen::Index>(scores.size()));
  return pca.mean + pca.modes.leftCols(s.size()) * s.cast<float>();
}

}  // namespace kinemesh
