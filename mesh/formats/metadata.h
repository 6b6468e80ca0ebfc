// What a mesh knows beside its shape, as lines of text that formats keep in their comments:
//
//   kinemesh unit "mm"
//   kinemesh rate_hz 120
//   kinemesh first_frame 1
//   kinemesh vertex_name 0 "LFHD"
//   kinemesh event 1.25 "Foot Strike" "Left" "Anna"
//   kinemesh filled 17 12-30 44-44        (vertex, then runs of 0-based frames of this file)
//   kinemesh uncertainty 17 12 0.21 0.3   (vertex, first frame, standard deviations in mm)
//   kinemesh program "kinemesh 0.1.0"     (and command, options, source)
//   kinemesh options+ "max-gap = 0.1\n"   (a long text goes on: lines stay below 1,000 bytes)
//   kinemesh input "session.c3d" "9f86d0…"
//
// Strings are quoted; \" \\ \n \r \t stand for themselves.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "mesh/animated_mesh.h"
#include "mesh/formats/mesh_data.h"
#include "mesh/formats/options.h"

namespace kinemesh {

/// Which lines to write.
struct MetadataChoice {
  bool description = true;  ///< names, events, provenance: in the first file of a sequence
  bool filled_runs = false;
  bool uncertainty = false;  ///< of all frames
  double to_mm = 1.0;        ///< what the mesh's uncertainty is multiplied with
};

/// The lines without a line end, for frame `frame` and those that follow it.
std::vector<std::string> metadata_lines(const AnimatedMesh& mesh, std::size_t frame,
                                        const WriteOptions& options,
                                        const MetadataChoice& choice = {});

/// Collects lines while a file is read; what is wrong or unknown is ignored, since comments are
/// anybody's.
class MetadataReader {
 public:
  /// `line` as written above, without the format's comment sign.
  void read(std::string_view line);
  /// Puts what was collected into `data`, whose vertex count is known by now.
  void apply(MeshData& data) const;

 private:
  /// The text that `key` ("options", "options+") names, or null.
  std::string* provenance_text(std::string_view key);
  void read_uncertainty(const std::vector<std::string>& words);

  MeshData found_;
  std::vector<std::pair<std::size_t, std::string>> names_;
};

}  // namespace kinemesh
