#include "report/match_view.h"

#include <array>

#include "report/camera.h"
#include "report/chart.h"
#include "report/mesh_view.h"

namespace kinemesh {
namespace {

constexpr double margin = 18.0, panel = 460.0, heading = 66.0;

Colour colour_of(std::size_t k) {
  constexpr std::array<uint32_t, 8> colours = {0x1f6feb, 0xd1242f, 0x1a7f37, 0xbf8700,
                                               0x8250df, 0x0e8a9a, 0xbf3989, 0x6e4f1f};
  return colour_from_hex(colours[k % colours.size()]);
}

Camera front_of(const Mesh& mesh) {
  std::vector<float> flat;
  for (const Eigen::Vector3f& p : mesh.positions) flat.insert(flat.end(), p.data(), p.data() + 3);
  const FrameView view(flat.data(), static_cast<Eigen::Index>(mesh.positions.size()), 3);
  Camera camera = camera_for(View::front, estimate_axes(*mesh.topology, view));
  aim(camera, mesh.positions, 1.0);
  return camera;
}

struct Side {
  const Mesh& mesh;
  Box box;
  Camera camera;
  Eigen::Vector2d pixel(const Eigen::Vector3f& p) const {
    const Eigen::Vector2d inside = camera.project(p, box.width, box.height);
    return {box.x + inside.x(), box.y + inside.y()};
  }
  void draw(Canvas& canvas, const RunContext& ctx) const {
    Scene scene;
    SceneMesh& surface = scene.meshes.emplace_back();
    surface.topology = mesh.topology;
    surface.positions = mesh.positions;
    draw_scene(canvas, box, scene, camera, 2.0, {}, ctx);
  }
};

}  // namespace

Canvas draw_matches(const Mesh& source, const Mesh& target, const std::vector<MatchLine>& matches,
                    const std::vector<Eigen::Vector3f>& unmatched_source,
                    const std::vector<Eigen::Vector3f>& unmatched_target,
                    const MatchViewOptions& options, const RunContext& ctx) {
  const double width = 2.0 * panel + 3.0 * margin;
  Canvas canvas(width, heading + panel + margin);
  canvas.text_within({margin, 28.0}, options.title, width - 2.0 * margin,
                     {.size = 17.0, .bold = true});
  canvas.text_within({margin, 48.0}, options.subtitle, width - 2.0 * margin,
                     {.size = 12.0, .colour = colour_from_hex(0x57606a)});
  const Side left{source, {margin, heading, panel, panel}, front_of(source)};
  const Side right{target, {2.0 * margin + panel, heading, panel, panel}, front_of(target)};
  left.draw(canvas, ctx);
  right.draw(canvas, ctx);
  const Colour grey = colour_from_hex(0x8c959f);
  for (const Eigen::Vector3f& p : unmatched_source) canvas.circle(left.pixel(p), 3.0, grey);
  for (const Eigen::Vector3f& p : unmatched_target) canvas.circle(right.pixel(p), 3.0, grey);
  for (std::size_t k = 0; k < matches.size(); ++k) {
    const Eigen::Vector2d from = left.pixel(matches[k].source), to = right.pixel(matches[k].target);
    canvas.line(from, to, {.colour = colour_of(k), .width = 1.2});
    canvas.circle(from, 4.0, colour_of(k));
    canvas.circle(to, 4.0, colour_of(k));
  }
  return canvas;
}

}  // namespace kinemesh
