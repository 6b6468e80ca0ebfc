#include "report/match_view.h"

#include <algorithm>
#include <array>

#include "report/camera.h"
#include "report/chart.h"
#include "report/mesh_view.h"

namespace kinemesh {
namespace {

constexpr double margin = 18.0, panel = 460.0, heading = 66.0, footing = 24.0;

/// Dark enough for lines on white.
Colour colour_of(std::size_t k) {
  constexpr std::array<uint32_t, 10> colours = {0x1f6feb, 0xd1242f, 0x1a7f37, 0xbf8700, 0x8250df,
                                                0x0e8a9a, 0xbf3989, 0x6e4f1f, 0x0a3069, 0xe16f24};
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
  /// Whether a face lies before the point, by more than a hair.
  bool hides(const Eigen::Vector3f& point) const {
    const Eigen::Vector3f seen = camera.to_view(point);
    const float hair = 0.01F * camera.view_height;
    return std::ranges::any_of(mesh.topology->faces(), [&](const Triangle& face) {
      std::array<Eigen::Vector3f, 3> c;
      for (std::size_t k = 0; k < 3; ++k) c[k] = camera.to_view(mesh.positions[face[k]]);
      const auto area = [&](const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
        return (a.x() - seen.x()) * (b.y() - seen.y()) - (a.y() - seen.y()) * (b.x() - seen.x());
      };
      const std::array<float, 3> w = {area(c[1], c[2]), area(c[2], c[0]), area(c[0], c[1])};
      const bool inside = (w[0] > 0 && w[1] > 0 && w[2] > 0) || (w[0] < 0 && w[1] < 0 && w[2] < 0);
      if (!inside) return false;
      const float sum = w[0] + w[1] + w[2];
      const float depth = (w[0] * c[0].z() + w[1] * c[1].z() + w[2] * c[2].z()) / sum;
      return depth > seen.z() + hair;
    });
  }
  void mark(Canvas& canvas, const Eigen::Vector3f& point, double radius,
            const Colour& colour) const {
    canvas.circle(pixel(point), radius, colour);
    if (hides(point)) canvas.circle(pixel(point), radius - 1.4, colour_from_hex(0xffffff));
  }
  void label(Canvas& canvas, const Eigen::Vector3f& point, const std::string& text, bool left,
             const Colour& colour) const {
    const Eigen::Vector2d at = pixel(point) + Eigen::Vector2d(left ? -7.0 : 7.0, 3.0);
    TextStyle style{.size = 9.0, .colour = colour_from_hex(0xffffff), .bold = true};
    if (left) style.align = TextAlign::right;
    for (const double x : {-0.9, 0.9}) {  // a halo, for what lies on dark parts
      for (const double y : {-0.9, 0.9}) canvas.text(at + Eigen::Vector2d(x, y), text, style);
    }
    style.colour = colour;
    canvas.text(at, text, style);
  }
  void draw(Canvas& canvas, const RunContext& ctx) const {
    Scene scene;
    SceneMesh& surface = scene.meshes.emplace_back();
    surface.topology = mesh.topology;
    surface.positions = mesh.positions;
    draw_scene(canvas, box, scene, camera, 2.0, {}, ctx);
  }
};

void draw_lines(Canvas& canvas, const Side& left, const Side& right,
                const std::vector<MatchLine>& matches) {
  std::vector<const MatchLine*> order;  // from the top, so that neighbours differ in colour
  for (const MatchLine& line : matches) order.push_back(&line);
  std::ranges::stable_sort(order, {},
                           [&](const MatchLine* m) { return left.pixel(m->source).y(); });
  for (std::size_t k = 0; k < order.size(); ++k) {
    const MatchLine& line = *order[k];
    Stroke stroke{.colour = colour_of(k), .width = 1.2};
    if (left.hides(line.source) || right.hides(line.target)) stroke.dash = {5.0, 4.0};
    canvas.line(left.pixel(line.source), right.pixel(line.target), stroke);
  }
  for (std::size_t k = 0; k < order.size(); ++k) {
    const MatchLine& line = *order[k];
    left.mark(canvas, line.source, 4.0, colour_of(k));
    right.mark(canvas, line.target, 4.0, colour_of(k));
    left.label(canvas, line.source, line.source_text, true, colour_of(k));
    right.label(canvas, line.target, line.target_text, false, colour_of(k));
  }
}

}  // namespace

Canvas draw_matches(const Mesh& source, const Mesh& target, const std::vector<MatchLine>& matches,
                    const std::vector<Eigen::Vector3f>& unmatched_source,
                    const std::vector<Eigen::Vector3f>& unmatched_target,
                    const MatchViewOptions& options, const RunContext& ctx) {
  const double width = 2.0 * panel + 3.0 * margin;
  Canvas canvas(width, heading + panel + footing + margin);
  canvas.text_within({margin, 28.0}, options.title, width - 2.0 * margin,
                     {.size = 17.0, .bold = true});
  canvas.text_within({margin, 48.0}, options.subtitle, width - 2.0 * margin,
                     {.size = 12.0, .colour = colour_from_hex(0x57606a)});
  const Side left{source, {margin, heading, panel, panel}, front_of(source)};
  const Side right{target, {2.0 * margin + panel, heading, panel, panel}, front_of(target)};
  left.draw(canvas, ctx);
  right.draw(canvas, ctx);
  const Colour grey = colour_from_hex(0x8c959f);
  for (const Eigen::Vector3f& p : unmatched_source) left.mark(canvas, p, 3.0, grey);
  for (const Eigen::Vector3f& p : unmatched_target) right.mark(canvas, p, 3.0, grey);
  draw_lines(canvas, left, right, matches);
  for (const Side* side : {&left, &right}) {
    canvas.text_within({side->box.x + 0.5 * panel, heading + panel + footing - 6.0},
                       side == &left ? options.source_name : options.target_name, panel,
                       {.size = 13.0, .bold = true, .align = TextAlign::centre});
  }
  return canvas;
}

}  // namespace kinemesh
