#include "analysis/full_matching/anchors.h"

#include <algorithm>

#include "config/error.h"
#include "config/text.h"

namespace kinemesh::full_matching {

namespace {

std::string name_of(std::span<const LandmarkPair> landmarks, std::size_t k) {
  const std::string& name = landmarks[k].name;
  return std::to_string(k + 1) + (name.empty() ? "" : " (" + name + ")");
}

VertexIndex vertex_of(const SurfacePoint& point, const ClosedSurface& a, const std::string& name) {
  if (point.face < a.surface_faces) {
    for (std::size_t c = 0; c < 3; ++c) {
      if (point.weights[c] > 1.0 - 1e-9) return a.topology->faces()[point.face][c];
    }
  }
  throw InputError({.what = "landmark " + name + " is no vertex of the source",
                    .remedy = "Name the nearest vertex of the source; on the target any point will "
                              "do"});
}

void refuse_both(std::span<const LandmarkPair> landmarks, std::size_t i, std::size_t k,
                 const std::string& which) {
  throw NoResultError({.what = "landmarks " + name_of(landmarks, i) + " and " +
                               name_of(landmarks, k) + " are one place of the " + which +
                               ": no one-to-one map meets both",
                       .remedy = "Leave one of them out"});
}

}  // namespace

std::vector<Anchor> anchors_of(std::span<const LandmarkPair> landmarks, const ClosedSurface& a,
                               const ClosedSurface& b, std::span<const Eigen::Vector3d> sphere_b) {
  std::vector<Anchor> anchors;
  for (std::size_t k = 0; k < landmarks.size(); ++k) {
    const SurfacePoint& place = landmarks[k].target;
    const std::string name = name_of(landmarks, k);
    if (place.face >= b.surface_faces) {
      throw InputError({.what = "landmark " + name + " is no point of the target"});
    }
    Anchor anchor{vertex_of(landmarks[k].source, a, name), place, {}};
    anchor.goal = position_of(place, *b.topology, sphere_b).normalized();
    for (std::size_t i = 0; i < k; ++i) {
      if (anchors[i].vertex == anchor.vertex) refuse_both(landmarks, i, k, "source");
      if ((anchors[i].goal - anchor.goal).norm() < 1e-9) refuse_both(landmarks, i, k, "target");
    }
    anchors.push_back(anchor);
  }
  return anchors;
}

void refuse_landmarks(std::span<const LandmarkPair> landmarks, std::span<const std::size_t> away) {
  if (away.empty()) {
    throw NoResultError({.what = "a map that meets the landmarks would fold",
                         .remedy = "Leave some of them out, or remesh the source so that its "
                                   "triangles are less thin"});
  }
  std::vector<std::string> names;
  for (const std::size_t k : away) names.push_back(name_of(landmarks, k));
  throw NoResultError({.what = (names.size() == 1 ? "landmark " : "landmarks ") +
                               join(names, ", ", " and ") +
                               " cannot be met together with the others without a fold",
                       .remedy = "Check that no two are exchanged and none is mirrored, or leave "
                                 "those out"});
}

}  // namespace kinemesh::full_matching
