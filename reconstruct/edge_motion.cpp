#include "reconstruct/edge_motion.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "config/parallel.h"

namespace kinemesh {
namespace {

using Vector = Eigen::Vector3f;

/// The median of each coordinate on its own.
Vector median_of(std::vector<Vector>& values) {
  Vector median = Vector::Zero();
  if (values.empty()) return median;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  for (int k = 0; k < 3; ++k) {
    std::nth_element(values.begin(), middle, values.end(),
                     [k](const Vector& a, const Vector& b) { return a[k] < b[k]; });
    median[k] = (*middle)[k];
  }
  return median;
}

/// One marker among its neighbours over the take.
class MarkerTrack {
 public:
  MarkerTrack(const MarkerSequence& take, std::size_t marker, std::vector<std::size_t> ring,
              float jump)
      : take_(take), marker_(marker), ring_(std::move(ring)), jump_(jump) {}

  void mark_reliable(std::vector<uint8_t>& reliable) {
    const std::vector<std::size_t> starts = piece_starts();
    const std::size_t pieces = starts.size() - 1;
    std::size_t longest = 0;
    for (std::size_t i = 1; i < pieces; ++i) {
      if (starts[i + 1] - starts[i] > starts[longest + 1] - starts[longest]) longest = i;
    }
    std::vector<bool> trusted(pieces, false);
    trusted[longest] = true;
    for (std::size_t last = longest, i = longest + 1; i < pieces; ++i) {
      trusted[i] = agrees(starts[last + 1] - 1, starts[i]);
      if (trusted[i]) last = i;
    }
    for (std::size_t last = longest, i = longest; i-- > 0;) {
      trusted[i] = agrees(starts[last], starts[i + 1] - 1);
      if (trusted[i]) last = i;
    }
    for (std::size_t i = 0; i < pieces; ++i) {
      for (std::size_t f = starts[i]; f < starts[i + 1]; ++f) {
        const bool usable = trusted[i] && take_.valid(f, marker_) && !take_.filled(f, marker_);
        reliable[take_.sample(f, marker_)] = usable ? 1 : 0;
      }
    }
  }

 private:
  /// First frames of the pieces between jumps, and the number of frames.
  std::vector<std::size_t> piece_starts() {
    std::vector<std::size_t> starts{0};
    for (std::size_t f = 1; f < take_.frame_count(); ++f) {
      const Vector step = take_.position(f, marker_) - take_.position(f - 1, marker_);
      if (step.norm() < 0.5F * jump_) continue;  // saves the neighbours' median almost always
      steps_.clear();
      for (const std::size_t m : ring_)
        steps_.emplace_back(take_.position(f, m) - take_.position(f - 1, m));
      if ((step - median_of(steps_)).norm() > jump_) starts.push_back(f);
    }
    starts.push_back(take_.frame_count());
    return starts;
  }

  Vector place(std::size_t frame) {
    steps_.clear();
    for (const std::size_t m : ring_) steps_.emplace_back(take_.position(frame, m));
    return take_.position(frame, marker_) - median_of(steps_);
  }
  bool agrees(std::size_t frame, std::size_t other) {
    return (place(frame) - place(other)).norm() <= jump_;
  }

  const MarkerSequence& take_;
  std::size_t marker_;
  std::vector<std::size_t> ring_;
  float jump_;
  std::vector<Vector> steps_;
};

double quantile(std::vector<float>& values, double share) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(
                                       std::lround(share * static_cast<double>(values.size() - 1)));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

std::vector<uint8_t> reliable_samples(const MarkerSequence& take, const EditMesh& mesh,
                                      const std::vector<VertexIndex>& original, double spacing,
                                      const RunContext& ctx) {
  constexpr double share_of_spacing = 0.5;
  constexpr double fastest = 600;  // mm/s; skin moves at up to 300 against the skin around it
  const double step = take.rate_hz > 0 ? fastest / take.rate_hz : 0.0;
  const auto jump = static_cast<float>(std::max(share_of_spacing * spacing, step));
  std::vector<uint8_t> reliable(take.sample_count(), 1);
  parallel_for(ctx, mesh.vertex_count(), 8, [&](std::size_t v) {
    std::vector<std::size_t> ring;
    for (const VertexIndex w : mesh.neighbours(static_cast<VertexIndex>(v)))
      ring.push_back(original[w]);
    MarkerTrack(take, original[v], std::move(ring), jump).mark_reliable(reliable);
  });
  return reliable;
}

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace

EdgeMotion::EdgeMotion(const MarkerSequence& take, const EditMesh& mesh,
                       const std::vector<VertexIndex>& original, double spacing,
                       const RunContext& ctx)
    : take_(take), original_(original) {
  const auto start = Clock::now();
  reliable_ = reliable_samples(take, mesh, original, spacing, ctx);
  for (std::size_t i = 0; i < reliable_.size(); ++i) {
    const bool measured =
        (take.flags()[i] & SampleFlag::valid) != 0 && (take.flags()[i] & SampleFlag::filled) == 0;
    jump_samples_ += measured && reliable_[i] == 0 ? 1 : 0;
  }
  const auto edges = mesh.edges();
  std::vector<LengthRange> ranges(edges.size());
  parallel_for(ctx, edges.size(), 16,
               [&](std::size_t i) { ranges[i] = measure(edges[i][0], edges[i][1]); });
  for (std::size_t i = 0; i < edges.size(); ++i) {
    known_[{std::min(edges[i][0], edges[i][1]), std::max(edges[i][0], edges[i][1])}] = ranges[i];
  }
  seconds_ = seconds_since(start);
}

const LengthRange& EdgeMotion::of(VertexIndex a, VertexIndex b) {
  const DirectedEdge key{std::min(a, b), std::max(a, b)};
  if (const auto found = known_.find(key); found != known_.end()) return found->second;
  const auto start = Clock::now();
  const LengthRange& range = known_[key] = measure(a, b);
  seconds_ += seconds_since(start);
  return range;
}

LengthRange EdgeMotion::measure(VertexIndex a, VertexIndex b) const {
  constexpr std::size_t fewest = 20;  // common frames below which all are used
  const std::size_t p = original_[a];
  const std::size_t q = original_[b];
  std::vector<float> lengths;
  lengths.reserve(take_.frame_count());
  for (const bool all : {false, true}) {
    if (all && lengths.size() >= fewest) break;
    lengths.clear();
    for (std::size_t f = 0; f < take_.frame_count(); ++f) {
      if (!all && (reliable_[take_.sample(f, p)] & reliable_[take_.sample(f, q)]) == 0) continue;
      const float length = (take_.position(f, p) - take_.position(f, q)).norm();
      if (std::isfinite(length)) lengths.push_back(length);
    }
  }
  if (lengths.empty()) return {};
  LengthRange range;
  range.used = static_cast<double>(lengths.size()) / static_cast<double>(take_.frame_count());
  range.low = quantile(lengths, 0.01);
  range.median = quantile(lengths, 0.5);
  range.high = quantile(lengths, 0.99);
  return range;
}

}  // namespace kinemesh
