// What the user can say about files that are read and written.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "config/parameter.h"
#include "mesh/formats/units.h"

namespace kinemesh {

struct ReadOptions {
  /// Length unit of files that do not say theirs; a file that says its unit is believed.
  LengthUnit unit = LengthUnit::mm;
  /// Frames per second of files that do not say; 0 leaves the rate unknown.
  double rate_hz = 0.0;

  void declare(ParameterSet& p);
  void validate() const { validate_options(*this); }
};

enum class Encoding { binary, binary_big, ascii };
enum class VertexColour { none, deformation };

/// Which axis of the data points up. glTF prescribes Y; nothing else asks. A mesh does not know:
/// automatic is z, unless who writes it has a session that says otherwise.
enum class GltfUp { automatic, y, z };

/// Options of glTF and GLB alone.
struct GltfOptions {
  /// Largest size of all files together, MB = 10⁶ bytes. Modes and key rate are chosen for the
  /// least RMS error within it, and the file stays smaller when 0.001 mm is reached before.
  double budget_mb = 6.0;
  /// When above 0: the smallest file whose every vertex in every frame is closer than this.
  double max_error_mm = 0.0;
  VertexColour colour = VertexColour::none;
  GltfUp up = GltfUp::automatic;

  void declare(ParameterSet& p);
  void validate() const { validate_options(*this); }
};

struct WriteOptions {
  /// Name of a format ("ply+pc2", "obj-sequence"); empty: by the extension of the output.
  std::string format;
  /// Length unit written; formats with a fixed unit (glTF: metres) do not ask.
  LengthUnit unit = LengthUnit::mm;
  /// Frames to write, by frame number of the take: "", "12", "100:200", "100:200:2".
  std::string frames;
  /// Number of the first file of a numbered sequence; −1: the frame numbers of the take.
  int first_number = -1;
  /// How PLY, STL and VTP are written.
  Encoding encoding = Encoding::binary;
  GltfOptions gltf;

  void declare(ParameterSet& p);
  void validate() const { validate_options(*this); }
};

}  // namespace kinemesh
