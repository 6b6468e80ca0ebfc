// What is in a session, as an operator wants to know it before working with it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "capture/c3d/layout.h"
#include "capture/marker_sequence.h"

namespace kinemesh {

/// One point of the take and what is missing of it. A gap is a run of frames without a measured
/// position; leading and trailing ones count.
struct MarkerSummary {
  std::string label, subject, kind, unit;
  std::size_t valid_frames = 0;
  std::size_t gaps = 0;
  double missing_percent = 0.0;
  double longest_gap_s = 0.0;
  std::size_t longest_gap_frames = 0;
};

struct C3dSummary {
  std::string file;
  std::string format;  ///< "C3D", "TRC", …
  std::vector<std::string> subjects;
  std::size_t points = 0;  ///< columns of points, of every kind
  std::size_t frames = 0;
  int64_t first_frame = 1;
  double rate_hz = 0.0;
  double duration_s = 0.0;  ///< frames / rate
  std::string unit;         ///< length unit of the file; values are always given in mm
  std::string x_screen, y_screen;
  std::string manufacturer;
  std::string processor, storage;  ///< "intel", "dec", "sgi"; "int", "float"; empty unless C3D
  double scale = 0.0;              ///< mm per integer step; 0 for floats
  std::size_t rotations = 0;       ///< of group ROTATION
  std::size_t analog_channels = 0;
  double analog_rate_hz = 0.0;
  std::vector<std::string> analog_labels;
  std::vector<Event> events;
  std::vector<MarkerSummary> markers;
  std::size_t missing_samples = 0;  ///< over all markers of kind "marker"
  std::size_t marker_samples = 0;   ///< frames × markers of that kind
};

/// `layout` is null for a session that is no C3D file; `format` is its name then.
C3dSummary summarise(const MarkerSequence& take, const C3dLayout* layout,
                     const std::string& format = "C3D");

/// For a person: plain words, units, markers with gaps as a table.
std::string summary_text(const C3dSummary& summary);
/// The stable document that docs/c3d.md describes; keys are only ever added.
std::string summary_json(const C3dSummary& summary);

}  // namespace kinemesh
