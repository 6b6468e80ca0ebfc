#include "mesh/formats/text_mesh.h"

#include "config/text.h"

namespace kinemesh {

void append_comments(std::string& out, std::string_view mark,
                     const std::vector<std::string>& lines) {
  for (const std::string& line : lines) {
    out += mark;
    out += line;
    out += '\n';
  }
}

void append_position(std::string& out, const float* xyz) {
  append_number(out, xyz[0]);
  append_number(out += ' ', xyz[1]);
  append_number(out += ' ', xyz[2]);
}

void append_positions(std::string& out, const AnimatedMesh& mesh, std::size_t frame,
                      std::string_view mark) {
  out.reserve(out.size() + mesh.vertex_count() * 40 + mesh.topology().face_count() * 24);
  const float* p = mesh.frame(frame).data();
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v, p += 3) {
    out += mark;
    append_position(out, p);
    out += '\n';
  }
}

void append_faces(std::string& out, const Topology& topology, std::string_view mark,
                  uint32_t first_index) {
  for (const Triangle& t : topology.faces()) {
    out += mark;
    for (const VertexIndex v : t) append_number(out += ' ', v + first_index);
    out += '\n';
  }
}

}  // namespace kinemesh
