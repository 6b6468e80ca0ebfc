#include "tests/support/recording.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace kinemesh::test {

namespace {

/// A smooth wandering curve of about the given amplitude: three sines of 0.1 to 0.9 Hz.
class Wander {
 public:
  Wander(Random& random, double amplitude) : amplitude_(amplitude) {
    for (int k = 0; k < 3; ++k) {
      frequency_[k] = random.uniform(0.1, 0.3) * (k + 1);
      phase_[k] = random.uniform(0, 2 * std::numbers::pi);
    }
  }
  double at(double t) const {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
      sum += std::sin(2 * std::numbers::pi * frequency_[k] * t + phase_[k]) / (k + 1);
    }
    return amplitude_ * sum / 1.8;
  }

 private:
  double amplitude_;
  std::array<double, 3> frequency_{}, phase_{};
};

void put(MarkerSequence& s, std::size_t frame, std::size_t marker, const Eigen::Vector3d& p) {
  s.position(frame, marker) = p.cast<float>();
  s.flags()[s.sample(frame, marker)] = SampleFlag::valid;
}

void measure(Recording& take, const TrueMarkers& true_markers, const TakeOptions& options,
             Random random) {
  MarkerSequence &measured = take.measured, &truth = take.truth;
  for (std::size_t f = 0; f < measured.frame_count(); ++f) {
    const std::vector<Eigen::Vector3d> points = true_markers(f);
    for (std::size_t m = 0; m < points.size(); ++m) {
      put(truth, f, m, points[m]);
      const Eigen::Vector3d noise = options.noise_mm * random.normal3();
      put(measured, f, m, points[m] + noise);
      const std::size_t sample = measured.sample(f, m);
      // What a tracker reports: small where rays meet well, never quite 0.
      measured.residuals()[sample] =
          static_cast<float>(0.05 + options.noise_mm * std::abs(random.normal()));
      // Between three and seven of seven cameras.
      measured.camera_masks()[sample] =
          static_cast<uint8_t>(0x7F & ~((1U << random.below(7)) | (1U << random.below(7))));
    }
  }
}

void add_gap(Recording& take, std::size_t marker, std::size_t first, std::size_t last) {
  last = std::min(last, take.measured.frame_count() - 1);
  if (first > last) return;
  for (std::size_t f = first; f <= last; ++f) {
    if (!take.measured.valid(f, marker)) return;  // gaps of one marker do not overlap
  }
  for (std::size_t f = first; f <= last; ++f) {
    const std::size_t sample = take.measured.sample(f, marker);
    take.measured.position(f, marker).setZero();
    take.measured.flags()[sample] = 0;
    take.measured.residuals()[sample] = -1;
    take.measured.camera_masks()[sample] = 0;
  }
  take.gaps.push_back({marker, first, last});
}

/// Among the first `count` markers.
std::size_t nearest_marker(const Recording& take, std::size_t count, std::size_t marker,
                           std::size_t rank) {
  std::vector<std::pair<float, std::size_t>> others;
  for (std::size_t m = 0; m < count; ++m) {
    if (m != marker) {
      others.emplace_back((take.truth.position(0, m) - take.truth.position(0, marker)).norm(), m);
    }
  }
  std::sort(others.begin(), others.end());
  return others.at(std::min(rank, others.size() - 1)).second;
}

void add_gaps(Recording& take, std::size_t count, const TakeOptions& options, Random random) {
  const std::size_t frames = take.measured.frame_count();
  const auto length = [&](double low, double high) {
    return std::max<std::size_t>(
        1, static_cast<std::size_t>(random.uniform(low, high) * options.rate_hz));
  };
  const auto before = static_cast<std::size_t>(0.15 * options.rate_hz);
  std::size_t added = 0;
  while (added < options.short_gaps) {
    const std::size_t marker = random.below(count);
    const std::size_t together = std::min(1 + random.below(4), options.short_gaps - added);
    // A take begins and ends in the middle of things: gaps may have begun before it.
    const std::size_t begin = random.below(frames + before);
    for (std::size_t k = 0; k < together; ++k, ++added) {
      const std::size_t m = k == 0 ? marker : nearest_marker(take, count, marker, k - 1);
      const std::size_t first = begin + random.below(4), last = first + 2 + length(0.02, 0.15);
      if (last >= before) add_gap(take, m, std::max(first, before) - before, last - before);
    }
  }
  for (std::size_t k = 0; k < options.long_gaps; ++k) {
    const std::size_t frames_lost = length(0.3, 1.0);
    const std::size_t room = frames > frames_lost + 2 ? frames - frames_lost - 2 : 1;
    const std::size_t first = 1 + random.below(room);
    add_gap(take, random.below(take.measured.marker_count()), first, first + frames_lost - 1);
  }
}

