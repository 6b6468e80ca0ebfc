// Generated surfaces for tests, grouped by what they are good for.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "mesh/mesh.h"
#include "mesh/topology.h"

namespace kinemesh::test {

/// A surface with positions in double: floats would curve what is meant to be flat.
struct Surface {
  std::string name;
  std::shared_ptr<const Topology> topology;
  std::vector<Eigen::Vector3d> positions;
  Mesh mesh() const;
};

/// n × n quads of unit size in the plane z = 0, inner vertices moved by up to `jitter`; vertex
/// (column, row) is row * (n + 1) + column.
Surface plane_grid(int n, double jitter, uint64_t seed);
/// The plane grid without the quads whose column and row both lie in [from, to).
Surface plane_with_hole(int n, int from, int to);
/// A flat rectangle with vertices at every x and y (row by row), each cell cut along either
/// diagonal.
Surface rectangle(const std::vector<double>& x, const std::vector<double>& y, uint64_t seed);
/// The cube [0, size]³, each side n × n quads, closed.
Surface cube(int n, double size);
/// A sphere from an icosahedron subdivided `levels` times.
Surface sphere(int levels, double radius);
/// A torus with the radii R and r, m × n quads, jittered: genus 1.
Surface torus(int m, int n, double big, double small, double jitter, uint64_t seed);
/// Cubes of a voxel picture, the surface between full and empty: any genus. `full(x, y, z)`.
Surface voxels(int nx, int ny, int nz, bool (*full)(int, int, int));
/// A slab with two holes: genus 2.
Surface double_ring();
/// A surface with the same shape, whose triangles are split into slivers with heights of about
/// `height` times their edges.
Surface with_slivers(const Surface& surface, double height, uint64_t seed);
/// A bumpy closed or open surface: many saddles.
Surface bumpy(const Surface& surface, double amplitude, double wavelength);

}  // namespace kinemesh::test
