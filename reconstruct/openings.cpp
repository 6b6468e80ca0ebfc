#include "reconstruct/openings.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "config/error.h"
#include "config/text.h"
#include "reconstruct/delaunay_flips.h"
#include "reconstruct/edge_motion.h"
#include "reconstruct/face_frame.h"
#include "reconstruct/strip.h"

namespace kinemesh {
namespace {
/// Growth of strips: every edge has more contrast than the floor (in h) and than this share of the
/// seed's. Between what skin and openings show on generated faces: docs/reconstruct.md.
constexpr double mouth_floor = 0.12, mouth_share = 0.28;
constexpr double eye_seed = 0.22, eye_floor = 0.10, eye_share = 0.22;

/// A strip and where it lies.
struct PlacedStrip {
  Strip strip;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double side = 0.0;               ///< distance of its centre from the mirror plane, mm, signed
  double left = 0.0, right = 0.0;  ///< farthest edge middles on either side of the plane, mm, ≥ 0
};

struct EyePair {
  std::array<PlacedStrip, 2> eyes;
  double score = 0.0;
};

class OpeningCutter {
 public:
  OpeningCutter(EditMesh& mesh, const Points& points, double spacing, const MarkerSequence& take,
                const std::vector<VertexIndex>& original, const OpeningOptions& options,
                const EdgeConstraints& constraints, const RunContext& ctx)
      : mesh_(mesh),
        points_(points),
        h_(spacing),
        take_(take),
        original_(original),
        options_(options),
        constraints_(constraints),
        ctx_(ctx),
        motion_(take, mesh, original, spacing, ctx),
        frame_(find_face_frame(mesh, points, spacing)) {}

  OpeningSearch run() {
    if (options_.mouth != OpeningMode::closed) cut_mouth();
    if (options_.left_eye != OpeningMode::closed || options_.right_eye != OpeningMode::closed)
      cut_eyes();
    result_.jump_samples = motion_.jump_samples();
    result_.statistics_seconds = motion_.seconds();
    return std::move(result_);
  }

 private:
  PlacedStrip placed(Strip strip) const {
    PlacedStrip p;
    for (const auto& [a, b] : strip.edges) {
      const Eigen::Vector3d middle = 0.5 * (points_[a] + points_[b]);
      p.centre += middle / static_cast<double>(strip.edges.size());
      p.left = std::max(p.left, frame_.plane.side(middle));
      p.right = std::max(p.right, -frame_.plane.side(middle));
    }
    p.side = frame_.plane.side(p.centre);
    p.strip = std::move(strip);
    return p;
  }

  std::vector<PlacedStrip> strips(const StripRule& rule, std::size_t fewest) const {
    std::vector<PlacedStrip> list;
    for (Strip& s : find_strips(mesh_, rule)) {
      drop_corner_fans(s, points_, at_slit * h_);
      if (s.edges.size() >= fewest) list.push_back(placed(std::move(s)));
    }
    return list;
  }

  using Measure = double (LengthRange::*)() const;

  /// Geometric mean of how much an edge varies and how much more that is than if it were strained
  /// like the skin that continues it at both ends, in h: high across an opening, near 0 on skin
  /// however stretched.
  double contrast(VertexIndex a, VertexIndex b, Measure measure) {
    const LengthRange& own = motion_.of(a, b);
    const double skin = 0.5 * (strain_beyond(a, b, measure) + strain_beyond(b, a, measure));
    if (constraints_.forces(a, b)) return 0.0;
    const double variation = (own.*measure)();
    return std::sqrt(std::max(0.0, variation * (variation - own.median * skin))) / h_;
  }

  /// Relative variation of the edges that lead from `at` away from `from`, mean over directions.
  double strain_beyond(VertexIndex at, VertexIndex from, Measure measure) {
    const Eigen::Vector3d away = (points_[at] - points_[from]).normalized();
    double sum = 0.0;
    double weights = 0.0;
    for (const VertexIndex next : mesh_.neighbours(at)) {
      const double cosine = away.dot((points_[next] - points_[at]).normalized());
      if (!(cosine > 0)) continue;
      const LengthRange& length = motion_.of(at, next);
      if (length.median <= 0) continue;
      const double weight = std::pow(cosine, 4);
      sum += weight * (length.*measure)() / length.median;
      weights += weight;
    }
    return weights > 0.05 ? sum / weights : 0.0;
  }

  /// A mouth lies on both sides of the mirror plane.
  bool straddles(const PlacedStrip& p) const {
    return !frame_.symmetric() || std::min(p.left, p.right) > 0.15 * std::max(p.left, p.right);
  }

  void open(OpeningName name, const Strip& strip, double score, bool forced) {
    cut_strip(mesh_, strip);
    auto loop = fill_notches(mesh_, points_, strip, largest_notch);
    result_.openings.push_back({name, std::move(loop), score, forced});
  }
  void flip() { flip_to_delaunay(mesh_, points_, constraints_.edges, constraints_.no_edges, ctx_); }

