#include "reconstruct/topology_reuse.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <limits>
#include <set>

#include "config/error.h"
#include "reconstruct/delaunay_flips.h"
#include "reconstruct/face_frame.h"
#include "reconstruct/marker_spacing.h"
#include "reconstruct/named_constraints.h"
#include "reconstruct/reference_frame.h"
#include "reconstruct/surface_repair.h"
#include "reconstruct/triangulate_result.h"

namespace kinemesh {
namespace {

/// The previous mesh with its vertices numbered like the take's markers; those without a marker
/// come after them.
class Reuse {
 public:
  Reuse(const Mesh& previous, const MarkerSequence& take, const Points& points)
      : take_(take), points_(points), mesh_(0) {
    std::vector<VertexIndex> marker_of;
    auto next = static_cast<VertexIndex>(take.marker_count());
    std::set<std::size_t> found;
    for (const std::string& name : previous.vertex_names) {
      const std::size_t m = marker_named(name, found);
      const bool known = m != MarkerSequence::npos && found.insert(m).second;
      marker_of.push_back(known ? static_cast<VertexIndex>(m) : next++);
      if (!known) missing_.push_back(name);
    }
    for (std::size_t m = 0; m < take.marker_count(); ++m) {
      if (!found.contains(m)) added_.push_back(m);
    }
    check_overlap(found.size(), previous.vertex_names.size());
    // Lost vertices keep a place while they are removed; no length of theirs is ever used.
    points_.resize(next, Eigen::Vector3d::Zero());
    std::vector<Triangle> faces;
    for (const auto& [a, b, c] : previous.topology->faces()) {
      faces.push_back({marker_of[a], marker_of[b], marker_of[c]});
    }
    mesh_ = EditMesh(next, faces);
  }

  /// The mesh over the take's markers.
  EditMesh run() {
    for (auto v = static_cast<VertexIndex>(take_.marker_count()); v < points_.size(); ++v) {
      remove_vertex(v);
    }
    points_.resize(take_.marker_count());
    EditMesh mesh(take_.marker_count(), mesh_.triangles());
    mend_pinches(mesh, points_);
    keep_largest_component(mesh, points_);
    std::vector<bool> loose(take_.marker_count(), false);
    for (VertexIndex v = 0; v < mesh.vertex_count(); ++v) {
      loose[v] = !mesh.has_vertex(v);
    }
    inserted_ = insert_missing_vertices(mesh, points_);
    flips_ = flip_to_delaunay(mesh, points_, kept_edges(mesh, loose));
    return mesh;
  }

  const std::vector<std::string>& missing() const { return missing_; }
  std::vector<std::string> added() const {
    std::vector<std::string> labels;
    for (const std::size_t m : added_) labels.push_back(take_.markers()[m].label);
    return labels;
  }
  std::size_t inserted() const { return inserted_; }
  std::size_t flips() const { return flips_; }

 private:
  /// Of several markers of one name the first that no vertex has taken yet: the order tells twins
  /// apart.
  std::size_t marker_named(const std::string& name, const std::set<std::size_t>& taken) const {
    const std::size_t first = take_.find(name);
    if (first == MarkerSequence::npos || !taken.contains(first)) return first;
    const Marker& like = take_.markers()[first];
    for (std::size_t m = first + 1; m < take_.marker_count(); ++m) {
      const Marker& marker = take_.markers()[m];
      if (marker.label == like.label && marker.subject == like.subject && !taken.contains(m))
        return m;
    }
    return MarkerSequence::npos;
  }

  void check_overlap(std::size_t found, std::size_t vertices) const {
    if (found >= 3 && 2 * found >= vertices) return;
    throw NoResultError(
        {.what = "only " + std::to_string(found) + " of the " + std::to_string(vertices) +
                 " vertices of the previous mesh are markers of this take",
         .file = take_.origin.path,
         .remedy = "Give the mesh of another take of the same subject, or leave --topology out"});
  }

