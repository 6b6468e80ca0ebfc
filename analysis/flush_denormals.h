// Keeps arithmetic on vanishing numbers from costing a hundred times as much. Private to analysis/.
#pragma once

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace kinemesh {

/// While it lives, floats of this thread below 1e-38 count as 0.
class FlushDenormals {
 public:
#if defined(__SSE2__)
  FlushDenormals() : before_(_mm_getcsr()) { _mm_setcsr(before_ | 0x8040U); }
  ~FlushDenormals() { _mm_setcsr(before_); }
#else
  FlushDenormals() = default;
#endif
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

 private:
  unsigned before_ = 0;
};

}  // namespace kinemesh
