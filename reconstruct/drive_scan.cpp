#include "reconstruct/drive_scan.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

#include "capture/rigid_fit.h"
#include "config/error.h"
#include "config/parallel.h"
#include "mesh/laplacian.h"
#include "reconstruct/marker_field.h"
#include "reconstruct/spread_product.h"

namespace kinemesh {
namespace {

using Eigen::Index;

struct Driving {
  const Mesh& scan;
  const std::vector<AttachedMarker>& markers;
  const MarkerSequence& take;
  std::vector<Eigen::Vector3d> positions;  // of the scan
  std::vector<SurfacePoint> points;
};

void check(const Driving& d) {
  if (d.markers.size() < 3) {
    throw NoResultError({.what = "fewer than three markers lie on the scan",
                         .remedy = "Check that scan and session are of the same subject"});
  }
  if (d.take.marker_count() != d.markers.size()) {
    throw InternalError("the take does not have the attached markers");
  }
  for (std::size_t f = 0; f < d.take.frame_count(); ++f) {
    for (std::size_t m = 0; m < d.markers.size(); ++m) {
      if (d.take.valid(f, m) && d.take.position(f, m).allFinite()) continue;
      throw InputError({.what = "a sample has no position",
                        .file = d.take.origin.path,
                        .marker = d.markers[m].label,
                        .frame = d.take.first_frame + static_cast<int64_t>(f),
                        .remedy = "Fill the gaps first"});
    }
  }
  for (std::size_t m = 0; m < d.markers.size(); ++m) {
    const Eigen::Vector3d p = position_of(d.points[m], *d.scan.topology, d.positions);
    for (std::size_t other = 0; other < m; ++other) {
      if ((p - position_of(d.points[other], *d.scan.topology, d.positions)).norm() > 1e-3) continue;
      throw NoResultError({.what = "two markers lie at the same place of the scan: '" +
                                   d.markers[other].label + "' and '" + d.markers[m].label + "'",
                           .marker = d.markers[m].label,
                           .remedy = "Leave one of them out with --exclude"});
    }
  }
}

/// Smooth normals of the scan at the markers: a single facet of a scan is noise.
std::vector<Eigen::Vector3d> rest_normals(const Driving& d) {
  const std::vector<Eigen::Vector3d> of_vertices = vertex_normals(*d.scan.topology, d.positions);
  std::vector<Eigen::Vector3d> normals;
  for (const SurfacePoint& p : d.points) {
    normals.push_back(position_of(p, *d.scan.topology, of_vertices).normalized());
  }
  return normals;
}

/// Displacements of the skin under the markers: the marker's centre minus its stand-off along the
/// normal, which turns with the skin (`turned`; empty: as at rest).
Eigen::MatrixXd displacements(const Driving& d, const std::vector<Eigen::Vector3d>& normals,
                              const std::vector<Eigen::Vector3d>& turned) {
  const std::size_t count = d.markers.size(), frames = d.take.frame_count();
  Eigen::MatrixXd y(static_cast<Index>(count), static_cast<Index>(3 * frames));
  for (std::size_t m = 0; m < count; ++m) {
    const Eigen::Vector3d foot = position_of(d.points[m], *d.scan.topology, d.positions);
    for (std::size_t f = 0; f < frames; ++f) {
      const Eigen::Vector3d& normal = turned.empty() ? normals[m] : turned[f * count + m];
      const Eigen::Vector3d move =
          d.take.position(f, m).cast<double>() - d.markers[m].stand_off_mm * normal - foot;
      y.block<1, 3>(static_cast<Index>(m), static_cast<Index>(3 * f)) = move.transpose();
    }
  }
  return y;
}

/// The markers that are closest on the surface, itself first.
std::vector<std::size_t> companions(const Eigen::MatrixXd& covariance, std::size_t marker) {
  std::vector<std::size_t> order(static_cast<std::size_t>(covariance.rows()));
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto nearness = [&](std::size_t i) {
    const auto a = static_cast<Index>(marker), b = static_cast<Index>(i);
    return -covariance(a, b) / std::sqrt(covariance(a, a) * covariance(b, b));
  };
  std::ranges::stable_sort(order, {}, nearness);
  order.resize(std::min<std::size_t>(order.size(), 8));
  return order;
}

/// Where the skin's normals turn to in every frame (frames × markers): with the rigid motion of
/// each marker and its neighbours on the surface.
std::vector<Eigen::Vector3d> turned_normals(const Driving& d,
                                            const std::vector<Eigen::Vector3d>& normals,
                                            const Eigen::MatrixXd& covariance,
                                            const RunContext& ctx) {
  const std::size_t count = d.markers.size(), frames = d.take.frame_count();
  std::vector<Eigen::Vector3d> rest, turned(frames * count);
  for (std::size_t m = 0; m < count; ++m) {
    rest.push_back(position_of(d.points[m], *d.scan.topology, d.positions) +
                   d.markers[m].stand_off_mm * normals[m]);
  }
  parallel_for(ctx, count, 4, [&](std::size_t m) {
    const std::vector<std::size_t> group = companions(covariance, m);
    std::vector<Eigen::Vector3d> from, to(group.size());
    for (const std::size_t g : group) from.push_back(rest[g]);
    for (std::size_t f = 0; f < frames; ++f) {
      for (std::size_t i = 0; i < group.size(); ++i) {
        to[i] = d.take.position(f, group[i]).cast<double>();
      }
      const RigidFit fit = fit_rigid(from, to);
      turned[f * count + m] = fit.spread > 1.0 ? fit.rotation * normals[m] : normals[m];
    }
  });
  return turned;
}

Eigen::Matrix<uint8_t, Eigen::Dynamic, Eigen::Dynamic> measured_of(const MarkerSequence& take) {
  Eigen::Matrix<uint8_t, Eigen::Dynamic, Eigen::Dynamic> measured(
      static_cast<Index>(take.marker_count()), static_cast<Index>(take.frame_count()));
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    for (std::size_t m = 0; m < take.marker_count(); ++m) {
      measured(static_cast<Index>(m), static_cast<Index>(f)) =
          take.valid(f, m) && !take.filled(f, m) ? 1 : 0;
    }
  }
  return measured;
}

std::vector<double> marker_errors(const Driving& d, const AnimatedMesh& animation,
                                  const std::vector<Eigen::Vector3d>& normals,
                                  const std::vector<Eigen::Vector3d>& turned, std::size_t first) {
  std::vector<double> errors;
  for (std::size_t m = 0; m < d.markers.size(); ++m) {
    const Triangle& face = d.scan.topology->faces()[d.points[m].face];
    double sum = 0.0, count = 0.0;
    for (std::size_t f = 0; f < animation.frame_count(); ++f) {
      const std::size_t frame = first + f;
      if (d.take.filled(frame, m)) continue;
      Eigen::Vector3d place = Eigen::Vector3d::Zero();
      for (std::size_t c = 0; c < 3; ++c) {
        place += d.points[m].weights[c] * animation.position(f, face[c]).cast<double>();
      }
      place += d.markers[m].stand_off_mm *
               (turned.empty() ? normals[m] : turned[frame * d.markers.size() + m]);
      sum += (place - d.take.position(frame, m).cast<double>()).squaredNorm();
      count += 1.0;
    }
    errors.push_back(count > 0.0 ? std::sqrt(sum / count) : 0.0);
  }
  return errors;
}

}  // namespace

