#include "reconstruct/retarget.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "config/error.h"
#include "config/parallel.h"
#include "mesh/closest_point.h"
#include "mesh/laplacian.h"
#include "mesh/surface_map_io.h"

namespace kinemesh {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Points = std::vector<Vector3d>;
using Sparse = Eigen::SparseMatrix<double>;
using Clock = std::chrono::steady_clock;

double since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

Points points_of(const std::vector<Eigen::Vector3f>& positions) {
  Points points;
  for (const auto& p : positions) points.push_back(p.cast<double>());
  return points;
}

/// Two edges and the unit normal as columns: what a deformation gradient maps.
Matrix3d frame_of(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  Matrix3d frame;
  const Vector3d normal = (b - a).cross(c - a);
  const double length = normal.norm();
  frame << b - a, c - a, length > 0.0 ? Vector3d(normal / length) : Vector3d::Zero();
  return frame;
}

double area_of(const Points& p, const Triangle& t) {
  return 0.5 * (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]).norm();
}

double total_area(const Points& p, const std::vector<Triangle>& faces) {
  double sum = 0.0;
  for (const Triangle& t : faces) sum += area_of(p, t);
  return sum;
}

double longest_edge(const Points& p, const Triangle& t) {
  return std::max(
      {(p[t[0]] - p[t[1]]).norm(), (p[t[1]] - p[t[2]]).norm(), (p[t[2]] - p[t[0]]).norm()});
}

/// For each target face the source face that lies on it: the closest one of the source mesh laid
/// over the target by the map.
std::vector<FaceIndex> corresponding_faces(const Topology& source, const Topology& target,
                                           const Points& target_rest, const SurfaceMap& map,
                                           const RunContext& ctx) {
  Points laid(source.vertex_count(), Vector3d::Constant(std::nan("")));
  for (std::size_t v = 0; v < laid.size(); ++v) {
    if (map.points[v].valid()) laid[v] = position_of(map.points[v], target, target_rest);
  }
  const ClosestPointSearch search(laid, source.faces());
  const double edge = std::sqrt(4.0 / std::sqrt(3.0) * total_area(target_rest, target.faces()) /
                                static_cast<double>(std::max<std::size_t>(1, target.face_count())));
  // A source face that is stretched over what is round cuts through it, as far off as it is long.
  const auto lies_on = [&](const ClosestHit& hit) {
    return hit.point.valid() &&
           hit.distance <= std::max(3.0 * edge, longest_edge(laid, source.faces()[hit.point.face]));
  };
  std::vector<FaceIndex> result(target.face_count(), invalid_index);
  parallel_for(ctx, result.size(), 256, [&](std::size_t f) {
    const Triangle& t = target.faces()[f];
    const Vector3d centre = (target_rest[t[0]] + target_rest[t[1]] + target_rest[t[2]]) / 3.0;
    const Vector3d normal =
        (target_rest[t[1]] - target_rest[t[0]]).cross(target_rest[t[2]] - target_rest[t[0]]);
    ClosestHit hit = search.closest(centre, std::numeric_limits<double>::infinity(), &normal);
    if (!lies_on(hit)) hit = search.closest(centre);
    if (lies_on(hit)) result[f] = hit.point.face;
  });
  return result;
}

/// Target faces without a source that hang together, and the source faces on the border they share
/// with others: what the source has no counterpart of, as an elephant's trunk for a horse.
struct Patches {
  std::vector<std::vector<FaceIndex>> borders;  // source faces, once per shared edge
  std::vector<FaceIndex> of_face;               // per target face: its patch, or invalid_index
};

Patches patches_of(const Topology& target, const std::vector<FaceIndex>& from) {
  Patches patches;
  patches.of_face.assign(from.size(), invalid_index);
  std::vector<FaceIndex> waiting;
  for (FaceIndex start = 0; start < from.size(); ++start) {
    if (from[start] != invalid_index || patches.of_face[start] != invalid_index) continue;
    const auto patch = static_cast<FaceIndex>(patches.borders.size());
    patches.borders.emplace_back();
    patches.of_face[start] = patch;
    waiting.push_back(start);
    while (!waiting.empty()) {
      const FaceIndex face = waiting.back();
      waiting.pop_back();
      for (HalfedgeIndex h = 3 * face; h < 3 * face + 3; ++h) {
        if (target.twin(h) == invalid_index) continue;
        const FaceIndex across = target.twin(h) / 3;
        if (from[across] != invalid_index) {
          patches.borders[patch].push_back(from[across]);
        } else if (patches.of_face[across] == invalid_index) {
          patches.of_face[across] = patch;
          waiting.push_back(across);
        }
      }
    }
  }
  return patches;
}