  void cut_mouth();
  void cut_eyes();
  std::optional<EyePair> best_eyes(const std::vector<PlacedStrip>& strips) const;
  double pair_score(const PlacedStrip& a, const PlacedStrip& b) const;
  /// Some samples of its markers are missing.
  std::function<bool(VertexIndex, VertexIndex)> doubtful() {
    return [this](VertexIndex a, VertexIndex b) { return motion_.of(a, b).used < 0.99; };
  }
  bool in_eye_window(const PlacedStrip& a, const PlacedStrip& b) const;
  /// Markers' names say that the strip lies somewhere else. Only asked where the motion does not
  /// decide: an opening that is forced.
  bool named_like(const PlacedStrip& p, std::initializer_list<std::string_view> words) const {
    return std::ranges::any_of(p.strip.edges, [&](const DirectedEdge& e) {
      return std::ranges::any_of(e, [&](VertexIndex v) {
        const std::string label = lower(take_.markers()[original_[v]].label);
        return std::ranges::any_of(
            words, [&](std::string_view word) { return label.find(word) != std::string::npos; });
      });
    });
  }
  Eigen::Vector3d up(const Eigen::Vector3d& eyes) const {
    return frame_.up(points_, mouth_ ? std::optional(mouth_->centre) : std::nullopt, eyes);
  }

  static constexpr double at_slit = 0.40;        // spacings
  static constexpr double largest_notch = 95.0;  // degrees

