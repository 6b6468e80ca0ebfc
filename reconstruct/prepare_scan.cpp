#include "reconstruct/prepare_scan.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <tuple>

#include "config/error.h"
#include "config/text.h"

namespace kinemesh {
namespace {

/// A side of a face, to be paired with the face across it.
struct Side {
  VertexIndex low, high;
  FaceIndex face;
  bool forward;  // from low to high
};

std::vector<Side> sides_of(const std::vector<Triangle>& faces) {
  std::vector<Side> sides;
  for (FaceIndex f = 0; f < faces.size(); ++f) {
    for (std::size_t c = 0; c < 3; ++c) {
      const VertexIndex a = faces[f][c], b = faces[f][(c + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), f, a < b});
    }
  }
  std::ranges::sort(sides, [](const Side& x, const Side& y) {
    return std::tie(x.low, x.high, x.face) < std::tie(y.low, y.high, y.face);
  });
  return sides;
}

struct Across {
  FaceIndex face;
  bool agrees;
};

/// Per face and side, the face across manifold edges.
std::vector<std::vector<Across>> neighbours_of(const std::vector<Triangle>& faces) {
  std::vector<std::vector<Across>> across(faces.size());
  const std::vector<Side> sides = sides_of(faces);
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i + 1;
    while (end < sides.size() && sides[end].low == sides[i].low && sides[end].high == sides[i].high)
      ++end;
    if (end == i + 2) {
      const Side &a = sides[i], &b = sides[i + 1];
      across[a.face].push_back({b.face, a.forward != b.forward});
      across[b.face].push_back({a.face, a.forward != b.forward});
    }
    i = end;
  }
  return across;
}

/// Turns faces until those of a component agree; returns the component of each face.
std::vector<uint32_t> orient_alike(std::vector<Triangle>& faces, std::vector<bool>& turned) {
  const auto across = neighbours_of(faces);
  std::vector<uint32_t> component(faces.size(), invalid_index);
  uint32_t count = 0;
  std::vector<FaceIndex> waiting;
  for (FaceIndex start = 0; start < faces.size(); ++start) {
    if (component[start] != invalid_index) continue;
    component[start] = count;
    waiting.push_back(start);
    while (!waiting.empty()) {
      const FaceIndex f = waiting.back();
      waiting.pop_back();
      for (const Across& next : across[f]) {
        if (component[next.face] != invalid_index) continue;
        component[next.face] = count;
        turned[next.face] = turned[f] == next.agrees;
        waiting.push_back(next.face);
      }
    }
    ++count;
  }
  for (FaceIndex f = 0; f < faces.size(); ++f) {
    if (turned[f]) std::swap(faces[f][1], faces[f][2]);
  }
  return component;
}

/// Volume under each component, its boundary loops closed by fans from their middles.
std::vector<double> volumes_of(const Topology& topology, const std::vector<Eigen::Vector3d>& p,
                               const std::vector<uint32_t>& component) {
  std::vector<double> volumes;
  for (FaceIndex f = 0; f < topology.face_count(); ++f) {
    if (component[f] >= volumes.size()) volumes.resize(component[f] + 1, 0.0);
    const Triangle& t = topology.faces()[f];
    volumes[component[f]] += p[t[0]].dot(p[t[1]].cross(p[t[2]])) / 6.0;
  }
  for (const auto& loop : topology.boundary_loops()) {
    const auto around = topology.faces_of(loop.front());
    if (around.empty()) continue;
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const VertexIndex v : loop) middle += p[v] / static_cast<double>(loop.size());
    for (std::size_t i = 0; i < loop.size(); ++i) {
      volumes[component[around.front()]] +=
          middle.dot(p[loop[(i + 1) % loop.size()]].cross(p[loop[i]])) / 6.0;
    }
  }
  return volumes;
}

void describe(PreparedScan& scan) {
  const Topology& topology = *scan.mesh.topology;
  scan.components = topology.component_count();
  scan.isolated_vertices = topology.isolated_vertex_count();
  if (scan.turned_faces == topology.face_count()) {
    scan.notes.push_back("The scan's normals pointed inwards: all faces were turned round");
  } else if (scan.turned_faces > 0) {
    scan.notes.push_back(count_of(scan.turned_faces, "face") +
                         " of the scan faced the wrong way and were turned round");
  }
  if (scan.components > 1) {
    scan.notes.push_back("The scan has " + std::to_string(scan.components) +
                         " components: a marker moves only the one it sits on, the others stay "
                         "with the head; remove what is no skin, or join the parts");
  }
  if (scan.isolated_vertices > 0) {
    scan.notes.push_back(count_of(scan.isolated_vertices, "vertex", "vertices") +
                         " of the scan belong to no face and stay where they are");
  }
}

