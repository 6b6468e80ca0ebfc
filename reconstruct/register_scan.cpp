#include "reconstruct/register_scan.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "config/error.h"
#include "config/parallel.h"
#include "config/text.h"
#include "mesh/closest_point.h"
#include "mesh/laplacian.h"

namespace kinemesh {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using PointList = std::vector<Vector3d>;

constexpr std::size_t spins = 24, search_markers = 40, kept_starts = 48, finalists = 6;
constexpr double start_spacing_mm = 22.0, patch_mm = 45.0, capped_mm = 15.0;

double median_of(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Root mean square of the smaller nine tenths.
double trimmed_rms(std::vector<double> values) {
  std::ranges::sort(values, {}, [](double d) { return std::abs(d); });
  const auto used = std::max<std::size_t>(1, values.size() * 9 / 10);
  double sum = 0.0;
  for (std::size_t i = 0; i < used && i < values.size(); ++i) sum += values[i] * values[i];
  return std::sqrt(sum / static_cast<double>(used));
}

/// `count` points that are far from each other, from the first one on.
PointList spread_out(const PointList& points, std::size_t count) {
  PointList chosen{points.front()};
  std::vector<double> away(points.size(), 1e30);
  while (chosen.size() < std::min(count, points.size())) {
    std::size_t farthest = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      away[i] = std::min(away[i], (points[i] - chosen.back()).squaredNorm());
      if (away[i] > away[farthest]) farthest = i;
    }
    chosen.push_back(points[farthest]);
  }
  return chosen;
}

/// A frame on a patch of surface: z outwards, from a place in its middle.
struct Patch {
  Vector3d at, normal;
};

class Registrar {
 public:
  Registrar(const Mesh& scan, double radius) : topology_(*scan.topology), radius_(radius) {
    for (const auto& p : scan.positions) positions_.push_back(p.cast<double>());
    normals_ = vertex_normals(topology_, positions_);
    search_.emplace(positions_, topology_.faces());
    find_patches();
  }

  struct Fit {
    Isometry3d pose = Isometry3d::Identity();
    double rms = 1e9;
  };

  Fit best_fit(const PointList& markers, const RunContext& ctx) const {
    const PointList few = spread_out(markers, search_markers);
    const Patch own = patch_of(markers);
    struct Start {
      Isometry3d pose;
      double cost;
    };
    std::vector<Start> starts(patches_.size() * spins);
    parallel_for(ctx, starts.size(), 16, [&](std::size_t i) {
      const Patch& to = patches_[i / spins];
      const double angle = 2.0 * std::numbers::pi * static_cast<double>(i % spins) / spins;
      Isometry3d pose = Isometry3d::Identity();
      pose.linear() = Eigen::AngleAxisd(angle, to.normal).toRotationMatrix() *
                      Eigen::Quaterniond::FromTwoVectors(own.normal, to.normal).toRotationMatrix();
      pose.translation() = to.at - pose.linear() * own.at;
      starts[i] = {pose, capped_cost(few, pose)};
    });
    std::ranges::stable_sort(starts, {}, &Start::cost);
    starts.resize(std::min(starts.size(), kept_starts));
    parallel_for(ctx, starts.size(), 2, [&](std::size_t i) {
      starts[i].pose = refine(few, starts[i].pose, 12);
      starts[i].cost = capped_cost(few, starts[i].pose);
    });
    std::ranges::stable_sort(starts, {}, &Start::cost);
    starts.resize(std::min(starts.size(), finalists));
    Fit best;
    for (const Start& start : starts) {
      const Isometry3d pose = refine(markers, start.pose, 40);
      const double rms = trimmed_rms(distances(markers, pose));
      if (rms < best.rms) best = {pose, rms};
    }
    return best;
  }

