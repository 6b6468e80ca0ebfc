#include "capture/rigid_markers.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "capture/measured.h"
#include "capture/stabilise.h"
#include "config/parallel.h"

namespace kinemesh {
namespace {

constexpr std::size_t most_frames = 400;  // sampled evenly over the take
constexpr double unknown = std::numeric_limits<double>::infinity();

/// A sub-take of the candidates: frames × candidates.
struct Sample {
  std::vector<std::size_t> markers;
  std::size_t frames = 0;
  std::vector<Eigen::Vector3d> positions;
  std::vector<uint8_t> seen;
  const Eigen::Vector3d& at(std::size_t f, std::size_t k) const {
    return positions[f * markers.size() + k];
  }
  bool has(std::size_t f, std::size_t k) const { return seen[f * markers.size() + k] != 0; }
};

Sample sample(const MarkerSequence& take) {
  Sample out;
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    if (take.markers()[m].kind != MarkerKind::marker) continue;
    std::size_t count = 0;
    for (std::size_t f = 0; f < take.frame_count(); ++f) count += measured(take, f, m) ? 1 : 0;
    if (count > 0 && 2 * count >= take.frame_count()) out.markers.push_back(m);
  }
  out.frames = std::min(most_frames, take.frame_count());
  for (std::size_t i = 0; i < out.frames; ++i) {
    const std::size_t f = i * take.frame_count() / out.frames;
    for (const std::size_t m : out.markers) {
      out.seen.push_back(measured(take, f, m) ? 1 : 0);
      out.positions.emplace_back(take.position(f, m).cast<double>());
    }
  }
  return out;
}

/// `values` is reordered and must not be empty.
double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// Root mean square after dropping the largest hundredth. `squares` is reordered.
double trimmed_rms(std::vector<double>& squares) {
  if (squares.empty()) return unknown;
  const std::size_t keep = squares.size() - squares.size() / 100;
  std::ranges::nth_element(squares, squares.begin() + static_cast<std::ptrdiff_t>(keep - 1));
  double sum = 0.0;
  for (std::size_t i = 0; i < keep; ++i) sum += squares[i];
  return std::sqrt(sum / static_cast<double>(keep));
}

/// Change of the distance of two candidates over the take, in relation to the distance.
double relative_change(const Sample& s, std::size_t a, std::size_t b) {
  std::vector<double> distances;
  for (std::size_t f = 0; f < s.frames; ++f) {
    if (s.has(f, a) && s.has(f, b)) distances.push_back((s.at(f, a) - s.at(f, b)).norm());
  }
  if (4 * distances.size() < s.frames || distances.size() < 2) return unknown;
  const double typical = median(distances);
  if (typical <= 0.0) return unknown;
  for (double& d : distances) d = (d - typical) * (d - typical);
  return trimmed_rms(distances) / typical;
}

Eigen::MatrixXd relative_changes(const Sample& s, const RunContext& ctx) {
  const auto n = static_cast<Eigen::Index>(s.markers.size());
  Eigen::MatrixXd out = Eigen::MatrixXd::Constant(n, n, unknown);
  parallel_for(ctx, s.markers.size(), 1, [&](std::size_t a) {
    for (std::size_t b = 0; b < a; ++b) {
      out(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) = relative_change(s, a, b);
    }
  });
  out.triangularView<Eigen::StrictlyUpper>() = out.transpose();
  return out;
}

/// The largest change between `candidate` and the members.
double linkage(const Eigen::MatrixXd& change, const std::vector<std::size_t>& members,
               Eigen::Index candidate) {
  double worst = 0.0;
  for (const std::size_t m : members) {
    worst = std::max(worst, static_cast<Eigen::Index>(m) == candidate
                                ? unknown
                                : change(static_cast<Eigen::Index>(m), candidate));
  }
  return worst;
}

/// From every pair, grown by complete linkage to `size`; the set with the smallest change.
std::vector<std::size_t> tightest(const Eigen::MatrixXd& change, std::size_t size) {
  std::vector<std::size_t> best;
  double best_change = unknown;
  for (Eigen::Index a = 0; a < change.rows(); ++a) {
    for (Eigen::Index b = 0; b < a; ++b) {
      double worst = change(a, b);
      std::vector<std::size_t> members{static_cast<std::size_t>(b), static_cast<std::size_t>(a)};
      while (members.size() < size && worst < best_change) {
        Eigen::Index next = -1;
        double next_change = unknown;
        for (Eigen::Index c = 0; c < change.rows(); ++c) {
          const double link = linkage(change, members, c);
          if (link < next_change) {
            next_change = link;
            next = c;
          }
        }
        if (next < 0) break;
        members.push_back(static_cast<std::size_t>(next));
        worst = std::max(worst, next_change);
      }
      if (members.size() == size && worst < best_change) {
        best_change = worst;
        best = members;
      }
    }
  }
  return best;
}

/// The body that the members form, tracked through the sample.
struct Body {
  std::vector<Eigen::Vector3d> places;  ///< of all candidates in body coordinates
  std::vector<double> residuals;        ///< of all candidates, trimmed RMS, 3D; mm
  double member_rms = 0.0;              ///< of the members, corrected for the freedom of the poses
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Matrix3d turning = Eigen::Matrix3d::Zero();  ///< inverse of Σ (|r|² I − r rᵀ), mm⁻²
};

std::vector<HeadPose> track(const Sample& s, RigidShape& shape) {
  std::vector<HeadPose> poses(s.frames);
  std::vector<Eigen::Vector3d> positions(shape.markers.size());
  std::vector<bool> visible(shape.markers.size());
  for (std::size_t f = 0; f < s.frames; ++f) {
    for (std::size_t k = 0; k < shape.markers.size(); ++k) {
      positions[k] = s.at(f, shape.markers[k]);
      visible[k] = s.has(f, shape.markers[k]);
    }
    poses[f] = fit_pose(shape, positions, visible);
  }
  return poses;
}

/// Place and residual of every candidate in the body's coordinates.
void locate(const Sample& s, const std::vector<HeadPose>& poses, Body& body) {
  body.places.assign(s.markers.size(), Eigen::Vector3d::Zero());
  body.residuals.assign(s.markers.size(), unknown);
  for (std::size_t k = 0; k < s.markers.size(); ++k) {
    std::vector<Eigen::Vector3d> places;
    for (std::size_t f = 0; f < s.frames; ++f) {
      if (s.has(f, k) && !poses[f].interpolated) places.push_back(poses[f].to_head(s.at(f, k)));
    }
    if (places.empty()) continue;
    std::vector<double> values(places.size());
    for (Eigen::Index c = 0; c < 3; ++c) {
      std::ranges::transform(places, values.begin(),
                             [c](const Eigen::Vector3d& p) { return p[c]; });
      body.places[k][c] = median(values);
    }
    std::vector<double> squares;
    for (const Eigen::Vector3d& p : places) squares.push_back((p - body.places[k]).squaredNorm());
    body.residuals[k] = trimmed_rms(squares);
  }
}

/// The frame of the sample that shows most of the members.
std::size_t fullest_frame(const Sample& s, const std::vector<std::size_t>& members) {
  std::size_t fullest = 0;
  std::ptrdiff_t most = 0;
  for (std::size_t f = 0; f < s.frames; ++f) {
    const auto seen = std::ranges::count_if(members, [&](std::size_t m) { return s.has(f, m); });
    if (seen <= most) continue;
    most = seen;
    fullest = f;
  }
  return fullest;
}

Body form_body(const Sample& s, const std::vector<std::size_t>& members) {
  Body body;
  RigidShape shape{.markers = members, .positions = {}, .weights = {}, .residuals_mm = {}};
  shape.weights.assign(members.size(), 1.0);
  const std::size_t start = fullest_frame(s, members);
  for (const std::size_t m : members) shape.positions.push_back(s.at(start, m));
  constexpr int rounds = 3;
  for (int round = 0; round < rounds; ++round) {
    locate(s, track(s, shape), body);
    for (std::size_t k = 0; k < members.size(); ++k) shape.positions[k] = body.places[members[k]];
  }
  const auto n = static_cast<double>(members.size());
  double squares = 0.0;
  for (const std::size_t m : members) {
    squares += body.residuals[m] * body.residuals[m];
    body.centre += body.places[m] / n;
  }
  // Each frame's pose takes six of the 3 n coordinates' freedom.
  body.member_rms = std::sqrt(squares / std::max(1.0, n - 2.0));
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  for (const std::size_t m : members) {
    const Eigen::Vector3d r = body.places[m] - body.centre;
    inertia += r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose();
  }
  body.turning = inertia.inverse();
  return body;
}

/// RMS distance to expect of a marker that is as rigid as the first members, at `place`: its own
/// error and that of the pose there.
double expected(const Body& body, double core_rms, const Eigen::Vector3d& place,
                std::size_t members) {
  const Eigen::Vector3d r = place - body.centre;
  Eigen::Matrix3d cross;
  cross << 0.0, -r.z(), r.y(), r.z(), 0.0, -r.x(), -r.y(), r.x(), 0.0;
  const double turned = (cross * body.turning * cross.transpose()).trace() / 3.0;
  return core_rms * std::sqrt(1.0 + 1.0 / static_cast<double>(members) + turned);
}

}  // namespace

