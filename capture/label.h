// Labelling: points without identity are joined into trajectories and named from a template of the
// subject, by its rigid and its spatial structure.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "capture/marker_sequence.h"
#include "capture/rigid_fit.h"
#include "config/run_context.h"

namespace kinemesh {

/// What a subject's marker set looks like, learnt from a labelled take.
struct SubjectTemplate {
  std::vector<Marker> markers;
  std::vector<Eigen::Vector3d> positions;  ///< median place in the head's coordinates, mm
  std::vector<double> spread_mm;           ///< RMS distance from it over the take
  std::vector<std::size_t> rigid;          ///< indices of those that move as one body
  /// Some frames of the take in the same coordinates; NaN where a marker was not seen.
  std::vector<std::vector<Eigen::Vector3d>> shapes;
};

/// Markers of the body that are measured at least once. Label swaps are mended first. Throws
/// NoResultError when fewer than four are left, or no frame shows three of them.
SubjectTemplate learn_template(const MarkerSequence& take, const RunContext& ctx = {});

/// Places the template among unordered points without any hint: triples of its most rigid markers
/// are sought by their mutual distances, each pose that they give is judged by how many markers
/// find a point, and the best refined. Nothing when less than half of the markers find one. `hint`:
/// a pose to be judged first; it saves time when it is right.
std::optional<RigidFit> locate_template(const SubjectTemplate& subject,
                                        const std::vector<Eigen::Vector3d>& points,
                                        const std::optional<RigidFit>& hint = {});

struct LabelResult {
  /// The take with the template's markers (those it already had, then the new ones); what got no
  /// label stays among the points without identity.
  MarkerSequence take;
  std::size_t points = 0;        ///< without identity, over all frames
  std::size_t labelled = 0;      ///< of them
  std::size_t trajectories = 0;  ///< unbroken runs of labelled points
  std::size_t start = 0;         ///< 0-based: the frame from which labels were carried both ways
  std::vector<std::string> warnings;  ///< full sentences, also sent to ctx
};

/// Points without identity and points of unlabelled columns get labels; samples that have one keep
/// it. The frame that fits the template best is labelled first (rigid pose, then the smooth
/// deformation that matches most points), and labels are carried both ways in time: by the
/// marker's and its neighbours' motion while it is seen, by its neighbours' rigid motion while it
/// is not. No point is given two labels, no label two points. Throws NoResultError when the
/// template is not found among the points.
LabelResult label_points(const MarkerSequence& take, const SubjectTemplate& subject,
                         const RunContext& ctx = {});

}  // namespace kinemesh
