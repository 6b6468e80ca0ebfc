// rename, swap, delete, move, unite-twins: which samples belong to which marker.
#include <algorithm>
#include <cmath>

#include "capture/edit/operation.h"
#include "capture/edit/timeline.h"
#include "capture/formats/table_text.h"
#include "capture/repair/local_motion.h"
#include "config/error.h"
#include "config/text.h"

namespace kinemesh {
namespace {

std::string span_text(const MarkerSequence& take, const FrameSpan& span) {
  if (span.begin == 0 && span.end == take.frame_count()) return "";
  const auto number = [&](std::size_t f) {
    return std::to_string(take.first_frame + static_cast<int64_t>(f));
  };
  if (span.end - span.begin == 1) return " in frame " + number(span.begin);
  return " in frames " + number(span.begin) + " to " + number(span.end - 1);
}

void invalidate(MarkerSequence& take, std::size_t sample) {
  take.flags()[sample] = 0;
  take.residuals()[sample] = 0.0F;
  take.camera_masks()[sample] = 0;
}

void drop_columns(MarkerSequence& take, const std::vector<std::size_t>& kept) {
  MarkerSequence left = take.select(kept);
  left.unlabelled = std::move(take.unlabelled);
  left.analog = std::move(take.analog);
  left.rotations = std::move(take.rotations);
  left.parameters = std::move(take.parameters);
  take = std::move(left);
}

class Rename : public EditOperation {
 public:
  std::string_view name() const override { return "rename"; }
  void declare(ParameterSet& p) override {
    p.text("marker", marker_, {.metavar = "MARKER", .help = "label it has"});
    p.text("to", to_,
           {.metavar = "LABEL", .help = "label it gets, with SUBJECT: where it changes"});
  }
  std::string apply(MarkerSequence& take, const EditContext& context) const override {
    (void)context;
    const std::size_t m = marker_named(take, marker_);
    if (to_.empty()) throw UsageError({.what = "'to' says the new label, and is missing"});
    const QualifiedLabel split = split_label(to_);
    Marker renamed = take.markers()[m];
    renamed.label = split.label;
    if (!split.subject.empty()) renamed.subject = split.subject;
    if (renamed.kind == MarkerKind::unlabelled) renamed.kind = MarkerKind::marker;
    for (std::size_t k = 0; k < take.marker_count(); ++k) {
      const Marker& other = take.markers()[k];
      if (k != m && other.label == renamed.label && other.subject == renamed.subject) {
        throw UsageError({.what = "the take already has a marker '" + to_ + "'",
                          .marker = to_,
                          .remedy = "Rename or delete that one first, or use swap or move"});
      }
    }
    take.markers()[m] = renamed;
    return "renamed " + marker_ + " to " + to_;
  }

 private:
  std::string marker_, to_;
};

class Swap : public EditOperation {
 public:
  std::string_view name() const override { return "swap"; }
  void declare(ParameterSet& p) override {
    p.text("a", a_, {.metavar = "MARKER", .help = "one marker"});
    p.text("b", b_, {.metavar = "MARKER", .help = "the other"});
    declare_frames(p, from_, to_);
  }
  std::string apply(MarkerSequence& take, const EditContext& context) const override {
    (void)context;
    if (a_.empty() || b_.empty()) {
      throw UsageError({.what = "'a' and 'b' say which markers to swap, and one is missing"});
    }
    const std::size_t a = marker_named(take, a_, "a");
    const std::size_t b = marker_named(take, b_, "b");
    if (a == b) {
      throw UsageError({.what = "'a' and 'b' are the same marker, '" + a_ + "'",
                        .marker = a_,
                        .remedy = "Name two markers, or take the step out"});
    }
    const FrameSpan span = frames_between(take, from_, to_);
    swap_samples(take, a, b, span);
    return "swapped " + a_ + " and " + b_ + span_text(take, span);
  }

