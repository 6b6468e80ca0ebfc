// What a C3D file to be written will hold: decided completely before the first byte is written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "capture/c3d/analog_table.h"
#include "capture/c3d/layout.h"
#include "capture/c3d/writer.h"
#include "capture/marker_sequence.h"

namespace kinemesh {

struct C3dWritePlan {
  Processor processor = Processor::intel;
  Storage storage = Storage::real;
  double scale = -1.0;         ///< POINT:SCALE, in the file's unit
  std::size_t points = 0;      ///< the take's markers, then columns for points without identity
  std::size_t unlabelled = 0;  ///< number of those columns
  std::vector<float> to_mm;    ///< per point
  AnalogTable analog;
  C3dParameters parameters;  ///< brought up to date, POINT:DATA_START included
  std::string section;       ///< the encoded parameters
  C3dHeader header;
  std::vector<C3dLoss> losses;
};

/// Throws UsageError when no C3D file can hold the take.
C3dWritePlan plan_c3d(const MarkerSequence& take, const C3dWriteOptions& options);

// ---- parts of it, one file each -----------------------------------------------------------------

/// Decides processor, storage, unit and scale.
void plan_numbers(const MarkerSequence& take, const C3dWriteOptions& options, C3dWritePlan& plan);
/// Brings POINT's labels, descriptions, kinds and units up to date and fills `to_mm`.
void plan_points(const MarkerSequence& take, const C3dWriteOptions& options, C3dWritePlan& plan);
/// Brings the ANALOG group up to date and decides how samples are stored.
void plan_analog(const MarkerSequence& take, C3dWritePlan& plan);

/// Sets a parameter as C3dParameters::set() does, but keeps description and lock of the old one,
/// and the old one altogether where it has the same values.
void update(C3dParameters& tree, const char* group, C3dParameter parameter);
/// Sets NAME, NAME2… to at most 255 entries each and removes what is left of longer lists.
void update_texts(C3dParameters& tree, const char* group, const std::string& name,
                  const std::vector<std::string>& texts);
void update_numbers(C3dParameters& tree, const char* group, const std::string& name, C3dType type,
                    const std::vector<double>& numbers);

}  // namespace kinemesh