  /// Robust point-to-plane ICP.
  Isometry3d refine(const PointList& markers, Isometry3d pose, int rounds) const {
    for (int round = 0; round < rounds; ++round) {
      struct Pair {
        Vector3d p, normal;
        double residual;
      };
      std::vector<Pair> pairs;
      std::vector<double> sizes;
      for (const Vector3d& m : markers) {
        const Vector3d p = pose * m;
        const ClosestHit hit = search_->closest(p, 80.0);
        if (!hit.point.valid()) continue;
        const Vector3d normal = normal_at(hit.point);
        pairs.push_back({p, normal, normal.dot(p - hit.position) - radius_});
        sizes.push_back(std::abs(pairs.back().residual));
      }
      if (pairs.size() < 6) return pose;
      const double scale = std::max(0.3, 2.0 * median_of(sizes));
      Vector3d middle = Vector3d::Zero();
      for (const Pair& pair : pairs) middle += pair.p / static_cast<double>(pairs.size());
      Eigen::Matrix<double, 6, 6> normal_matrix = 1e-6 * Eigen::Matrix<double, 6, 6>::Identity();
      Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
      for (const Pair& pair : pairs) {
        Eigen::Matrix<double, 6, 1> row;
        row << (pair.p - middle).cross(pair.normal), pair.normal;
        const double weight = 1.0 / (1.0 + std::pow(pair.residual / scale, 2));
        normal_matrix += weight * row * row.transpose();
        right -= weight * pair.residual * row;
      }
      const Eigen::Matrix<double, 6, 1> step = normal_matrix.ldlt().solve(right);
      const Vector3d turn = step.head<3>();
      const double angle = std::min(turn.norm(), 0.3);
      Isometry3d move = Isometry3d::Identity();
      if (angle > 0.0) {
        move.linear() = Eigen::AngleAxisd(angle, turn.normalized()).toRotationMatrix();
      }
      move.translation() = middle + step.tail<3>() - move.linear() * middle;
      pose = move * pose;
      if (angle < 1e-6 && step.tail<3>().norm() < 1e-4) break;
    }
    return pose;
  }

  /// Signed distances of the markers' centres less their radius; unreached ones count 80 mm.
  std::vector<double> distances(const PointList& markers, const Isometry3d& pose) const {
    std::vector<double> result;
    for (const Vector3d& m : markers) {
      const Vector3d p = pose * m;
      const ClosestHit hit = search_->closest(p, 80.0);
      if (!hit.point.valid()) {
        result.push_back(80.0);
        continue;
      }
      const double side = normal_at(hit.point).dot(p - hit.position) < 0.0 ? -1.0 : 1.0;
      result.push_back(side * hit.distance - radius_);
    }
    return result;
  }

  /// Feet of the markers after a smooth pull onto the scan.
  std::vector<SurfacePoint> feet(PointList markers) const {
    for (const double width : {40.0, 30.0, 20.0, 15.0}) {
      PointList pull;
      for (const Vector3d& p : markers) {
        const ClosestHit hit = search_->closest(p);
        const Vector3d normal = normal_at(hit.point);
        pull.push_back(-normal * (normal.dot(p - hit.position) - radius_));
      }
      PointList moved = markers;
      for (std::size_t i = 0; i < markers.size(); ++i) {
        Vector3d sum = Vector3d::Zero();
        double weights = 0.0;
        for (std::size_t j = 0; j < markers.size(); ++j) {
          const double d2 = (markers[i] - markers[j]).squaredNorm();
          const double w = std::exp(-0.5 * d2 / (width * width));
          sum += w * pull[j];
          weights += w;
        }
        moved[i] += sum / weights;
      }
      markers = std::move(moved);
    }
    std::vector<SurfacePoint> points;
    for (const Vector3d& p : markers) points.push_back(search_->closest(p).point);
    return points;
  }

  Vector3d normal_at(const SurfacePoint& point) const {
    return position_of(point, topology_, normals_).normalized();
  }
  const PointList& positions() const { return positions_; }
  const Topology& topology() const { return topology_; }

 private:
  double capped_cost(const PointList& markers, const Isometry3d& pose) const {
    double cost = 0.0;
    for (const Vector3d& m : markers) {
      const double d = std::min(search_->closest(pose * m, capped_mm + radius_).distance, 1e3);
      cost += std::min(std::pow(d - radius_, 2), capped_mm * capped_mm);
    }
    return cost;
  }

