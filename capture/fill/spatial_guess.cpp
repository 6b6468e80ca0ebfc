#include "capture/fill/spatial_guess.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace kinemesh::fill {
namespace {

/// Displacements known at some places.
struct Field {
  std::vector<Eigen::Vector3d> at;  ///< mm, in the marker's common frame
  Eigen::MatrixXd moved;            ///< places × (3 × frames): x, y, z of each frame
  std::size_t here = 0;             ///< of them on the marker's own half, first
  double distance = 0.0;            ///< mean from these to the marker, mm
};

void append(Field& field, const CommonFrame& frame, std::size_t k, std::size_t rows,
            const Eigen::Matrix3d& turn) {
  const auto row = field.moved.rows();
  field.moved.conservativeResize(row + 1, static_cast<Eigen::Index>(3 * frame.size()));
  const Eigen::Vector3d rest = frame.mean(k, rows);
  for (std::size_t i = 0; i < frame.size(); ++i) {
    field.moved.block<1, 3>(row, static_cast<Eigen::Index>(3 * i)) =
        (turn * (frame.inside(i, k) - rest)).transpose();
  }
}

Field near_field(const GuessPlace& place, const GuessOptions& options) {
  Field field;
  field.here = std::min(place.donors.size(), options.donors);
  for (std::size_t k = 0; k < field.here; ++k) {
    append(field, place.frame, k, place.rows, Eigen::Matrix3d::Identity());
    field.at.push_back(place.frame.mean(k, place.rows));
    field.distance += (field.at.back() - place.own).norm() / static_cast<double>(field.here);
  }
  return field;
}

/// Markers around the mirror image, nearest first, seen throughout the gap.
std::vector<std::size_t> markers_opposite(const GuessPlace& place, const Mirror& mirror) {
  const std::size_t marker = place.gap.marker;
  const Eigen::Vector3d image = mirror.plane.mirrored(mirror.shape[marker]);
  std::vector<std::size_t> out;
  for (const std::size_t m : mirror.known) {
    if (m != marker && place.take.measured_throughout(m, place.gap.frames)) out.push_back(m);
  }
  std::ranges::stable_sort(out, {},
                           [&](std::size_t m) { return (mirror.shape[m] - image).squaredNorm(); });
  constexpr std::size_t enough = 12;  // for a frame of their own
  out.resize(std::min({out.size(), place.donors.size(), enough}));
  return out;
}

void add_other_half(const GuessPlace& place, const Mirror& mirror, const GuessOptions& options,
                    Field& field) {
  const std::vector<std::size_t> opposite = markers_opposite(place, mirror);
  const CommonFrame frame(place.rough, opposite, place.frames, place.rows, 1);
  std::vector<Eigen::Vector3d> shape;
  std::vector<Eigen::Vector3d> now;
  for (const std::size_t m : mirror.known) {
    shape.push_back(mirror.shape[m]);
    now.emplace_back(place.rough.at(m, place.frames[CommonFrame::first_shape(place.rows)]));
  }
  const Eigen::Matrix3d turn = fit_rigid(shape, now).rotation;
  const Eigen::Matrix3d reflection =
      turn *
      (Eigen::Matrix3d::Identity() - 2.0 * mirror.plane.normal * mirror.plane.normal.transpose()) *
      turn.transpose();
  const auto near_end = place.donors.begin() + static_cast<std::ptrdiff_t>(field.here);
  std::size_t added = 0;
  for (std::size_t k = 0; k < opposite.size() && added < options.donors; ++k) {
    if (std::find(place.donors.begin(), near_end, opposite[k]) != near_end) continue;
    append(field, frame, k, place.rows, reflection);
    field.at.push_back(place.own + turn * (mirror.plane.mirrored(mirror.shape[opposite[k]]) -
                                           mirror.shape[place.gap.marker]));
    ++added;
  }
}

/// What the covariance depends on.
struct Law {
  double symmetry = 0.0;  ///< correlation of the two halves, 0 to 1
  double nugget = 0.0;
  double range = 0.0;  ///< mm
};

/// Matérn 3/2.
double alike(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Law& law) {
  const double r = std::sqrt(3.0) * (p - q).norm() / law.range;
  return (1.0 + r) * std::exp(-r);
}

Eigen::MatrixXd covariance(const Field& field, const Law& law) {
  const auto n = static_cast<Eigen::Index>(field.at.size());
  const auto here = static_cast<Eigen::Index>(field.here);
  Eigen::MatrixXd k(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      k(i, j) =
          alike(field.at[static_cast<std::size_t>(i)], field.at[static_cast<std::size_t>(j)], law) *
          ((i < here) == (j < here) ? 1.0 : law.symmetry);
    }
    k(i, i) += law.nugget;
  }
  return k;
}

