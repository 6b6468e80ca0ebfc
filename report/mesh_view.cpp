#include "report/mesh_view.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "config/error.h"
#include "config/parallel.h"
#include "report/rasteriser.h"

namespace kinemesh {
namespace {

using Eigen::Vector3f;

constexpr int tile_pixels = 32;

raster::Rgb rgb(const Colour& c) { return Eigen::Vector3d(c.r, c.g, c.b).cast<float>(); }

// Area-weighted vertex normals in view axes.
std::vector<Vector3f> vertex_normals(const Topology& topology, const std::vector<Vector3f>& view) {
  std::vector<Vector3f> normals(view.size(), Vector3f::Zero());
  for (const Triangle& t : topology.faces()) {
    const Vector3f n = (view[t[1]] - view[t[0]]).cross(view[t[2]] - view[t[0]]);
    if (!n.allFinite()) continue;
    for (const VertexIndex v : t) normals[v] += n;
  }
  for (Vector3f& n : normals) {
    const float length = n.norm();
    if (length > 0.0F) n /= length;
  }
  return normals;
}

// What tile drawing needs, and which primitives touch which tile.
class Renderer {
 public:
  Renderer(const Scene& scene, const Camera& camera, const RenderOptions& options)
      : camera_(camera),
        options_(options),
        n_(std::clamp(options.samples, 1, 8)),
        width_(options.width * n_),
        height_(options.height * n_),
        samples_per_mm_(static_cast<float>(height_) / camera.view_height),
        columns_((options.width + tile_pixels - 1) / tile_pixels),
        rows_((options.height + tile_pixels - 1) / tile_pixels) {
    shading_.light = options.light.normalized();
    shading_.ambient = options.ambient;
    for (const SceneMesh& mesh : scene.meshes) add(mesh);
    for (const SceneSphere& sphere : scene.spheres) add(sphere);
    for (const SceneLine& line : scene.lines) add(line);
    bins_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
    bin_everything();
  }

  RenderedScene run(const RunContext& ctx) {
    result_.image = Image(options_.width, options_.height, options_.background);
    result_.depth.assign(
        static_cast<std::size_t>(options_.width) * static_cast<std::size_t>(options_.height),
        -std::numeric_limits<float>::infinity());
    parallel_for(ctx, bins_.size(), 1, [this](std::size_t tile) { draw_tile(tile); });
    return std::move(result_);
  }

 private:
  struct Primitive {
    enum class Kind : uint32_t { face, sphere, segment } kind;
    uint32_t owner;  // mesh, for a face
    uint32_t index;
  };

  Vector3f to_samples(const Vector3f& view) const {
    return {0.5F * static_cast<float>(width_) + view.x() * samples_per_mm_,
            0.5F * static_cast<float>(height_) - view.y() * samples_per_mm_, view.z()};
  }

  void add(const SceneMesh& mesh) {
    if (!mesh.topology || mesh.positions.size() != mesh.topology->vertex_count()) {
      throw InternalError("a mesh was to be drawn whose positions do not fit its topology");
    }
    raster::MeshData data;
    data.mesh = &mesh;
    data.samples_per_mm = samples_per_mm_;
    std::vector<Vector3f> view(mesh.positions.size());
    for (std::size_t v = 0; v < view.size(); ++v) view[v] = camera_.to_view(mesh.positions[v]);
    if (mesh.smooth) data.normals = vertex_normals(*mesh.topology, view);
    data.points.reserve(view.size());
    for (const Vector3f& p : view) data.points.push_back(to_samples(p));
    data.front = rgb(mesh.colour);
    data.back = rgb(mesh.back_colour);
    data.edges = {rgb(mesh.edge_colour), static_cast<float>(mesh.edge_colour.a),
                  static_cast<float>(0.5 * mesh.edge_width * n_)};
    data.boundary.resize(3 * mesh.topology->face_count());
    for (std::size_t h = 0; h < data.boundary.size(); ++h) {
      data.boundary[h] = mesh.topology->twin(static_cast<HalfedgeIndex>(h)) == invalid_index;
    }
    add_colours(mesh, data);
    meshes_.push_back(std::move(data));
  }

  static void add_colours(const SceneMesh& mesh, raster::MeshData& data) {
    const std::size_t vertices = mesh.positions.size();
    if (mesh.values.size() == vertices && vertices > 0) {
      constexpr int entries = 1024;
      for (int i = 0; i < entries; ++i) {
        const double t = i / (entries - 1.0);
        data.table.push_back(
            rgb(mesh.scale(mesh.scale.low + t * (mesh.scale.high - mesh.scale.low))));
      }
      data.table.push_back(rgb(mesh.scale(std::numeric_limits<double>::quiet_NaN())));
    } else if (mesh.vertex_colours.size() == vertices) {
      for (const Colour& c : mesh.vertex_colours) data.colours.push_back(rgb(c));
    }
  }

  void add(const SceneSphere& sphere) {
    const float radius = sphere.radius_px > 0.0F ? sphere.radius_px * static_cast<float>(n_)
                                                 : sphere.radius * samples_per_mm_;
    const Vector3f centre = to_samples(camera_.to_view(sphere.centre));
    if (!centre.allFinite() || !(radius > 0.0F)) return;
    spheres_.push_back({centre, radius, samples_per_mm_, rgb(sphere.colour)});
  }

