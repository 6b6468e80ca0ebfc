#include "reconstruct/openings.h"

namespace kinemesh {

std::string_view name_of(OpeningName name) {
  switch (name) {
    case OpeningName::mouth: return "mouth";
    case OpeningName::left_eye: return "left eye";
    case OpeningName::right_eye: return "right eye";
    case OpeningName::gap: return "gap";
  }
  return "gap";
}

void OpeningOptions::declare(ParameterSet& p) {
  p.group("openings", "Openings of the face");
  const std::vector<Choice<OpeningMode>> modes{
      {OpeningMode::automatic, "auto", "where the motion shows it"},
      {OpeningMode::open, "open", "wherever it is most likely"},
      {OpeningMode::closed, "closed", "never"}};
  p.choice("mouth", mouth, modes, "whether the mesh is open between the lips");
  p.choice("left-eye", left_eye, modes,
           "whether the mesh is open between the lids of the left eye");
  p.choice("right-eye", right_eye, modes,
           "whether the mesh is open between the lids of the right eye");
}

}  // namespace kinemesh
