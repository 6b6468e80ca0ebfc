#include "config/text.h"
#include "mesh/formats/bytes.h"
#include "mesh/formats/ply.h"
#include "mesh/formats/registry.h"
#include "mesh/formats/text_mesh.h"

namespace kinemesh {
namespace {

std::string header_of(const AnimatedMesh& mesh, std::size_t frame, const WriteOptions& options,
                      const MetadataChoice& comments) {
  std::string out = "ply\nformat ";
  out += options.encoding == Encoding::ascii        ? "ascii"
         : options.encoding == Encoding::binary_big ? "binary_big_endian"
                                                    : "binary_little_endian";
  out += " 1.0\n";
  append_comments(out, "comment ", metadata_lines(mesh, frame, options, comments));
  out += "element vertex " + std::to_string(mesh.vertex_count()) +
         "\nproperty float x\nproperty float y\nproperty float z\n";
  if (!mesh.filled().empty()) out += "property uchar filled\n";
  if (!mesh.uncertainty().empty()) out += "property float uncertainty\n";
  out += "element face " + std::to_string(mesh.topology().face_count()) +
         "\nproperty list uchar int vertex_indices\nend_header\n";
  return out;
}

void append_text(const AnimatedMesh& mesh, std::size_t frame, std::string& out) {
  const std::size_t vertices = mesh.vertex_count();
  const float* p = mesh.frame(frame).data();
  for (std::size_t v = 0; v < vertices; ++v, p += 3) {
    append_position(out, p);
    const std::size_t sample = frame * vertices + v;
    if (!mesh.filled().empty()) out += mesh.filled()[sample] != 0 ? " 1" : " 0";
    if (!mesh.uncertainty().empty()) append_number(out += ' ', mesh.uncertainty()[sample]);
    out += '\n';
  }
  append_faces(out, mesh.topology(), "3");
}

void append_binary(const AnimatedMesh& mesh, std::size_t frame, bool big, std::string& out) {
  const std::size_t vertices = mesh.vertex_count();
  const float* p = mesh.frame(frame).data();
  const bool plain = mesh.filled().empty() && mesh.uncertainty().empty();
  if (plain && !big) {
    out.append(reinterpret_cast<const char*>(p), vertices * 3 * sizeof(float));
  } else {
    for (std::size_t v = 0; v < vertices; ++v, p += 3) {
      for (int axis = 0; axis < 3; ++axis) append_value(out, p[axis], big);
      const std::size_t sample = frame * vertices + v;
      if (!mesh.filled().empty()) out += mesh.filled()[sample] != 0 ? '\1' : '\0';
      if (!mesh.uncertainty().empty()) append_value(out, mesh.uncertainty()[sample], big);
    }
  }
  for (const Triangle& t : mesh.topology().faces()) {
    out += '\3';
    for (const VertexIndex v : t) append_value(out, v, big);
  }
}

}  // namespace

std::string encode_ply(const AnimatedMesh& mesh, std::size_t frame, const WriteOptions& options,
                       const MetadataChoice& comments) {
  std::string out = header_of(mesh, frame, options, comments);
  const bool text = options.encoding == Encoding::ascii;
  out.reserve(out.size() + mesh.vertex_count() * (text ? 40 : 17) +
              mesh.topology().face_count() * (text ? 24 : 13));
  if (text) {
    append_text(mesh, frame, out);
  } else {
    append_binary(mesh, frame, options.encoding == Encoding::binary_big, out);
  }
  return out;
}

std::string encode_ply(const AnimatedMesh& mesh, std::size_t frame, const WriteOptions& options) {
  return encode_ply(mesh, frame, options, {.description = frame == 0});
}

Format ply_format();
Format ply_format() {
  return make_single_frame_format(
      "ply", ".ply", "PLY, ascii or binary; numbered for animations", Keeps::everything(),
      "every float", decode_ply,
      [](const AnimatedMesh& mesh, std::size_t frame, const WriteOptions& options) {
        return encode_ply(mesh, frame, options);
      });
}

}  // namespace kinemesh
