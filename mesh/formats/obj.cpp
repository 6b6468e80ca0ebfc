#include "mesh/formats/obj.h"

#include <algorithm>
#include <charconv>

#include "mesh/formats/bytes.h"
#include "mesh/formats/faces.h"
#include "mesh/formats/metadata.h"
#include "mesh/formats/registry.h"
#include "mesh/formats/text_mesh.h"
#include "mesh/formats/text_scanner.h"

namespace kinemesh {
namespace {

class ObjReader {
 public:
  ObjReader(std::span<const std::byte> bytes, const std::string& name)
      : scan_(text_of(bytes), name) {
    if (text_of(bytes).starts_with("\xEF\xBB\xBF")) scan_.skip(3);  // mark of UTF-8
    positions_.reserve(bytes.size() / 20);
    faces_.reserve(bytes.size() / 40);
  }

  MeshData read() {
    for (; !scan_.at_end(); scan_.next_line()) {
      if (scan_.at_line_end()) continue;
      switch (scan_.peek()) {
        case 'v': read_vertex(); break;
        case 'f': read_face(); break;
        case '#': metadata_.read(comment()); break;
        default: skip_statement();
      }
    }
    const std::size_t vertices = positions_.size() / 3;
    if (largest_ >= 0 && static_cast<std::size_t>(largest_) >= vertices) {
      scan_.move_to(largest_at_);
      scan_.fail("a face refers to vertex " + std::to_string(largest_ + 1) +
                 " (1-based), but there are only " + std::to_string(vertices));
    }
    MeshData data;
    data.allocate(1, vertices);
    std::copy(positions_.begin(), positions_.end(), data.positions.begin());
    faces_.finish(data);
    metadata_.apply(data);
    return data;
  }

 private:
  std::string_view comment() {
    scan_.skip(1);
    return scan_.rest_of_line();
  }

  void read_vertex() {
    if (scan_.word() != "v") return;  // vn, vt, vp
    float xyz[3];
    for (float& value : xyz) value = scan_.coordinate();
    positions_.insert(positions_.end(), xyz, xyz + 3);
  }

  void read_face() {
    if (scan_.word() != "f") return;
    corners_.clear();
    for (;;) {
      if (scan_.at_line_end()) break;
      if (scan_.peek() == '\\') {  // the face goes on in the next line
        scan_.next_line();
        continue;
      }
      if (scan_.peek() == '#') break;
      corners_.push_back(corner());
    }
    faces_.add(corners_);
  }

  /// One corner as "v", "v/vt", "v//vn" or "v/vt/vn"; the 0-based vertex.
  VertexIndex corner() {
    const std::size_t at = scan_.offset();
    int64_t index = scan_.integer("a vertex index");
    if (scan_.peek() == '/') scan_.word();
    if (const char next = scan_.peek();
        next != 0 && next != ' ' && next != '\n' && next != '\t' && next != '\r' && next != '\\') {
      scan_.fail("a face's corner is no vertex index");
    }
    const auto count = static_cast<int64_t>(positions_.size() / 3);
    if (index == 0) scan_.fail("a face refers to vertex 0, but OBJ counts from 1");
    if (index < 0 && -index > count) {
      scan_.fail("a face refers to vertex " + std::to_string(index) + ", but only " +
                 std::to_string(count) + " stand before it");
    }
    index = index < 0 ? count + index : index - 1;
    if (index >= int64_t{invalid_index}) scan_.fail("the vertex index is too large");
    if (index > largest_) {
      largest_ = index;
      largest_at_ = at;
    }
    return static_cast<VertexIndex>(index);
  }

  /// OBJ has many statements that say nothing about the mesh; what is no word is no OBJ.
  void skip_statement() {
    const char c = scan_.peek();
    if (!(c >= 'a' && c <= 'z') && !(c >= 'A' && c <= 'Z')) {
      scan_.fail("the line does not begin with a word of OBJ");
    }
    while (scan_.rest_of_line().ends_with('\\') && !scan_.at_end()) scan_.next_line();
  }

  TextScanner scan_;
  MetadataReader metadata_;
  std::vector<float> positions_;
  FaceCollector faces_;
  std::vector<VertexIndex> corners_;
  int64_t largest_ = -1;
  std::size_t largest_at_ = 0;
};

}  // namespace

MeshData decode_obj(std::span<const std::byte> bytes, const std::string& name) {
  return ObjReader(bytes, name).read();
}

std::string encode_obj(const AnimatedMesh& mesh, std::size_t frame, const WriteOptions& options) {
  std::string out;
  append_comments(
      out, "# ",
      metadata_lines(mesh, frame, options, {.description = frame == 0, .filled_runs = false}));
  append_positions(out, mesh, frame, "v ");
  append_faces(out, mesh.topology(), "f", 1);
  return out;
}

Format obj_format();
Format obj_format() {
  return make_single_frame_format("obj", ".obj", "Wavefront OBJ; numbered for animations",
                                  Keeps::description(), "every float, as decimal text", decode_obj,
                                  encode_obj);
}

}  // namespace kinemesh
