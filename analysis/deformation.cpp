#include "analysis/deformation.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "analysis/strain.h"
#include "config/error.h"
#include "config/parallel.h"

namespace kinemesh {
namespace {

using strain::Block;

constexpr std::size_t vertex_grain = 128;
constexpr std::size_t block_frames = 64;

void check_finite(const AnimatedMesh& animation) {
  const auto positions = animation.positions();
  const std::size_t count = animation.vertex_count();
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (std::isfinite(positions[i])) continue;
    throw InputError(
        {.what = "the position of vertex " + std::to_string(i / 3 % count) + " is no finite number",
         .frame = static_cast<int64_t>(i / 3 / count) + animation.first_frame,
         .remedy = "Fill the gaps first, for instance with kinemesh convert"});
  }
}

std::vector<double> gaussian(double deviation) {
  std::vector<double> weights{1.0};
  if (!(deviation > 0.0)) return weights;
  const int reach = static_cast<int>(std::ceil(3.0 * deviation));
  weights.assign(2 * static_cast<std::size_t>(reach) + 1, 0.0);
  double sum = 0.0;
  for (int i = -reach; i <= reach; ++i) {
    sum += weights[static_cast<std::size_t>(i + reach)] =
        std::exp(-0.5 * i * i / (deviation * deviation));
  }
  for (double& w : weights) w /= sum;
  return weights;
}

/// Reads positions relative to each frame's centroid, smoothed over time. Frames are turned onto
/// `still` before: the mean of a turning body is smaller than the body.
class Positions {
 public:
  Positions(const AnimatedMesh& animation, double smoothing, std::size_t still)
      : animation_(animation), kernel_(gaussian(smoothing)) {
    for (std::size_t f = 0; f < animation.frame_count(); ++f) {
      centres_.push_back(animation.frame(f).cast<double>().colwise().mean().transpose());
    }
    turns_.assign(animation.frame_count(), Eigen::Matrix3d::Identity());
    if (reach() == 0 || still >= animation.frame_count()) return;
    const Eigen::MatrixX3d onto =
        animation.frame(still).cast<double>().rowwise() - centres_[still].transpose();
    for (std::size_t f = 0; f < animation.frame_count(); ++f) {
      if (f != still) turns_[f] = turn_of(f, onto);
    }
  }

  Eigen::Vector3d at(std::size_t frame, VertexIndex v) const {
    return smoothed(frame, [&](std::size_t f) { return raw(f, v); });
  }

  void fill(Block& block, std::size_t first, std::size_t frames, const RunContext& ctx) const {
    block.stride = frames;
    block.positions.resize(3 * animation_.vertex_count() * frames);
    parallel_for(ctx, animation_.vertex_count(), vertex_grain, [&](std::size_t v) {
      float* row = block.positions.data() + 3 * v * frames;
      // Each position is read once, however wide the kernel.
      thread_local std::vector<Eigen::Vector3d> read;
      const std::size_t begin = first - std::min(first, reach());
      const std::size_t end = std::min(first + frames + reach(), animation_.frame_count());
      read.clear();
      for (std::size_t f = begin; f < end; ++f) {
        read.push_back(raw(f, static_cast<VertexIndex>(v)));
      }
      for (std::size_t f = 0; f < frames; ++f) {
        const Eigen::Vector3f p =
            smoothed(
                first + f, [&](std::size_t g) -> const auto& { return read[g - begin]; })
                .cast<float>();
        for (std::size_t axis = 0; axis < 3; ++axis) {
          row[axis * frames + f] = p[static_cast<Eigen::Index>(axis)];
        }
      }
    });
  }