  /// Takes the faces of a vertex off and joins its neighbours over the hole, if that is possible.
  void remove_vertex(VertexIndex v) {
    const std::vector<VertexIndex> link = link_of(v);
    for (const auto& c : std::vector<EditMesh::Corner>(mesh_.corners(v)))
      mesh_.remove_face(v, c.next);
    if (link.size() < 3) return;
    // Against the ring: the direction of the hole's boundary halfedges.
    const std::vector<VertexIndex> loop(link.rbegin(), link.rend());
    if (!fill_loop(mesh_, points_, loop, std::numeric_limits<double>::infinity())) return;
    changed_.insert(link.begin(), link.end());
  }

  /// Neighbours of v in the order of its faces, from one end of the fan to the other.
  std::vector<VertexIndex> link_of(VertexIndex v) const {
    const auto& corners = mesh_.corners(v);
    if (corners.empty()) return {};
    VertexIndex start = corners.front().next;
    for (const auto& c : corners) {
      if (!mesh_.has_halfedge(c.next, v)) start = c.next;
    }
    std::vector<VertexIndex> link{start};
    for (VertexIndex at = mesh_.opposite(v, start); at != invalid_index && at != start;
         at = mesh_.opposite(v, at)) {
      link.push_back(at);
    }
    return link;
  }

  /// Edges that must not be flipped: all but those at inserted vertices, opposite to them, and in
  /// filled holes.
  std::vector<DirectedEdge> kept_edges(const EditMesh& mesh, const std::vector<bool>& loose) const {
    std::vector<DirectedEdge> kept;
    for (const auto& [a, b] : mesh.edges()) {
      const VertexIndex left = mesh.opposite(a, b);
      const VertexIndex right = mesh.opposite(b, a);
      const bool near_new = loose[a] || loose[b] || (left != invalid_index && loose[left]) ||
                            (right != invalid_index && loose[right]);
      const bool in_hole = changed_.contains(a) && changed_.contains(b);
      if (!near_new && !in_hole) kept.push_back({std::min(a, b), std::max(a, b)});
    }
    return kept;
  }

