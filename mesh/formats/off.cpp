#include "mesh/formats/off.h"

#include "config/text.h"
#include "mesh/formats/bytes.h"
#include "mesh/formats/faces.h"
#include "mesh/formats/metadata.h"
#include "mesh/formats/registry.h"
#include "mesh/formats/text_mesh.h"
#include "mesh/formats/text_scanner.h"

namespace kinemesh {
namespace {

class OffReader {
 public:
  OffReader(std::span<const std::byte> bytes, const std::string& name)
      : scan_(text_of(bytes), name), bytes_(bytes.size()) {}

  MeshData read() {
    read_header();
    data_.allocate(1, vertices_);
    for (std::size_t v = 0; v < vertices_; ++v) {
      begin_row("vertex", v, vertices_);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        data_.positions[3 * v + axis] = scan_.coordinate();
      }
      scan_.next_line();
    }
    FaceCollector faces;
    faces.reserve(std::min(face_count_, bytes_ / 6));
    for (std::size_t f = 0; f < face_count_; ++f) {
      begin_row("face", f, face_count_);
      read_face(faces);
    }
    faces.finish(data_);
    metadata_.apply(data_);
    return std::move(data_);
  }

 private:
  /// Skips blank lines and comments, which may carry our metadata.
  void skip() {
    for (scan_.skip_space(); scan_.peek() == '#'; scan_.skip_space()) {
      scan_.skip(1);
      metadata_.read(scan_.rest_of_line());
    }
  }

  void begin_row(const char* what, std::size_t row, std::size_t count) {
    skip();
    if (!scan_.at_end()) return;
    scan_.fail("the file ends at " + std::string(what) + " " + std::to_string(row) + " of " +
                   std::to_string(count),
               "The file is damaged or incomplete");
  }

  void read_header() {
    skip();
    if (const char c = scan_.peek(); c < '0' || c > '9' || next_word_ends_with_off())
      read_keyword();
    skip();
    const int64_t vertices = scan_.integer("the number of vertices");
    const int64_t faces = scan_.integer("the number of faces");
    scan_.next_line();  // the number of edges, which nobody keeps
    const auto left = static_cast<int64_t>(bytes_ - scan_.offset());
    if (vertices < 0 || faces < 0) scan_.fail("a number of elements is negative");
    if (vertices > left / 5 || faces > left / 2 + 1) {
      scan_.fail("the header promises " + std::to_string(vertices) + " vertices and " +
                     std::to_string(faces) + " faces, but the file is too short for them",
                 "The file is damaged or incomplete");
    }
    vertices_ = static_cast<std::size_t>(vertices);
    face_count_ = static_cast<std::size_t>(faces);
  }

  bool next_word_ends_with_off() {
    const std::size_t before = scan_.offset();
    const bool ends = scan_.word().ends_with("OFF");
    scan_.move_to(before);
    return ends;
  }

  void read_keyword() {
    const std::string_view word = scan_.word();
    if (!word.ends_with("OFF")) scan_.fail("this is no OFF file: it does not begin with 'OFF'");
    if (word.find_first_of("4n") != std::string_view::npos) {
      scan_.fail("points of other than three dimensions ('" + std::string(word.substr(0, 20)) +
                 "') are not read");
    }
    const std::size_t before = scan_.offset();
    if (scan_.word() == "BINARY") scan_.fail("binary OFF is not read", "Save it as text");
    scan_.move_to(before);
  }

  void read_face(FaceCollector& faces) {
    const int64_t corners = scan_.integer("the number of a face's corners");
    if (corners < 0) scan_.fail("the number of a face's corners is negative");
    corners_.clear();
    for (int64_t i = 0; i < corners; ++i) {
      const int64_t v = scan_.integer("a vertex index");
      if (v < 0 || v >= static_cast<int64_t>(vertices_)) {
        scan_.fail("a face refers to vertex " + std::to_string(v) +
                   " (0-based), but there are only " + std::to_string(vertices_));
      }
      corners_.push_back(static_cast<VertexIndex>(v));
    }
    faces.add(corners_);
    scan_.next_line();  // a colour may follow
  }

  TextScanner scan_;
  std::size_t bytes_;
  std::size_t vertices_ = 0, face_count_ = 0;
  MeshData data_;
  MetadataReader metadata_;
  std::vector<VertexIndex> corners_;
};

}  // namespace

MeshData decode_off(std::span<const std::byte> bytes, const std::string& name) {
  return OffReader(bytes, name).read();
}

std::string encode_off(const AnimatedMesh& mesh, std::size_t frame, const WriteOptions& options) {
  std::string out = "OFF\n";
  append_comments(
      out, "# ",
      metadata_lines(mesh, frame, options, {.description = frame == 0, .filled_runs = false}));
  out += std::to_string(mesh.vertex_count()) + " " + std::to_string(mesh.topology().face_count()) +
         " 0\n";
  append_positions(out, mesh, frame);
  append_faces(out, mesh.topology(), "3");
  return out;
}

Format off_format();
Format off_format() {
  return make_single_frame_format("off", ".off", "OFF of Geomview; numbered for animations",
                                  Keeps::description(), "every float, as decimal text", decode_off,
                                  encode_off);
}

}  // namespace kinemesh
