#include "analysis/anim_mesh_hog.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "analysis/surface_balls.h"

namespace kinemesh {
namespace {

constexpr std::size_t landmark_count = 32, kernel_points = 160;
constexpr int grid = 12, time_grid = 8, azimuths = 8, elevations = 4, polar_bins = 36;
constexpr double unreached = std::numeric_limits<double>::infinity();

/// Every n-th of `count` so that at most `most` remain; 0 belongs.
std::vector<std::size_t> thinned(std::size_t count, std::size_t most) {
  std::vector<std::size_t> chosen;
  const std::size_t step = (count + most - 1) / most;
  for (std::size_t i = 0; i < count; i += std::max<std::size_t>(step, 1)) chosen.push_back(i);
  return chosen;
}

/// Values at `targets` by Gaussian radial basis functions through values at `points`: targets ×
/// points. `width` is the functions' standard deviation.
Eigen::MatrixXd interpolation(const Eigen::MatrixXd& points, const Eigen::MatrixXd& targets,
                              double width) {
  const auto kernel = [&](const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) -> Eigen::MatrixXd {
    Eigen::MatrixXd k(a.rows(), b.rows());
    for (Eigen::Index i = 0; i < a.rows(); ++i) {
      for (Eigen::Index j = 0; j < b.rows(); ++j) {
        k(i, j) = std::exp(-0.5 * (a.row(i) - b.row(j)).squaredNorm() / (width * width));
      }
    }
    return k;
  };
  Eigen::MatrixXd at_points = kernel(points, points);
  at_points.diagonal().array() += 1e-3;  // points may coincide after flattening
  return at_points.llt().solve(kernel(points, targets)).transpose();
}

/// Smoothing by differences of first and second order that keeps counts positive (Eilers & Goeman
/// 2004, eq. 2), λ = 0.5.
Eigen::MatrixXd smoother(int size, bool periodic) {
  constexpr double lambda = 0.5;
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(size, size);
  Eigen::MatrixXd first = Eigen::MatrixXd::Zero(size, size);
  for (int i = 0; i < (periodic ? size : size - 1); ++i) {
    first(i, i) = -1.0;
    first(i, (i + 1) % size) = 1.0;
  }
  Eigen::MatrixXd second = Eigen::MatrixXd::Zero(size, size);
  for (int i = 0; i < (periodic ? size : size - 2); ++i) {
    second(i, i) = 1.0;
    second(i, (i + 1) % size) = -2.0;
    second(i, (i + 2) % size) = 1.0;
  }
  return (one + lambda * lambda * second.transpose() * second +
          2.0 * lambda * first.transpose() * first)
      .inverse();
}

using Octant = Eigen::Matrix<double, elevations, azimuths>;

void count_direction(const Eigen::Vector3d& gradient, Octant& octant) {
  const double length = gradient.norm();
  if (!(length > 0.0)) return;
  const double theta = std::acos(std::clamp(gradient.z() / length, -1.0, 1.0));
  const double phi = std::atan2(gradient.y(), gradient.x()) + std::numbers::pi;
  const int row = std::min(static_cast<int>(theta / std::numbers::pi * elevations), elevations - 1);
  const int column =
      std::min(static_cast<int>(phi / (2.0 * std::numbers::pi) * azimuths), azimuths - 1);
  constexpr double d_theta = std::numbers::pi / elevations, d_phi = 2 * std::numbers::pi / azimuths;
  const double solid = d_phi * (std::cos(row * d_theta) - std::cos((row + 1) * d_theta));
  octant(row, column) += length / solid;
}

/// The grid's places in [−1, 1].
double coordinate(int i, int size) { return (2.0 * i + 1.0) / size - 1.0; }

Eigen::MatrixXd grid_places() {
  Eigen::MatrixXd places(grid * grid, 2);
  for (int y = 0; y < grid; ++y) {
    for (int x = 0; x < grid; ++x) {
      places.row(y * grid + x) << coordinate(x, grid), coordinate(y, grid);
    }
  }
  return places;
}

/// Gradients by central differences of a volume (places × time_grid) between two moments, counted
/// per octant.
std::array<Octant, 8> count_gradients(const Eigen::MatrixXd& volume, double earliest,
                                      double latest) {
  std::array<Octant, 8> octants;
  for (Octant& o : octants) o.setZero();
  for (int t = 0; t < time_grid; ++t) {
    const double time = coordinate(t, time_grid);
    if (time < earliest || time > latest) continue;
    const int t0 = std::max(t - 1, 0), t1 = std::min(t + 1, time_grid - 1);
    for (int y = 1; y + 1 < grid; ++y) {
      for (int x = 1; x + 1 < grid; ++x) {
        const double px = coordinate(x, grid), py = coordinate(y, grid);
        if (px * px + py * py > 1.0) continue;
        const int at = y * grid + x;
        const Eigen::Vector3d gradient(
            (volume(at + 1, t) - volume(at - 1, t)) * grid / 4.0,
            (volume(at + grid, t) - volume(at - grid, t)) * grid / 4.0,
            (volume(at, t1) - volume(at, t0)) * time_grid / (2.0 * (t1 - t0)));
        const std::size_t octant = (px > 0 ? 1U : 0U) | (py > 0 ? 2U : 0U) | (time > 0 ? 4U : 0U);
        count_direction(gradient, octants[octant]);
      }
    }
  }
  return octants;
}

/// The octants smoothed, one after the other, with a sum of 1; zeros where nothing changes.
std::vector<float> normalised(std::array<Octant, 8> octants) {
  static const Eigen::MatrixXd across = smoother(elevations, false),
                               along = smoother(azimuths, true);
  std::vector<float> result(8 * elevations * azimuths, 0.0F);
  double total = 0.0;
  for (Octant& o : octants) {
    o = (across * o * along.transpose()).cwiseMax(0.0).eval();
    total += o.sum();
  }
  if (!(total > 0.0)) return result;
  std::size_t next = 0;
  for (const Octant& o : octants) {
    for (int e = 0; e < elevations; ++e) {
      for (int a = 0; a < azimuths; ++a) result[next++] = static_cast<float>(o(e, a) / total);
    }
  }
  return result;
}

}  // namespace

struct AnimMeshHog::Patch {
  std::vector<VertexIndex> vertices;   // the feature first, then by path length
  std::vector<FaceIndex> faces;        // with all corners in the patch
  std::vector<std::size_t> local;      // per corner of each face: index into vertices
  std::vector<Eigen::Vector2d> plane;  // flattened, the feature at the origin
  double radius = 0.0;
};

AnimMeshHog::AnimMeshHog(const AnimatedMesh& animation, const DeformationResult& deformation,
                         double patch)
    : animation_(animation),
      deformation_(deformation),
      patch_(patch),
      normals_(vertex_normals(animation.topology(), deformation.rest)) {}

AnimMeshHog::Patch AnimMeshHog::make_patch(const Feature& feature) const {
  const Topology& topology = animation_.topology();
  Patch patch;
  patch.radius = std::max(patch_ * feature.sigma_mm, 2.5 * deformation_.mean_edge_mm);
  // Grown from the feature over vertices that look the same way, by length of path.
  std::vector<double> path(topology.vertex_count(), unreached);
  std::vector<std::pair<double, VertexIndex>> queue{{0.0, feature.vertex}};
  path[feature.vertex] = 0.0;
  while (!queue.empty()) {
    std::pop_heap(queue.begin(), queue.end(), std::greater<>());
    const auto [length, v] = queue.back();
    queue.pop_back();
    if (length > path[v]) continue;
    patch.vertices.push_back(v);
    for (const VertexIndex n : topology.neighbours_of(v)) {
      const double next = length + (deformation_.rest[n] - deformation_.rest[v]).norm();
      if (next > patch.radius || next >= path[n]) continue;
      if (!(normals_[n].dot(normals_[feature.vertex]) > 0.0)) continue;
      path[n] = next;
      queue.emplace_back(next, n);
      std::push_heap(queue.begin(), queue.end(), std::greater<>());
    }
  }
  std::vector<std::size_t> index(topology.vertex_count(), patch.vertices.size());
  for (std::size_t i = 0; i < patch.vertices.size(); ++i) index[patch.vertices[i]] = i;
  for (const VertexIndex v : patch.vertices) {
    for (const FaceIndex t : topology.faces_of(v)) {
      const Triangle& face = topology.faces()[t];
      const bool inside = std::all_of(face.begin(), face.end(), [&](VertexIndex c) {
        return index[c] < patch.vertices.size();
      });
      if (!inside || *std::min_element(face.begin(), face.end()) != v) continue;
      patch.faces.push_back(t);
      for (const VertexIndex c : face) patch.local.push_back(index[c]);
    }
  }
  return patch;
}

/// Landmark isomap: distances along edges from some vertices of the patch, their plane by classical
/// scaling, and every other vertex by its distances.
void AnimMeshHog::flatten(Patch& patch) const {
  const std::size_t count = patch.vertices.size();
  std::vector<std::vector<std::pair<std::size_t, double>>> ring(count);
  for (std::size_t i = 0; i < patch.local.size(); i += 3) {
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t a = patch.local[i + c], b = patch.local[i + (c + 1) % 3];
      const double length =
          (deformation_.rest[patch.vertices[a]] - deformation_.rest[patch.vertices[b]]).norm();
      ring[a].emplace_back(b, length);
      ring[b].emplace_back(a, length);
    }
  }
  const std::vector<std::size_t> landmarks = thinned(count, landmark_count);
  const auto marks = static_cast<Eigen::Index>(landmarks.size());
  Eigen::MatrixXd squared(marks, static_cast<Eigen::Index>(count));
  std::vector<std::pair<double, std::size_t>> queue;
  std::vector<double> distance;
  for (Eigen::Index m = 0; m < marks; ++m) {
    distance.assign(count, unreached);
    const std::size_t start = landmarks[static_cast<std::size_t>(m)];
    distance[start] = 0.0;
    queue.assign(1, {0.0, start});
    while (!queue.empty()) {
      std::pop_heap(queue.begin(), queue.end(), std::greater<>());
      const auto [length, v] = queue.back();
      queue.pop_back();
      if (length > distance[v]) continue;
      for (const auto& [n, edge] : ring[v]) {
        if (length + edge >= distance[n]) continue;
        distance[n] = length + edge;
        queue.emplace_back(distance[n], n);
        std::push_heap(queue.begin(), queue.end(), std::greater<>());
      }
    }
    for (std::size_t i = 0; i < count; ++i) {
      const double d = std::min(distance[i], 4.0 * patch.radius);
      squared(m, static_cast<Eigen::Index>(i)) = d * d;
    }
  }
  Eigen::MatrixXd among(marks, marks);
  for (Eigen::Index m = 0; m < marks; ++m) {
    among.col(m) = squared.col(static_cast<Eigen::Index>(landmarks[static_cast<std::size_t>(m)]));
  }
  among = (0.5 * (among + among.transpose())).eval();
  const Eigen::VectorXd mean = among.rowwise().mean();
  const Eigen::MatrixXd centring = Eigen::MatrixXd::Identity(marks, marks) -
                                   Eigen::MatrixXd::Constant(marks, marks, 1.0 / marks);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(-0.5 * centring * among * centring);
  patch.plane.assign(count, Eigen::Vector2d::Zero());
  for (int axis = 0; axis < 2; ++axis) {
    const double value = solver.eigenvalues()[marks - 1 - axis];
    if (!(value > 1e-12 * patch.radius * patch.radius)) continue;
    const Eigen::VectorXd pseudo = solver.eigenvectors().col(marks - 1 - axis) / std::sqrt(value);
    for (std::size_t i = 0; i < count; ++i) {
      patch.plane[i][axis] = -0.5 * pseudo.dot(squared.col(static_cast<Eigen::Index>(i)) - mean);
    }
  }
  const Eigen::Vector2d origin = patch.plane[0];
  for (Eigen::Vector2d& p : patch.plane) p -= origin;
}

