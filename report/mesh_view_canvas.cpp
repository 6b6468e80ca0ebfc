// A rendered scene on a canvas, with its labels as text.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "report/clean_text.h"
#include "report/mesh_view.h"

namespace kinemesh {
namespace {

bool overlap(const Box& a, const Box& b) {
  return a.x < b.right() && b.x < a.right() && a.y < b.bottom() && b.y < a.bottom();
}

bool covered(const RenderedScene& view, const Camera& camera, const Eigen::Vector3f& point) {
  const Eigen::Vector2d at = camera.project(point, view.image.width, view.image.height);
  const int x = static_cast<int>(std::floor(at.x()));
  const int y = static_cast<int>(std::floor(at.y()));
  if (x < 0 || y < 0 || x >= view.image.width || y >= view.image.height) return true;
  const float front =
      view.depth[static_cast<std::size_t>(y) * static_cast<std::size_t>(view.image.width) +
                 static_cast<std::size_t>(x)];
  return front > camera.to_view(point).z() + 0.03F * camera.view_height;
}

}  // namespace

void draw_scene(Canvas& canvas, const Box& box, const Scene& scene, const Camera& camera,
                double scale, const RenderOptions& options, const RunContext& ctx) {
  RenderOptions scaled = options;
  scaled.width = std::max(1, static_cast<int>(std::lround(box.width * scale)));
  scaled.height = std::max(1, static_cast<int>(std::lround(box.height * scale)));
  Scene sized = scene;
  for (SceneMesh& mesh : sized.meshes) mesh.edge_width *= scale;
  for (SceneSphere& sphere : sized.spheres) sphere.radius_px *= static_cast<float>(scale);
  for (SceneLine& line : sized.lines) line.width *= scale;
  RenderedScene view = render(sized, camera, scaled, ctx);

  std::vector<Box> taken;
  std::vector<std::pair<Eigen::Vector2d, const SceneLabel*>> placed;
  for (const SceneLabel& label : scene.labels) {
    if (!label.at.allFinite() || (label.hide_behind && covered(view, camera, label.at))) continue;
    const Eigen::Vector2d at =
        camera.project(label.at, box.width, box.height) + Eigen::Vector2d(box.x, box.y);
    const double wide = text_width(label.text, label.style);
    const double high = 1.1 * label.style.size;
    const std::array<Eigen::Vector2d, 4> offsets = {
        Eigen::Vector2d{6.0, -0.5 * high}, Eigen::Vector2d{-6.0 - wide, -0.5 * high},
        Eigen::Vector2d{-0.5 * wide, -7.0 - high}, Eigen::Vector2d{-0.5 * wide, 7.0}};
    for (const Eigen::Vector2d& offset : offsets) {
      const Box spot{at.x() + offset.x(), at.y() + offset.y(), wide, high};
      const bool inside = spot.x >= box.x && spot.y >= box.y && spot.right() <= box.right() &&
                          spot.bottom() <= box.bottom();
      if (!inside || std::any_of(taken.begin(), taken.end(),
                                 [&](const Box& other) { return overlap(spot, other); })) {
        continue;
      }
      taken.push_back(spot);
      placed.emplace_back(Eigen::Vector2d{spot.x, spot.y}, &label);
      break;
    }
  }
  canvas.image(box, std::move(view.image));
  for (const auto& [at, label] : placed) {
    TextStyle style = label->style;
    style.align = TextAlign::left;
    style.anchor = TextAnchor::top;
    canvas.text(at, label->text, style);
  }
}

}  // namespace kinemesh
