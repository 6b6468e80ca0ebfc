// Animated meshes with random but known contents, for round trips that compare values.
#pragma once

#include "mesh/animated_mesh.h"

namespace kinemesh::test {

/// A grid of columns × rows vertices, two triangles a cell, with random positions of very
/// different sizes, names with awkward characters, filled flags, uncertainty, events, provenance.
AnimatedMesh random_animation(uint32_t columns, uint32_t rows, std::size_t frames);

/// A smooth deformation of the same grid, 10 mm a cell: what a face's motion is like.
AnimatedMesh smooth_animation(uint32_t columns, uint32_t rows, std::size_t frames, double rate_hz);

/// GoogleTest failures where the two differ: every float; and faces, rate, first frame, events,
/// names, provenance.
void expect_same_positions(const AnimatedMesh& a, const AnimatedMesh& b);
void expect_same_description(const AnimatedMesh& a, const AnimatedMesh& b);

}  // namespace kinemesh::test