 private:
  std::size_t reach() const { return kernel_.size() / 2; }
  Eigen::Vector3d raw(std::size_t frame, VertexIndex v) const {
    return turns_[frame] * (animation_.position(frame, v).cast<double>() - centres_[frame]);
  }
  /// The rotation that lays a frame over these centred positions best (Kabsch 1976).
  Eigen::Matrix3d turn_of(std::size_t frame, const Eigen::MatrixX3d& onto) const {
    const Eigen::MatrixX3d here =
        animation_.frame(frame).cast<double>().rowwise() - centres_[frame].transpose();
    const Eigen::Matrix3d covariance = here.transpose() * onto;
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                                Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Vector3d signs = Eigen::Vector3d::Ones();
    if ((svd.matrixV() * svd.matrixU().transpose()).determinant() < 0.0) signs[2] = -1.0;
    return svd.matrixV() * signs.asDiagonal() * svd.matrixU().transpose();
  }
  /// Over the frames that there are: repeating the first and last would keep their noise.
  template <class Read>
  Eigen::Vector3d smoothed(std::size_t frame, Read read) const {
    const std::size_t begin = frame - std::min(frame, reach());
    const std::size_t end = std::min(frame + reach() + 1, animation_.frame_count());
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double weights = 0.0;
    for (std::size_t f = begin; f < end; ++f) {
      const double weight = kernel_[f + reach() - frame];
      weights += weight;
      sum += weight * read(f);
    }
    return sum / weights;
  }

