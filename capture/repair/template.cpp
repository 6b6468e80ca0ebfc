// learn_template() and locate_template() of label.h.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "capture/label.h"
#include "capture/repair.h"
#include "capture/repair/local_motion.h"
#include "capture/rigid_markers.h"
#include "capture/stabilise.h"
#include "config/error.h"
#include "config/text.h"

namespace kinemesh {
namespace {

using Points = std::vector<Eigen::Vector3d>;
constexpr std::size_t most_shapes = 16;

/// Markers of the take that can be part of a template.
std::vector<std::size_t> template_columns(const MarkerSequence& take) {
  std::vector<std::size_t> columns;
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    if (take.markers()[m].kind != MarkerKind::marker) continue;
    for (std::size_t f = 0; f < take.frame_count(); ++f) {
      if (measured(take, f, m)) {
        columns.push_back(m);
        break;
      }
    }
  }
  return columns;
}

/// The markers that hold the head's coordinates: the rigid ones, or all when none are.
std::vector<std::size_t> body_of(const MarkerSequence& take, const RunContext& ctx) {
  std::vector<std::size_t> rigid = find_rigid_markers(take, ctx).markers;
  if (rigid.size() >= 3) return rigid;
  rigid.resize(take.marker_count());
  for (std::size_t m = 0; m < rigid.size(); ++m) rigid[m] = m;
  return rigid;
}

void learn_places(const MarkerSequence& steady, SubjectTemplate& subject) {
  for (std::size_t m = 0; m < steady.marker_count(); ++m) {
    std::array<std::vector<double>, 3> values;
    for (std::size_t f = 0; f < steady.frame_count(); ++f) {
      if (!measured(steady, f, m)) continue;
      for (std::size_t c = 0; c < 3; ++c) {
        values[c].push_back(steady.position(f, m)[static_cast<Eigen::Index>(c)]);
      }
    }
    double squares = 0.0;
    Eigen::Vector3d place;
    for (std::size_t c = 0; c < 3; ++c) {
      const double middle = repair::median_of(values[c]);
      place[static_cast<Eigen::Index>(c)] = middle;
      for (const double v : values[c]) squares += (v - middle) * (v - middle);
    }
    subject.positions.push_back(place);
    subject.spread_mm.push_back(std::sqrt(squares / static_cast<double>(values[0].size())));
  }
  const std::size_t shapes = std::min(most_shapes, steady.frame_count());
  for (std::size_t i = 0; i < shapes; ++i) {
    const std::size_t f = i * steady.frame_count() / shapes;
    Points shape(steady.marker_count(), Eigen::Vector3d::Constant(std::nan("")));
    for (std::size_t m = 0; m < shape.size(); ++m) {
      if (measured(steady, f, m)) shape[m] = steady.position(f, m).cast<double>();
    }
    subject.shapes.push_back(std::move(shape));
  }
}

/// Finds poses of the template by the mutual distances of three markers.
class Locator {
 public:
  Locator(const SubjectTemplate& subject, const Points& points)
      : subject_(subject), points_(points) {
    double nearest = 0.0;
    for (std::size_t m = 0; m < subject.positions.size(); ++m) {
      double least = std::numeric_limits<double>::infinity();
      for (std::size_t k = 0; k < subject.positions.size(); ++k) {
        if (k != m) {
          least = std::min(least, (subject.positions[k] - subject.positions[m]).norm());
        }
      }
      nearest += least / static_cast<double>(subject.positions.size());
    }
    reach_ = 0.5 * nearest;
    choose_anchors();
    choose_probes();
  }

  std::optional<RigidFit> best(const std::optional<RigidFit>& hint) {
    constexpr double good = 0.85;
    if (hint) judge(*hint);
    for (const auto& triple : triples_) {
      if (best_score_ > good * static_cast<double>(probes_.size())) break;
      try_triple(triple);
    }
    if (best_score_ <= 0.0) return std::nullopt;
    return refined();
  }

 private:
  using Triple = std::array<std::size_t, 3>;

  /// Those that move least, but at least a dozen.
  void choose_anchors() {
    anchors_ = subject_.rigid;
    if (anchors_.size() >= 4) return;
    anchors_.resize(subject_.positions.size());
    for (std::size_t m = 0; m < anchors_.size(); ++m) anchors_[m] = m;
    std::ranges::stable_sort(anchors_, {}, [&](std::size_t m) { return subject_.spread_mm[m]; });
    anchors_.resize(
        std::max<std::size_t>(std::min<std::size_t>(12, anchors_.size()), anchors_.size() / 3));
  }

  /// Large triangles of anchors, spread over them; markers to judge a pose by.
  void choose_probes() {
    constexpr std::size_t probes = 40;
    const std::size_t n = subject_.positions.size();
    const std::size_t count = std::min(probes, n);
    for (std::size_t i = 0; i < count; ++i) probes_.push_back(i * n / count);
    std::vector<std::pair<double, Triple>> all;
    const std::size_t k = anchors_.size();
    const std::size_t step =
        std::max<std::size_t>(1, k / 14);  // some 14 anchors make 364 triangles
    for (std::size_t a = 0; a < k; a += step) {
      for (std::size_t b = a + step; b < k; b += step) {
        for (std::size_t c = b + step; c < k; c += step) {
          const Eigen::Vector3d& p = place(a);
          const double area = (place(b) - p).cross(place(c) - p).norm();
          all.push_back({-area, {anchors_[a], anchors_[b], anchors_[c]}});
        }
      }
    }
    std::ranges::sort(all);
    constexpr std::size_t most = 24;
    const std::size_t kept = std::min(all.size(), std::max<std::size_t>(most, all.size() / 4));
    const std::size_t taken = std::min(most, kept);
    for (std::size_t i = 0; i < taken; ++i) triples_.push_back(all[i * kept / taken].second);
  }