void DriveOptions::declare(ParameterSet& p) {
  p.group("drive", "Driving the scan");
  p.choice("method", method,
           {{DriveMethod::surface, "surface", "a random field on the surface"},
            {DriveMethod::geodesic, "geodesic", "radial functions of the distance on the surface"},
            {DriveMethod::biharmonic, "biharmonic", "least bending of the displacements"},
            {DriveMethod::euclidean, "euclidean", "thin-plate spline in space, for comparison"}},
           "how the motion of the markers spreads over the scan");
  p.number("reach", reach_mm,
           {.unit = "mm",
            .min = 0.0,
            .max = 1000.0,
            .help = "distance over which a marker's motion fades where no other marker is; 0: 1.6 "
                    "times the distance between markers"});
  p.number("solve-faces", most_faces,
           {.min = 1000,
            .max = 1e9,
            .help = "a scan of more triangles is solved on a mesh decimated to so many, and driven "
                    "at full resolution"});
  p.flag("smooth", smooth, "take off measurement noise that no neighbouring marker shares");
  p.number("noise", noise_mm,
           {.unit = "mm",
            .min = 0.0,
            .max = 10.0,
            .help = "measurement noise of one coordinate of a marker; 0: estimated"});
  p.number("fade", fade_s,
           {.unit = "s",
            .min = 0.0,
            .max = 10.0,
            .help = "time over which a marker without measurement gives way to its neighbours"});
}