  const AnimatedMesh& animation_;
  std::vector<double> kernel_;
  std::vector<Eigen::Vector3d> centres_;
  std::vector<Eigen::Matrix3d> turns_;
};

std::vector<Eigen::Vector3d> pose_of(const Positions& positions, std::size_t frame,
                                     std::size_t vertices) {
  std::vector<Eigen::Vector3d> pose(vertices);
  for (std::size_t v = 0; v < vertices; ++v) {
    pose[v] = positions.at(frame, static_cast<VertexIndex>(v));
  }
  return pose;
}

/// The mean of all frames, each laid over the first one rigidly.
std::vector<Eigen::Vector3d> mean_pose(const Positions& positions, std::size_t frames,
                                       std::size_t vertices) {
  const auto matrix_of = [&](const std::vector<Eigen::Vector3d>& pose) {
    return Eigen::Map<const Eigen::Matrix3Xd>(pose.front().data(), 3,
                                              static_cast<Eigen::Index>(pose.size()));
  };
  const auto first = pose_of(positions, 0, vertices);
  std::vector<Eigen::Vector3d> mean(vertices, Eigen::Vector3d::Zero());
  for (std::size_t f = 0; f < frames; ++f) {
    const auto pose = pose_of(positions, f, vertices);
    const Eigen::Matrix4d lay = Eigen::umeyama(matrix_of(pose), matrix_of(first), false);
    for (std::size_t v = 0; v < vertices; ++v) {
      mean[v] += (lay.topLeftCorner<3, 3>() * pose[v] + lay.topRightCorner<3, 1>()) /
                 static_cast<double>(frames);
    }
  }
  return mean;
}

std::vector<Eigen::Vector3d> other_rest(const Mesh& rest, std::size_t vertices) {
  if (rest.positions.size() != vertices) {
    throw InputError({.what = "the rest pose has " + std::to_string(rest.positions.size()) +
                              " vertices, but the animation " + std::to_string(vertices),
                      .remedy = "Give a take of the same subject with the same connectivity"});
  }
  std::vector<Eigen::Vector3d> pose;
  for (const Eigen::Vector3f& p : rest.positions) {
    if (!p.allFinite()) {
      throw InputError({.what = "the rest pose holds a position that is no finite number",
                        .place = "vertex " + std::to_string(pose.size())});
    }
    pose.push_back(p.cast<double>());
  }
  return pose;
}

std::vector<Eigen::Vector3d> rest_pose(const AnimatedMesh& animation, const Positions& positions,
                                       const DeformationOptions& options, const Mesh* rest) {
  if (rest != nullptr) return other_rest(*rest, animation.vertex_count());
  if (options.rest == RestPose::mean) {
    return mean_pose(positions, animation.frame_count(), animation.vertex_count());
  }
  if (static_cast<std::size_t>(options.rest_frame) >= animation.frame_count()) {
    throw UsageError(
        {.what = "there is no frame " + std::to_string(options.rest_frame) +
                 " to take the rest pose from",
         .remedy = "Frames count from 0 to " + std::to_string(animation.frame_count() - 1)});
  }
  return pose_of(positions, static_cast<std::size_t>(options.rest_frame), animation.vertex_count());
}

/// What is the same for every block of frames.
struct Stage {
  const Topology& topology;
  const DeformationOptions& options;
  const RunContext& ctx;
  strain::Stencils stencils;        // of the ball, or of the 1-ring for directions
  strain::RestTriangles triangles;  // of the thesis' strain
  VertexLists curvature_balls;
  std::vector<float> rest_curvature;
  float curvature_factor = 0.0F;  // α × unit of length
};

/// Strain of each triangle, averaged over those around a vertex.
void triangle_strain(const Stage& stage, const Block& block, std::size_t first,
                     VertexCurves& values) {
  const std::size_t frames = block.stride;
  std::vector<float> of_face(stage.topology.face_count() * frames, 0.0F);
  parallel_for(stage.ctx, stage.topology.face_count(), vertex_grain, [&](std::size_t t) {
    if (stage.triangles.valid[t] == 0) return;
    thread_local std::vector<float> tensor;
    tensor.resize(3 * frames);
    strain::stretch_of_face(stage.triangles, stage.topology, block, t, tensor.data());
    strain::measure_row(tensor.data(), frames, stage.options.measure,
                        static_cast<float>(stage.options.root_floor), &of_face[t * frames]);
  });
  parallel_for(stage.ctx, values.vertex_count, vertex_grain, [&](std::size_t v) {
    float* out = values.of(v).data() + first;
    std::fill(out, out + frames, 0.0F);
    std::size_t count = 0;
    for (const FaceIndex t : stage.topology.faces_of(static_cast<VertexIndex>(v))) {
      if (stage.triangles.valid[t] == 0) continue;
      ++count;
      for (std::size_t f = 0; f < frames; ++f) out[f] += of_face[t * frames + f];
    }
    if (count == 0) return;
    const float scale = 1.0F / static_cast<float>(count);
    for (std::size_t f = 0; f < frames; ++f) out[f] *= scale;
  });
}

void ball_strain(const Stage& stage, const Block& block, std::size_t first, VertexCurves& values) {
  parallel_for(stage.ctx, values.vertex_count, vertex_grain, [&](std::size_t v) {
    thread_local std::vector<float> tensor;
    tensor.resize(3 * block.stride);
    strain::stretch_of_vertex(stage.stencils, block, v, tensor.data());
    strain::measure_row(tensor.data(), block.stride, stage.options.measure,
                        static_cast<float>(stage.options.root_floor), values.of(v).data() + first);
  });
}

/// Curvature of each vertex, 1/mm: vertices × stride.
std::vector<float> curvature_of(const Stage& stage, const Block& block) {
  const std::size_t frames = block.stride, count = stage.topology.vertex_count();
  std::vector<float> bend, area, curvature(count * frames, 0.0F);
  strain::bend_at_vertices(stage.topology, block, bend, area, stage.ctx);
  parallel_for(stage.ctx, count, vertex_grain, [&](std::size_t v) {
    thread_local std::vector<float> total;
    total.assign(frames, 0.0F);
    float* out = &curvature[v * frames];
    for (const VertexIndex j : stage.curvature_balls.of(v)) {
      const std::size_t row = j * frames;
      for (std::size_t f = 0; f < frames; ++f) {
        out[f] += bend[row + f];
        total[f] += area[row + f];
      }
    }
    for (std::size_t f = 0; f < frames; ++f) out[f] = total[f] > 0.0F ? out[f] / total[f] : 0.0F;
  });
  return curvature;
}

void add_curvature_change(const Stage& stage, const Block& block, std::size_t first,
                          VertexCurves& values) {
  const std::vector<float> curvature = curvature_of(stage, block);
  for (std::size_t v = 0; v < values.vertex_count; ++v) {
    float* out = values.of(v).data() + first;
    for (std::size_t f = 0; f < block.stride; ++f) {
      out[f] += stage.curvature_factor *
                std::abs(curvature[v * block.stride + f] - stage.rest_curvature[v]);
    }
  }
}

void add_directions(const Stage& stage, const Block& block, std::size_t first,
                    std::size_t frame_count, Buffer<float>& directions) {
  const std::size_t frames = block.stride;
  parallel_for(stage.ctx, stage.topology.vertex_count(), vertex_grain, [&](std::size_t v) {
    std::vector<float> tensor(3 * frames);
    strain::stretch_of_vertex(stage.stencils, block, v, tensor.data());
    for (std::size_t f = 0; f < frames; ++f) {
      const float c00 = tensor[f], c01 = tensor[frames + f], c11 = tensor[2 * frames + f];
      const float angle = 0.5F * std::atan2(2.0F * c01, c00 - c11);
      const bool stretched = std::hypot(c00 - c11, 2.0F * c01) > 1e-6F;
      const Eigen::Vector3f d = std::cos(angle) * stage.stencils.basis[2 * v] +
                                std::sin(angle) * stage.stencils.basis[2 * v + 1];
      float* out = directions.data() + 3 * (v * frame_count + first + f);
      for (int axis = 0; axis < 3; ++axis) out[axis] = stretched ? d[axis] : 0.0F;
    }
  });
}

Block rest_block(const std::vector<Eigen::Vector3d>& rest) {
  Block block{1, {}};
  for (const Eigen::Vector3d& p : rest) {
    for (int axis = 0; axis < 3; ++axis) block.positions.push_back(static_cast<float>(p[axis]));
  }
  return block;
}

Stage make_stage(const AnimatedMesh& animation, const DeformationOptions& options,
                 const DeformationResult& result, const RunContext& ctx) {
  const Topology& topology = animation.topology();
  Stage stage{topology, options, ctx, {}, {}, {}, {}, 0.0F};
  stage.triangles = strain::rest_triangles(topology, result.rest);
  const bool ball = options.region == StrainRegion::ball;
  if (ball || options.directions) {
    const double radius = ball ? options.strain_radius * result.root_area_mm : 0.0;
    stage.stencils = strain::make_stencils(topology, result.rest,
                                           sampled_balls(topology, result.rest, radius, ctx), ctx);
  }
  if (options.curvature_weight > 0.0) {
    stage.curvature_balls =
        surface_balls(topology, result.rest, options.curvature_radius * result.root_area_mm, ctx);
    stage.rest_curvature = curvature_of(stage, rest_block(result.rest));
    stage.curvature_factor =
        static_cast<float>(options.curvature_weight * (options.curvature_unit == CurvatureUnit::edge
                                                           ? result.mean_edge_mm
                                                           : result.root_area_mm));
  }
  return stage;
}

void describe_rest(const Topology& topology, DeformationResult& result) {
  double area = 0.0;
  for (const double a : vertex_areas(topology, result.rest)) area += a;
  if (!(area > 0.0)) {
    throw NoResultError({.what = "the mesh has no faces with an area at rest, so nothing deforms",
                         .remedy = "Give an animation with triangles"});
  }
  result.root_area_mm = std::sqrt(area);
  result.mean_edge_mm = mean_edge_length(topology, result.rest);
  result.diagonal_mm = bounding_diagonal(topology, result.rest);
  result.isolated_vertices = topology.isolated_vertex_count();
}

/// Vertices without faces do not deform, whatever measure counts from 1.
void clear_isolated(const Topology& topology, DeformationResult& result) {
  for (std::size_t v = 0; v < topology.vertex_count(); ++v) {
    const auto curve = result.values.of(v);
    if (topology.faces_of(static_cast<VertexIndex>(v)).empty()) {
      std::fill(curve.begin(), curve.end(), 0.0F);
    }
    for (const float d : curve) result.largest = std::max(result.largest, d);
  }
}

}  // namespace

