#include "tests/support/ict_expressions.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "mesh/laplacian.h"
#include "tests/support/random.h"

namespace kinemesh::test {
namespace {

DriveError error_of(std::vector<double> errors) {
  DriveError e;
  if (errors.empty()) return e;
  e.mean = std::accumulate(errors.begin(), errors.end(), 0.0) / static_cast<double>(errors.size());
  const auto nth =
      errors.begin() + static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(errors.size()));
  std::nth_element(errors.begin(), nth, errors.end());
  e.p95 = *nth;
  return e;
}

}  // namespace

IctExpressions ict_expressions(uint64_t identity, double noise_mm, double least_mm,
                               double stand_off_mm) {
  const IctModel& model = ict_model();
  const IctActor actor(model, {.seed = identity}, {});
  IctExpressions ict;
  ict.scan.topology = model.topology;
  for (const auto& p : actor.rest()) ict.scan.positions.push_back(p.cast<float>());
  const auto points = place_ict_markers(model, least_mm, 40 + identity);
  std::vector<Marker> labels;
  for (std::size_t m = 0; m < points.size(); ++m) {
    ict.markers.push_back({"M" + std::to_string(m + 1), points[m], stand_off_mm});
    labels.push_back({.label = ict.markers.back().label});
  }
  const std::size_t frames = model.expressions.size();
  ict.measured = MarkerSequence::invalid(frames, labels, 0.0);
  Random random(identity * 7919 + 3);
  for (std::size_t f = 0; f < frames; ++f) {
    std::vector<Eigen::Vector3d> moved = actor.rest();
    std::vector<Eigen::Vector3f> truth;
    for (std::size_t v = 0; v < moved.size(); ++v) {
      moved[v] += model.expressions[f][v].cast<double>();
      truth.push_back(moved[v].cast<float>());
    }
    const auto normals = vertex_normals(*model.topology, moved);
    for (std::size_t m = 0; m < points.size(); ++m) {
      const Eigen::Vector3d centre =
          position_of(points[m], *model.topology, moved) +
          stand_off_mm * position_of(points[m], *model.topology, normals).normalized();
      ict.measured.position(f, m) = (centre + noise_mm * random.normal3()).cast<float>();
      ict.measured.flags()[ict.measured.sample(f, m)] = SampleFlag::valid;
    }
    ict.truth.push_back(std::move(truth));
  }
  for (const auto& p : actor.rest()) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& point : points) {
      nearest = std::min(nearest, (position_of(point, *model.topology, actor.rest()) - p).norm());
    }
    ict.near_markers.push_back(nearest <= 12.0);
  }
  return ict;
}

DriveError drive_error(const IctExpressions& ict, const AnimatedMesh& driven,
                       const std::vector<bool>& chosen) {
  std::vector<double> errors;
  for (std::size_t f = 0; f < driven.frame_count(); ++f) {
    for (VertexIndex v = 0; v < driven.vertex_count(); ++v) {
      if (!chosen.empty() && !chosen[v]) continue;
      errors.push_back((driven.position(f, v) - ict.truth[f][v]).cast<double>().norm());
    }
  }
  return error_of(std::move(errors));
}

IctExpressions without_markers(const IctExpressions& ict,
                               const std::vector<std::size_t>& left_out) {
  IctExpressions fewer = ict;
  fewer.markers.clear();
  std::vector<std::size_t> kept;
  for (std::size_t m = 0; m < ict.markers.size(); ++m) {
    if (std::ranges::binary_search(left_out, m)) continue;
    kept.push_back(m);
    fewer.markers.push_back(ict.markers[m]);
  }
  fewer.measured = ict.measured.select(kept);
  return fewer;
}

DriveError place_error(const IctExpressions& ict, const std::vector<std::size_t>& markers,
                       const AnimatedMesh& driven) {
  std::vector<double> errors;
  for (std::size_t f = 0; f < driven.frame_count(); ++f) {
    for (const std::size_t m : markers) {
      const SurfacePoint& p = ict.markers[m].point;
      const Triangle& face = ict.scan.topology->faces()[p.face];
      Eigen::Vector3d off = Eigen::Vector3d::Zero();
      for (std::size_t c = 0; c < 3; ++c) {
        off += p.weights[c] * (driven.position(f, face[c]) - ict.truth[f][face[c]]).cast<double>();
      }
      errors.push_back(off.norm());
    }
  }
  return error_of(std::move(errors));
}

std::vector<std::size_t> draw_markers(std::size_t count, std::size_t of, uint64_t seed) {
  std::vector<std::size_t> all(of);
  std::iota(all.begin(), all.end(), std::size_t{0});
  Random random(seed);
  random.shuffle(all);
  all.resize(std::min(count, of));
  std::ranges::sort(all);
  return all;
}

}  // namespace kinemesh::test
