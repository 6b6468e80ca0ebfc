// One picture of a whole animated mesh: a few frames side by side, from the front and the side.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "config/parameter.h"
#include "config/run_context.h"
#include "mesh/animated_mesh.h"
#include "report/canvas.h"
#include "report/colour.h"

namespace kinemesh {

enum class UpAxis { automatic, plus_x, minus_x, plus_y, minus_y, plus_z, minus_z };
/// Empty for automatic.
std::optional<Eigen::Vector3f> direction_of(UpAxis axis);

struct ContactSheetOptions {
  int frames = 6;                     ///< columns of the sheet
  UpAxis up = UpAxis::automatic;      ///< automatic: see estimate_axes
  std::vector<std::size_t> chosen{};  ///< 0-based frames to show instead; not a parameter
  std::string title{};                ///< "subject, take"; not a parameter
  std::string subtitle{};             ///< "160 markers, 3,000 frames at 120 Hz"; not a parameter

  void declare(ParameterSet& p);
  void validate() const { validate_options(*this); }
};

struct ContactSheetResult {
  Canvas sheet;
  std::vector<std::size_t> frames;  ///< 0-based, ascending: the frames shown
};

/// Draws the sheet: shaded with edges, samples that were filled in `filled_colour`, frame number
/// and time below. Without `chosen`, the frames are the first one and those that differ most from
/// it and from each other (in edge lengths, so that head motion does not count). The camera
/// follows the body: frames are laid over the first one rigidly. Throws NoResultError for a mesh
/// without frames or vertices.
ContactSheetResult draw_contact_sheet(const AnimatedMesh& animation,
                                      const ContactSheetOptions& options = {},
                                      const RunContext& ctx = {});

/// At most `count` frames, 0-based and ascending, as described above.
std::vector<std::size_t> telling_frames(const AnimatedMesh& animation, std::size_t count);

}  // namespace kinemesh
