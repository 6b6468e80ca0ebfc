// Pictures of meshes, drawn in software: no display, no graphics driver, the same bytes for any
// number of threads.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "config/run_context.h"
#include "mesh/topology.h"
#include "report/camera.h"
#include "report/canvas.h"
#include "report/colour.h"
#include "report/image.h"

namespace kinemesh {

/// A surface. Triangles with a corner that is not finite are left out.
struct SceneMesh {
  std::shared_ptr<const Topology> topology;
  std::vector<Eigen::Vector3f> positions;  ///< one per vertex, mm

  Colour colour = colour_from_hex(0xd3dce6);
  Colour back_colour = colour_from_hex(0xb58a63);  ///< of faces seen from inside
  bool smooth = true;                              ///< false: one shade per triangle
  double edge_width = 0.0;                         ///< pixels; 0 draws no edges
  Colour edge_colour = {0.13, 0.17, 0.22, 0.55};   ///< alpha mixes it with the surface

  std::vector<Colour> vertex_colours;  ///< empty, or one per vertex instead of `colour`
  std::vector<float> values;           ///< empty, or one per vertex, coloured by `scale`
  ColourScale scale;
  double contour_spacing = 0.0;  ///< > 0: isolines of `values` that far apart
};

struct SceneSphere {
  Eigen::Vector3f centre;
  float radius = 0.0F;     ///< mm, or
  float radius_px = 0.0F;  ///< pixels of the picture (instead, when > 0): a marker
  Colour colour;
};

struct SceneLine {
  std::vector<Eigen::Vector3f> points;
  Colour colour;
  double width = 2.0;  ///< pixels
  float lift = 0.0F;   ///< mm towards the viewer, so that a line on a surface is not hidden by it
};

struct SceneLabel {
  Eigen::Vector3f at;
  std::string text;
  TextStyle style{.size = 10.0};
  bool hide_behind = true;  ///< left out where a surface covers its point
};

struct Scene {
  std::vector<SceneMesh> meshes;
  std::vector<SceneSphere> spheres;
  std::vector<SceneLine> lines;
  std::vector<SceneLabel> labels;  ///< drawn by draw_scene only
};

/// Lambert shading by one light: colour × (ambient + (1 − ambient) · max(0, normal · light)).
struct RenderOptions {
  int width = 640, height = 480;  ///< pixels
  int samples = 3;                ///< per pixel along each axis, 1 to 8
  Colour background = {1.0, 1.0, 1.0, 1.0};
  float ambient = 0.32F;
  Eigen::Vector3f light{-0.25F, 0.35F, 1.0F};  ///< in view axes, towards the light
};

struct RenderedScene {
  Image image;
  /// height × width: distance towards the viewer at the pixel's middle, mm from the camera's
  /// centre; −infinity where nothing is.
  std::vector<float> depth;
};

/// Throws NoResultError for a picture that is empty or over 64 megapixels.
RenderedScene render(const Scene& scene, const Camera& camera, const RenderOptions& options,
                     const RunContext& ctx = {});

/// Renders at `scale` pixels per unit into a box of the canvas, and writes the labels as text,
/// moved aside where they would cover each other and left out where they still do. Sizes in the
/// scene (edge widths, marker radii) are canvas units.
void draw_scene(Canvas& canvas, const Box& box, const Scene& scene, const Camera& camera,
                double scale = 2.0, const RenderOptions& options = {}, const RunContext& ctx = {});

}  // namespace kinemesh
