#include "tests/support/synthetic_take.h"

#include <array>
#include <cmath>

#include "tests/support/random.h"

namespace kinemesh::test {

namespace {

/// Rigid places in the face frame as fractions of the head's half extents.
constexpr std::array<std::array<double, 3>, 6> rig_places{{{0.62, 1.02, 0.62},
                                                           {-0.60, 1.04, 0.60},
                                                           {0.70, 0.92, -0.55},
                                                           {-0.68, 0.95, -0.58},
                                                           {0.06, 1.38, 0.05},
                                                           {-0.10, 0.80, -0.98}}};

Eigen::Vector3d rig_place(const FaceShape& s, std::size_t k) {
  const auto& f = rig_places[k];
  return {80 * s.width * f[0], 95 * s.height * f[1], 98 * s.depth * f[2]};
}

std::vector<Marker> markers_of(const MarkerLayout& layout, const TakeOptions& options) {
  std::vector<Marker> markers;
  const auto add = [&](const std::string& label) {
    Marker marker;
    marker.label = label;
    marker.subject = options.subject;
    markers.push_back(std::move(marker));
  };
  for (const std::string& label : layout.labels) add(label);
  if (options.head_rig) {
    for (const std::string& label : head_rig_labels()) add(label);
  }
  return markers;
}

/// True positions of one frame, in double precision.
std::vector<Eigen::Vector3d> true_frame(const SyntheticTake& take, std::size_t frame, bool rig) {
  std::vector<Eigen::Vector3d> points;
  for (const SurfacePoint& p : take.layout.points) {
    points.emplace_back(take.head_pose[frame] * take.face->point(p, take.weights[frame]));
  }
  for (std::size_t k = 0; rig && k < rig_places.size(); ++k) {
    points.emplace_back(take.head_pose[frame] * rig_place(take.face->shape(), k));
  }
  return points;
}

}  // namespace

const std::vector<std::string>& head_rig_labels() {
  static const std::vector<std::string> labels{"LFHD", "RFHD",    "LBHD",
                                               "RBHD", "HeadTop", "rootNape"};
  return labels;
}

SyntheticTake make_take(std::shared_ptr<const SyntheticFace> face, const MarkerLayout& layout,
                        const Motion& motion, const TakeOptions& options) {
  SyntheticTake take{std::move(face), layout, motion, {}, {}, {}, {}, {}, {}};
  const auto frames = static_cast<std::size_t>(std::lround(options.duration_s * options.rate_hz));
  Random seeds(options.seed * 6700417 + 11);
  take.head_pose = wandering_head(frames, options, Random(seeds.bits()));
  for (std::size_t f = 0; f < frames; ++f) {
    take.weights.push_back(motion.at(static_cast<double>(f) / options.rate_hz));
  }
  const auto true_markers = [&](std::size_t f) { return true_frame(take, f, options.head_rig); };
  Recording recording =
      record(markers_of(layout, options), layout.size(), true_markers, options, seeds);
  take.measured = std::move(recording.measured);
  take.truth = std::move(recording.truth);
  take.gaps = std::move(recording.gaps);
  take.swap = recording.swap;
  for (MarkerSequence* s : {&take.measured, &take.truth}) {
    s->events.push_back({"onset", "General", options.subject, motion.onset_s});
    s->events.push_back({"peak", "General", options.subject, motion.peak_s});
  }
  return take;
}

TrueSurface SyntheticTake::surface_at(std::size_t frame) const {
  TrueSurface surface = face->surface(weights[frame]);
  for (Eigen::Vector3d& p : surface.positions) p = head_pose[frame] * p;
  return surface;
}

GeodesicDelaunay SyntheticTake::reference_at(std::size_t frame) const {
  return geodesic_delaunay(surface_at(frame), layout.points, {.open = motion.openings});
}

}  // namespace kinemesh::test