void DeformationOptions::declare(ParameterSet& p) {
  p.group("deformation", "Deformation of the surface");
  p.choice("strain-region", region,
           {{StrainRegion::triangles, "triangles", "each triangle, averaged around a vertex"},
            {StrainRegion::ball, "ball", "all vertices within --strain-radius"}},
           "What the strain at a vertex is computed from");
  p.number("strain-radius", strain_radius,
           {.min = 0.0,
            .max = 0.5,
            .help = "Radius of the strain's ball, as a part of the root of the surface's area"});
  p.choice("strain", measure,
           {{StrainMeasure::lambda, "lambda", "largest eigenvalue of FᵀF (1 at rest)"},
            {StrainMeasure::green, "green", "(lambda − 1) / 2"},
            {StrainMeasure::log, "log", "½ ln lambda"},
            {StrainMeasure::root_log, "root-log", "√(½ ln lambda + floor) − √floor"},
            {StrainMeasure::log_norm, "log-norm", "stretch and shortening alike"}},
           "How strain is measured");
  p.number("root-floor", root_floor,
           {.min = 0.0,
            .max = 1.0,
            .help = "Strain up to which root-log grows evenly; without it noise counts much"});
  p.number("curvature-weight", curvature_weight,
           {.min = 0.0, .max = 1000.0, .help = "Weight of the change of curvature beside strain"});
  p.number("curvature-radius", curvature_radius,
           {.min = 0.0,
            .max = 0.5,
            .help = "Radius within which curvature is averaged, as a part of the root of the "
                    "surface's area"});
  p.choice("curvature-unit", curvature_unit,
           {{CurvatureUnit::edge, "edge", "times the mean edge"},
            {CurvatureUnit::root_area, "area", "times the root of the surface's area"}},
           "What makes curvature a pure number");
  p.number("position-smoothing", position_smoothing,
           {.min = 0.0,
            .max = 0.5,
            .help = "Standard deviation of a Gaussian over time that smooths the positions, as a "
                    "part of the duration"});
  p.choice("rest", rest,
           {{RestPose::frame, "frame", "the frame --rest-frame"},
            {RestPose::mean, "mean", "the mean of all frames, laid over the first"}},
           "The pose in which nothing is deformed");
  p.number("rest-frame", rest_frame,
           {.min = 0, .max = 1e9, .help = "Frame of the rest pose, counted from 0"});
}