  /// Places all over the scan, with the mean normal around each.
  void find_patches() {
    PointList places;
    const std::size_t step = std::max<std::size_t>(1, positions_.size() / 20000);
    std::vector<VertexIndex> sample;
    for (VertexIndex v = 0; v < positions_.size(); v += static_cast<VertexIndex>(step)) {
      if (normals_[v].squaredNorm() > 0.5) sample.push_back(v);
    }
    for (const VertexIndex v : sample) {
      const bool near = std::ranges::any_of(places, [&](const Vector3d& p) {
        return (p - positions_[v]).squaredNorm() < start_spacing_mm * start_spacing_mm;
      });
      if (near) continue;
      places.push_back(positions_[v]);
      Vector3d normal = Vector3d::Zero();
      for (const VertexIndex other : sample) {
        const double d2 = (positions_[other] - positions_[v]).squaredNorm();
        if (d2 < patch_mm * patch_mm) normal += normals_[other];
      }
      if (normal.norm() > 0.0) patches_.push_back({positions_[v], normal.normalized()});
    }
  }

  /// The markers as a patch: they bulge outwards, so that those far from the middle lie lower.
  static Patch patch_of(const PointList& markers) {
    Vector3d middle = Vector3d::Zero();
    for (const Vector3d& m : markers) middle += m / static_cast<double>(markers.size());
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const Vector3d& m : markers) spread += (m - middle) * (m - middle).transpose();
    // Axis of least spread by inverse iteration.
    const Eigen::Matrix3d inverse =
        (spread + 1e-6 * spread.trace() * Eigen::Matrix3d::Identity()).inverse();
    Vector3d axis(0.3, 0.5, 0.8);
    for (int i = 0; i < 60; ++i) axis = (inverse * axis).normalized();
    double covariance = 0.0, mean = spread.trace() / static_cast<double>(markers.size());
    for (const Vector3d& m : markers) {
      covariance += ((m - middle).squaredNorm() - mean) * axis.dot(m - middle);
    }
    if (covariance > 0.0) axis = -axis;
    Vector3d at = markers.front();
    for (const Vector3d& m : markers) {
      const auto beside = [&](const Vector3d& p) {
        const Vector3d d = p - middle;
        return (d - axis.dot(d) * axis).squaredNorm();
      };
      if (beside(m) < beside(at)) at = m;
    }
    return {at, axis};
  }

  const Topology& topology_;
  double radius_;
  PointList positions_, normals_;
  std::optional<ClosestPointSearch> search_;
  std::vector<Patch> patches_;
};

RigidFit rigid(const Isometry3d& pose) {
  RigidFit fit;
  fit.rotation = pose.linear();
  fit.translation = pose.translation();
  return fit;
}

PointList mirrored(PointList points) {
  for (Vector3d& p : points) p.x() = -p.x();
  return points;
}

[[noreturn]] void refuse_mirrored(double as_is, double as_mirror) {
  throw NoResultError({.what = "the markers are the mirror image of the scan: they fit it within " +
                               format_fixed(as_mirror, 2) + " mm when mirrored, and only within " +
                               format_fixed(as_is, 2) + " mm as they are",
                       .remedy = "Check the axes with which session and scan were exported: one of "
                                 "them has swapped or negated a single axis"});
}

void keep_near(const std::vector<std::string>& labels, const RegisterOptions& options,
               Registration& result) {
  std::vector<std::string> far;
  std::vector<double> near;
  for (std::size_t m = 0; m < labels.size(); ++m) {
    if (std::abs(result.distance_mm[m]) <= options.farthest_mm) {
      result.kept.push_back(m);
      near.push_back(result.distance_mm[m]);
    } else {
      far.push_back(labels[m] + " (" + format_fixed(result.distance_mm[m], 0) + " mm)");
    }
  }
  if (result.kept.size() < 3 || 3 * far.size() > labels.size()) {
    throw NoResultError(
        {.what = "the markers do not fit the scan: " + std::to_string(far.size()) + " of " +
                 std::to_string(labels.size()) + " lie more than " +
                 format_number(options.farthest_mm) + " mm off it",
         .remedy = "Check that scan and session are of the same subject and that the neutral frame "
                   "is neutral (--neutral), or say where the markers sit with --points"});
  }
  double sum = 0.0;
  for (const double d : near) sum += d * d;
  result.rms_mm = std::sqrt(sum / static_cast<double>(near.size()));
  if (far.empty()) return;
  const std::size_t all = far.size();
  if (far.size() > 8) far.resize(8);
  result.notes.push_back(count_of(all, "marker") + " farther than " +
                         format_number(options.farthest_mm) + " mm from the scan left out: " +
                         join(far, ", ") + (all > 8 ? " …" : "") + "; see --farthest");
}

}  // namespace