 private:
  std::string a_, b_;
  int64_t from_ = 0, to_ = 0;
};

class Delete : public EditOperation {
 public:
  std::string_view name() const override { return "delete"; }
  void declare(ParameterSet& p) override {
    p.list("markers", markers_,
           {.metavar = "PATTERN", .help = "labels or wildcards; \"subject:label\" works, too"});
    declare_frames(p, from_, to_);
  }
  std::string apply(MarkerSequence& take, const EditContext& context) const override {
    (void)context;
    const std::vector<std::string> idle = idle_patterns(take);
    std::vector<std::size_t> hit, kept;
    for (std::size_t m = 0; m < take.marker_count(); ++m) {
      const bool gone = std::ranges::any_of(
          markers_, [&](const std::string& p) { return names(p, take.markers()[m]); });
      (gone ? hit : kept).push_back(m);
    }
    const FrameSpan span = frames_between(take, from_, to_);
    const std::string what =
        hit.size() == 1 ? take.markers()[hit[0]].label : count_of(hit.size(), "marker");
    std::string text = "deleted " + what + span_text(take, span);
    if (!idle.empty()) text += "; nothing is called " + join(idle, ", ", " or ");
    if (span.begin == 0 && span.end == take.frame_count()) {
      if (kept.empty()) {
        throw UsageError({.what = "nothing would be left: every marker of the take is deleted",
                          .remedy = "Narrow the patterns, or give frames with 'from' and 'to'"});
      }
      drop_columns(take, kept);
      return text;
    }
    for (std::size_t f = span.begin; f < span.end; ++f) {
      for (const std::size_t m : hit) invalidate(take, take.sample(f, m));
    }
    return text;
  }

 private:
  static bool names(const std::string& pattern, const Marker& marker) {
    return matches_wildcard(pattern, marker.label) ||
           matches_wildcard(pattern, marker.subject + ":" + marker.label);
  }

  /// Those that name nothing, each in quotes. Throws UsageError when all do.
  std::vector<std::string> idle_patterns(const MarkerSequence& take) const {
    if (markers_.empty()) {
      throw UsageError({.what = "'markers' says what to delete, and is missing"});
    }
    std::vector<std::string> idle;
    for (const std::string& pattern : markers_) {
      if (std::ranges::none_of(take.markers(),
                               [&](const Marker& m) { return names(pattern, m); })) {
        idle.push_back("'" + pattern + "'");
      }
    }
    if (idle.size() < markers_.size()) return idle;
    throw UsageError({.what = join(idle, ", ", " and ") + " matches no marker",
                      .remedy = "See the labels with \"kinemesh c3d info\""});
  }

  std::vector<std::string> markers_;
  int64_t from_ = 0, to_ = 0;
};

class Move : public EditOperation {
 public:
  std::string_view name() const override { return "move"; }
  void declare(ParameterSet& p) override {
    p.text("marker", marker_, {.metavar = "MARKER", .help = "trajectory that has the samples"});
    p.text("into", into_, {.metavar = "MARKER", .help = "trajectory that they belong to"});
    declare_frames(p, from_, to_);
  }
  std::string apply(MarkerSequence& take, const EditContext& context) const override {
    (void)context;
    const std::size_t from = marker_named(take, marker_);
    const std::size_t into = marker_named(take, into_, "into");
    const FrameSpan span = frames_between(take, from_, to_);
    std::size_t moved = 0;
    for (std::size_t f = span.begin; f < span.end; ++f) {
      if (!take.valid(f, from)) continue;
      if (take.valid(f, into) && !take.filled(f, into)) {
        throw UsageError({.what = into_ + " is measured there itself",
                          .marker = into_,
                          .frame = take.first_frame + static_cast<int64_t>(f),
                          .remedy = "Narrow the frames, or use swap"});
      }
      copy_sample(take, take.sample(f, from), take, take.sample(f, into));
      invalidate(take, take.sample(f, from));
      ++moved;
    }
    return "moved " + count_of(moved, "sample") + " of " + marker_ + " into " + into_ +
           span_text(take, span);
  }

 private:
  std::string marker_, into_;
  int64_t from_ = 0, to_ = 0;
};

/// Markers that exist twice: one trajectory broken in two is joined, others get names of their own.
class UniteTwins : public EditOperation {
 public:
  std::string_view name() const override { return "unite-twins"; }
  void declare(ParameterSet& p) override { (void)p; }
  std::string apply(MarkerSequence& take, const EditContext& context) const override {
    (void)context;
    std::vector<std::string> done;
    std::vector<std::size_t> kept;
    for (std::size_t m = 0; m < take.marker_count(); ++m) {
      const std::size_t twin = twin_of(take, m, kept);
      if (twin == MarkerSequence::npos) {
        kept.push_back(m);
        continue;
      }
      const std::string label = take.markers()[m].label;
      if (unite(take, twin, m)) {
        done.push_back("joined the two trajectories of " + label);
        continue;
      }
      take.markers()[m].label = free_label(take, take.markers()[m]);
      kept.push_back(m);
      done.push_back("renamed the second " + label + " to " + take.markers()[m].label +
                     ", because it is elsewhere than the first");
    }
    if (kept.size() < take.marker_count()) drop_columns(take, kept);
    return done.empty() ? "no marker exists twice" : join(done, "; ");
  }

