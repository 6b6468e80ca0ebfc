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

/// Options of glTF and GLB alone.
struct GltfOptions {
  /// Size of the animation file, MB = 10⁶ bytes; 0 takes 6 MB per 5,000 vertices × 60 s × 120 Hz,
  /// and never less than 1 MB.
  double budget_mb = 0.0;
  /// Largest error of any vertex in any frame; when above 0, the smallest file that keeps it.
  double max_error_mm = 0.0;
  VertexColour colour = VertexColour::none;

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