double diagonal_of(const auto& points) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d high = -low;
  for (const auto& p : points) {
    low = low.cwiseMin(p.template cast<double>());
    high = high.cwiseMax(p.template cast<double>());
  }
  return (high - low).norm();
}

}  // namespace

PreparedScan prepare_scan(const Mesh& scan) {
  if (!scan.topology || scan.topology->face_count() == 0) {
    throw NoResultError({.what = "the scan has no faces",
                         .remedy = "Reconstruct a triangle mesh from the scanner's points first"});
  }
  std::vector<Eigen::Vector3d> positions;
  for (std::size_t v = 0; v < scan.positions.size(); ++v) {
    if (!scan.positions[v].allFinite()) {
      throw InputError({.what = "vertex " + std::to_string(v) + " of the scan is not finite",
                        .remedy = "Repair the scan"});
    }
    positions.push_back(scan.positions[v].cast<double>());
  }
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const auto& p : positions) middle += p / static_cast<double>(positions.size());
  for (auto& p : positions) p -= middle;
  std::vector<Triangle> faces = scan.topology->faces();
  std::vector<bool> turned(faces.size(), false);
  const std::vector<uint32_t> component = orient_alike(faces, turned);
  const std::vector<double> volumes =
      volumes_of(Topology(positions.size(), faces), positions, component);
  for (FaceIndex f = 0; f < faces.size(); ++f) {
    if (volumes[component[f]] >= 0.0) continue;
    std::swap(faces[f][1], faces[f][2]);
    turned[f] = !turned[f];
  }
  PreparedScan result{scan};
  result.turned_faces = static_cast<std::size_t>(std::ranges::count(turned, true));
  if (result.turned_faces > 0) {
    result.mesh.topology = Topology::create(positions.size(), std::move(faces));
  }
  describe(result);
  return result;
}

ScanOpenings scan_openings(const Mesh& scan) {
  constexpr double least_eye_mm = 40.0;
  constexpr std::size_t eyes_and_mouth = 3;
  std::vector<double> perimeters;
  for (const auto& loop : scan.topology->boundary_loops()) {
    double perimeter = 0.0;
    for (std::size_t i = 0; i < loop.size(); ++i) {
      perimeter += static_cast<double>(
          (scan.positions[loop[(i + 1) % loop.size()]] - scan.positions[loop[i]]).norm());
    }
    perimeters.push_back(perimeter);
  }
  ScanOpenings result{perimeters.size(), {}};
  std::ranges::sort(perimeters, std::greater<>());
  const auto large = static_cast<std::size_t>(std::ranges::count_if(
      perimeters, [](double perimeter) { return perimeter >= least_eye_mm; }));
  const std::size_t expected =
      std::min(perimeters.size(), std::clamp<std::size_t>(large, 1, 1 + eyes_and_mouth));
  const std::size_t holes = perimeters.size() - expected;
  if (holes == 0) return result;
  result.note = "The scan has " + count_of(holes, "hole") +
                " besides its rim, eyes and mouth, of up to " +
                format_fixed(perimeters[expected], 0) +
                " mm around: motion goes around holes and does not cross them; close those that "
                "are larger than the markers' spacing in the scanner's software";
  return result;
}

double scan_scale(const Mesh& scan, const std::vector<Eigen::Vector3d>& markers) {
  const double ratio = diagonal_of(scan.positions) / diagonal_of(markers);
  constexpr double least = 0.8, most = 6.0, usual = 2.0;
  if (ratio >= least && ratio <= most) return 1.0;
  double best = 0.0;
  for (const double factor : {1000.0, 10.0, 25.4, 0.001}) {
    if (ratio * factor < least || ratio * factor > most) continue;
    const auto off = [&](double f) { return std::abs(std::log(ratio * f / usual)); };
    if (best == 0.0 || off(factor) < off(best)) best = factor;
  }
  if (best != 0.0) return best;
  throw NoResultError({.what = "the scan is " + format_number(std::round(100.0 * ratio) / 100.0) +
                               " times as large as the markers' extent, which no length unit "
                               "explains",
                       .remedy = "Cut the scan to the head, choose the face's markers with "
                                 "--include, or scale the scan to mm"});
}

}  // namespace kinemesh
