// Reading and writing meshes by path, in any registered format.
//
// A path that is read names a file; or the files of a numbered sequence, as `face_####.ply` (each
// # a digit or more) or as the folder that holds them. PLY or OBJ with a .pc2 or .mdd of the same
// stem beside it is the animation of both.
//
// A path that is written is taken by WriteOptions::format or its extension. Formats of one frame a
// file write numbered sequences: `face.obj` and `face_####.obj` both give face_0001.obj …, and a
// folder (`out/`, with the format given) gives out/frame_0001.ply …. A mesh of one frame is one
// file with the name given. `.ply` is PLY for one frame and PLY + PC2 for more.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mesh/animated_mesh.h"
#include "mesh/formats/options.h"
#include "mesh/formats/registry.h"
#include "mesh/mesh.h"

namespace kinemesh {

/// Throws InputError for a file that is missing, malformed or of an unknown format, naming file,
/// line or byte, and reason; and for a numbered sequence whose frames differ in topology.
AnimatedMesh read_animation(const FormatRegistry& formats, const std::filesystem::path& path,
                            const ReadOptions& options = {}, const RunContext& ctx = {});

/// What the files said, beside the mesh.
struct AnimationFile {
  AnimatedMesh mesh;
  std::string format;                        ///< name in the registry
  std::vector<std::filesystem::path> files;  ///< those read; the numbered ones of a sequence
  std::optional<LengthUnit> unit;            ///< empty when the file does not say
};

/// As read_animation, and where it came from.
AnimationFile read_animation_file(const FormatRegistry& formats, const std::filesystem::path& path,
                                  const ReadOptions& options = {}, const RunContext& ctx = {});

/// As read_animation; every frame may have its own connectivity. Equal ones are shared.
MeshSequence read_mesh_sequence(const FormatRegistry& formats, const std::filesystem::path& path,
                                const ReadOptions& options = {}, const RunContext& ctx = {});

/// One file as a static mesh: its first frame, files beside it ignored.
Mesh read_mesh(const FormatRegistry& formats, const std::filesystem::path& path,
               const ReadOptions& options = {}, const RunContext& ctx = {});

struct WriteResult {
  std::vector<std::filesystem::path> files;  ///< in the order of the frames
  std::string format;
  WriteReport report;
};

/// Writes all files or none. Throws UsageError for an unknown format, InputError when something
/// cannot be written.
WriteResult write_animation(const FormatRegistry& formats, const AnimatedMesh& mesh,
                            const std::filesystem::path& path, const WriteOptions& options = {},
                            const RunContext& ctx = {});

/// As write_animation, but into `files`, to appear together with others when the caller commits.
WriteResult add_animation(const FormatRegistry& formats, const AnimatedMesh& mesh,
                          const std::filesystem::path& path, const WriteOptions& options,
                          OutputSet& files, const RunContext& ctx = {});

/// As write_animation, for frames of differing topology: a numbered sequence.
WriteResult write_mesh_sequence(const FormatRegistry& formats, const MeshSequence& sequence,
                                const std::filesystem::path& path, const WriteOptions& options = {},
                                const RunContext& ctx = {});

WriteResult write_mesh(const FormatRegistry& formats, const Mesh& mesh,
                       const std::filesystem::path& path, const WriteOptions& options = {},
                       const RunContext& ctx = {});

/// Which format write_animation would take; throws as it does. For defaults and messages.
const Format& output_format(const FormatRegistry& formats, const std::filesystem::path& path,
                            const WriteOptions& options, std::size_t frame_count);

}  // namespace kinemesh
