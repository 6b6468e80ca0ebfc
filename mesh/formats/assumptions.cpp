#include "mesh/formats/assumptions.h"

#include "config/text.h"

namespace kinemesh {

std::vector<std::string> assumptions_of(const AnimationFile& file, const std::string& name,
                                        const ReadOptions& options) {
  std::vector<std::string> texts;
  if (!file.unit && options.unit == LengthUnit::mm) {
    texts.push_back(name + " does not say its unit: taken as mm (--unit says otherwise)");
  } else if (file.unit && options.unit != LengthUnit::mm && options.unit != *file.unit) {
    texts.push_back(name + " says that its unit is " + std::string(name_of(*file.unit)) +
                    ": --unit " + std::string(name_of(options.unit)) + " is not used");
  }
  if (file.mesh.rate_hz <= 0 && file.mesh.frame_count() > 1) {
    texts.push_back(name + " does not say its frame rate: left unknown (--rate gives one)");
  } else if (options.rate_hz > 0 && file.mesh.rate_hz != options.rate_hz) {
    texts.push_back(name + " says that its rate is " + format_number(file.mesh.rate_hz) +
                    " Hz: --rate " + format_number(options.rate_hz) + " is not used");
  }
  return texts;
}

}  // namespace kinemesh