RigidMarkersResult find_rigid_markers(const MarkerSequence& take, const RunContext& ctx) {
  constexpr double tolerance = 1.4;
  RigidMarkersResult result;
  const Sample s = sample(take);
  if (s.markers.size() < 3) return result;
  const Eigen::MatrixXd change = relative_changes(s, ctx);
  std::vector<std::size_t> members = tightest(change, std::min<std::size_t>(4, s.markers.size()));
  if (members.size() < 3) members = tightest(change, 3);
  if (members.size() < 3) return result;
  Body body = form_body(s, members);
  const double core_rms = body.member_rms;  // not that of all members: it would creep up with them
  for (;;) {
    ctx.check_cancelled();
    std::vector<std::size_t> joining;
    for (std::size_t k = 0; k < s.markers.size(); ++k) {
      if (std::ranges::find(members, k) != members.end()) continue;
      const double limit = tolerance * expected(body, core_rms, body.places[k], members.size());
      if (body.residuals[k] < limit) joining.push_back(k);
    }
    if (joining.empty()) break;
    members.insert(members.end(), joining.begin(), joining.end());
    body = form_body(s, members);
  }
  for (const std::size_t k : members) result.markers.push_back(s.markers[k]);
  std::ranges::sort(result.markers);
  result.residual_mm = body.member_rms;
  return result;
}

}  // namespace kinemesh