/// Not mirrored, and the dominant gradient of deformation along x.
void AnimMeshHog::align(Patch& patch, std::size_t frame) const {
  const auto turned = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() * b.y() - a.y() * b.x();
  };
  double area = 0.0;
  for (std::size_t i = 0; i < patch.local.size(); i += 3) {
    area += turned(patch.plane[patch.local[i + 1]] - patch.plane[patch.local[i]],
                   patch.plane[patch.local[i + 2]] - patch.plane[patch.local[i]]);
  }
  if (area < 0.0) {
    for (Eigen::Vector2d& p : patch.plane) p.y() = -p.y();
  }
  std::array<double, polar_bins> votes{};
  const auto value = [&](std::size_t i) {
    return static_cast<double>(deformation_.values.of(patch.vertices[i])[frame]);
  };
  for (std::size_t i = 0; i < patch.local.size(); i += 3) {
    const std::size_t a = patch.local[i], b = patch.local[i + 1], c = patch.local[i + 2];
    const Eigen::Vector2d u = patch.plane[b] - patch.plane[a], v = patch.plane[c] - patch.plane[a];
    const double twice = turned(u, v);
    if (!(std::abs(twice) > 1e-9 * patch.radius * patch.radius / 100.0)) continue;
    // Gradient times area of the linear function over the triangle.
    const Eigen::Vector2d g = (value(b) - value(a)) * Eigen::Vector2d(v.y(), -v.x()) +
                              (value(c) - value(a)) * Eigen::Vector2d(-u.y(), u.x());
    const double angle = std::atan2(g.y(), g.x()) + std::numbers::pi;
    const auto bin = static_cast<std::size_t>(angle / (2 * std::numbers::pi) * polar_bins);
    votes[std::min<std::size_t>(bin, polar_bins - 1)] += g.norm();
  }
  std::size_t best = 0;
  double most = -1.0;
  for (std::size_t b = 0; b < polar_bins; ++b) {
    const double sum =
        votes[b] + 0.5 * (votes[(b + 1) % polar_bins] + votes[(b + polar_bins - 1) % polar_bins]);
    if (sum > most) best = b;
    most = std::max(most, sum);
  }
  const double angle =
      (static_cast<double>(best) + 0.5) * 2 * std::numbers::pi / polar_bins - std::numbers::pi;
  const Eigen::Rotation2Dd turn(-angle);
  for (Eigen::Vector2d& p : patch.plane) p = turn * p;
}