DriveResult drive_scan(const Mesh& scan, const std::vector<AttachedMarker>& markers,
                       const MarkerSequence& take, const DriveOptions& options,
                       const RunContext& ctx) {
  options.validate();
  Driving d{scan, markers, take, {}, {}};
  for (const auto& p : scan.positions) d.positions.push_back(p.cast<double>());
  for (const AttachedMarker& m : markers) d.points.push_back(m.point);
  check(d);
  DriveResult result;
  const DriveOperator op = make_drive_operator(
      *scan.topology, d.positions, d.points, options.method, options.reach_mm,
      static_cast<std::size_t>(options.most_faces), ctx.part(0.0, 0.5, "attaching"));
  result.reach_mm = op.reach_mm;
  result.solved_faces = op.solved_faces;
  result.operator_seconds = op.seconds;
  const std::vector<Eigen::Vector3d> normals = rest_normals(d);
  const Eigen::MatrixXf absence = absence_of(measured_of(take), take.rate_hz, options.fade_s);
  const RunContext settling = ctx.part(0.5, 0.7, "settling");
  std::vector<Eigen::Vector3d> turned;
  if (std::ranges::any_of(markers, [](const auto& m) { return m.stand_off_mm != 0.0; })) {
    turned = turned_normals(d, normals, op.covariance, settling);
  }
  const MarkerFieldResult settled =
      settle_markers(displacements(d, normals, turned), absence, op.covariance,
                     {options.smooth, options.noise_mm}, settling);
  result.noise_mm = settled.noise_mm;
  result.largest_change_mm = settled.largest_change_mm;
  const auto start = std::chrono::steady_clock::now();
  const PackedSpread spread(op.spread);
  const std::size_t first = options.frames.count > 0 ? options.frames.first : 0;
  const std::size_t count = options.frames.count > 0 ? options.frames.count : take.frame_count();
  if (first + count > take.frame_count()) throw InternalError("frames that the take does not have");
  result.animation = AnimatedMesh(scan.topology, count, take.rate_hz);
  std::vector<float> rest;
  for (const auto& p : scan.positions) rest.insert(rest.end(), {p.x(), p.y(), p.z()});
  const Eigen::MatrixXf moves = settled.displacements.middleCols(static_cast<Index>(3 * first),
                                                                 static_cast<Index>(3 * count));
  spread.apply(rest, moves, result.animation.positions(), ctx.part(0.7, 1.0, "driving"));
  result.frames_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  result.animation.first_frame = take.first_frame + static_cast<int64_t>(first);
  result.animation.events = take.events;
  result.animation.vertex_names = scan.vertex_names;
  result.marker_error_mm = marker_errors(d, result.animation, normals, turned, first);
  return result;
}

}  // namespace kinemesh
