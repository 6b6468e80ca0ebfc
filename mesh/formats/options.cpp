#include "mesh/formats/options.h"

namespace kinemesh {
namespace {

std::vector<Choice<LengthUnit>> unit_choices() {
  return {{LengthUnit::mm, "mm", "millimetres"}, {LengthUnit::um, "um", "micrometres"},
          {LengthUnit::cm, "cm", "centimetres"}, {LengthUnit::m, "m", "metres"},
          {LengthUnit::inch, "in", "inches"},    {LengthUnit::foot, "ft", "feet"}};
}

}  // namespace

void ReadOptions::declare(ParameterSet& p) {
  p.group("read", "Reading files");
  p.choice("unit", unit, unit_choices(), "length unit of input files that do not say theirs");
  p.number("rate", rate_hz,
           {.unit = "Hz",
            .min = 0,
            .max = 1e6,
            .help = "frames per second of input files that do not say; 0 leaves it unknown"});
}

void GltfOptions::declare(ParameterSet& p) {
  p.group("gltf", "glTF and GLB");
  p.number("budget", budget_mb,
           {.unit = "MB",
            .min = 0.01,
            .max = 4000,
            .help = "largest size of a glTF animation; its modes and key rate are chosen for the "
                    "least error within it"});
  p.number("max-error", max_error_mm,
           {.unit = "mm",
            .min = 0,
            .max = 1000,
            .help = "largest error of any vertex in a glTF animation, instead of a size: gives the "
                    "smallest file that keeps it; 0 goes by size"});
  p.choice("colour", colour,
           {{VertexColour::none, "none", "no vertex colours"},
            {VertexColour::deformation, "deformation",
             "by how far each vertex moves beyond the rigid motion of all"}},
           "vertex colours of glTF files");
  p.choice("gltf-up", up,
           {{GltfUp::automatic, "auto", "as the session says, or else Z"},
            {GltfUp::z, "z", "the data's Z axis points up"},
            {GltfUp::y, "y", "the data's Y axis points up"}},
           "axis that points up, turned to Y in glTF files");
}

void WriteOptions::declare(ParameterSet& p) {
  p.group("write", "Writing files");
  p.text("format", format,
         {.metavar = "FORMAT",
          .help = "format written, as listed by 'kinemesh formats'; empty goes by the extension"});
  p.choice("output-unit", unit, unit_choices(), "length unit written, where the format allows it");
  p.text("frames", frames,
         {.metavar = "FIRST:LAST[:STEP]",
          .help = "frames written, by the take's frame numbers; empty writes all"});
  p.number("first-number", first_number,
           {.min = -1,
            .max = 1e9,
            .help = "number of the first file of a numbered sequence; -1 keeps the take's frame "
                    "numbers"});
  p.choice("encoding", encoding,
           {{Encoding::binary, "binary", "binary, little-endian"},
            {Encoding::binary_big, "binary-big", "binary, big-endian"},
            {Encoding::ascii, "ascii", "text"}},
           "how PLY and VTP are written");
  gltf.declare(p);
}

}  // namespace kinemesh
