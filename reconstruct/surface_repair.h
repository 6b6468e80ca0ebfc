// From the triangles of a reconstruction to one manifold surface through all markers.
#pragma once

#include <cstddef>
#include <vector>

#include "reconstruct/edit_mesh.h"
#include "reconstruct/marker_spacing.h"

namespace kinemesh {

/// Removes all faces but those of the component with most vertices (ties: the larger area).
void keep_largest_component(EditMesh& mesh, const Points& points);

/// Makes every vertex's faces one fan by removing all fans but the one with most faces.
void mend_pinches(EditMesh& mesh, const Points& points);

/// Fills every boundary loop but the rim by the triangulation of least summed squared edge length,
/// where that needs no inner edge longer than `longest`, mm. The rim is the loop of largest
/// perimeter; it is filled only where the fill is no more than 100° from the surface around it,
/// as in a closed body that lacks a few triangles. Returns the number of loops filled.
std::size_t fill_holes(EditMesh& mesh, const Points& points, double longest);

/// Fills one boundary loop (vertices in the direction of their halfedges). False, and no change,
/// when it cannot be filled under the bound.
bool fill_loop(EditMesh& mesh, const Points& points, const std::vector<VertexIndex>& loop,
               double longest);

/// Joins each vertex without faces to the mesh: into the face or edge nearest to it, or to the
/// rim where that is nearest; nearest vertices first. Returns their number.
std::size_t insert_missing_vertices(EditMesh& mesh, const Points& points);

/// Removes rim faces whose rim edge is longer than `bound` × its spacing (the smaller of h and the
/// mean over its ends), longest first, as long as the mesh stays manifold and loses no vertex.
/// Only loops through a vertex of `rim` are trimmed. Returns the number of faces removed.
std::size_t trim_rim(EditMesh& mesh, const Points& points, const MarkerSpacing& spacing,
                     double bound, const std::vector<DirectedEdge>& keep);

/// Turns the surface so that its faces are counter-clockwise seen from outside: the volume under
/// it, closed by fans from the centres of its boundary loops, is positive. Returns that volume
/// over area^1.5 (sphere .094, hemisphere .07, plane 0): near 0 the side is a guess.
double orient_outwards(EditMesh& mesh, const Points& points);

}  // namespace kinemesh
