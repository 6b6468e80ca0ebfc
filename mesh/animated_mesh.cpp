#include "mesh/animated_mesh.h"

#include "config/error.h"

namespace kinemesh {

AnimatedMesh::AnimatedMesh(std::shared_ptr<const Topology> topology, std::size_t frame_count,
                           double rate)
    : rate_hz(rate), topology_(std::move(topology)), frame_count_(frame_count) {
  if (!topology_) throw InternalError("an animated mesh needs a topology");
  positions_ = Buffer<float>(frame_count_ * vertex_count() * 3);
}

AnimatedMesh::AnimatedMesh(std::shared_ptr<const Topology> topology, std::size_t frame_count,
                           double rate, Buffer<float> positions)
    : rate_hz(rate),
      topology_(std::move(topology)),
      frame_count_(frame_count),
      positions_(std::move(positions)) {
  if (!topology_) throw InternalError("an animated mesh needs a topology");
  if (positions_.size() != frame_count_ * vertex_count() * 3) {
    throw InternalError("the number of positions does not fit frames and vertices");
  }
}

MutableFrameView AnimatedMesh::frame(std::size_t f) {
  return {positions_.data() + 3 * sample(f, 0), static_cast<Eigen::Index>(vertex_count()), 3};
}

FrameView AnimatedMesh::frame(std::size_t f) const {
  return {positions_.data() + 3 * sample(f, 0), static_cast<Eigen::Index>(vertex_count()), 3};
}

void AnimatedMesh::add_filled() { filled_ = Buffer<uint8_t>(frame_count_ * vertex_count(), 0); }

void AnimatedMesh::add_uncertainty() {
  uncertainty_ = Buffer<float>(frame_count_ * vertex_count(), 0.0F);
}

double AnimatedMesh::duration_s() const {
  return rate_hz > 0 ? static_cast<double>(frame_count_) / rate_hz : 0.0;
}

Mesh AnimatedMesh::mesh_at(std::size_t f) const {
  Mesh mesh{topology_, std::vector<Eigen::Vector3f>(vertex_count()), vertex_names};
  for (std::size_t v = 0; v < vertex_count(); ++v) {
    mesh.positions[v] = position(f, static_cast<VertexIndex>(v));
  }
  return mesh;
}

}  // namespace kinemesh