DeformationResult deformation_of(const AnimatedMesh& animation, const DeformationOptions& options,
                                 const RunContext& ctx, const Mesh* rest) {
  options.validate();
  if (animation.frame_count() == 0 || animation.vertex_count() == 0) {
    throw NoResultError({.what = "the animation has no frames or no vertices"});
  }
  check_finite(animation);
  const std::size_t frames = animation.frame_count();
  const Positions positions(animation, options.position_smoothing * static_cast<double>(frames),
                            static_cast<std::size_t>(std::max(options.rest_frame, 0)));
  DeformationResult result;
  result.rest = rest_pose(animation, positions, options, rest);
  describe_rest(animation.topology(), result);
  const Stage stage = make_stage(animation, options, result, ctx);
  result.degenerate_faces = stage.triangles.degenerate;
  result.values = VertexCurves(animation.vertex_count(), frames);
  if (options.directions) result.directions = Buffer<float>(3 * result.values.values.size());
  Block block;
  for (std::size_t first = 0; first < frames; first += block.stride) {
    ctx.progress(static_cast<double>(first) / static_cast<double>(frames));
    positions.fill(block, first, std::min(block_frames, frames - first), ctx);
    if (options.region == StrainRegion::ball) {
      ball_strain(stage, block, first, result.values);
    } else {
      triangle_strain(stage, block, first, result.values);
    }
    if (options.curvature_weight > 0.0) add_curvature_change(stage, block, first, result.values);
    if (options.directions) add_directions(stage, block, first, frames, result.directions);
  }
  clear_isolated(animation.topology(), result);
  ctx.progress(1.0);
  return result;
}

}  // namespace kinemesh
