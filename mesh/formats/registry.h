// The table of file formats: a new format is one .cpp and one line in builtin_mesh_formats().
// The registry is a value; modules above mesh add theirs:
//
//   FormatRegistry formats = builtin_mesh_formats();
//   add_capture_formats(formats);
//   AnimatedMesh mesh = read_animation(formats, path);   // mesh/formats/mesh_io.h
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/output_file.h"
#include "config/run_context.h"
#include "mesh/animated_mesh.h"
#include "mesh/formats/mesh_data.h"
#include "mesh/formats/options.h"

namespace kinemesh {

/// What a format keeps of an animated mesh.
struct Keeps {
  bool faces = true;
  bool names = false;
  bool unit = false;
  bool rate = false;
  bool first_frame = false;
  bool events = false;
  bool filled = false;
  bool uncertainty = false;
  bool provenance = false;

  /// Faces and the description that text lines carry (mesh/formats/metadata.h).
  static Keeps description() {
    return {.names = true,
            .unit = true,
            .rate = true,
            .first_frame = true,
            .events = true,
            .provenance = true};
  }
  static Keeps description_and_filled() {
    Keeps keeps = description();
    keeps.filled = true;
    return keeps;
  }
  static Keeps everything() {
    Keeps keeps = description_and_filled();
    keeps.uncertainty = true;
    return keeps;
  }
  /// What there is to keep of this mesh.
  static Keeps content_of(const AnimatedMesh& mesh);
  /// What of `content` is not kept, in words: "vertex names", "rate".
  std::vector<std::string> lost_of(const Keeps& content) const;
};

/// Numbers worth saying about a written file (the error reached by a lossy format).
struct WriteReport {
  std::vector<std::string> notes;  ///< sentences for the user
  std::vector<std::string> lost;   ///< what the mesh has and the format has no place for
  double max_error_mm = 0.0;       ///< 0 for formats that keep every float
  double rms_error_mm = 0.0;
};

struct Format {
  std::string name;                     ///< "ply", "ply+pc2": the word of --format
  std::vector<std::string> extensions;  ///< lower case with the dot; the first is preferred
  std::string description;
  Keeps keeps;
  std::string exactness;      ///< "every float", "decimal text, every float", "PCA within a budget"
  bool single_frame = false;  ///< one file holds one frame; animations are numbered sequences

  /// Decodes a file that stands alone. `name` is for error messages. Never trusts a count:
  /// memory stays in proportion to the number of bytes.
  using Decode = std::function<MeshData(std::span<const std::byte> bytes, const std::string& name)>;
  /// Reads a file together with those beside it (PC2 and its PLY), or one that is not held in
  /// memory at once.
  using Read = std::function<MeshData(const std::filesystem::path& path, const ReadOptions& options,
                                      const RunContext& ctx)>;
  /// One frame as a file's content. Positions are in options.unit already.
  using Encode = std::function<std::string(const AnimatedMesh& mesh, std::size_t frame,
                                           const WriteOptions& options)>;
  /// All files of an animation, into `files`. Positions are in options.unit already, in mm for
  /// formats with `fixed_unit`.
  using Write = std::function<WriteReport(
      const AnimatedMesh& mesh, const std::filesystem::path& path, const WriteOptions& options,
      OutputSet& files, const RunContext& ctx)>;
  Decode decode;            ///< empty when the format does not stand alone
  Read read;                ///< empty: the file is loaded and decoded
  Encode encode;            ///< of single-frame formats
  Write write;              ///< of animation formats
  bool fixed_unit = false;  ///< the format prescribes its unit and converts by itself
  /// Of formats that hold positions alone (PC2, MDD): extensions of the file of the same stem that
  /// holds the faces, the one that is written first.
  std::vector<std::string> geometry_extensions;

  bool can_read() const { return decode || read; }
  bool can_write() const { return encode || write; }
  /// "vertex names, rate": what is lost, in words; empty when nothing is.
  std::string loses() const;
};

/// A format with its description; the caller adds what reads and writes it.
Format make_format(std::string name, std::string extension, std::string description, Keeps keeps,
                   std::string exactness);

/// One that holds a frame a file.
Format make_single_frame_format(std::string name, std::string extension, std::string description,
                                Keeps keeps, std::string exactness, Format::Decode decode,
                                Format::Encode encode);

class FormatRegistry {
 public:
  /// Throws InternalError when the name is taken, or an extension by a reader.
  void add(Format format);
  const std::vector<Format>& formats() const { return formats_; }
  /// Null when there is none of that name.
  const Format* find(std::string_view name) const;
  /// The format that reads (writes) files named like this, by extension, any case; null if none.
  const Format* reader_for(const std::filesystem::path& path) const;
  const Format* writer_for(const std::filesystem::path& path) const;
  /// All extensions that can be read (written), for messages and file dialogues.
  std::vector<std::string> read_extensions() const;
  std::vector<std::string> write_extensions() const;

 private:
  std::vector<Format> formats_;
};

/// Every format of the mesh module.
FormatRegistry builtin_mesh_formats();

}  // namespace kinemesh