  const MarkerSequence& take_;
  Points points_;
  EditMesh mesh_;
  std::vector<std::string> missing_;
  std::vector<std::size_t> added_;
  std::set<VertexIndex> changed_;
  std::size_t inserted_ = 0, flips_ = 0;
};

void check_previous(const Mesh& previous) {
  if (previous.topology && previous.topology->face_count() == 0) {
    throw InputError({.what = "what is given as the previous mesh has points, but no triangles",
                      .remedy =
                          "Give the mesh that 'kinemesh convert' wrote of the other take, for "
                          "example its .ply"});
  }
  if (!previous.topology || previous.vertex_names.size() != previous.topology->vertex_count()) {
    throw InputError({.what = "the previous mesh has no names of its vertices",
                      .remedy = "Give a mesh that kinemesh wrote from markers"});
  }
  if (!previous.topology->is_manifold() || previous.topology->face_count() == 0) {
    throw InputError({.what = "the previous mesh is no manifold surface"});
  }
}

/// The topology of these triangles: the previous one itself when they are the same, so that two
/// takes of a subject share every index, whatever order the triangles were kept in meanwhile.
std::shared_ptr<const Topology> topology_of(const Mesh& previous, std::size_t vertex_count,
                                            std::vector<Triangle> triangles) {
  const auto ordered = [](std::vector<Triangle> faces) {
    for (Triangle& face : faces) {
      std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
    }
    std::sort(faces.begin(), faces.end());
    return faces;
  };
  if (previous.topology->vertex_count() == vertex_count &&
      ordered(previous.topology->faces()) == ordered(triangles)) {
    return previous.topology;
  }
  return Topology::create(vertex_count, std::move(triangles));
}

/// The openings come with the previous mesh; what was asked for beside them is not passed over.
void warn_of_openings(const OpeningOptions& options, std::vector<std::string>& warnings) {
  const std::pair<const char*, OpeningMode> asked[] = {{"--mouth", options.mouth},
                                                       {"--left-eye", options.left_eye},
                                                       {"--right-eye", options.right_eye}};
  for (const auto& [name, mode] : asked) {
    if (mode == OpeningMode::automatic) continue;
    warnings.push_back(
        std::string(name) +
        " has no effect here: the openings are those of the mesh given as --topology");
  }
}

/// Names the loops but the rim by where they lie: one across the mirror plane is the mouth, the
/// largest on either side are the eyes.
std::vector<Opening> name_by_place(const EditMesh& mesh, const Points& points, double spacing) {
  auto loops = mesh.boundary_loops();
  std::sort(loops.begin(), loops.end(), [&](const auto& a, const auto& b) {
    return perimeter(a, points) > perimeter(b, points);
  });
  if (loops.size() < 2) return {};
  loops.erase(loops.begin());
  const FaceFrame frame = find_face_frame(mesh, points, spacing);
  if (!frame.symmetric()) return {};
  std::vector<Opening> named;
  std::optional<Eigen::Vector3d> mouth;
  std::vector<std::pair<std::vector<VertexIndex>, Eigen::Vector3d>> sides;
  for (const auto& loop : loops) {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (const VertexIndex v : loop) centre += points[v] / static_cast<double>(loop.size());
    if (std::abs(frame.plane.side(centre)) > spacing) {
      sides.emplace_back(loop, centre);
    } else if (!mouth) {
      mouth = centre;
      named.push_back({OpeningName::mouth, loop, 0.0, false});
    }
  }
  if (sides.empty()) return named;
  const Eigen::Vector3d left = frame.up(points, mouth, sides.front().second).cross(frame.front);
  bool taken[2] = {false, false};
  for (const auto& [loop, centre] : sides) {
    const bool is_left = left.dot(frame.plane.normal) * frame.plane.side(centre) > 0;
    if (taken[is_left]) continue;
    taken[is_left] = true;
    named.push_back({is_left ? OpeningName::left_eye : OpeningName::right_eye, loop, 0.0, false});
  }
  return named;
}

}  // namespace

ReuseResult reuse_topology(const Mesh& previous, const MarkerSequence& take,
                           const TriangulateOptions& options, const RunContext& ctx) {
  options.validate();
  check_previous(previous);
  const ReferenceFrame reference = choose_reference_frame(take, options.frame);
  ctx.check_cancelled();
  const auto start = std::chrono::steady_clock::now();
  Reuse reuse(previous, take, reference.points);
  EditMesh mesh = reuse.run();
  refuse_unmet(apply_constraints(mesh, reference.points,
                                 named_constraints(take, options.edges, options.no_edges)),
               take);

  ReuseResult result;
  TriangulateResult& t = result.triangulation;
  TriangulateDiagnostics& d = t.diagnostics;
  d.outwardness = orient_outwards(mesh, reference.points);
  t.topology = topology_of(previous, take.marker_count(), mesh.triangles());
  d.method = "previous topology";
  d.inserted = reuse.inserted();
  d.flips = reuse.flips();
  const double spacing = measure_spacing(reference.points).mean;
  const auto named = name_by_place(mesh, reference.points, spacing);
  d.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  describe_result(t, take, reference, spacing, named);
  warn_of_openings(options.openings, d.warnings);
  result.missing = reuse.missing();
  result.added = reuse.added();
  for (const auto& name : result.missing) {
    d.warnings.push_back("the vertex " + name +
                         " of the previous mesh is no marker of this take and was removed");
  }
  for (const auto& name : result.added) {
    d.warnings.push_back("the marker " + name + " is not in the previous mesh and was inserted");
  }
  return result;
}

}  // namespace kinemesh
