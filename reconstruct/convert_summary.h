// What a conversion says about itself: a text for the operator, JSON for programs, charts.
#pragma once

#include <string>
#include <vector>

#include "reconstruct/convert.h"
#include "report/gap_chart.h"

namespace kinemesh {

/// What became of the mesh when it was written.
struct WrittenMesh {
  std::vector<std::string> outputs;     ///< all files; of a numbered mesh the first and the last
  std::vector<std::string> mesh_files;  ///< every file of the mesh
  std::string format;
  std::vector<std::string> lost;  ///< what the mesh has and the format has no place for
  double max_error_mm = 0.0;      ///< of formats that do not keep every float
  double rms_error_mm = 0.0;
};

/// A page of plain text: what came in, what was measured, what was filled, what is doubtful.
std::string summary_text(const MarkerSequence& session, const ConvertResult& result);

/// The same and more as a JSON document; its fields are documented in docs/convert.md.
std::string summary_json(const MarkerSequence& session, const ConvertResult& result,
                         const WrittenMesh& written);

/// How uncertain the filled samples of a vertex are: standard deviation of one coordinate, mm.
struct FillUncertainty {
  std::size_t frames = 0;  ///< filled
  double mean_mm = 0.0;    ///< over these
  double max_mm = 0.0;
};
FillUncertainty uncertainty_of(const ConvertResult& result, std::size_t vertex);

/// Per frame the largest uncertainty of its vertices, mm; empty when nothing is filled.
std::vector<double> largest_uncertainty(const AnimatedMesh& mesh);

/// CSV: frame, time_s, flipped, degenerate, stretch_min, stretch_max, stretch_rms, filled,
/// uncertainty_max_mm, head_error_mm (empty where the head's pose was not measured).
std::string quality_csv(const ConvertResult& result);

/// When which marker was missing, and how it was filled.
GapChart gap_chart_of(const ConvertResult& result);

/// Sentences about what should be looked at before the mesh is trusted; empty when nothing is.
std::vector<std::string> doubts_of(const ConvertResult& result);

}  // namespace kinemesh
