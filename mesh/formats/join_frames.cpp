#include "mesh/formats/join_frames.h"

#include <algorithm>
#include <map>

#include "config/error.h"
#include "config/parallel.h"
#include "config/text.h"

namespace kinemesh {
namespace {

/// Adds the directed edges of a triangle, `sign` times; an edge and its reverse cancel.
void add_outline(const Triangle& t, int sign,
                 std::map<std::pair<VertexIndex, VertexIndex>, int>& outline) {
  for (std::size_t k = 0; k < 3; ++k) {
    const VertexIndex a = t[k], b = t[(k + 1) % 3];
    const auto edge = std::pair(std::min(a, b), std::max(a, b));
    int& count = outline[edge];
    count += a < b ? sign : -sign;
    if (count == 0) outline.erase(edge);
  }
}

/// True when the triangles are equal but for how polygons were cut, which depends on the positions
/// of a frame: every stretch of differing triangles has the same outline.
bool same_polygons(const MeshData& first, const MeshData& other) {
  if (first.polygons == 0 || other.polygons != first.polygons ||
      other.faces.size() != first.faces.size()) {
    return false;
  }
  std::map<std::pair<VertexIndex, VertexIndex>, int> outline;
  for (std::size_t i = 0; i < first.faces.size(); ++i) {
    if (outline.empty() && first.faces[i] == other.faces[i]) continue;
    add_outline(first.faces[i], 1, outline);
    add_outline(other.faces[i], -1, outline);
  }
  return outline.empty();
}

}  // namespace

bool same_faces(const MeshData& first, const MeshData& other) {
  return other.vertex_count == first.vertex_count &&
         (other.faces == first.faces || same_polygons(first, other));
}

namespace {

void require_same_topology(const MeshData& first, const MeshData& other, const std::string& name) {
  if (other.frame_count == 1 && same_faces(first, other)) return;
  const bool counts = other.vertex_count != first.vertex_count;
  throw InputError({.what = counts
                                ? "it has " + count_of(other.vertex_count, "vertex", "vertices") +
                                      ", the first file " + std::to_string(first.vertex_count)
                                : std::string("its faces differ from those of the first file"),
                    .file = name,
                    .remedy = "An animated mesh has one topology in all frames"});
}

/// Puts frame 0 of `from`, in the unit of `from`, at frame `f` of `into`.
void place_frame(const MeshData& from, MeshData& into, std::size_t f) {
  const double factor =  // a file that does not say its unit has that of the first
      from.unit && into.unit ? millimetres_per(*from.unit) / millimetres_per(*into.unit) : 1.0;
  const auto copy = [factor](const Buffer<float>& source, float* target) {
    if (factor == 1.0) {
      std::copy_n(source.data(), source.size(), target);
    } else {
      std::transform(source.begin(), source.end(), target,
                     [factor](float v) { return static_cast<float>(v * factor); });
    }
  };
  copy(from.positions, into.positions.data() + 3 * f * into.vertex_count);
  const std::size_t row = f * into.vertex_count;
  if (!into.filled.empty() && !from.filled.empty()) {
    std::copy_n(from.filled.data(), into.vertex_count, into.filled.data() + row);
  }
  if (!into.uncertainty.empty() && !from.uncertainty.empty()) {
    copy(from.uncertainty, into.uncertainty.data() + row);
  }
}

}  // namespace

MeshData join_frames(std::size_t count, const std::function<MeshData(std::size_t)>& load,
                     const std::function<std::string(std::size_t)>& name, const RunContext& ctx) {
  MeshData first = load(0);
  MeshData all;
  all.allocate(count, first.vertex_count);
  all.faces = first.faces;
  if (!first.filled.empty()) all.filled = Buffer<uint8_t>(count * first.vertex_count, 0);
  if (!first.uncertainty.empty()) all.uncertainty = Buffer<float>(count * first.vertex_count, 0);
  all.unit = first.unit;
  all.rate_hz = first.rate_hz;
  all.first_frame = first.first_frame;
  all.events = std::move(first.events);
  all.vertex_names = std::move(first.vertex_names);
  all.provenance = std::move(first.provenance);
  all.polygons = first.polygons;
  all.dropped_faces = first.dropped_faces;
  all.warnings = std::move(first.warnings);
  place_frame(first, all, 0);
  parallel_for(ctx, count - 1, 4, [&](std::size_t i) {
    const MeshData frame = load(i + 1);
    require_same_topology(first, frame, name(i + 1));
    place_frame(frame, all, i + 1);
  });
  return all;
}

}  // namespace kinemesh
