#include "mesh/formats/mesh_data.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "config/error.h"
#include "config/multiversion.h"
#include "config/text.h"

namespace kinemesh {
namespace {

/// True when every value is finite. Plain integer arithmetic, so that it vectorises.
KINEMESH_MULTIVERSION bool all_finite(const float* values, std::size_t count) {
  uint32_t found = 0;
  for (std::size_t i = 0; i < count; ++i) {
    uint32_t bits = 0;
    std::memcpy(&bits, values + i, sizeof bits);
    found |= (bits & 0x7F800000U) == 0x7F800000U ? 1U : 0U;
  }
  return found == 0;
}

void scale(std::span<float> values, double factor) {
  if (factor == 1.0) return;
  for (float& value : values) value = static_cast<float>(value * factor);
}

void require_finite(const MeshData& data, const std::string& file) {
  const float* values = data.positions.data();
  const std::size_t count = data.positions.size();
  constexpr std::size_t block = 1 << 16;
  for (std::size_t begin = 0; begin < count; begin += block) {
    const std::size_t size = std::min(block, count - begin);
    if (all_finite(values + begin, size)) continue;
    std::size_t i = begin;
    while (std::isfinite(values[i])) ++i;
    const std::size_t vertex = i / 3 % data.vertex_count;
    std::string place = "vertex " + std::to_string(vertex);
    if (!data.vertex_names.empty()) place += " '" + data.vertex_names[vertex] + "'";
    const std::size_t frame = i / 3 / data.vertex_count;
    if (data.frame_count > 1) place += " in frame " + std::to_string(frame) + " of the file";
    throw InputError({.what = "the position is not a finite number",
                      .file = file,
                      .place = place + " (0-based)",
                      .remedy = "Fill the gap, or leave the vertex out"});
  }
}

void expand_runs(MeshData& data) {
  if (!data.filled_runs || !data.filled.empty()) return;
  data.filled = Buffer<uint8_t>(data.frame_count * data.vertex_count, 0);
  std::vector<FilledRun>& runs = *data.filled_runs;
  std::ranges::sort(runs, [](const FilledRun& a, const FilledRun& b) {
    return a.vertex != b.vertex ? a.vertex < b.vertex : a.first < b.first;
  });
  std::size_t vertex = data.vertex_count, done = 0;  // overlapping runs: every sample set once
  for (const FilledRun& run : runs) {
    if (run.vertex >= data.vertex_count) break;
    if (run.vertex != vertex) done = 0;
    vertex = run.vertex;
    const std::size_t end = std::min(run.last, data.frame_count - 1) + 1;
    for (std::size_t f = std::max(run.first, done); f < end; ++f) {
      data.filled[f * data.vertex_count + run.vertex] = 1;
    }
    done = std::max(done, end);
  }
}

/// After lengths were scaled: the runs are in mm.
void expand_uncertainty(MeshData& data) {
  if (!data.uncertainty_runs || !data.uncertainty.empty()) return;
  data.uncertainty = Buffer<float>(data.frame_count * data.vertex_count, 0.0F);
  for (const UncertaintyRun& run : *data.uncertainty_runs) {
    if (run.vertex >= data.vertex_count || run.first >= data.frame_count) continue;
    const std::size_t count = std::min(run.mm.size(), data.frame_count - run.first);
    for (std::size_t i = 0; i < count; ++i) {
      data.uncertainty[(run.first + i) * data.vertex_count + run.vertex] = run.mm[i];
    }
  }
}

/// Scales lengths to mm and drops faces that repeat a vertex.
void settle(MeshData& data, const ReadOptions& options, const std::string& file,
            const RunContext& ctx) {
  if (data.vertex_count == 0 || data.frame_count == 0) {
    throw InputError({.what = "the file holds no vertices", .file = file});
  }
  if (!data.unit && options.unit != LengthUnit::mm) {
    ctx.log(LogLevel::debug, file + ": lengths taken as " + std::string(name_of(options.unit)));
  }
  const double factor = millimetres_per(data.unit.value_or(options.unit));
  scale(data.positions.span(), factor);
  scale(data.uncertainty.span(), factor);
  require_finite(data, file);
  expand_runs(data);
  expand_uncertainty(data);
  const std::size_t before = data.faces.size();
  std::erase_if(data.faces,
                [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
  data.dropped_faces += before - data.faces.size();
  for (const std::string& warning : data.warnings) {
    std::string line = file;
    ctx.warn(line.append(": ").append(warning));
  }
  if (data.polygons > 0) {
    ctx.info(file + ": " + count_of(data.polygons, "polygon") + " triangulated");
  }
  if (data.dropped_faces > 0) {
    ctx.warn(file + ": " + count_of(data.dropped_faces, "face") +
             (data.dropped_faces == 1 ? " that uses" : " that use") + " a vertex twice left out");
  }
}

}  // namespace

void MeshData::allocate(std::size_t frames, std::size_t vertices) {
  frame_count = frames;
  vertex_count = vertices;
  positions = Buffer<float>(frames * vertices * 3);
}

AnimatedMesh to_animated_mesh(MeshData data, const ReadOptions& options, const std::string& file,
                              const RunContext& ctx) {
  settle(data, options, file, ctx);
  const double rate = data.rate_hz > 0 ? data.rate_hz : options.rate_hz;
  AnimatedMesh mesh(Topology::create(data.vertex_count, std::move(data.faces)), data.frame_count,
                    rate, std::move(data.positions));
  if (!data.filled.empty()) {
    mesh.add_filled();
    std::copy_n(data.filled.data(), data.filled.size(), mesh.filled().data());
  }
  if (!data.uncertainty.empty()) {
    mesh.add_uncertainty();
    std::copy_n(data.uncertainty.data(), data.uncertainty.size(), mesh.uncertainty().data());
  }
  mesh.first_frame = data.first_frame.value_or(1);
  mesh.events = std::move(data.events);
  mesh.vertex_names = std::move(data.vertex_names);
  mesh.provenance = std::move(data.provenance);
  return mesh;
}

Mesh to_mesh(MeshData data, const ReadOptions& options, const std::string& file,
             const std::shared_ptr<const Topology>& topology, const RunContext& ctx) {
  settle(data, options, file, ctx);
  Mesh mesh;
  const bool shared =
      topology && topology->vertex_count() == data.vertex_count && topology->faces() == data.faces;
  mesh.topology = shared ? topology : Topology::create(data.vertex_count, std::move(data.faces));
  mesh.positions.resize(data.vertex_count);
  for (std::size_t v = 0; v < data.vertex_count; ++v) {
    mesh.positions[v] = Eigen::Map<const Eigen::Vector3f>(data.positions.data() + 3 * v);
  }
  mesh.vertex_names = std::move(data.vertex_names);
  return mesh;
}

}  // namespace kinemesh