/// The rotation nearest to a gradient (polar decomposition).
Matrix3d rotation_of(const Matrix3d& gradient) {
  const Eigen::JacobiSVD<Matrix3d> svd(gradient, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d u = svd.matrixU();
  const Matrix3d& v = svd.matrixV();
  if ((u * v.transpose()).determinant() < 0.0) u.col(2) = -u.col(2);
  return u * v.transpose();
}

class Transfer {
 public:
  Transfer(const Topology& source, const Points& source_rest, const Topology& target,
           const Points& target_rest, std::vector<FaceIndex> from)
      : source_(source),
        target_(target),
        target_rest_(target_rest),
        from_(std::move(from)),
        patches_(patches_of(target, from_)) {
    for (FaceIndex f = 0; f < from_.size(); ++f) {
      if (from_[f] != invalid_index) continue;
      from_[f] = static_cast<FaceIndex>(source.face_count()) + patches_.of_face[f];
    }
    for (FaceIndex f = 0; f < source.face_count(); ++f) {
      const Triangle& t = source.faces()[f];
      const Matrix3d frame = frame_of(source_rest[t[0]], source_rest[t[1]], source_rest[t[2]]);
      Matrix3d inverse = Matrix3d::Zero();
      bool sound = false;
      double determinant = 0.0;
      frame.computeInverseAndDetWithCheck(inverse, determinant, sound, 1e-12);
      inverses_.push_back(sound ? inverse : Matrix3d(Matrix3d::Zero()));
    }
    factorise();
  }

  /// Target positions of one frame; `moved` are the source's.
  Eigen::MatrixXd solve(const Points& moved) const {
    std::vector<Matrix3d> gradients(source_.face_count());
    for (FaceIndex f = 0; f < gradients.size(); ++f) {
      const Triangle& t = source_.faces()[f];
      gradients[f] = inverses_[f].isZero()
                         ? Matrix3d(Matrix3d::Identity())
                         : Matrix3d(frame_of(moved[t[0]], moved[t[1]], moved[t[2]]) * inverses_[f]);
    }
    for (const std::vector<FaceIndex>& border : patches_.borders) {
      Matrix3d sum = Matrix3d::Zero();
      for (const FaceIndex f : border) sum += gradients[f];
      gradients.push_back(border.empty() ? Matrix3d(Matrix3d::Identity()) : rotation_of(sum));
    }
    // Gᵀ A S for displacements: the rest shape solves it for S = 1.
    Eigen::MatrixXd right = Eigen::MatrixXd::Zero(static_cast<Index>(target_rest_.size()), 3);
    for (FaceIndex f = 0; f < target_.face_count(); ++f) {
      const Matrix3d change = gradients[from_[f]] - Matrix3d::Identity();
      const Triangle& t = target_.faces()[f];
      for (std::size_t c = 0; c < 3; ++c) {
        const Vector3d &p = target_rest_[t[(c + 1) % 3]], &q = target_rest_[t[(c + 2) % 3]];
        const Vector3d u = p - target_rest_[t[c]], v = q - target_rest_[t[c]];
        const double doubled = u.cross(v).norm();
        const double cotangent = doubled > 0.0 ? std::clamp(u.dot(v) / doubled, -1e3, 1e3) : 0.0;
        const Vector3d flow = 0.5 * cotangent * (change * (p - q));
        right.row(static_cast<Index>(t[(c + 1) % 3])) += flow.transpose();
        right.row(static_cast<Index>(t[(c + 2) % 3])) -= flow.transpose();
      }
    }
    return solver_.solve(right);
  }

 private:
  void factorise() {
    const auto count = static_cast<Index>(target_rest_.size());
    std::vector<Eigen::Triplet<double>> entries;
    double mean = 0.0;
    for (const Triangle& t : target_.faces()) {
      for (std::size_t c = 0; c < 3; ++c) {
        const auto i = static_cast<int>(t[(c + 1) % 3]), j = static_cast<int>(t[(c + 2) % 3]);
        const Vector3d u = target_rest_[t[(c + 1) % 3]] - target_rest_[t[c]];
        const Vector3d v = target_rest_[t[(c + 2) % 3]] - target_rest_[t[c]];
        const double doubled = u.cross(v).norm();
        const double cotangent = doubled > 0.0 ? std::clamp(u.dot(v) / doubled, -1e3, 1e3) : 0.0;
        const double w = 0.5 * cotangent;
        mean += std::abs(w);
        entries.insert(entries.end(), {{i, i, w}, {j, j, w}, {i, j, -w}, {j, i, -w}});
      }
    }
    mean /= static_cast<double>(std::max<std::size_t>(1, 3 * target_.face_count()));
    // One vertex of every component is held, and every vertex without faces.
    std::vector<bool> seen(target_rest_.size(), false);
    for (VertexIndex v = 0; v < seen.size(); ++v) {
      if (seen[v]) continue;
      entries.emplace_back(static_cast<int>(v), static_cast<int>(v), mean);
      std::vector<VertexIndex> waiting{v};
      seen[v] = true;
      while (!waiting.empty()) {
        const VertexIndex at = waiting.back();
        waiting.pop_back();
        for (const VertexIndex n : target_.neighbours_of(at)) {
          if (!seen[n]) waiting.push_back(n);
          seen[n] = true;
        }
      }
    }
    Sparse system(count, count);
    system.setFromTriplets(entries.begin(), entries.end());
    solver_.compute(system);
    if (solver_.info() != Eigen::Success) {
      throw NoResultError({.what = "the target mesh cannot be factorised",
                           .remedy = "Remesh it: its triangles are too ill-shaped"});
    }
  }

  const Topology &source_, &target_;
  const Points& target_rest_;
  std::vector<FaceIndex> from_;  // source faces, and behind them the patches
  Patches patches_;
  std::vector<Matrix3d> inverses_;
  Eigen::SimplicialLDLT<Sparse> solver_;
};

/// Per source vertex, how well it tells the translation: the stiller, the better.
std::vector<double> stillness(const AnimatedMesh& source, const Points& rest,
                              const SurfaceMap& map) {
  std::vector<double> weights(rest.size(), 0.0);
  for (VertexIndex v = 0; v < rest.size(); ++v) {
    if (!map.points[v].valid() || source.topology().faces_of(v).empty()) continue;
    double sum = 0.0;
    for (std::size_t f = 0; f < source.frame_count(); ++f) {
      sum += (source.position(f, v).cast<double>() - rest[v]).squaredNorm();
    }
    const double mean = sum / static_cast<double>(std::max<std::size_t>(1, source.frame_count()));
    weights[v] = 1.0 / (0.01 + mean);
  }
  return weights;
}

void check(const AnimatedMesh& source, const Mesh& source_rest, const Mesh& target_rest,
           const SurfaceMap& map) {
  if (!source_rest.topology || !target_rest.topology ||
      !(source.topology() == *source_rest.topology)) {
    throw InputError({.what = "the animation and the source's rest mesh differ in their faces",
                      .remedy = "Give the rest shape of the same mesh, for example one frame of "
                                "the animation"});
  }
  check_surface_map(map, *source_rest.topology, *target_rest.topology);
  for (const Mesh* mesh : {&source_rest, &target_rest}) {
    if (!std::ranges::all_of(mesh->positions, [](const auto& p) { return p.allFinite(); })) {
      throw InputError({.what = "a vertex of a rest mesh is not finite", .remedy = "Repair it"});
    }
  }
}

}  // namespace