  void add(const SceneLine& line) {
    for (std::size_t i = 0; i + 1 < line.points.size(); ++i) {
      const Vector3f lift(0.0F, 0.0F, line.lift);
      const Vector3f from = to_samples(camera_.to_view(line.points[i]) + lift);
      const Vector3f to = to_samples(camera_.to_view(line.points[i + 1]) + lift);
      if (!from.allFinite() || !to.allFinite()) continue;
      segments_.push_back({from, to, static_cast<float>(0.5 * line.width * n_), rgb(line.colour),
                           static_cast<float>(line.colour.a)});
    }
  }

  void bin_everything() {
    for (uint32_t m = 0; m < meshes_.size(); ++m) {
      const auto& faces = meshes_[m].mesh->topology->faces();
      for (uint32_t f = 0; f < faces.size(); ++f) {
        const Vector3f& a = meshes_[m].points[faces[f][0]];
        const Vector3f& b = meshes_[m].points[faces[f][1]];
        const Vector3f& c = meshes_[m].points[faces[f][2]];
        if (!a.allFinite() || !b.allFinite() || !c.allFinite()) continue;
        bin({Primitive::Kind::face, m, f}, a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c));
      }
    }
    for (uint32_t i = 0; i < spheres_.size(); ++i) {
      const Vector3f r = Vector3f::Constant(spheres_[i].radius);
      bin({Primitive::Kind::sphere, 0, i}, spheres_[i].centre - r, spheres_[i].centre + r);
    }
    for (uint32_t i = 0; i < segments_.size(); ++i) {
      const raster::SegmentData& s = segments_[i];
      const Vector3f r = Vector3f::Constant(s.half_width);
      bin({Primitive::Kind::segment, 0, i}, s.from.cwiseMin(s.to) - r, s.from.cwiseMax(s.to) + r);
    }
  }

  void bin(const Primitive& primitive, const Vector3f& low, const Vector3f& high) {
    const auto tile_of = [this](float at, int count) {
      const float tile = std::floor(at / static_cast<float>(tile_pixels * n_));
      return static_cast<int>(std::clamp(tile, -1.0F, static_cast<float>(count)));
    };
    const int x_last = std::min(tile_of(high.x(), columns_), columns_ - 1);
    const int y_last = std::min(tile_of(high.y(), rows_), rows_ - 1);
    for (int y = std::max(tile_of(low.y(), rows_), 0); y <= y_last; ++y) {
      for (int x = std::max(tile_of(low.x(), columns_), 0); x <= x_last; ++x) {
        bins_[static_cast<std::size_t>(y * columns_ + x)].push_back(primitive);
      }
    }
  }

  void draw_tile(std::size_t index) {
    const int px = static_cast<int>(index) % columns_ * tile_pixels;
    const int py = static_cast<int>(index) / columns_ * tile_pixels;
    if (bins_[index].empty()) return;
    const int wide = std::min(tile_pixels, options_.width - px);
    const int high = std::min(tile_pixels, options_.height - py);
    raster::Tile tile(px * n_, py * n_, wide * n_, high * n_, options_.background);
    for (const Primitive& p : bins_[index]) {
      switch (p.kind) {
        case Primitive::Kind::face: raster::paint(tile, meshes_[p.owner], p.index, shading_); break;
        case Primitive::Kind::sphere: raster::paint(tile, spheres_[p.index], shading_); break;
        case Primitive::Kind::segment: raster::paint(tile, segments_[p.index]); break;
      }
    }
    for (int y = 0; y < high; ++y) {
      for (int x = 0; x < wide; ++x) resolve(tile, x, y, px + x, py + y);
    }
  }

  // The mean of a pixel's samples, colours weighted by their alpha.
  void resolve(const raster::Tile& tile, int x, int y, int px, int py) {
    std::array<uint32_t, 4> sum{};
    for (int row = 0; row < n_; ++row) {
      for (int column = 0; column < n_; ++column) {
        const auto& c = tile.at(x * n_ + column, y * n_ + row).rgba;
        for (std::size_t i = 0; i < 3; ++i) sum[i] += c[i] * static_cast<uint32_t>(c[3]);
        sum[3] += c[3];
      }
    }
    uint8_t* out = result_.image.pixel(px, py);
    for (std::size_t i = 0; i < 3; ++i) {
      out[i] = static_cast<uint8_t>(sum[3] == 0 ? 0 : (sum[i] + sum[3] / 2) / sum[3]);
    }
    const auto count = static_cast<uint32_t>(n_ * n_);
    out[3] = static_cast<uint8_t>((sum[3] + count / 2) / count);
    result_.depth[static_cast<std::size_t>(py) * static_cast<std::size_t>(options_.width) +
                  static_cast<std::size_t>(px)] = tile.at(x * n_ + n_ / 2, y * n_ + n_ / 2).z;
  }

  const Camera& camera_;
  const RenderOptions& options_;
  int n_;
  int width_, height_;  // in samples
  float samples_per_mm_;
  int columns_, rows_;  // tiles
  raster::Shading shading_;
  std::vector<raster::MeshData> meshes_;
  std::vector<raster::SphereData> spheres_;
  std::vector<raster::SegmentData> segments_;
  std::vector<std::vector<Primitive>> bins_;
  RenderedScene result_;
};

}  // namespace

RenderedScene render(const Scene& scene, const Camera& camera, const RenderOptions& options,
                     const RunContext& ctx) {
  constexpr int64_t most = int64_t{64} << 20;
  if (options.width < 1 || options.height < 1 ||
      static_cast<int64_t>(options.width) * options.height > most || !(camera.view_height > 0.0F)) {
    throw NoResultError({.what = "a picture of " + std::to_string(options.width) + " × " +
                                 std::to_string(options.height) + " pixels cannot be drawn"});
  }
  return Renderer(scene, camera, options).run(ctx);
}

}  // namespace kinemesh
