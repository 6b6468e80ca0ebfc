// The difference of Gaussians over all scales at one vertex, and its test against neighbouring
// scales and frames. Private to analysis/.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "config/buffer.h"

namespace kinemesh::dog {

/// From one temporal level to the next: passes of (a, 1 − 2a, a) over the frames, the first and
/// last frame repeated beyond the ends.
struct TimeStep {
  int passes = 1;
  float a = 1.0F / 3.0F;
};

/// D(k, l) = space(k, l) (L(k+1, l) − L(k, l)) + time(k, l) (L(k, l+1) − L(k, l)).
struct Scales {
  std::size_t sigma_levels = 0, tau_levels = 0;  ///< of D; L has one more of each
  TimeStep first;                                ///< to the first temporal level; passes may be 0
  std::vector<TimeStep> steps;                   ///< tau_levels: from l to l + 1
  std::vector<float> space, time;                ///< sigma_levels × tau_levels
  bool ends = true;                              ///< the first and last scales are tested, too
  float limit = 0.0F;                            ///< only D below it counts; at most 0
  std::size_t index(std::size_t k, std::size_t l) const { return k * tau_levels + l; }
};

struct Hit {
  uint32_t k, l, frame;
};

/// Tests one vertex after the other; one object per thread.
class RowTester {
 public:
  RowTester(const Scales& scales, std::size_t frames);
  /// `levels`: (sigma_levels + 1) × frames, L(k, before any smoothing in time). Appends the samples
  /// that are smaller than their neighbours in scale and time.
  void test(const float* levels, std::vector<Hit>& hits);

 private:
  struct Plane;
  void load(const float* levels, std::size_t first, std::size_t rows);
  void advance(const TimeStep& step);
  void run_block(std::size_t begin, std::size_t end, std::vector<Hit>& hits);
  float* rows(Buffer<float>& plane) { return plane.data() + 16; }

  const Scales& scales_;
  std::size_t frames_, padded_, stride_, block_;
  Buffer<float> current_, next_, spare_, d_[2], pair_[2], least_[3];
  std::size_t first_ = 0, row_count_ = 0;  // of the L rows loaded
};

/// Smoothing in time as sums over frames, for single samples.
class TimeKernels {
 public:
  TimeKernels(const Scales& scales, std::size_t frames);
  /// D(k, l) at one frame; `low` and `high` are L(k) and L(k + 1) before smoothing in time.
  float response(const Scales& scales, std::size_t k, std::size_t l, std::size_t frame,
                 const float* low, const float* high) const;

 private:
  struct Row {
    uint32_t begin = 0, length = 0;
    std::size_t at = 0;  // of `length` weights of level l, then as many of level l + 1 − level l
  };
  std::size_t frames_;
  std::vector<Row> rows_;
  std::vector<float> weights_;
};

}  // namespace kinemesh::dog
