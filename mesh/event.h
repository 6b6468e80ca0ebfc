// A labelled instant of a recording: a foot strike, "smile begins", a sync pulse.
#pragma once

#include <string>

namespace kinemesh {

struct Event {
  std::string label;    ///< what happened
  std::string context;  ///< "Left", "Right", "General" or empty
  std::string subject;  ///< whose event it is; empty when the file does not say
  double time_s = 0.0;  ///< seconds since recorded frame 1 of the original take, as in C3D
  friend bool operator==(const Event&, const Event&) = default;
};

}  // namespace kinemesh
