// Triangulates the markers of the four samples and of generated faces that no threshold was tuned
// on, and compares with the true geodesic Delaunay triangulation. One JSON object per take on
// stdout; tools/verify.d/3_triangulation makes the table. `triangulation_figures [FACES]`.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include "capture/gap_fill.h"
#include "capture/marker_selection.h"
#include "reconstruct/canonical_pose.h"
#include "reconstruct/delaunay_flips.h"
#include "reconstruct/edge_motion.h"
#include "reconstruct/reference_frame.h"
#include "reconstruct/strip.h"
#include "reconstruct/surface_cgal.h"
#include "reconstruct/surface_repair.h"
#include "reconstruct/triangulate.h"
#include "tests/support/samples.h"
#include "tests/support/triangulation_score.h"

namespace kinemesh {
namespace {

constexpr int repetitions = 10;

/// The second way of the geometry: a plane across the mean normal, Delaunay, the same trimming and
/// flips.
EditMesh planar_way(const Points& points, const EditMesh& oriented) {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (const auto& n : vertex_normals(oriented, points)) normal += n;
  normal.normalize();
  const Eigen::Vector3d x = normal.unitOrthogonal(), y = normal.cross(x);
  std::vector<Eigen::Vector2d> flat;
  for (const auto& p : points) flat.emplace_back(p.dot(x), p.dot(y));
  EditMesh mesh(points.size(), planar_delaunay(flat));
  trim_rim(mesh, points, measure_spacing(points), 1.8, {});
  flip_to_delaunay(mesh, points);
  return mesh;
}

/// The second way of the mouth: a strip grown by the range of lengths alone.
void range_way(EditMesh& mesh, const MarkerSequence& take, const std::vector<VertexIndex>& same,
               double h) {
  EdgeMotion motion(take, mesh, same, h);
  const EdgeScore range = [&](VertexIndex a, VertexIndex b) { return motion.of(a, b).range() / h; };
  const auto strips =
      find_strips(mesh, {range, 0.7, range, 0.45, 0.4, [](auto, auto) { return false; }});
  if (!strips.empty() && strips.front().edges.size() >= 3) cut_strip(mesh, strips.front());
}

std::size_t differing(const test::TriangulationScore& score, std::string_view name) {
  for (const auto& o : score.openings) {
    if (o.name == name) return o.differing_triangles;
  }
  return 0;
}

/// Processor time of this thread, ms: other programs do not disturb it.
double processor_time() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

/// Of triangulate() without the statistics of the motion, ms.
double geometry_time(const MarkerSequence& take) {
  const double start = processor_time();
  const auto result = triangulate(take);
  const double middle = processor_time();
  std::vector<VertexIndex> same(take.marker_count());
  for (VertexIndex v = 0; v < same.size(); ++v) same[v] = v;
  const EditMesh mesh(same.size(), result.topology->faces());
  const EdgeMotion motion(take, mesh, same, result.diagnostics.spacing);
  return middle - start - (processor_time() - middle);
}

void measure(const std::string& name, const test::SyntheticTake& generated,
             const MarkerSequence& take) {
  const auto result = triangulate(take);
  double milliseconds = 1e9;
  for (int i = 0; i < repetitions; ++i) milliseconds = std::min(milliseconds, geometry_time(take));
  const auto reference = generated.reference_at(result.frame);
  const auto score = test::score_triangulation(*result.topology, reference);
  std::size_t most = 0;
  for (const auto& o : score.openings) most = std::max(most, o.differing_triangles);

  TriangulateOptions closed;
  closed.openings.mouth = closed.openings.left_eye = closed.openings.right_eye =
      OpeningMode::closed;
  const auto whole = triangulate(take, closed);
  const Points points = choose_reference_frame(take, -1).points;
  const EditMesh mesh(points.size(), whole.topology->faces());
  const auto planar = test::score_triangulation(
      Topology(points.size(), planar_way(points, mesh).triangles()), reference);
  std::vector<VertexIndex> same(points.size());
  for (VertexIndex v = 0; v < same.size(); ++v) same[v] = v;
  EditMesh by_range = mesh;
  range_way(by_range, take, same, whole.diagnostics.spacing);
  const auto ranged =
      test::score_triangulation(Topology(points.size(), by_range.triangles()), reference);

  std::printf(
      "{\"take\": \"%s\", \"markers\": %zu, \"precision\": %.4f, \"recall\": %.4f, "
      "\"rms_ratio\": %.3f, \"rim\": %.3f, \"rim_local\": %.3f, \"openings\": %zu, "
      "\"openings_right\": %s, \"differing\": %zu, \"across\": %zu, \"sound\": %s, "
      "\"ms\": %.2f, \"planar_precision\": %.4f, \"planar_recall\": %.4f, "
      "\"mouth_differing\": %zu, \"mouth_differing_by_range\": %zu}\n",
      name.c_str(), take.marker_count(), score.precision, score.recall, score.rms_ratio,
      score.longest_rim_edge, score.longest_rim_edge_local, score.openings.size(),
      score.openings_right ? "true" : "false", most, score.edges_across,
      score.manifold && score.all_markers && score.outwards && score.components == 1 &&
              score.euler == 1 - static_cast<int64_t>(score.openings.size())
          ? "true"
          : "false",
      milliseconds, planar.precision, planar.recall, differing(score, "mouth"),
      differing(ranged, "mouth"));
  std::fflush(stdout);
}

void measure_all(int faces) {
  for (const std::string& name : test::sample_names()) {
    const auto sample = test::make_sample(name);
    const auto chosen = select_markers(sample.measured).chosen;
    measure(name, sample, fill_gaps(sample.measured.select(chosen)).take);
  }
  using enum test::MotionKind;
  const test::MotionKind motions[] = {happy, surprise, talk,       jaw, blinks,
                                      brows, pucker,   pucker_jaw, puff};
  for (int i = 0; i < faces; ++i) {
    const auto seed = static_cast<uint64_t>(1000 + i);
    const auto face = test::make_face({seed});
    test::LayoutOptions layout{.spacing_mm = 8.5 + 0.5 * (i % 4), .seed = seed};
    if (i % 3 == 2) layout.sideways = 90;
    if (i % 4 == 3) layout.rings = false;
    const auto motion = test::make_motion(motions[i % 9]);
    const auto take = test::make_take(face, test::place_markers(*face, layout), motion,
                                      {.head_degrees = 10, .head_mm = 20, .seed = seed});
    measure("face " + std::to_string(seed) + " " + motion.name + (layout.rings ? "" : ", no rings"),
            take, take.measured);
  }
}

}  // namespace
}  // namespace kinemesh

int main(int argc, char** argv) { kinemesh::measure_all(argc > 1 ? std::atoi(argv[1]) : 14); }