  EditMesh& mesh_;
  const Points& points_;
  double h_;
  const MarkerSequence& take_;
  const std::vector<VertexIndex>& original_;  // marker of each vertex
  const OpeningOptions& options_;
  const EdgeConstraints& constraints_;
  const RunContext& ctx_;
  EdgeMotion motion_;
  FaceFrame frame_;
  std::optional<PlacedStrip> mouth_;
  OpeningSearch result_;
};

void OpeningCutter::cut_mouth() {
  const bool forced = options_.mouth == OpeningMode::open;
  const double seed = forced ? 0.0 : options_.mouth_seed;
  const EdgeScore range = [this](VertexIndex a, VertexIndex b) {
    return constraints_.forces(a, b) ? 0.0 : motion_.of(a, b).range() / h_;
  };
  const EdgeScore beyond_skin = [this](VertexIndex a, VertexIndex b) {
    return contrast(a, b, &LengthRange::range);
  };
  const StripRule rule{range,       seed,      beyond_skin, forced ? 0.0 : mouth_floor,
                       mouth_share, doubtful()};
  std::string reason = "the distances across it vary too little";
  double strongest = 0.0;
  for (PlacedStrip& p : strips(rule, 1)) {
    strongest = std::max(strongest, p.strip.peak);
    if (p.strip.edges.size() < 3) {
      reason = "fewer than three edges in a row part";
    } else if (forced && named_like(p, {"brow", "eye", "lid", "nose", "forehead"})) {
      reason = "no strip of edges lies at the lips";
    } else if (!straddles(p)) {
      reason = "what parts lies on one side of the face";
    } else {
      result_.candidates.push_back({OpeningName::mouth, p.strip.peak, seed, true, ""});
      open(OpeningName::mouth, p.strip, p.strip.peak, forced);
      mouth_ = std::move(p);
      return flip();
    }
  }
  if (strongest == 0.0) {
    for (const auto& [a, b] : mesh_.edges()) {
      if (!mesh_.is_boundary_edge(a, b)) strongest = std::max(strongest, range(a, b));
    }
  }
  result_.candidates.push_back({OpeningName::mouth, strongest, seed, false, reason});
  if (forced) {
    throw NoResultError(
        {.what = "the mouth cannot be opened: " + reason,
         .file = take_.origin.path,
         .remedy = "Use --mouth auto or closed, or a take in which the mouth opens"});
  }
}

double OpeningCutter::pair_score(const PlacedStrip& a, const PlacedStrip& b) const {
  const double apart = (frame_.plane.mirrored(a.centre) - b.centre).norm() / h_;
  constexpr double farthest = 1.5;
  if (a.side * b.side >= 0 || apart > farthest) return 0.0;
  if (std::min(std::abs(a.side), std::abs(b.side)) < h_) return 0.0;
  if (mouth_ && !in_eye_window(a, b)) return 0.0;
  const double likeness = 1 - 0.5 * apart / farthest;
  return std::min(a.strip.sum, b.strip.sum) * likeness;
}

/// Eyes are about as far above the mouth as from each other.
bool OpeningCutter::in_eye_window(const PlacedStrip& a, const PlacedStrip& b) const {
  const Eigen::Vector3d middle = 0.5 * (a.centre + b.centre);
  const double apart = (a.centre - b.centre).norm();
  const double height = (middle - mouth_->centre).dot(up(middle));
  return height > 0.6 * apart && height < 1.9 * apart &&
         apart > 0.7 * (mouth_->left + mouth_->right);
}

std::optional<EyePair> OpeningCutter::best_eyes(const std::vector<PlacedStrip>& list) const {
  std::optional<EyePair> best;
  for (std::size_t i = 0; i < list.size(); ++i) {
    for (std::size_t j = i + 1; j < list.size(); ++j) {
      const double score = pair_score(list[i], list[j]);
      if (score > (best ? best->score : 0.0)) best = EyePair{{list[i], list[j]}, score};
    }
  }
  return best;
}

void OpeningCutter::cut_eyes() {
  const EdgeScore shortening = [this](VertexIndex a, VertexIndex b) {
    const LengthRange& length = motion_.of(a, b);
    return constraints_.forces(a, b) ? 0.0 : length.shortening() / h_ * length.median / h_;
  };
  const EdgeScore beyond_skin = [this](VertexIndex a, VertexIndex b) {
    return contrast(a, b, &LengthRange::shortening);
  };
  const bool any_forced =
      options_.left_eye == OpeningMode::open || options_.right_eye == OpeningMode::open;
  const StripRule rule{shortening,  any_forced ? 0.0 : eye_seed,
                       beyond_skin, any_forced ? 0.0 : eye_floor,
                       eye_share,   doubtful()};
  std::vector<PlacedStrip> list = strips(rule, 2);
  if (any_forced) {
    std::erase_if(list, [this](const PlacedStrip& p) {
      return named_like(p, {"mouth", "lip", "chin", "jaw"});
    });
  }
  const auto pair = best_eyes(list);
  const double found = pair ? pair->score : 0.0;
  bool cut = false;
  for (const OpeningName name : {OpeningName::left_eye, OpeningName::right_eye}) {
    const OpeningMode mode = name == OpeningName::left_eye ? options_.left_eye : options_.right_eye;
    const bool forced = mode == OpeningMode::open;
    const bool wanted =
        mode != OpeningMode::closed && pair && (forced || found >= options_.eye_score);
    result_.candidates.push_back({name, found, forced ? 0.0 : options_.eye_score, wanted,
                                  wanted                        ? ""
                                  : mode == OpeningMode::closed ? "closed by name"
                                  : pair                        ? "the lids shorten too little"
                                         : "no mirror-symmetric pair of strips shortens"});
    if (forced && !pair) {
      throw NoResultError({.what = "the " + std::string(name_of(name)) +
                                   " cannot be opened: no mirror-symmetric pair of strips shortens",
                           .file = take_.origin.path,
                           .remedy = "Use auto or closed, or a take in which the subject blinks"});
    }
    if (!wanted) continue;
    const auto& [a, b] = pair->eyes;
    const Eigen::Vector3d left = up(0.5 * (a.centre + b.centre)).cross(frame_.front);
    const bool a_is_left = left.dot(a.centre - b.centre) > 0;
    const PlacedStrip& eye = a_is_left == (name == OpeningName::left_eye) ? a : b;
    open(name, eye.strip, found, forced);
    cut = true;
  }
  if (cut) flip();
}

}  // namespace

std::string_view name_of(OpeningName name) {
  switch (name) {
    case OpeningName::mouth: return "mouth";
    case OpeningName::left_eye: return "left eye";
    case OpeningName::right_eye: return "right eye";
    case OpeningName::gap: return "gap";
  }
  return "gap";
}

void OpeningOptions::declare(ParameterSet& p) {
  p.group("openings", "Openings of the face");
  const std::vector<Choice<OpeningMode>> modes{
      {OpeningMode::automatic, "auto", "where the motion shows it"},
      {OpeningMode::open, "open", "where the motion points to most, however weak it is"},
      {OpeningMode::closed, "closed", "never"}};
  p.choice("mouth", mouth, modes, "whether the mesh is open between the lips");
  p.choice("left-eye", left_eye, modes,
           "whether the mesh is open between the lids of the left eye");
  p.choice("right-eye", right_eye, modes,
           "whether the mesh is open between the lids of the right eye");
  p.number(
      "mouth-seed", mouth_seed,
      {.min = 0.05,
       .max = 10,
       .help = "least variation of the strongest distance across the lips, in mean distances of "
               "a marker to its five nearest"});
  p.number("eye-score", eye_score,
           {.min = 0.0, .max = 100, .help = "least strength of the weaker of both eyes' lids"});
}

OpeningSearch cut_openings(EditMesh& mesh, const Points& points, double spacing,
                           const MarkerSequence& take, const std::vector<VertexIndex>& original,
                           const OpeningOptions& options, const EdgeConstraints& constraints,
                           const RunContext& ctx) {
  const bool none = options.mouth == OpeningMode::closed &&
                    options.left_eye == OpeningMode::closed &&
                    options.right_eye == OpeningMode::closed;
  if (none || spacing <= 0) return {};
  return OpeningCutter(mesh, points, spacing, take, original, options, constraints, ctx).run();
}

}  // namespace kinemesh