 private:
  static std::size_t twin_of(const MarkerSequence& take, std::size_t m,
                             const std::vector<std::size_t>& among) {
    const Marker& marker = take.markers()[m];
    if (marker.kind != MarkerKind::marker) return MarkerSequence::npos;
    for (const std::size_t k : among) {
      const Marker& other = take.markers()[k];
      if (other.kind == marker.kind && other.label == marker.label &&
          other.subject == marker.subject) {
        return k;
      }
    }
    return MarkerSequence::npos;
  }

  /// True when, wherever one of the two ends and the other goes on, this is where the neighbours
  /// carry the last sample to; no farther off than what passes for a jump.
  static bool hand_over(const MarkerSequence& take, std::size_t a, std::size_t b) {
    constexpr double alone_mm = 5.0;  // nothing near says more
    std::vector<std::size_t> columns{a};
    for (std::size_t m = 0; m < take.marker_count(); ++m) {
      const bool other = m != a && m != b && take.markers()[m].kind == MarkerKind::marker;
      if (other) columns.push_back(m);
    }
    const auto motion = repair::LocalMotion::of(take, columns);
    double limit = repair::least_jump(motion, 0);
    if (!std::isfinite(limit)) limit = alone_mm;
    std::size_t last = take.frame_count();  // frame of the last sample, and whose it is
    std::size_t whose = a;
    for (std::size_t f = 0; f < take.frame_count(); ++f) {
      const bool of_a = take.valid(f, a);
      if (!of_a && !take.valid(f, b)) continue;
      const std::size_t now = of_a && (whose == a || !take.valid(f, b)) ? a : b;
      if (last < f && now != whose) {
        const Eigen::Vector3d left = take.position(last, whose).cast<double>();
        const Eigen::Vector3d next = take.position(f, now).cast<double>();
        if (!((motion.carried(0, left, last, f) - next).norm() < limit)) return false;
      }
      last = f;
      whose = now;
    }
    return true;
  }

  /// True when both are one: nowhere apart in the same frame, and one goes on where the other ends.
  /// `b`'s samples then are `a`'s, too.
  static bool unite(MarkerSequence& take, std::size_t a, std::size_t b) {
    constexpr float apart_mm = 1.0F;
    for (std::size_t f = 0; f < take.frame_count(); ++f) {
      if (!take.valid(f, a) || !take.valid(f, b)) continue;
      if (!((take.position(f, a) - take.position(f, b)).norm() < apart_mm)) return false;
    }
    if (!hand_over(take, a, b)) return false;
    for (std::size_t f = 0; f < take.frame_count(); ++f) {
      if (take.valid(f, b) && !take.valid(f, a)) {
        copy_sample(take, take.sample(f, b), take, take.sample(f, a));
      }
    }
    return true;
  }

  static std::string free_label(const MarkerSequence& take, const Marker& marker) {
    for (int i = 2;; ++i) {
      std::string label = marker.label + "_" + std::to_string(i);
      const bool used = std::ranges::any_of(take.markers(), [&](const Marker& m) {
        return m.label == label && m.subject == marker.subject;
      });
      if (!used) return label;
    }
  }
};

}  // namespace

void swap_samples(MarkerSequence& take, std::size_t a, std::size_t b, const FrameSpan& span) {
  for (std::size_t f = span.begin; f < span.end; ++f) {
    const std::size_t i = take.sample(f, a);
    const std::size_t j = take.sample(f, b);
    for (std::size_t c = 0; c < 3; ++c) {
      std::swap(take.positions()[3 * i + c], take.positions()[3 * j + c]);
    }
    std::swap(take.flags()[i], take.flags()[j]);
    std::swap(take.residuals()[i], take.residuals()[j]);
    std::swap(take.camera_masks()[i], take.camera_masks()[j]);
    if (!take.uncertainty().empty()) std::swap(take.uncertainty()[i], take.uncertainty()[j]);
  }
}

std::shared_ptr<EditOperation> make_column_operation(std::string_view name) {
  if (name == "rename") return std::make_shared<Rename>();
  if (name == "swap") return std::make_shared<Swap>();
  if (name == "delete") return std::make_shared<Delete>();
  if (name == "move") return std::make_shared<Move>();
  if (name == "unite-twins") return std::make_shared<UniteTwins>();
  return nullptr;
}

}  // namespace kinemesh
