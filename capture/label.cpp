#include "capture/label.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "capture/edit/timeline.h"
#include "capture/repair/carrier.h"
#include "capture/repair/local_motion.h"
#include "config/error.h"
#include "config/text.h"

namespace kinemesh {
namespace {

using repair::LabelCarrier;
using repair::LocalMotion;
using repair::LoosePoints;
using Points = std::vector<Eigen::Vector3d>;
constexpr std::size_t none = MarkerSequence::npos;

/// Where a loose point came from: a column, or a row of the points without identity.
struct Source {
  std::size_t column = none;
  std::size_t row = 0;
};

struct Loose {
  std::vector<LoosePoints> points;
  std::vector<std::vector<Source>> sources;
  std::size_t count = 0;
};

Loose gather(const MarkerSequence& take) {
  Loose loose;
  loose.points.resize(take.frame_count());
  loose.sources.resize(take.frame_count());
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    const auto add = [&](const Eigen::Vector3d& p, Source source) {
      loose.points[f].positions.push_back(p);
      loose.sources[f].push_back(source);
      ++loose.count;
    };
    for (std::size_t m = 0; m < take.marker_count(); ++m) {
      if (take.markers()[m].kind == MarkerKind::unlabelled && measured(take, f, m)) {
        add(take.position(f, m).cast<double>(), {m, 0});
      }
    }
    const std::vector<uint64_t>& offsets = take.unlabelled.offsets;
    for (std::size_t i = f + 1 < offsets.size() ? offsets[f] : 0;
         f + 1 < offsets.size() && i < offsets[f + 1]; ++i) {
      if (take.unlabelled.positions[i].allFinite()) {
        add(take.unlabelled.positions[i].cast<double>(), {none, i});
      }
    }
    loose.points[f].labels.assign(loose.points[f].positions.size(), -1);
  }
  return loose;
}

/// The take's column of each marker of the template, or none. A label alone is enough while only
/// one subject of the take has it: the same person may be called otherwise in another session.
std::vector<std::size_t> columns_of(const MarkerSequence& take, const SubjectTemplate& subject) {
  std::vector<std::size_t> columns;
  for (const Marker& wanted : subject.markers) {
    std::size_t found = none, alike = 0;
    bool exact = false;
    for (std::size_t m = 0; m < take.marker_count() && !exact; ++m) {
      const Marker& marker = take.markers()[m];
      if (marker.kind != MarkerKind::marker || marker.label != wanted.label) continue;
      exact = marker.subject == wanted.subject;
      if (alike++ == 0 || exact) found = m;
    }
    columns.push_back(exact || alike == 1 ? found : none);
  }
  return columns;
}

/// All points of a frame, labelled or not.
Points all_points(const Loose& loose, const LocalMotion& motion, std::size_t f) {
  Points out = loose.points[f].positions;
  for (std::size_t m = 0; m < motion.markers(); ++m) {
    if (motion.has(f, m)) out.push_back(motion.at(f, m));
  }
  return out;
}

/// The template bent until it meets the points of a frame.
struct Match {
  Points places;                      ///< one per marker
  std::vector<std::ptrdiff_t> point;  ///< index into the points, −1: none
  double cost = std::numeric_limits<double>::infinity();
};

class Bender {
 public:
  Bender(const SubjectTemplate& subject, const LocalMotion& motion, const Points& points)
      : subject_(subject), motion_(motion), points_(points) {}

  /// The best over all shapes of the template, moved by `pose`.
  Match best(const RigidFit& pose) const {
    Match best;
    const auto consider = [&](const Points& shape) {
      Match match = bent(shape, pose);
      if (match.cost < best.cost) best = std::move(match);
    };
    consider(subject_.positions);
    for (const Points& shape : subject_.shapes) {
      Points full = shape;
      for (std::size_t m = 0; m < full.size(); ++m) {
        if (!full[m].allFinite()) full[m] = subject_.positions[m];
      }
      consider(full);
    }
    return best;
  }

 private:
  Match bent(const Points& shape, const RigidFit& pose) const {
    Match match;
    Points moved;
    for (const Eigen::Vector3d& p : shape) moved.push_back(pose.apply(p));
    match.places = moved;
    constexpr int rounds = 10;
    for (int round = 0; round < rounds; ++round) {
      pair_up(match);
      smooth(moved, match);
    }
    pair_up(match);
    match.cost = 0.0;
    for (std::size_t m = 0; m < moved.size(); ++m) {
      const double spacing = std::min(motion_.spacing(m), 1e3);
      const double limit = 0.6 * spacing;
      const double off =
          match.point[m] < 0 ? limit : (points_[index(match.point[m])] - match.places[m]).norm();
      match.cost += off * off / (limit * limit);
    }
    return match;
  }

