#include "tests/support/faults.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace kinemesh::test {

SpikyTake with_spikes(MarkerSequence take, double share, uint32_t seed, std::size_t apart) {
  SpikyTake out;
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  std::uniform_real_distribution<float> uniform;
  constexpr double longest_s = 0.035;
  const auto longest =
      std::clamp<std::size_t>(static_cast<std::size_t>(longest_s * take.rate_hz), 1, 3);
  std::vector<uint8_t> used(take.sample_count(), 0);
  const double wanted = share * static_cast<double>(take.sample_count());
  double put = 0.0;
  for (int tries = 0; put < wanted && tries < 1'000'000; ++tries) {
    const std::size_t m = random() % take.marker_count();
    const std::size_t length = 1 + random() % longest;
    const std::size_t f = random() % (take.frame_count() - length + 1);
    const std::size_t begin = f > apart ? f - apart : 0;
    bool free = take.markers()[m].kind == MarkerKind::marker;
    for (std::size_t k = begin; k < std::min(take.frame_count(), f + length + apart); ++k) {
      free = free && used[take.sample(k, m)] == 0;
    }
    for (std::size_t k = f; k < f + length; ++k) free = free && take.valid(k, m);
    if (!free) continue;
    const float size = 3.0F * std::pow(50.0F / 3.0F, uniform(random));
    const Eigen::Vector3f way =
        Eigen::Vector3f(normal(random), normal(random), normal(random)).normalized();
    for (std::size_t k = f; k < f + length; ++k) {
      used[take.sample(k, m)] = 1;
      take.position(k, m) += size * way;
    }
    out.spikes.push_back({m, {f, f + length}, size});
    put += static_cast<double>(length);
  }
  out.take = std::move(take);
  return out;
}

std::size_t not_among(const std::vector<Spike>& found, const std::vector<Spike>& truth) {
  return static_cast<std::size_t>(std::ranges::count_if(found, [&](const Spike& a) {
    return std::ranges::none_of(truth, [&](const Spike& b) {
      return a.marker == b.marker && a.frames.begin < b.frames.end && b.frames.begin < a.frames.end;
    });
  }));
}

void rotate_labels(MarkerSequence& take, const std::vector<std::size_t>& markers, std::size_t from,
                   std::size_t until) {
  for (std::size_t f = from; f < until; ++f) {
    for (std::size_t i = 0; i + 1 < markers.size(); ++i) {
      const std::size_t a = markers[i];
      const std::size_t b = markers[i + 1];
      const Eigen::Vector3f p = take.position(f, a);
      take.position(f, a) = take.position(f, b);
      take.position(f, b) = p;
      std::swap(take.flags()[take.sample(f, a)], take.flags()[take.sample(f, b)]);
    }
  }
}

namespace {

/// The nearest of the others in a frame in which all are seen, one of the first six.
std::size_t near_marker(const MarkerSequence& take, std::size_t m, std::size_t f, uint32_t which) {
  std::vector<std::pair<float, std::size_t>> others;
  for (std::size_t k = 0; k < take.marker_count(); ++k) {
    if (k == m || !take.valid(f, k) || take.markers()[k].kind != MarkerKind::marker) continue;
    others.emplace_back((take.position(f, k) - take.position(f, m)).norm(), k);
  }
  std::ranges::sort(others);
  return others.at(which % 6).second;
}

struct Island {
  std::size_t marker;
  FrameRange frames;
  std::size_t before, behind;  ///< frames of the gaps
};

std::vector<Island> islands(const MarkerSequence& take, std::size_t count, std::mt19937& random) {
  std::vector<Island> out;
  std::vector<uint8_t> used(take.marker_count(), 0);
  for (int tries = 0; out.size() < count && tries < 100'000; ++tries) {
    const std::size_t m = random() % take.marker_count();
    const std::size_t length = 5 + random() % 26;
    const std::size_t before = 3 + random() % 18;
    const std::size_t behind = 3 + random() % 18;
    const std::size_t all = before + length + behind + 40;
    const std::size_t f = 20 + before + random() % (take.frame_count() - all);
    bool seen = used[m] == 0 && take.markers()[m].kind == MarkerKind::marker;
    for (std::size_t k = f - before - 5; k < f + length + behind + 5; ++k) {
      seen = seen && take.valid(k, m);
    }
    if (!seen) continue;
    used[m] = 1;
    out.push_back({m, {f, f + length}, before, behind});
  }
  return out;
}

void lose(MarkerSequence& take, std::size_t m, std::size_t begin, std::size_t end) {
  for (std::size_t f = begin; f < end; ++f) take.flags()[take.sample(f, m)] = 0;
}

void surround(MarkerSequence& take, const Island& island) {
  lose(take, island.marker, island.frames.begin - island.before, island.frames.begin);
  lose(take, island.marker, island.frames.end, island.frames.end + island.behind);
}

}  // namespace

StrayTake with_strays(MarkerSequence take, std::size_t count, uint32_t seed) {
  StrayTake out;
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform;
  std::normal_distribution<float> normal;
  const MarkerSequence truth = take;
  std::vector<uint8_t> used(take.marker_count(), 0);
  for (const Island& island : islands(take, count, random)) {
    const auto [begin, end] = island.frames;
    const std::size_t owner = near_marker(truth, island.marker, begin, random());
    bool seen = used[owner] == 0 && used[island.marker] == 0;
    for (std::size_t f = begin; f < end; ++f) seen = seen && truth.valid(f, owner);
    if (!seen) continue;
    used[owner] = used[island.marker] = 1;
    surround(take, island);
    Stray stray{island.marker, island.frames, 0.0, {}};
    if (out.strays.size() % 2 == 0) {
      stray.owner = owner;
      lose(take, owner, begin - std::min(begin, random() % 5),
           std::min(end + random() % 5, take.frame_count()));
    }
    const Eigen::Vector3f way =
        Eigen::Vector3f(normal(random), normal(random), normal(random)).normalized() *
        (12.0F + 48.0F * uniform(random));
    for (std::size_t f = begin; f < end; ++f) {
      if (stray.owner) {
        take.position(f, island.marker) = truth.position(f, owner);
      } else {
        take.position(f, island.marker) += way;
      }
    }
    out.strays.push_back(stray);
  }
  out.take = std::move(take);
  return out;
}

MarkerSequence with_islands(MarkerSequence take, std::size_t count, uint32_t seed) {
  std::mt19937 random(seed);
  for (const Island& island : islands(take, count, random)) surround(take, island);
  return take;
}

}  // namespace kinemesh::test
