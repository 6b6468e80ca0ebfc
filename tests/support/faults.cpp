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

}  // namespace kinemesh::test