  static std::size_t index(std::ptrdiff_t i) { return static_cast<std::size_t>(i); }

  /// One point to one marker, the closest first.
  void pair_up(Match& match) const {
    struct Pair {
      double square;
      std::size_t marker, point;
    };
    std::vector<Pair> pairs;
    for (std::size_t m = 0; m < match.places.size(); ++m) {
      const double reach = 0.6 * std::min(motion_.spacing(m), 1e3);
      for (std::size_t i = 0; i < points_.size(); ++i) {
        const double square = (points_[i] - match.places[m]).squaredNorm();
        if (square < reach * reach) pairs.push_back({square, m, i});
      }
    }
    std::ranges::sort(pairs, [](const Pair& a, const Pair& b) {
      return a.square != b.square ? a.square < b.square
                                  : std::pair(a.marker, a.point) < std::pair(b.marker, b.point);
    });
    match.point.assign(match.places.size(), -1);
    std::vector<uint8_t> taken(points_.size(), 0);
    for (const Pair& p : pairs) {
      if (match.point[p.marker] >= 0 || taken[p.point] != 0) continue;
      match.point[p.marker] = static_cast<std::ptrdiff_t>(p.point);
      taken[p.point] = 1;
    }
  }

  /// Each marker goes by the mean displacement of the pairs around it.
  void smooth(const Points& moved, Match& match) const {
    for (std::size_t m = 0; m < moved.size(); ++m) {
      const double range = 1.5 * std::clamp(motion_.spacing(m), 1.0, 1e3);
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      double total = 1e-9;
      for (std::size_t k = 0; k < moved.size(); ++k) {
        if (match.point[k] < 0) continue;
        const double w = std::exp(-0.5 * (moved[k] - moved[m]).squaredNorm() / (range * range));
        sum += w * (points_[index(match.point[k])] - moved[k]);
        total += w;
      }
      match.places[m] = moved[m] + sum / total;
    }
  }