/// The frames of a feature's volume; beyond the animation's ends there is none.
struct AnimMeshHog::Moments {
  std::vector<std::size_t> frames;
  double half = 0.0;  ///< of the volume's duration, in frames
  double step = 0.0;  ///< between the frames, in `half`
  static Moments of(const Feature& feature, const AnimatedMesh& animation, double patch_size);
  double time_of(std::size_t frame, const Feature& feature) const {
    return (static_cast<double>(frame) - feature.frame) / half;
  }
};

AnimMeshHog::Moments AnimMeshHog::Moments::of(const Feature& feature, const AnimatedMesh& animation,
                                              double patch_size) {
  const double rate = animation.rate_hz > 0 ? animation.rate_hz : 1.0;
  Moments result{.frames = {}, .half = std::max(patch_size * feature.tau_s * rate, 2.0)};
  const auto last = static_cast<double>(animation.frame_count()) - 1.0;
  const auto from =
      static_cast<std::size_t>(std::max(0.0, std::floor(feature.frame - result.half)));
  const auto to = static_cast<std::size_t>(std::min(last, std::ceil(feature.frame + result.half)));
  const std::size_t stride = std::max<std::size_t>((to - from) / 48, 1);
  for (std::size_t f = from; f <= to; f += stride) result.frames.push_back(f);
  result.step = static_cast<double>(stride) / result.half;
  return result;
}

