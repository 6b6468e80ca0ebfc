// A scan of half a million triangles and more: a model face whose triangles are divided, with the
// truth of its expressions; solved decimated or whole. `large_scan_figures [FACES [MOST [FRAMES]]]`
// divides until there are FACES triangles at least, solves on MOST at most and repeats the
// expressions up to FRAMES. Prints one JSON object, for tools/verify.d/10_large_scan.
#include <sys/resource.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <utility>
#include <vector>

#include "tests/support/ict_expressions.h"

namespace kinemesh {
namespace {

/// Each triangle in four; new vertices lie on the middles of edges.
struct Divided {
  std::vector<std::array<VertexIndex, 2>> middles;  // of the new vertices, in order
  std::vector<Triangle> faces;                      // 4 f … 4 f + 3 from face f
};

Divided divide(const Topology& topology) {
  Divided d;
  std::map<std::pair<VertexIndex, VertexIndex>, VertexIndex> index;
  const auto middle = [&](VertexIndex a, VertexIndex b) {
    const auto next = static_cast<VertexIndex>(topology.vertex_count() + d.middles.size());
    const auto [at, added] = index.try_emplace(std::minmax(a, b), next);
    if (added) d.middles.push_back({a, b});
    return at->second;
  };
  for (const Triangle& t : topology.faces()) {
    const VertexIndex a = middle(t[0], t[1]), b = middle(t[1], t[2]), c = middle(t[2], t[0]);
    d.faces.insert(d.faces.end(), {{t[0], a, c}, {t[1], b, a}, {t[2], c, b}, {a, b, c}});
  }
  return d;
}

void add_middles(const Divided& d, std::vector<Eigen::Vector3f>& positions) {
  for (const auto& [a, b] : d.middles) positions.emplace_back(0.5F * (positions[a] + positions[b]));
}

/// The same point in one of the four triangles.
SurfacePoint divided_point(const SurfacePoint& p) {
  for (std::size_t c = 0; c < 3; ++c) {
    if (p.weights.at(c) < 0.5) continue;
    SurfacePoint q{4 * p.face + static_cast<FaceIndex>(c)};
    q.weights = {2.0 * p.weights.at(c) - 1.0, 2.0 * p.weights.at((c + 1) % 3),
                 2.0 * p.weights.at((c + 2) % 3)};
    return q;
  }
  return {4 * p.face + 3,
          {1.0 - 2.0 * p.weights[2], 1.0 - 2.0 * p.weights[0], 1.0 - 2.0 * p.weights[1]}};
}

test::IctExpressions divided_face(std::size_t faces) {
  test::IctExpressions ict = test::ict_expressions(2);
  while (ict.scan.topology->face_count() < faces) {
    const Divided d = divide(*ict.scan.topology);
    const std::size_t vertices = ict.scan.positions.size() + d.middles.size();
    add_middles(d, ict.scan.positions);
    for (auto& truth : ict.truth) add_middles(d, truth);
    for (AttachedMarker& m : ict.markers) m.point = divided_point(m.point);
    ict.scan.topology = Topology::create(vertices, d.faces);
  }
  return ict;
}

/// The expressions again and again.
MarkerSequence repeated(const MarkerSequence& take, std::size_t frames) {
  MarkerSequence longer = MarkerSequence::invalid(frames, take.markers(), take.rate_hz);
  for (std::size_t f = 0; f < frames; ++f) {
    for (std::size_t m = 0; m < take.marker_count(); ++m) {
      longer.position(f, m) = take.position(f % take.frame_count(), m);
      longer.flags()[longer.sample(f, m)] = SampleFlag::valid;
    }
  }
  return longer;
}

double memory_gb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) * 1024e-9;
}

void measure(std::size_t faces, int64_t most, std::size_t frames) {
  const test::IctExpressions ict = divided_face(faces);
  const MarkerSequence take = repeated(ict.measured, std::max(frames, ict.measured.frame_count()));
  const double before = memory_gb();
  DriveOptions options;
  options.most_faces = most;
  const auto start = std::chrono::steady_clock::now();
  const DriveResult driven = drive_scan(ict.scan, ict.markers, take, options);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const double after = memory_gb();
  double sum = 0.0;
  for (std::size_t f = 0; f < ict.truth.size(); ++f) {
    for (VertexIndex v = 0; v < driven.animation.vertex_count(); ++v) {
      sum += static_cast<double>((driven.animation.position(f, v) - ict.truth[f][v]).norm());
    }
  }
  std::printf(
      "{\"faces\": %zu, \"vertices\": %zu, \"markers\": %zu, \"frames\": %zu, \"solved_faces\": "
      "%zu, "
      "\"operator_s\": %.2f, \"frames_s\": %.2f, \"drive_s\": %.2f, \"mean\": %.4f, "
      "\"memory_gb\": %.2f, \"memory_before_gb\": %.2f}\n",
      ict.scan.topology->face_count(), ict.scan.positions.size(), ict.markers.size(),
      take.frame_count(), driven.solved_faces, driven.operator_seconds, driven.frames_seconds,
      seconds, sum / static_cast<double>(ict.truth.size() * ict.scan.positions.size()), after,
      before);
}

}  // namespace
}  // namespace kinemesh

int main(int argc, char** argv) {
  const auto number = [&](int at, unsigned long long otherwise) {
    return argc > at ? std::strtoull(argv[at], nullptr, 10) : otherwise;
  };
  kinemesh::measure(number(1, 500000), static_cast<int64_t>(number(2, 100000)), number(3, 57));
}