RetargetResult retarget(const AnimatedMesh& source, const Mesh& source_rest,
                        const Mesh& target_rest, const SurfaceMap& map, const RunContext& ctx) {
  check(source, source_rest, target_rest, map);
  const Topology &from = *source_rest.topology, &to = *target_rest.topology;
  const Points rest = points_of(source_rest.positions), target = points_of(target_rest.positions);
  std::vector<FaceIndex> faces = corresponding_faces(from, to, target, map, ctx);
  RetargetResult result;
  result.faces_without_source = static_cast<std::size_t>(std::ranges::count(faces, invalid_index));
  if (result.faces_without_source == faces.size()) {
    throw NoResultError({.what = "no face of the target lies near a mapped face of the source",
                         .remedy = "Check the direction of the map: source to target"});
  }
  const double source_area = total_area(rest, from.faces());
  result.scale = std::sqrt(total_area(target, to.faces()) / std::max(source_area, 1e-12));
  auto start = Clock::now();
  const Transfer transfer(from, rest, to, target, std::move(faces));
  result.factor_seconds = since(start);
  start = Clock::now();
  result.animation = AnimatedMesh(target_rest.topology, source.frame_count(), source.rate_hz);
  const std::vector<double> still = stillness(source, rest, map);
  parallel_for(ctx.part(0.1, 1.0, "transferring"), source.frame_count(), 1, [&](std::size_t f) {
    Points moved;
    for (VertexIndex v = 0; v < rest.size(); ++v) {
      moved.push_back(source.position(f, v).cast<double>());
    }
    const Eigen::MatrixXd moves = transfer.solve(moved);
    Vector3d offset = Vector3d::Zero();
    double weights = 0.0;
    for (VertexIndex v = 0; v < rest.size(); ++v) {
      if (still[v] == 0.0) continue;
      const Triangle& t = to.faces()[map.points[v].face];
      Vector3d here = Vector3d::Zero();
      for (std::size_t c = 0; c < 3; ++c) {
        here += map.points[v].weights[c] * moves.row(static_cast<Index>(t[c])).transpose();
      }
      offset += still[v] * (result.scale * (moved[v] - rest[v]) - here);
      weights += still[v];
    }
    if (weights > 0.0) offset /= weights;
    for (VertexIndex v = 0; v < target.size(); ++v) {
      const Vector3d move = moves.row(static_cast<Index>(v)).transpose() + offset;
      result.animation.position(f, v) = (target[v] + move).cast<float>();
    }
  });
  result.frames_seconds = since(start);
  result.animation.first_frame = source.first_frame;
  result.animation.events = source.events;
  result.animation.vertex_names = target_rest.vertex_names;
  return result;
}

}  // namespace kinemesh
