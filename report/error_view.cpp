#include "report/error_view.h"

#include <algorithm>
#include <cmath>

#include "config/error.h"
#include "report/camera.h"
#include "report/chart.h"
#include "report/figure_layout.h"

namespace kinemesh {
namespace {

constexpr double panel_width = 300.0, panel_height = 360.0, caption_height = 24.0;

ColourScale scale_of(const std::vector<ErrorPanel>& panels, const ErrorViewOptions& options) {
  ColourScale scale;
  scale.high = options.high_mm;
  if (scale.high <= 0.0) {
    for (const ErrorPanel& p : panels) {
      for (const float v : p.values) {
        if (std::isfinite(v)) scale.high = std::max(scale.high, static_cast<double>(v));
      }
    }
  }
  if (scale.high <= 0.0) scale.high = 1.0;
  scale.label = options.value_label;
  scale.unit = "mm";
  return scale;
}

}  // namespace

Canvas draw_error_view(const std::vector<ErrorPanel>& panels, const ErrorViewOptions& options,
                       const RunContext& ctx) {
  if (panels.empty() || panels.front().positions.empty()) {
    throw NoResultError({.what = "there is nothing to draw"});
  }
  const std::size_t columns = std::clamp<std::size_t>(options.columns, 1, panels.size());
  const std::size_t rows = (panels.size() + columns - 1) / columns;
  const double row_height = panel_height + caption_height;
  const double width = static_cast<double>(columns) * (panel_width + figure_margin) + figure_margin;
  Canvas canvas(width, figure_heading + static_cast<double>(rows) * row_height + figure_bar_height +
                           figure_margin);
  canvas.text_within({figure_margin, 14.0}, options.title, width - 2.0 * figure_margin,
                     {.size = 18.0, .bold = true, .anchor = TextAnchor::top});
  canvas.text_within({figure_margin, 40.0}, options.subtitle, width - 2.0 * figure_margin,
                     {.size = 12.0, .colour = muted_colour, .anchor = TextAnchor::top});
  const ErrorPanel& first = panels.front();
  const FrameView rest(first.positions.front().data(),
                       static_cast<Eigen::Index>(first.positions.size()), 3);
  Camera camera = camera_for(View::front, estimate_axes(*first.topology, rest));
  std::vector<Eigen::Vector3f> all;
  for (const ErrorPanel& p : panels) all.insert(all.end(), p.positions.begin(), p.positions.end());
  aim(camera, all, panel_width / panel_height);
  const ColourScale scale = scale_of(panels, options);
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const double x =
        figure_margin + static_cast<double>(i % columns) * (panel_width + figure_margin);
    const std::size_t row = i / columns;
    const double y = figure_heading + static_cast<double>(row) * row_height;
    Scene scene;
    scene.meshes.push_back({panels[i].topology, panels[i].positions});
    scene.meshes.back().values = panels[i].values;
    scene.meshes.back().scale = scale;
    scene.spheres = panels[i].spheres;
    RenderOptions render_options;
    render_options.background = colour_from_hex(0xf4f6f8);
    draw_scene(canvas, {x, y, panel_width, panel_height}, scene, camera, 2.0, render_options, ctx);
    canvas.text_within({x, y + panel_height + 6.0}, panels[i].caption, panel_width,
                       {.size = 12.0, .colour = muted_colour, .anchor = TextAnchor::top});
  }
  draw_colour_bar(canvas,
                  {figure_margin, figure_heading + static_cast<double>(rows) * row_height,
                   width - 2.0 * figure_margin, figure_bar_height},
                  scale);
  return canvas;
}

}  // namespace kinemesh