/// Mean square of what each place on the marker's half is off when it is guessed from all others,
/// the nearer to the marker the more it counts (Dubrule 1983: eᵢ = (K⁻¹u)ᵢ / (K⁻¹)ᵢᵢ, with the
/// unknown mean of either half as a part of K). `products`: of all pairs of places, over the gap.
double left_out_error(const Field& field, const Eigen::VectorXd& closeness,
                      const Eigen::MatrixXd& products, const Law& law) {
  constexpr double mean_variance = 100.0;  // of the halves' means, in units of the covariance
  const auto here = static_cast<Eigen::Index>(field.here);
  Eigen::MatrixXd k = covariance(field, law);
  const Eigen::Index there = k.rows() - here;
  k.topLeftCorner(here, here).array() += mean_variance;
  k.bottomRightCorner(there, there).array() += mean_variance;
  const Eigen::LLT<Eigen::MatrixXd> factor(k);
  if (factor.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
  const Eigen::MatrixXd inverse = factor.solve(Eigen::MatrixXd::Identity(k.rows(), k.rows()));
  double sum = 0.0;
  for (Eigen::Index i = 0; i < here; ++i) {
    const double square = inverse.row(i).dot(products * inverse.col(i));
    sum += closeness[i] * square / (inverse(i, i) * inverse(i, i));
  }
  return sum;
}

/// Without the straight line in time that fits best, for each coordinate of each place: both ends
/// of the gap are known, what happens between them is to be told.
Eigen::MatrixXd without_trend(Eigen::MatrixXd moved) {
  const Eigen::Index frames = moved.cols() / 3;
  Eigen::MatrixXd basis = Eigen::MatrixXd::Ones(frames, 2);
  for (Eigen::Index i = 0; i < frames; ++i) {
    basis(i, 1) = static_cast<double>(2 * i - frames + 1);  // orthogonal to the first
  }
  for (Eigen::Index k = 0; k < moved.rows(); ++k) {
    for (Eigen::Index c = 0; c < 3; ++c) {
      using EveryThird = Eigen::Map<Eigen::VectorXd, Eigen::Unaligned, Eigen::InnerStride<>>;
      EveryThird series(&moved(k, c), frames, Eigen::InnerStride<>(3 * moved.rows()));
      for (Eigen::Index b = 0; b < (frames > 1 ? 2 : 1); ++b) {
        const double share = series.dot(basis.col(b)) / basis.col(b).squaredNorm();
        series -= share * basis.col(b);
      }
    }
  }
  return moved;
}

/// The law under which the places on the marker's half are guessed best from all others, by what
/// they do in the gap.
Law best_law(const Field& field, const Eigen::Vector3d& own, Eigen::Index gap_columns,
             const Law& usual) {
  const Eigen::MatrixXd moved = without_trend(field.moved.rightCols(gap_columns));
  const Eigen::MatrixXd products = moved * moved.transpose();
  const auto here = static_cast<Eigen::Index>(field.here);
  Eigen::VectorXd closeness(here);
  double mean_distance = 0.0;
  for (Eigen::Index i = 0; i < here; ++i) {
    closeness[i] = (field.at[static_cast<std::size_t>(i)] - own).norm();
    mean_distance += closeness[i] / static_cast<double>(here);
  }
  closeness = (-0.5 * (closeness / mean_distance).array().square()).exp();
  Law best = usual;
  double least = left_out_error(field, closeness, products, usual);
  const bool halves = field.at.size() > field.here;
  for (const double range : {0.5, 1.0, 2.0}) {
    for (const double nugget : {0.02, 0.1, 0.5}) {
      for (const double symmetry : {0.0, 0.8, 0.95}) {
        if (symmetry > 0.0 && !halves) break;
        const Law law{symmetry, nugget, range * usual.range};
        const double error = left_out_error(field, closeness, products, law);
        if (error >= least) continue;
        least = error;
        best = law;
      }
    }
  }
  return best;
}

/// Ordinary kriging: the weights of the places on the marker's own half add up to 1, those of the
/// other half to 0 (their means may differ).
Eigen::VectorXd kriging_weights(const Field& field, const Eigen::Vector3d& own, const Law& law) {
  const auto n = static_cast<Eigen::Index>(field.at.size());
  const auto here = static_cast<Eigen::Index>(field.here);
  const Eigen::Index halves = here < n ? 2 : 1;
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n + halves, n + halves);
  a.topLeftCorner(n, n) = covariance(field, law);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n + halves);
  b[n] = 1.0;
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Index half = k < here ? n : n + 1;
    a(half, k) = a(k, half) = 1.0;
    b[k] = alike(field.at[static_cast<std::size_t>(k)], own, law) * (k < here ? 1.0 : law.symmetry);
  }
  return a.fullPivLu().solve(b).head(n);
}

/// Whether one of the donors goes farther in the gap than in any row.
bool goes_farther(const Field& field, std::size_t rows) {
  constexpr double farther = 1.2;
  for (Eigen::Index k = 0; k < field.moved.rows(); ++k) {
    double outside = 0.0;
    double inside = 0.0;
    for (Eigen::Index i = 0; 3 * i < field.moved.cols(); ++i) {
      double& most = i < static_cast<Eigen::Index>(rows) ? outside : inside;
      most = std::max(most, field.moved.block<1, 3>(k, 3 * i).norm());
    }
    if (inside > farther * outside) return true;
  }
  return false;
}

}  // namespace

Eigen::MatrixXd spatial_guess(const GuessPlace& place, const Mirror* mirror,
                              const GuessOptions& options) {
  const auto columns = static_cast<Eigen::Index>(place.frames.size());
  Eigen::MatrixXd guess = Eigen::MatrixXd::Zero(columns, 3);
  constexpr std::size_t least = 3;  // fewer say little of the surface between them
  if (place.donors.size() < least || place.rows == 0) return guess;
  Field field = near_field(place, options);
  if (!(field.distance > 0.0)) return guess;
  Law law{0.0, options.nugget, options.range * field.distance};
  if (options.adapt == GuessAdapt::always ||
      (options.adapt == GuessAdapt::where_new && goes_farther(field, place.rows))) {
    if (mirror != nullptr) add_other_half(place, *mirror, options, field);
    const auto gap = static_cast<Eigen::Index>(3 * (place.frames.size() - place.rows));
    law = best_law(field, place.own, gap, law);
  }
  const Eigen::RowVectorXd moved = kriging_weights(field, place.own, law).transpose() * field.moved;
  for (Eigen::Index i = 0; i < columns; ++i) guess.row(i) = moved.segment<3>(3 * i);
  return guess;
}

}  // namespace kinemesh::fill
