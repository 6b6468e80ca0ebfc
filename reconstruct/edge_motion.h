// How the distance between two markers varies over a take, with jumps of mislabelled samples and
// filled samples left out.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "capture/marker_sequence.h"
#include "config/run_context.h"
#include "reconstruct/edit_mesh.h"

namespace kinemesh {

/// Quantiles over the take of the distance between two markers, mm.
struct LengthRange {
  double low = 0.0;  ///< 1 %
  double median = 0.0;
  double high = 0.0;  ///< 99 %
  double used = 0.0;  ///< share of the frames in which both samples were used
  double range() const { return high - low; }
  double shortening() const { return median - low; }
};

/// Frames × markers, 1 where a sample may be used for statistics: measured, and not in a piece of
/// the trajectory that jumps away from the markers around it. A jump is a step, relative to the
/// median step of the neighbours in `mesh`, of more than half of `spacing` and of more than
/// 600 mm/s. Of the pieces between jumps the longest is trusted, and others where the marker lies
/// as it lay there relative to its neighbours. mesh vertex v is marker `original[v]`.
std::vector<uint8_t> reliable_samples(const MarkerSequence& take, const EditMesh& mesh,
                                      const std::vector<VertexIndex>& original, double spacing,
                                      const RunContext& ctx = {});

class EdgeMotion {
 public:
  /// Keeps references to `take` and `original`.
  EdgeMotion(const MarkerSequence& take, const EditMesh& mesh,
             const std::vector<VertexIndex>& original, double spacing, const RunContext& ctx = {});

  /// Of the markers of two mesh vertices; computed once per pair.
  const LengthRange& of(VertexIndex a, VertexIndex b);
  /// Samples that are measured but not trusted.
  std::size_t jump_samples() const { return jump_samples_; }
  /// Time spent on the statistics.
  double seconds() const { return seconds_; }

 private:
  LengthRange measure(VertexIndex a, VertexIndex b) const;

  const MarkerSequence& take_;
  const std::vector<VertexIndex>& original_;
  std::vector<uint8_t> reliable_;
  std::size_t jump_samples_ = 0;
  double seconds_ = 0.0;
  std::map<DirectedEdge, LengthRange> known_;
};

}  // namespace kinemesh
