// The lines that text formats of meshes have in common.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "mesh/animated_mesh.h"

namespace kinemesh {

/// Each of `lines` behind `mark` ("# "), on a line of its own.
void append_comments(std::string& out, std::string_view mark,
                     const std::vector<std::string>& lines);
/// "x y z", each number the shortest that reads back as the same float.
void append_position(std::string& out, const float* xyz);
/// One vertex a line, behind `mark` ("v "). Makes room for the faces too.
void append_positions(std::string& out, const AnimatedMesh& mesh, std::size_t frame,
                      std::string_view mark = {});
/// One face a line: `mark` ("3"), then its corners, counted from `first_index`.
void append_faces(std::string& out, const Topology& topology, std::string_view mark,
                  uint32_t first_index = 0);

}  // namespace kinemesh