  const Eigen::Vector3d& place(std::size_t anchor) const {
    return subject_.positions[anchors_[anchor]];
  }

  double tolerance(std::size_t a, std::size_t b) const {
    return 1.0 + 2.0 * std::hypot(subject_.spread_mm[a], subject_.spread_mm[b]);
  }

  void try_triple(const Triple& t) {
    const auto& p = subject_.positions;
    const double ab = (p[t[0]] - p[t[1]]).norm();
    const double ac = (p[t[0]] - p[t[2]]).norm();
    const double bc = (p[t[1]] - p[t[2]]).norm();
    const std::array<Eigen::Vector3d, 3> from = {p[t[0]], p[t[1]], p[t[2]]};
    std::vector<std::vector<std::size_t>> by_ac(points_.size());
    for (std::size_t i = 0; i < points_.size(); ++i) {
      for (std::size_t k = 0; k < points_.size(); ++k) {
        if (k != i && std::abs((points_[i] - points_[k]).norm() - ac) < tolerance(t[0], t[2])) {
          by_ac[i].push_back(k);
        }
      }
    }
    for (std::size_t i = 0; i < points_.size(); ++i) {
      for (std::size_t j = 0; j < points_.size() && !by_ac[i].empty(); ++j) {
        if (j == i || std::abs((points_[i] - points_[j]).norm() - ab) >= tolerance(t[0], t[1])) {
          continue;
        }
        for (const std::size_t k : by_ac[i]) {
          if (k == j) continue;
          if (std::abs((points_[j] - points_[k]).norm() - bc) >= tolerance(t[1], t[2])) continue;
          const std::array<Eigen::Vector3d, 3> to = {points_[i], points_[j], points_[k]};
          judge(fit_rigid(from, to));
        }
      }
    }
  }

  double nearest_square(const Eigen::Vector3d& q) const {
    double least = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3d& p : points_) least = std::min(least, (p - q).squaredNorm());
    return least;
  }

  void judge(const RigidFit& pose) {
    double score = 0.0;
    for (std::size_t i = 0; i < probes_.size(); ++i) {
      const double square = nearest_square(pose.apply(subject_.positions[probes_[i]]));
      score += std::max(0.0, 1.0 - square / (reach_ * reach_));
      // A pose that finds nothing in a third of the probes is given up.
      if (score + static_cast<double>(probes_.size() - i - 1) <= best_score_) return;
    }
    if (score <= best_score_) return;
    best_score_ = score;
    best_ = pose;
  }

  /// Iterated closest points, the steadier the heavier.
  std::optional<RigidFit> refined() const {
    RigidFit pose = best_;
    std::size_t matched = 0;
    for (int round = 0; round < 12; ++round) {
      Points from, to;
      std::vector<double> weights;
      for (std::size_t m = 0; m < subject_.positions.size(); ++m) {
        const Eigen::Vector3d q = pose.apply(subject_.positions[m]);
        const auto near = std::ranges::min_element(
            points_, {}, [&](const Eigen::Vector3d& p) { return (p - q).squaredNorm(); });
        const double distance = (*near - q).norm();
        if (distance > 1.4 * reach_) continue;
        from.push_back(subject_.positions[m]);
        to.push_back(*near);
        const double spread = 0.5 + subject_.spread_mm[m];
        weights.push_back(1.0 / (spread * spread));
      }
      matched = from.size();
      if (matched < 3) return std::nullopt;
      pose = fit_rigid(from, to, weights);
    }
    const std::size_t possible = std::min(points_.size(), subject_.positions.size());
    if (2 * matched < possible || matched < 4) return std::nullopt;
    return pose;
  }

  const SubjectTemplate& subject_;
  const Points& points_;
  double reach_ = 1.0;
  std::vector<std::size_t> anchors_, probes_;
  std::vector<Triple> triples_;
  RigidFit best_;
  double best_score_ = 0.0;
};

}  // namespace

SubjectTemplate learn_template(const MarkerSequence& take, const RunContext& ctx) {
  const RepairResult mended = repair_take(take, {.spikes = false}, ctx.part(0.0, 0.4, "mending"));
  const std::vector<std::size_t> columns = template_columns(mended.take);
  if (columns.size() < 4) {
    throw NoResultError({.what = "a template needs four labelled markers, and the take has " +
                                 std::to_string(columns.size()),
                         .file = take.origin.path,
                         .remedy = "Give a take of the subject with labels"});
  }
  const MarkerSequence body = mended.take.select(columns);
  SubjectTemplate subject;
  subject.markers = body.markers();
  subject.rigid = body_of(body, ctx.part(0.4, 0.8, "looking for rigid markers"));
  const StabiliseResult steady = stabilise_head(body, subject.rigid, StabiliseOptions{},
                                                ctx.part(0.8, 1.0, "learning the template"));
  if (subject.rigid.size() == subject.markers.size()) subject.rigid.clear();
  learn_places(steady.take, subject);
  return subject;
}

std::optional<RigidFit> locate_template(const SubjectTemplate& subject,
                                        const std::vector<Eigen::Vector3d>& points,
                                        const std::optional<RigidFit>& hint) {
  if (points.size() < 4 || subject.positions.size() < 4) return std::nullopt;
  return Locator(subject, points).best(hint);
}

}  // namespace kinemesh
