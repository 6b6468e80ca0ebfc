#include "capture/rotation_data.h"

#include <algorithm>

namespace kinemesh {
namespace {

constexpr std::size_t floats = 17;       // 4 × 4 column by column, reliability
constexpr std::size_t reliability = 16;  // its place
constexpr std::size_t translation = 12;  // the last column's

std::size_t floats_per_frame(const RotationData& r) {
  return r.count * r.samples_per_frame * floats;
}

}  // namespace

RotationData rotations_in(const RotationData& rotations, FrameRange frames) {
  const std::size_t per_frame = floats_per_frame(rotations);
  if (per_frame == 0 || rotations.values.size() < frames.end * per_frame) return {};
  RotationData out{rotations.count, rotations.samples_per_frame,
                   Buffer<float>(frames.size() * per_frame)};
  std::copy_n(rotations.values.data() + frames.begin * per_frame, out.values.size(),
              out.values.data());
  return out;
}

RotationData joined_rotations(const RotationData& first, std::size_t frames,
                              const RotationData& second, std::size_t pause) {
  const std::size_t per_frame = floats_per_frame(first);
  const bool alike = per_frame > 0 && first.count == second.count &&
                     first.samples_per_frame == second.samples_per_frame &&
                     first.values.size() == frames * per_frame;
  if (!alike) return {};
  RotationData out{
      first.count, first.samples_per_frame,
      Buffer<float>(first.values.size() + pause * per_frame + second.values.size(), 0.0F)};
  std::copy_n(first.values.data(), first.values.size(), out.values.data());
  float* between = out.values.data() + first.values.size();
  for (std::size_t i = reliability; i < pause * per_frame; i += floats) between[i] = -1.0F;
  std::copy_n(second.values.data(), second.values.size(), between + pause * per_frame);
  return out;
}

void move_rotations(RotationData& rotations, std::size_t frame, const Eigen::Matrix3d& turn,
                    const Eigen::Vector3d& shift) {
  const std::size_t per_frame = floats_per_frame(rotations);
  if (per_frame == 0 || rotations.values.size() < (frame + 1) * per_frame) return;
  float* const begin = rotations.values.data() + frame * per_frame;
  for (float* matrix = begin; matrix < begin + per_frame; matrix += floats) {
    if (matrix[reliability] < 0.0F) continue;  // not measured: whatever stands there means nothing
    for (std::size_t column = 0; column < 16; column += 4) {
      Eigen::Map<Eigen::Vector3f> v(matrix + column);
      Eigen::Vector3d moved = turn * v.cast<double>();
      if (column == translation) moved += shift;
      v = moved.cast<float>();
    }
  }
}

void scale_rotations(RotationData& rotations, double factor) {
  for (std::size_t at = 0; at + floats <= rotations.values.size(); at += floats) {
    Eigen::Map<Eigen::Vector3f> v(rotations.values.data() + at + translation);
    v = (v.cast<double>() * factor).cast<float>();
  }
}

}  // namespace kinemesh
