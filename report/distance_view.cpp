#include "report/distance_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "config/text.h"
#include "report/camera.h"
#include "report/chart.h"
#include "report/figure_layout.h"
#include "report/mesh_view.h"

namespace kinemesh {
namespace {

constexpr double view_width = 430.0, view_height = 430.0;

double longest_of(const GeodesicField& field) {
  double longest = 0.0;
  for (const double d : field.distances)
    longest = std::isfinite(d) ? std::max(longest, d) : longest;
  return longest;
}

Scene scene_of(const Mesh& mesh, const GeodesicField& field, const std::vector<GeodesicPath>& paths,
               const ColourScale& scale, float lift) {
  SceneMesh surface{mesh.topology, mesh.positions};
  surface.scale = scale;
  surface.contour_spacing = isoline_spacing(scale.high);
  for (const double d : field.distances) {
    surface.values.push_back(std::isfinite(d) ? static_cast<float>(d)
                                              : std::numeric_limits<float>::quiet_NaN());
  }
  Scene scene;
  scene.meshes.push_back(std::move(surface));
  const auto place = [&](const SurfacePoint& p) -> Eigen::Vector3f {
    return position_of(p, *mesh.topology, mesh.positions).cast<float>();
  };
  for (const SurfacePoint& source : field.sources) {
    scene.spheres.push_back(
        {.centre = place(source), .radius_px = 5.0F, .colour = colour_from_hex(0xd1242f)});
  }
  for (const GeodesicPath& path : paths) {
    if (path.points.empty()) continue;  // no path leads there
    SceneLine line{{}, colour_from_hex(0xd1242f), 2.4, lift};
    for (const SurfacePoint& p : path.points) line.points.push_back(place(p));
    scene.spheres.push_back(
        {.centre = line.points.back(), .radius_px = 4.0F, .colour = colour_from_hex(0xffffff)});
    scene.lines.push_back(std::move(line));
  }
  return scene;
}

}  // namespace

double isoline_spacing(double longest) {
  if (!(longest > 0.0) || !std::isfinite(longest)) return 0.0;
  const double wanted = longest / 20.0, power = std::pow(10.0, std::floor(std::log10(wanted)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= wanted) return factor * power;
  }
  return 10.0 * power;
}

Canvas draw_distances(const Mesh& mesh, const GeodesicField& field,
                      const std::vector<GeodesicPath>& paths, const DistanceViewOptions& options,
                      const RunContext& ctx) {
  ColourScale scale;
  scale.high = std::max(longest_of(field), 1e-9);
  scale.label = "distance, isolines every " + format_number(isoline_spacing(scale.high)) + " mm";
  scale.unit = "mm";
  const FrameView positions(mesh.positions.front().data(),
                            static_cast<Eigen::Index>(mesh.positions.size()), 3);
  const BodyAxes axes = estimate_axes(*mesh.topology, positions);
  std::vector<Eigen::Vector3f> points;
  for (const Triangle& face : mesh.topology->faces()) points.push_back(mesh.positions[face[0]]);
  Canvas canvas(2.0 * view_width + 3.0 * figure_margin,
                figure_heading + view_height + figure_bar_height + figure_margin);
  const double width = canvas.width() - 2.0 * figure_margin;
  canvas.text_within({figure_margin, 14.0}, options.title, width,
                     {.size = 18.0, .bold = true, .anchor = TextAnchor::top});
  canvas.text_within({figure_margin, 40.0}, options.subtitle, width,
                     {.size = 12.0, .colour = muted_colour, .anchor = TextAnchor::top});
  double x = figure_margin;
  for (const View view : {View::front, axes.faces ? View::three_quarter : View::back}) {
    Camera camera = camera_for(view, axes);
    aim(camera, points, view_width / view_height);
    const Box box{x, figure_heading, view_width, view_height};
    RenderOptions render_options;
    render_options.background = colour_from_hex(0xf4f6f8);
    draw_scene(canvas, box, scene_of(mesh, field, paths, scale, 0.01F * camera.view_height), camera,
               2.0, render_options, ctx);
    canvas.text({x + 8.0, figure_heading + 8.0},
                view == View::front  ? "front"
                : view == View::back ? "back"
                                     : "from the side",
                {.size = 12.0, .colour = muted_colour, .anchor = TextAnchor::top});
    x += view_width + figure_margin;
  }
  draw_colour_bar(
      canvas, {figure_margin, figure_heading + view_height + 8.0, width, figure_bar_height}, scale);
  return canvas;
}

}  // namespace kinemesh
