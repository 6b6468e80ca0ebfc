#include "report/contact_sheet.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "config/error.h"
#include "config/text.h"
#include "report/camera.h"
#include "report/chart.h"
#include "report/figure_layout.h"
#include "report/mesh_view.h"

namespace kinemesh {
namespace {

using Eigen::Vector3f;

constexpr double cell_width = 250.0;
constexpr double cell_gap = 10.0;
constexpr double pixels_per_unit = 2.0;

// Lengths of at most 1,000 edges of a frame.
Eigen::VectorXf edge_lengths(const AnimatedMesh& animation, std::size_t frame) {
  const auto& edges = animation.topology().edges();
  const std::size_t step = edges.size() / 1000 + 1;
  Eigen::VectorXf lengths((edges.size() + step - 1) / step);
  for (std::size_t i = 0; i * step < edges.size(); ++i) {
    const auto& ends = edges[i * step].vertices;
    const float length =
        (animation.position(frame, ends[0]) - animation.position(frame, ends[1])).norm();
    lengths[static_cast<Eigen::Index>(i)] = std::isfinite(length) ? length : 0.0F;
  }
  return lengths;
}

struct RigidMotion {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d from = Eigen::Vector3d::Zero(), to = from;  // a point and its image
  Vector3f operator()(const Vector3f& p) const {
    const Eigen::Vector3d moved = rotation * (p.cast<double>() - from) + to;
    return moved.cast<float>();
  }
};

// The least-squares rigid motion that lays `points` over the reference (Kabsch 1976).
RigidMotion onto_reference(const std::vector<Vector3f>& reference,
                           const std::vector<Vector3f>& points) {
  RigidMotion fit;
  double count = 0.0;
  Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
  for (const bool centred : {false, true}) {
    for (std::size_t v = 0; v < points.size(); ++v) {
      if (!points[v].allFinite() || !reference[v].allFinite()) continue;
      const Eigen::Vector3d p = points[v].cast<double>() - fit.from;
      const Eigen::Vector3d r = reference[v].cast<double>() - fit.to;
      if (centred) {
        products += r * p.transpose();
      } else {
        count += 1.0;
        // p and r are taken from the running means.
        fit.from += p / count;
        fit.to += r / count;
      }
    }
    if (count < 3.0) return {};
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(products, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d u = svd.matrixU();
  if ((u * svd.matrixV().transpose()).determinant() < 0.0) u.col(2) *= -1.0;
  fit.rotation = u * svd.matrixV().transpose();
  return fit;
}

struct ShownFrame {
  std::size_t frame;
  std::vector<Vector3f> positions;
  std::vector<VertexIndex> filled;
};

std::vector<ShownFrame> shown_frames(const AnimatedMesh& animation,
                                     const std::vector<std::size_t>& frames) {
  std::vector<ShownFrame> shown;
  const std::vector<Vector3f> reference = points_of(animation.frame(frames.front()));
  for (const std::size_t f : frames) {
    ShownFrame s{f, points_of(animation.frame(f)), {}};
    const RigidMotion fit = onto_reference(reference, s.positions);
    for (Vector3f& p : s.positions) p = fit(p);
    if (!animation.filled().empty()) {
      for (std::size_t v = 0; v < animation.vertex_count(); ++v) {
        if (animation.filled()[f * animation.vertex_count() + v] != 0) {
          s.filled.push_back(static_cast<VertexIndex>(v));
        }
      }
    }
    shown.push_back(std::move(s));
  }
  return shown;
}

Scene scene_of(const AnimatedMesh& animation, const ShownFrame& shown) {
  const bool sparse = animation.vertex_count() <= 2000;
  SceneMesh mesh{animation.shared_topology(), shown.positions};
  mesh.edge_width = sparse ? 0.9 : animation.vertex_count() <= 20000 ? 0.35 : 0.0;
  Scene scene;
  scene.meshes.push_back(std::move(mesh));
  if (!sparse) return scene;
  std::vector<bool> filled(animation.vertex_count(), false);
  for (const VertexIndex v : shown.filled) filled[v] = true;
  for (std::size_t v = 0; v < shown.positions.size(); ++v) {
    scene.spheres.push_back({.centre = shown.positions[v],
                             .radius_px = filled[v] ? 3.6F : 1.7F,
                             .colour = filled[v] ? filled_colour : colour_from_hex(0x2d4a66)});
  }
  return scene;
}

// One row of the sheet: a view of all frames.
struct Row {
  std::string name;
  Camera camera;
  double height;
};

// Both views at one scale, so that heights can be compared.
std::vector<Row> rows_of(const BodyAxes& axes, const std::vector<ShownFrame>& shown) {
  std::vector<Vector3f> all;
  for (const ShownFrame& s : shown) all.insert(all.end(), s.positions.begin(), s.positions.end());
  std::vector<Row> rows = {
      {axes.faces ? "front" : "broad side", camera_for(View::front, axes), 0.0},
      {axes.faces ? "left side" : "from one end", camera_for(View::left, axes), 0.0}};
  double mm_per_unit = 0.0;
  for (Row& row : rows) {
    aim(row.camera, all, 1e9, 0.0);  // so that view_height is the height of what is seen
    row.height = row.camera.view_height;
    Camera wide = row.camera;
    aim(wide, all, 1e-9, 0.0);
    const double width = 1e-9 * static_cast<double>(wide.view_height);
    mm_per_unit =
        std::max({mm_per_unit, width / (0.92 * cell_width), row.height / (1.4 * cell_width)});
  }
  for (Row& row : rows) {
    row.height = std::max(80.0, row.height / mm_per_unit + 20.0);
    row.camera.view_height = static_cast<float>(row.height * mm_per_unit);
  }
  return rows;
}

std::string caption(const AnimatedMesh& animation, std::size_t frame) {
  std::string text =
      "frame " +
      tick_label(static_cast<double>(animation.first_frame) + static_cast<double>(frame), 0);
  if (animation.rate_hz > 0.0) text += " · " + format_fixed(animation.time_s(frame), 2) + " s";
  return text;
}

class SheetPainter {
 public:
  SheetPainter(const AnimatedMesh& animation, const ContactSheetOptions& options,
               const std::vector<ShownFrame>& shown, std::vector<Row> rows)
      : animation_(animation), options_(options), shown_(shown), rows_(std::move(rows)) {}

  Canvas draw(const RunContext& ctx) {
    const auto columns = static_cast<double>(shown_.size());
    const double width = std::max(
        2.0 * figure_margin + label_width + columns * cell_width + (columns - 1.0) * cell_gap,
        640.0);
    double height = top + caption_height + figure_margin;
    for (const Row& row : rows_) height += row.height + cell_gap;
    Canvas canvas(width, height);
    draw_heading(canvas);
    double y = top;
    for (const Row& row : rows_) {
      canvas.text({figure_margin + 8.0, y + 0.5 * row.height}, row.name,
                  {.size = 12.0,
                   .colour = muted_colour,
                   .align = TextAlign::centre,
                   .anchor = TextAnchor::middle,
                   .angle = 90.0});
      for (std::size_t i = 0; i < shown_.size(); ++i) {
        const Box box{x_of(i), y, cell_width, row.height};
        RenderOptions render_options;
        render_options.background = colour_from_hex(0xf4f6f8);
        draw_scene(canvas, box, scene_of(animation_, shown_[i]), row.camera, pixels_per_unit,
                   render_options, ctx);
      }
      y += row.height + cell_gap;
    }
    for (std::size_t i = 0; i < shown_.size(); ++i) draw_caption(canvas, i, y);
    return canvas;
  }

 private:
  static constexpr double label_width = 24.0;
  static constexpr double top = 92.0;
  static constexpr double caption_height = 34.0;

  static double x_of(std::size_t column) {
    return figure_margin + label_width + static_cast<double>(column) * (cell_width + cell_gap);
  }

  void draw_heading(Canvas& canvas) {
    const double width = canvas.width() - 2.0 * figure_margin;
    canvas.text_within({figure_margin, 14},
                       options_.title.empty() ? "Animated mesh" : options_.title, width,
                       {.size = 18, .bold = true, .anchor = TextAnchor::top});
    canvas.text_within({figure_margin, 40}, options_.subtitle, width,
                       {.size = 12, .colour = muted_colour, .anchor = TextAnchor::top});
    if (animation_.vertex_count() > 2000) return;
    std::vector<LegendEntry> legend = {
        {"measured", colour_from_hex(0x2d4a66), LegendEntry::Symbol::dot},
        {"filled (estimated)", filled_colour, LegendEntry::Symbol::dot},
        {"inside of the surface", SceneMesh{}.back_colour, LegendEntry::Symbol::box}};
    if (animation_.filled().empty()) legend[0].label = "vertex";
    if (animation_.filled().empty()) legend.erase(legend.begin() + 1);
    draw_legend(canvas, {figure_margin, 63}, width, legend, 12.0);
  }

  void draw_caption(Canvas& canvas, std::size_t column, double y) {
    const double x = x_of(column) + 0.5 * cell_width;
    canvas.text(
        {x, y}, caption(animation_, shown_[column].frame),
        {.size = 13.0, .bold = true, .align = TextAlign::centre, .anchor = TextAnchor::top});
    const std::size_t filled = shown_[column].filled.size();
    if (filled == 0) return;
    canvas.text({x, y + 18.0}, std::to_string(filled) + " filled",
                {.size = 11.0,
                 .colour = colour_from_hex(0xa85c00),
                 .align = TextAlign::centre,
                 .anchor = TextAnchor::top});
  }

  const AnimatedMesh& animation_;
  const ContactSheetOptions& options_;
  const std::vector<ShownFrame>& shown_;
  std::vector<Row> rows_;
};

}  // namespace

std::optional<Vector3f> direction_of(UpAxis axis) {
  switch (axis) {
    case UpAxis::plus_x: return Vector3f::UnitX();
    case UpAxis::minus_x: return -Vector3f::UnitX();
    case UpAxis::plus_y: return Vector3f::UnitY();
    case UpAxis::minus_y: return -Vector3f::UnitY();
    case UpAxis::plus_z: return Vector3f::UnitZ();
    case UpAxis::minus_z: return -Vector3f::UnitZ();
    default: return std::nullopt;
  }
}

void ContactSheetOptions::declare(ParameterSet& p) {
  p.group("pictures", "Pictures");
  p.number("picture-frames", frames,
           {.min = 1, .max = 24, .help = "How many frames the contact sheet shows"});
  p.choice<UpAxis>("up-axis", up,
                   {{UpAxis::automatic, "auto", "the axis about which the mesh is symmetric"},
                    {UpAxis::plus_x, "x", "the x axis points up"},
                    {UpAxis::minus_x, "-x", "the x axis points down"},
                    {UpAxis::plus_y, "y", "the y axis points up"},
                    {UpAxis::minus_y, "-y", "the y axis points down"},
                    {UpAxis::plus_z, "z", "the z axis points up"},
                    {UpAxis::minus_z, "-z", "the z axis points down"}},
                   "Which way is up in the pictures");
}

std::vector<std::size_t> telling_frames(const AnimatedMesh& animation, std::size_t count) {
  const std::size_t frames = animation.frame_count();
  if (frames <= count) {
    std::vector<std::size_t> all(frames);
    for (std::size_t f = 0; f < frames; ++f) all[f] = f;
    return all;
  }
  // Farthest-point sampling over at most 300 frames.
  const std::size_t candidates = std::min<std::size_t>(frames, 300);
  const auto frame_of = [&](std::size_t c) { return c * (frames - 1) / (candidates - 1); };
  std::vector<Eigen::VectorXf> lengths;
  for (std::size_t c = 0; c < candidates; ++c) {
    lengths.push_back(edge_lengths(animation, frame_of(c)));
  }
  std::vector<float> distance(candidates, std::numeric_limits<float>::max());
  std::vector<std::size_t> chosen;
  for (std::size_t next = 0; chosen.size() < count;) {
    chosen.push_back(frame_of(next));
    for (std::size_t c = 0; c < candidates; ++c) {
      const std::size_t apart = c > next ? c - next : next - c;
      const bool too_near = 4 * apart * count < candidates;  // one jump must not fill the sheet
      const float difference = too_near ? 0.0F : (lengths[c] - lengths[next]).squaredNorm();
      distance[c] = std::min(distance[c], difference);
    }
    next = static_cast<std::size_t>(std::max_element(distance.begin(), distance.end()) -
                                    distance.begin());
    if (!(distance[next] > 0.0F)) break;  // nothing moves
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

ContactSheetResult draw_contact_sheet(const AnimatedMesh& animation,
                                      const ContactSheetOptions& options, const RunContext& ctx) {
  options.validate();
  if (animation.frame_count() == 0 || animation.vertex_count() == 0) {
    throw NoResultError({.what = "there is nothing to draw: the mesh has no frames or vertices"});
  }
  std::vector<std::size_t> frames = options.chosen;
  std::erase_if(frames, [&](std::size_t f) { return f >= animation.frame_count(); });
  if (frames.empty()) frames = telling_frames(animation, static_cast<std::size_t>(options.frames));
  std::sort(frames.begin(), frames.end());
  const std::vector<ShownFrame> shown = shown_frames(animation, frames);
  const BodyAxes axes = estimate_axes(animation.topology(), animation.frame(frames.front()),
                                      direction_of(options.up));
  SheetPainter painter(animation, options, shown, rows_of(axes, shown));
  return {painter.draw(ctx), frames};
}

}  // namespace kinemesh
