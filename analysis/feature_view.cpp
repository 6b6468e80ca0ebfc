#include "analysis/feature_view.h"

#include <algorithm>
#include <cmath>

#include "analysis/deformation_output.h"
#include "config/error.h"
#include "config/text.h"
#include "report/camera.h"
#include "report/chart.h"
#include "report/mesh_view.h"

namespace kinemesh {
namespace {

constexpr double margin = 18.0, heading = 66.0, panel_width = 500.0, panel_height = 420.0,
                 cell_height = 220.0, caption = 22.0, bar_height = 52.0;

struct View3 {
  const AnimatedMesh& animation;
  const DeformationResult& deformation;
  const FeatureSet& set;
  ColourScale colours, speeds;
  BodyAxes axes;
};

View3 make_view(const AnimatedMesh& animation, const DeformationResult& deformation,
                const FeatureSet& set) {
  View3 view{animation, deformation, set, {}, {}, {}};
  view.colours.high = colour_limit(deformation);
  view.colours.label = "deformation";
  view.speeds.map = ColourScale::Map::diverging;
  view.speeds.low = 1e300;
  view.speeds.high = 0.0;
  for (const Feature& f : set.features) {
    if (f.kind != FeatureKind::deformation || !(f.tau_s > 0.0)) continue;
    view.speeds.low = std::min(view.speeds.low, 1.0 / f.tau_s);
    view.speeds.high = std::max(view.speeds.high, 1.0 / f.tau_s);
  }
  if (!(view.speeds.high > view.speeds.low)) {
    view.speeds.low = 0.0;
    view.speeds.high = std::max(2.0 * view.speeds.high, 1.0);
  }
  view.speeds.label = "speed of features, 1/τ (red: fast)";
  view.speeds.unit = set.rate_hz > 0 ? "1/s" : "1/frame";
  view.axes = estimate_axes(animation.topology(), animation.frame(0));
  return view;
}

Colour colour_of(const View3& view, const Feature& f) {
  if (f.kind == FeatureKind::displacement || !(f.tau_s > 0.0)) return colour_from_hex(0x303030);
  return view.speeds(1.0 / f.tau_s);
}

bool shown_in(const View3& view, const Feature& f, std::size_t frame) {
  const double rate = view.set.rate_hz > 0 ? view.set.rate_hz : 1.0;
  return std::abs(static_cast<double>(f.frame) - static_cast<double>(frame)) <=
         std::max(1.0, f.tau_s * rate);
}

Scene scene_of(const View3& view, std::size_t frame, bool all) {
  SceneMesh surface{view.animation.shared_topology(), points_of(view.animation.frame(frame))};
  surface.scale = view.colours;
  for (std::size_t v = 0; v < view.animation.vertex_count() && !all; ++v) {
    surface.values.push_back(view.deformation.values.of(v)[frame]);
  }
  Scene scene;
  for (const Feature& f : view.set.features) {
    if (!all && !shown_in(view, f, frame)) continue;
    SceneSphere sphere{.centre = surface.positions[f.vertex],
                       .radius = static_cast<float>(f.sigma_mm),
                       .colour = colour_of(view, f)};
    if (f.kind == FeatureKind::displacement) sphere.radius_px = 4.0F;
    scene.spheres.push_back(sphere);
  }
  scene.meshes.push_back(std::move(surface));
  return scene;
}

Camera camera_on(const View3& view, View side, std::size_t frame, double aspect) {
  Camera camera = camera_for(side, view.axes);
  const auto points = points_of(view.animation.frame(frame));
  aim(camera, points, aspect);
  return camera;
}

/// Frames of the strongest features, ascending, each once.
std::vector<std::size_t> strip_frames(const FeatureSet& set, std::size_t count) {
  std::vector<std::size_t> frames;
  const std::size_t apart = std::max<std::size_t>(set.frame_count / (4 * count + 1), 1);
  for (const Feature& f : set.features) {
    if (frames.size() == count) break;
    const bool near = std::any_of(frames.begin(), frames.end(), [&](std::size_t g) {
      return std::max<std::size_t>(g, f.frame) - std::min<std::size_t>(g, f.frame) < apart;
    });
    if (!near) frames.push_back(f.frame);
  }
  for (std::size_t i = 0; frames.empty() && i < count && i < set.frame_count; ++i) {
    frames.push_back(i * set.frame_count / count);
  }
  std::sort(frames.begin(), frames.end());
  return frames;
}

RenderOptions pale() {
  RenderOptions options;
  options.background = colour_from_hex(0xf4f6f8);
  return options;
}

void draw_strip(Canvas& canvas, const View3& view, const Box& area, int count,
                const RunContext& ctx) {
  const auto frames = strip_frames(view.set, static_cast<std::size_t>(std::max(count, 1)));
  const View side = view.axes.faces ? View::front : View::three_quarter;
  const double width = (area.width - margin * static_cast<double>(frames.size() - 1)) /
                       static_cast<double>(frames.size());
  double x = area.x;
  for (const std::size_t frame : frames) {
    const Box box{x, area.y, width, cell_height};
    const Camera camera = camera_on(view, side, frame, box.width / box.height);
    draw_scene(canvas, box, scene_of(view, frame, false), camera, 2.0, pale(), ctx);
    canvas.text_within(
        {x, box.bottom() + 16.0},
        "frame " + std::to_string(frame) +
            (view.set.rate_hz > 0 ? ", " + format_fixed(view.animation.time_s(frame), 3) + " s"
                                  : ""),
        width, {.size = 11.0, .colour = muted_colour});
    x += width + margin;
  }
}

}  // namespace

Canvas draw_features(const AnimatedMesh& animation, const DeformationResult& deformation,
                     const FeatureSet& set, const FeatureViewOptions& options,
                     const RunContext& ctx) {
  if (animation.frame_count() == 0 || animation.vertex_count() == 0) {
    throw NoResultError({.what = "there is no frame to draw features on"});
  }
  const View3 view = make_view(animation, deformation, set);
  Canvas canvas(2 * panel_width + 3 * margin,
                heading + panel_height + margin + cell_height + caption + bar_height + margin);
  const double width = canvas.width() - 2 * margin;
  canvas.text_within({margin, 14.0}, options.title, width,
                     {.size = 18.0, .bold = true, .anchor = TextAnchor::top});
  canvas.text_within({margin, 40.0},
                     count_of(set.features.size(), "feature") +
                         ": radius σ, colour τ; below, the moments of the strongest over "
                         "the deformation",
                     width, {.size = 12.0, .colour = muted_colour, .anchor = TextAnchor::top});
  double x = margin;
  const View sides[] = {View::front, view.axes.faces ? View::three_quarter : View::back};
  for (const View side : sides) {
    const Box box{x, heading, panel_width, panel_height};
    draw_scene(canvas, box, scene_of(view, 0, true),
               camera_on(view, side, 0, panel_width / panel_height), 2.0, pale(), ctx);
    x += panel_width + margin;
  }
  const double strip = heading + panel_height + margin;
  draw_strip(canvas, view, {margin, strip, width, cell_height}, options.frames, ctx);
  const double bars = strip + cell_height + caption;
  draw_colour_bar(canvas, {margin, bars, 0.5 * (width - margin), bar_height}, view.colours);
  draw_colour_bar(canvas,
                  {margin + 0.5 * (width + margin), bars, 0.5 * (width - margin), bar_height},
                  view.speeds);
  return canvas;
}

Image draw_feature_frame(const AnimatedMesh& animation, const DeformationResult& deformation,
                         const FeatureSet& set, std::size_t frame, const RunContext& ctx) {
  const View3 view = make_view(animation, deformation, set);
  RenderOptions options = pale();
  options.width = 960;
  options.height = 720;
  const View side = view.axes.faces ? View::front : View::three_quarter;
  return render(scene_of(view, frame, false),
                camera_on(view, side, 0, static_cast<double>(options.width) / options.height),
                options, ctx)
      .image;
}

}  // namespace kinemesh