void swap_labels(Recording& take, std::size_t count, Random random) {
  const std::size_t first = random.below(count);
  const std::size_t frames = take.measured.frame_count();
  const SwapRecord swap{first, nearest_marker(take, count, first, 0),
                        frames / 2 + random.below(frames / 4)};
  for (std::size_t f = swap.from_frame; f < frames; ++f) {
    const std::size_t a = take.measured.sample(f, swap.first);
    const std::size_t b = take.measured.sample(f, swap.second);
    std::swap_ranges(&take.measured.positions()[3 * a], &take.measured.positions()[3 * a] + 3,
                     &take.measured.positions()[3 * b]);
    std::swap(take.measured.flags()[a], take.measured.flags()[b]);
    std::swap(take.measured.residuals()[a], take.measured.residuals()[b]);
    std::swap(take.measured.camera_masks()[a], take.measured.camera_masks()[b]);
  }
  take.swap = swap;
}

}  // namespace

std::vector<Eigen::Isometry3d> wandering_head(std::size_t frames, const TakeOptions& o,
                                              Random random) {
  std::vector<Wander> turn, move;
  for (int k = 0; k < 3; ++k) turn.emplace_back(random, o.head_degrees * std::numbers::pi / 180);
  for (int k = 0; k < 3; ++k) move.emplace_back(random, o.head_mm);
  // Face frame (x left, y up, z forward) to lab frame (x left, y backwards, z up).
  Eigen::Matrix3d upright;
  upright << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  std::vector<Eigen::Isometry3d> poses;
  for (std::size_t f = 0; f < frames; ++f) {
    const double t = static_cast<double>(f) / o.rate_hz;
    const Eigen::Quaterniond rotation = Eigen::AngleAxisd(turn[0].at(t), Eigen::Vector3d::UnitY()) *
                                        Eigen::AngleAxisd(turn[1].at(t), Eigen::Vector3d::UnitX()) *
                                        Eigen::AngleAxisd(turn[2].at(t), Eigen::Vector3d::UnitZ());
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = upright * rotation.toRotationMatrix();
    pose.translation() = Eigen::Vector3d(120, -340, 1280) +
                         Eigen::Vector3d(move[0].at(t), move[1].at(t), move[2].at(t));
    poses.push_back(pose);
  }
  return poses;
}

Recording record(const std::vector<Marker>& markers, std::size_t face_markers,
                 const TrueMarkers& true_markers, const TakeOptions& options, Random& random) {
  const auto frames = static_cast<std::size_t>(std::lround(options.duration_s * options.rate_hz));
  Recording recording;
  recording.measured = MarkerSequence::invalid(frames, markers, options.rate_hz);
  recording.truth = MarkerSequence::invalid(frames, markers, options.rate_hz);
  measure(recording, true_markers, options, Random(random.bits()));
  add_gaps(recording, face_markers, options, Random(random.bits()));
  if (options.label_swap) swap_labels(recording, face_markers, Random(random.bits()));
  for (MarkerSequence* s : {&recording.measured, &recording.truth}) {
    s->origin.manufacturer = "Kinemesh synthetic";
    s->origin.x_screen = "+X";
    s->origin.y_screen = "+Z";
    C3dParameter company;
    company.name = "COMPANY";
    company.type = C3dType::text;
    company.characters = s->origin.manufacturer;
    company.dimensions = {static_cast<uint8_t>(company.characters.size())};
    s->parameters.set("MANUFACTURER", std::move(company));
  }
  return recording;
}

}  // namespace kinemesh::test