  const SubjectTemplate& subject_;
  const LocalMotion& motion_;
  const Points& points_;
};

/// The frame from which labels are carried, and where all labels are in it.
struct Start {
  std::size_t frame = 0;
  Points places;
  std::vector<std::ptrdiff_t> point;
  double cost = std::numeric_limits<double>::infinity();
};

/// Tries frames spread over the take, the fullest first among equals; keeps the best fit.
Start find_start(const SubjectTemplate& subject, const Loose& loose, const LocalMotion& motion,
                 const RunContext& ctx) {
  constexpr std::size_t tries = 12;
  Start start;
  const std::size_t frames = motion.frames();
  const std::size_t count = std::min(tries, frames);
  std::optional<RigidFit> pose;
  for (std::size_t i = 0; i < count; ++i) {
    ctx.check_cancelled();
    // Of each stretch of the take, the frame with most points.
    std::size_t f = i * frames / count;
    Points points;
    for (std::size_t k = f; k < (i + 1) * frames / count; ++k) {
      Points other = all_points(loose, motion, k);
      if (other.size() > points.size()) {
        points = std::move(other);
        f = k;
      }
    }
    const auto found = locate_template(subject, points, pose);
    if (!found) continue;
    pose = found;
    const Match match = Bender(subject, motion, points).best(*pose);
    if (match.cost < start.cost) start = {f, match.places, match.point, match.cost};
  }
  return start;
}

[[noreturn]] void not_found(const MarkerSequence& take) {
  throw NoResultError(
      {.what = "the template is not found among the points of the take",
       .file = take.origin.path,
       .remedy = "Give a labelled take of the same subject with the same markers as template"});
}

/// The labelled take without the points that got a label.
MarkerSequence assemble(const MarkerSequence& take, const SubjectTemplate& subject,
                        const std::vector<std::size_t>& columns, const Loose& loose,
                        LabelResult& result) {
  std::vector<std::size_t> kept;
  std::vector<Marker> markers;
  for (std::size_t m = 0; m < take.marker_count(); ++m) {
    if (take.markers()[m].kind == MarkerKind::unlabelled) continue;
    kept.push_back(m);
    markers.push_back(take.markers()[m]);
  }
  std::vector<std::size_t> target;
  for (std::size_t k = 0; k < columns.size(); ++k) {
    if (columns[k] != none) {
      target.push_back(
          static_cast<std::size_t>(std::ranges::find(kept, columns[k]) - kept.begin()));
    } else {
      target.push_back(markers.size());
      markers.push_back(subject.markers[k]);
      markers.back().unit = "mm";
    }
  }
  MarkerSequence out = empty_like(take, take.frame_count(), markers);
  out.analog = take.analog;
  out.rotations = take.rotations;
  out.unlabelled.offsets.push_back(0);
  std::vector<int64_t> last(columns.size(), -2);
  for (std::size_t f = 0; f < take.frame_count(); ++f) {
    for (std::size_t k = 0; k < kept.size(); ++k) {
      copy_sample(take, take.sample(f, kept[k]), out, out.sample(f, k));
    }
    const LoosePoints& here = loose.points[f];
    for (std::size_t i = 0; i < here.positions.size(); ++i) {
      const Source source = loose.sources[f][i];
      const bool column = source.column != none;
      const std::size_t from = column ? take.sample(f, source.column) : source.row;
      const UnlabelledPoints& rows = take.unlabelled;
      const Eigen::Vector3f p = here.positions[i].cast<float>();
      const float residual = column                         ? take.residuals()[from]
                             : from < rows.residuals.size() ? rows.residuals[from]
                                                            : 0.0F;
      const uint8_t mask = column                            ? take.camera_masks()[from]
                           : from < rows.camera_masks.size() ? rows.camera_masks[from]
                                                             : uint8_t{0};
      if (here.labels[i] < 0) {
        out.unlabelled.positions.push_back(p);
        out.unlabelled.residuals.push_back(residual);
        out.unlabelled.camera_masks.push_back(mask);
        continue;
      }
      const auto label = static_cast<std::size_t>(here.labels[i]);
      const std::size_t to = out.sample(f, target[label]);
      out.position(f, target[label]) = p;
      out.flags()[to] = SampleFlag::valid;
      out.residuals()[to] = residual;
      out.camera_masks()[to] = mask;
      ++result.labelled;
      if (last[label] + 1 != static_cast<int64_t>(f)) ++result.trajectories;
      last[label] = static_cast<int64_t>(f);
    }
    out.unlabelled.offsets.push_back(out.unlabelled.positions.size());
  }
  if (out.unlabelled.positions.empty()) out.unlabelled = {};
  return out;
}

}  // namespace

LabelResult label_points(const MarkerSequence& take, const SubjectTemplate& subject,
                         const RunContext& ctx) {
  LabelResult result;
  Loose loose = gather(take);
  result.points = loose.count;
  if (loose.count == 0) {
    result.take = take;
    return result;
  }
  const std::vector<std::size_t> columns = columns_of(take, subject);
  LocalMotion motion(take.frame_count(), subject.positions);
  for (std::size_t k = 0; k < columns.size(); ++k) {
    if (columns[k] == none) continue;
    for (std::size_t f = 0; f < take.frame_count(); ++f) {
      if (measured(take, f, columns[k])) {
        motion.put(f, k, take.position(f, columns[k]).cast<double>());
      }
    }
  }
  Start start = find_start(subject, loose, motion, ctx.part(0.0, 0.5, "placing the template"));
  if (start.places.empty()) not_found(take);
  result.start = start.frame;
  LoosePoints& first = loose.points[start.frame];
  for (std::size_t m = 0; m < start.places.size(); ++m) {
    if (motion.has(start.frame, m)) {
      start.places[m] = motion.at(start.frame, m);
    } else if (start.point[m] >= 0 &&
               static_cast<std::size_t>(start.point[m]) < first.positions.size()) {
      const auto i = static_cast<std::size_t>(start.point[m]);
      first.labels[i] = static_cast<int>(m);
      start.places[m] = first.positions[i];
      motion.put(start.frame, m, first.positions[i]);
    }
  }
  LabelCarrier(loose.points, motion, start.places, start.frame).run();
  result.take = assemble(take, subject, columns, loose, result);
  // Where the take had its labels already, what is left over are ghosts, and no label is missing.
  const bool labelled_before = std::ranges::none_of(columns, [](auto c) { return c == none; });
  if (2 * result.labelled < result.points && !labelled_before) {
    result.warnings.push_back(
        (result.labelled == 0 ? std::string("None") : "Only " + std::to_string(result.labelled)) +
        " of the " + count_of(result.points, "point") +
        " without a label got one: is the template of the same subject?");
    ctx.warn(result.warnings.back());
  }
  return result;
}

}  // namespace kinemesh
