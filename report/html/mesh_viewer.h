// A 3D view of an animated mesh for HTML pages: turned, zoomed, scrubbed and played in the browser
// with WebGL, by mouse, touch and keyboard.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mesh/animated_mesh.h"
#include "report/camera.h"
#include "report/colour.h"
#include "report/html/animation_code.h"
#include "report/html/page.h"

namespace kinemesh {

/// Values that colour the surface.
struct ViewerField {
  ColourScale scale;          ///< fixed over time, with label and unit
  std::vector<float> values;  ///< one per vertex, or frames × vertices; NaN: no value
};

struct MeshViewerOptions {
  std::string title{};                ///< inside the view
  std::optional<BodyAxes> axes{};     ///< otherwise estimated
  std::vector<ViewerField> fields{};  ///< the last one is shown first
  AnimationCodeOptions code{};
  std::string group{};  ///< views of one group turn and play together; empty: alone
  /// For a group whose takes differ in time: the frame of this mesh at each common step, the same
  /// number of steps in every member. Empty: by seconds.
  std::vector<double> timeline{};
};

/// A component (report/html/components.h). Encoded once, when it is made.
class MeshViewer {
 public:
  /// Throws as encode_animation, and InternalError for fields of the wrong size.
  explicit MeshViewer(const AnimatedMesh& animation, MeshViewerOptions options = {},
                      const RunContext& ctx = {});

  std::string render(HtmlContext& context) const;

  /// What the compression cost, and the sentence that says so (also below the view).
  const AnimationCode& code() const { return code_; }
  std::string statement() const;

 private:
  std::string title_, about_, data_, colour_controls_, statement_;
  bool named_ = false, has_filled_ = false;
  AnimationCode code_;
};

}  // namespace kinemesh