void RegisterOptions::declare(ParameterSet& p) {
  p.group("attach", "Attaching markers to the scan");
  p.number("marker-radius", marker_radius_mm,
           {.unit = "mm",
            .min = 0.0,
            .max = 20.0,
            .help = "distance of the markers' centres from the skin they sit on"});
  p.number("farthest", farthest_mm,
           {.unit = "mm",
            .min = 0.5,
            .max = 100.0,
            .help = "markers farther from the scan than this are left out"});
}

Registration register_markers(const Mesh& scan, const PointList& neutral,
                              const std::vector<std::string>& labels,
                              const RegisterOptions& options, const RunContext& ctx) {
  options.validate();
  if (neutral.size() < 6) {
    throw NoResultError({.what = "fewer than six markers: their places on the scan cannot be found",
                         .remedy = "Say where they sit with --points"});
  }
  const Registrar registrar(scan, options.marker_radius_mm);
  const auto found = registrar.best_fit(neutral, ctx.part(0.0, 0.5, "registering"));
  // Faces are nearly symmetric: a mirrored one fits well, but the right one much better.
  if (found.rms > 0.1) {
    const auto turned =
        registrar.best_fit(mirrored(neutral), ctx.part(0.5, 1.0, "registering mirrored"));
    if (turned.rms < 0.7 * found.rms) refuse_mirrored(found.rms, turned.rms);
  }
  Registration result;
  result.pose = rigid(found.pose);
  result.distance_mm = registrar.distances(neutral, found.pose);
  keep_near(labels, options, result);
  PointList on_scan;
  for (const std::size_t m : result.kept) on_scan.push_back(found.pose * neutral[m]);
  const std::vector<SurfacePoint> feet = registrar.feet(on_scan);
  for (std::size_t i = 0; i < feet.size(); ++i) {
    result.markers.push_back({labels[result.kept[i]], feet[i], options.marker_radius_mm});
  }
  return result;
}

Registration register_at(const Mesh& scan, const std::vector<AttachedMarker>& places,
                         const PointList& neutral, const std::vector<std::string>& labels,
                         const RegisterOptions& options) {
  options.validate();
  PointList positions;
  for (const auto& p : scan.positions) positions.push_back(p.cast<double>());
  const PointList normals = vertex_normals(*scan.topology, positions);
  PointList from, to;
  Registration result;
  for (const AttachedMarker& place : places) {
    const auto it = std::ranges::find(labels, place.label);
    if (it == labels.end()) {
      result.notes.push_back("The session has no marker '" + place.label +
                             "' that the points file places");
      continue;
    }
    result.kept.push_back(static_cast<std::size_t>(it - labels.begin()));
    result.markers.push_back(place);
    from.push_back(neutral[result.kept.back()]);
    to.push_back(position_of(place.point, *scan.topology, positions) +
                 place.stand_off_mm *
                     position_of(place.point, *scan.topology, normals).normalized());
  }
  if (from.size() < 3) {
    throw NoResultError({.what = "fewer than three markers of the session have a place on the scan",
                         .remedy = "Check the labels of the points file"});
  }
  result.pose = fit_rigid(from, to);
  const double mirror = fit_rigid(mirrored(from), to).rms;
  if (result.pose.rms > 2.0 && mirror < 0.5 * result.pose.rms) {
    refuse_mirrored(result.pose.rms, mirror);
  }
  result.distance_mm.assign(labels.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < from.size(); ++i) {
    result.distance_mm[result.kept[i]] = (result.pose.apply(from[i]) - to[i]).norm();
  }
  result.rms_mm = result.pose.rms;
  if (result.rms_mm > options.farthest_mm) {
    throw NoResultError({.what = "the markers lie " + format_fixed(result.rms_mm, 0) +
                                 " mm (root mean square) from their places on the scan",
                         .remedy = "Check the points file: the labels, the scan and its unit"});
  }
  return result;
}

}  // namespace kinemesh