std::vector<float> AnimMeshHog::histogram(const Feature& feature) const {
  Patch patch = make_patch(feature);
  if (patch.vertices.size() < 4 || patch.local.empty()) {
    return std::vector<float>(8 * elevations * azimuths, 0.0F);
  }
  flatten(patch);
  align(patch, feature.frame);
  const Moments moments = Moments::of(feature, animation_, patch_);
  const Eigen::MatrixXd volume = volume_of(patch, feature, moments);
  return normalised(
      count_gradients(volume, moments.time_of(moments.frames.front(), feature) - moments.step,
                      moments.time_of(moments.frames.back(), feature) + moments.step));
}

/// Deformation on the regular grid in space and time: places × time_grid.
Eigen::MatrixXd AnimMeshHog::volume_of(const Patch& patch, const Feature& feature,
                                       const Moments& moments) const {
  const std::vector<std::size_t> chosen = thinned(patch.vertices.size(), kernel_points);
  const auto count = static_cast<Eigen::Index>(chosen.size());
  const auto frames = static_cast<Eigen::Index>(moments.frames.size());
  Eigen::MatrixXd points(count, 2), times(frames, 1), time_places(time_grid, 1);
  for (Eigen::Index i = 0; i < count; ++i) {
    points.row(i) = patch.plane[chosen[static_cast<std::size_t>(i)]].transpose() / patch.radius;
  }
  const double spacing = std::sqrt(std::numbers::pi / static_cast<double>(chosen.size()));
  const Eigen::MatrixXd in_space =
      interpolation(points, grid_places(), std::max(2.0 / grid, spacing));
  Eigen::MatrixXd values(count, frames);
  for (Eigen::Index m = 0; m < frames; ++m) {
    const std::size_t f = moments.frames[static_cast<std::size_t>(m)];
    times(m, 0) = moments.time_of(f, feature);
    for (Eigen::Index i = 0; i < count; ++i) {
      const VertexIndex v = patch.vertices[chosen[static_cast<std::size_t>(i)]];
      values(i, m) = static_cast<double>(deformation_.values.of(v)[f]);
    }
  }
  for (int t = 0; t < time_grid; ++t) time_places(t, 0) = coordinate(t, time_grid);
  const Eigen::MatrixXd in_time =
      interpolation(times, time_places, std::max(2.0 / time_grid, 1.5 * moments.step));
  values.array() -= values.mean();
  return in_space * values * in_time.transpose();
}

}  // namespace kinemesh
