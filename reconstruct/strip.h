// Strips: chains of neighbouring triangles across whose inner edges a surface parts.
#pragma once

#include <functional>
#include <vector>

#include "reconstruct/edit_mesh.h"

namespace kinemesh {

struct Strip {
  /// Inner edges in order; each two neighbouring ones share a triangle.
  std::vector<DirectedEdge> edges;
  std::vector<double> strengths;  ///< of the edges
  double peak = 0.0;              ///< largest strength
  double sum = 0.0;               ///< of the strengths
};

/// Score of the inner edge between two vertices.
using EdgeScore = std::function<double(VertexIndex, VertexIndex)>;

struct StripRule {
  EdgeScore strength;  ///< orders the seeds and weighs the strip
  double seed = 0.0;   ///< least strength of the first edge
  EdgeScore contrast;  ///< by which a strip grows
  double floor = 0.0;  ///< every other edge has more contrast than this…
  double share = 0.0;  ///< …and than this share of the first one's
  /// The edge may have parted while its markers were hidden.
  std::function<bool(VertexIndex, VertexIndex)> doubtful;
};

/// From the strongest edges on: each grows both ways, in each triangle over the one of
/// its two other edges with more contrast. A strip never touches the boundary and never comes back
/// to a vertex, so that its removal leaves one loop; strips share no triangle. Strongest first.
std::vector<Strip> find_strips(const EditMesh& mesh, const StripRule& rule);

/// Drops the edges at either end that meet in a vertex closer than `near` (mm) to the line of the
/// slit, which the middles of the other edges show, and that are weaker than the rest: that vertex
/// is the corner of the opening, and its edges only turn with the lips. The innermost of them
/// stays.
void drop_corner_fans(Strip& strip, const Points& points, double near);

/// Removes the triangles on both sides of every edge of the strip, which leaves one loop.
void cut_strip(EditMesh& mesh, const Strip& strip);

/// Gives triangles back that the cut took from one side of the opening alone: where three
/// neighbours of its loop lie on the same side (or at a corner) and the angle between them in the
/// opening is below `largest` degrees, the outer two are joined; the smallest angle first.
/// Returns the loop that remains, in the direction of its boundary halfedges.
std::vector<VertexIndex> fill_notches(EditMesh& mesh, const Points& points, const Strip& strip,
                                      double largest);

}  // namespace kinemesh
