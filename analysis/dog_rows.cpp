#include "analysis/dog_rows.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "config/multiversion.h"

namespace kinemesh::dog {
namespace {

constexpr std::size_t row_lanes = 16;
constexpr std::size_t block_bytes = 400U << 10U;  // all planes of a block of levels: fits the cache
constexpr float infinity = std::numeric_limits<float>::infinity();

/// The planes of one temporal level; rows of `stride`, k = 0 is row 1 of d, pair and least.
struct LevelPlanes {
  const float* current;
  float* next;
  float* d;                   // this level's D
  float* pair;                // min(D(k − 1), D(k + 1)) of this level
  float* least;               // min(pair, D(k)) of this level
  const float* d_before;      // level before: D
  const float* pair_before;   // level before
  const float* least_before;  // two levels before
  const float* space;
  const float* time;
  std::size_t coefficient_stride, stride, frames, padded, rows;
  float a;
  bool fused;  // next = one pass over current; otherwise it is given
};

inline void pad(float* row, std::size_t frames) {
  row[-1] = row[0];
  row[frames] = row[frames - 1];
}

inline void pad_infinite(float* row, std::size_t frames, std::size_t padded) {
  row[-1] = infinity;
  for (std::size_t f = frames; f < padded + 1; ++f) row[f] = infinity;
}

/// next = current after one pass; D from both and the row above.
inline void fused_row(const LevelPlanes& p, std::size_t k) {
  const float* c = p.current + k * p.stride;
  float* n = p.next + k * p.stride;
  const float a = p.a;
  if (k + 1 == p.rows) {
    for (std::size_t b = 0; b < p.padded; b += row_lanes) {
      for (std::size_t f = b; f < b + row_lanes; ++f) {
        n[f] = c[f] + a * ((c[f - 1] + c[f + 1]) - (c[f] + c[f]));
      }
    }
    pad(n, p.frames);
    return;
  }
  const float* up = c + p.stride;
  float* d = p.d + (k + 1) * p.stride;
  const float space = p.space[k * p.coefficient_stride], time = p.time[k * p.coefficient_stride];
  for (std::size_t b = 0; b < p.padded; b += row_lanes) {
    for (std::size_t f = b; f < b + row_lanes; ++f) {
      const float t = a * ((c[f - 1] + c[f + 1]) - (c[f] + c[f]));
      n[f] = c[f] + t;
      d[f] = space * (up[f] - c[f]) + time * t;
    }
  }
  pad(n, p.frames);
  pad_infinite(d, p.frames, p.padded);
}

inline void difference_row(const LevelPlanes& p, std::size_t k) {
  const float* c = p.current + k * p.stride;
  const float* up = c + p.stride;
  const float* n = p.next + k * p.stride;
  float* d = p.d + (k + 1) * p.stride;
  const float space = p.space[k * p.coefficient_stride], time = p.time[k * p.coefficient_stride];
  for (std::size_t b = 0; b < p.padded; b += row_lanes) {
    for (std::size_t f = b; f < b + row_lanes; ++f) {
      d[f] = space * (up[f] - c[f]) + time * (n[f] - c[f]);
    }
  }
  pad_infinite(d, p.frames, p.padded);
}

inline void minima_row(const LevelPlanes& p, std::size_t row) {
  const std::size_t at = row * p.stride;
  const float* below = p.d + at - p.stride;
  const float* here = p.d + at;
  const float* above = p.d + at + p.stride;
  float* pair = p.pair + at;
  float* least = p.least + at;
  for (std::size_t b = 0; b < p.padded; b += row_lanes) {
    for (std::size_t f = b; f < b + row_lanes; ++f) {
      const float m = below[f] < above[f] ? below[f] : above[f];
      pair[f] = m;
      least[f] = m < here[f] ? m : here[f];
    }
  }
}

KINEMESH_MULTIVERSION void level_rows(const LevelPlanes& p) {
  for (std::size_t k = 0; k < p.rows; ++k) {
    if (p.fused) {
      fused_row(p, k);
    } else if (k + 1 < p.rows) {
      difference_row(p, k);
    }
    if (k >= 1 && k + 1 < p.rows) minima_row(p, k);
  }
  if (p.rows >= 2) minima_row(p, p.rows - 1);
}

/// Whether any of the 64 frames from `b` on is smaller than its neighbours.
inline bool any_minimum(const LevelPlanes& p, std::size_t at, std::size_t b, float limit) {
  const float* d = p.d_before + at;
  const float* pair = p.pair_before + at;
  const float* before = p.least_before + at;
  const float* after = p.least + at;
  int found[row_lanes] = {};
  const std::size_t end = std::min(b + 4 * row_lanes, p.padded);
  for (std::size_t block = b; block < end; block += row_lanes) {
    for (std::size_t i = 0; i < row_lanes; ++i) {
      const std::size_t f = block + i;
      float m = pair[f] < limit ? pair[f] : limit;
      m = before[f] < m ? before[f] : m;
      m = after[f] < m ? after[f] : m;
      m = d[f - 1] < m ? d[f - 1] : m;
      m = d[f + 1] < m ? d[f + 1] : m;
      found[i] |= d[f] < m ? 1 : 0;
    }
  }
  int any = 0;
  for (const int f : found) any |= f;
  return any != 0;
}

inline bool is_minimum(const LevelPlanes& p, std::size_t at, std::size_t f, float limit) {
  const float d = p.d_before[at + f];
  return d < limit && d < p.pair_before[at + f] && d < p.least_before[at + f] &&
         d < p.least[at + f] && d < p.d_before[at + f - 1] && d < p.d_before[at + f + 1];
}

/// Appends what the level before has in the rows [begin, end) (row 1 is the block's first D).
KINEMESH_MULTIVERSION void test_rows(const LevelPlanes& p, std::size_t begin, std::size_t end,
                                     std::size_t first_k, std::size_t level, float limit,
                                     std::vector<Hit>* hits) {
  for (std::size_t row = begin; row < end; ++row) {
    const std::size_t at = row * p.stride;
    for (std::size_t b = 0; b < p.frames; b += 4 * row_lanes) {
      if (!any_minimum(p, at, b, limit)) continue;
      const std::size_t last = std::min(b + 4 * row_lanes, p.frames);
      for (std::size_t f = b; f < last; ++f) {
        if (!is_minimum(p, at, f, limit)) continue;
        hits->push_back({static_cast<uint32_t>(first_k + row - 1), static_cast<uint32_t>(level),
                         static_cast<uint32_t>(f)});
      }
    }
  }
}

KINEMESH_MULTIVERSION void pass_rows(const float* from, float* to, std::size_t stride,
                                     std::size_t frames, std::size_t padded, std::size_t rows,
                                     float a) {
  for (std::size_t k = 0; k < rows; ++k) {
    const float* c = from + k * stride;
    float* n = to + k * stride;
    for (std::size_t b = 0; b < padded; b += row_lanes) {
      for (std::size_t f = b; f < b + row_lanes; ++f) {
        n[f] = c[f] + a * ((c[f - 1] + c[f + 1]) - (c[f] + c[f]));
      }
    }
    pad(n, frames);
  }
}

KINEMESH_MULTIVERSION float weighted_difference(const float* g, const float* e, const float* low,
                                                const float* high, std::size_t length, float space,
                                                float time) {
  float sums[row_lanes] = {};
  std::size_t j = 0;
  for (; j + row_lanes <= length; j += row_lanes) {
    for (std::size_t i = 0; i < row_lanes; ++i) {
      sums[i] += space * g[j + i] * (high[j + i] - low[j + i]) + time * e[j + i] * low[j + i];
    }
  }
  float sum = 0.0F;
  for (; j < length; ++j) sum += space * g[j] * (high[j] - low[j]) + time * e[j] * low[j];
  for (const float s : sums) sum += s;
  return sum;
}

}  // namespace

RowTester::RowTester(const Scales& scales, std::size_t frames)
    : scales_(scales),
      frames_(frames),
      padded_((frames + row_lanes - 1) / row_lanes * row_lanes),
      stride_(padded_ + 2 * row_lanes) {
  const std::size_t fitting = block_bytes / (9 * stride_ * sizeof(float));
  block_ = std::min(scales.sigma_levels, std::max<std::size_t>(fitting, 11) - 3);
  const std::size_t size = (block_ + 5) * stride_ + 2 * row_lanes;
  for (Buffer<float>* plane : {&current_, &next_, &spare_, &d_[0], &d_[1], &pair_[0], &pair_[1],
                               &least_[0], &least_[1], &least_[2]}) {
    *plane = Buffer<float>(size, 0.0F);
  }
}

void RowTester::load(const float* levels, std::size_t first, std::size_t rows_loaded) {
  first_ = first;
  row_count_ = rows_loaded;
  for (std::size_t k = 0; k < rows_loaded; ++k) {
    float* row = rows(current_) + k * stride_;
    std::memcpy(row, levels + (first + k) * frames_, frames_ * sizeof(float));
    pad(row, frames_);
  }
}

/// next = current after the passes of the step; current is kept.
void RowTester::advance(const TimeStep& step) {
  pass_rows(rows(current_), rows(next_), stride_, frames_, padded_, row_count_, step.a);
  for (int pass = 1; pass < step.passes; ++pass) {
    pass_rows(rows(next_), rows(spare_), stride_, frames_, padded_, row_count_, step.a);
    std::swap(next_, spare_);
  }
}

void RowTester::test(const float* levels, std::vector<Hit>& hits) {
  const std::size_t low = scales_.ends ? 0 : 1;
  const std::size_t high = scales_.ends ? scales_.sigma_levels : scales_.sigma_levels - 1;
  for (std::size_t begin = low; begin < high; begin += block_) {
    const std::size_t end = std::min(high, begin + block_);
    const std::size_t first = begin > 0 ? begin - 1 : 0;
    const std::size_t last = std::min(end + 2, scales_.sigma_levels + 1);  // of the L rows
    load(levels, first, last - first);
    run_block(begin, end, hits);
  }
}

void RowTester::run_block(std::size_t begin, std::size_t end, std::vector<Hit>& hits) {
  if (scales_.first.passes > 0) {
    advance(scales_.first);
    std::swap(current_, next_);
  }
  const auto fill = [&](Buffer<float>& plane) {
    std::fill(plane.begin(), plane.end(), infinity);  // also the rows beyond the first and last k
  };
  for (Buffer<float>* plane : {&d_[0], &d_[1], &least_[0], &least_[1], &least_[2]}) fill(*plane);
  LevelPlanes p{};
  p.coefficient_stride = scales_.tau_levels;
  p.stride = stride_;
  p.frames = frames_;
  p.padded = padded_;
  p.rows = row_count_;
  const std::size_t first_row = begin - first_ + 1, last_row = end - first_ + 1;
  for (std::size_t l = 0; l <= scales_.tau_levels; ++l) {
    p.d = rows(d_[l % 2]);
    p.pair = rows(pair_[l % 2]);
    p.least = rows(least_[l % 3]);
    p.d_before = rows(d_[(l + 1) % 2]);
    p.pair_before = rows(pair_[(l + 1) % 2]);
    p.least_before = rows(least_[(l + 1) % 3]);  // that of l − 2
    if (l < scales_.tau_levels) {
      const TimeStep& step = scales_.steps[l];
      p.fused = step.passes == 1;
      p.a = step.a;
      if (!p.fused) advance(step);
      p.current = rows(current_);
      p.next = rows(next_);
      p.space = &scales_.space[scales_.index(first_, l)];
      p.time = &scales_.time[scales_.index(first_, l)];
      level_rows(p);
      std::swap(current_, next_);
    } else {
      fill(least_[l % 3]);
    }
    const bool tested = scales_.ends ? l >= 1 : l >= 2 && l < scales_.tau_levels;
    if (tested) test_rows(p, first_row, last_row, first_, l - 1, scales_.limit, &hits);
  }
}

namespace {

using Kernel = std::vector<double>;

/// The kernel after one more step, without tails below 1e-9.
Kernel convolved(Kernel kernel, const TimeStep& step) {
  for (int pass = 0; pass < step.passes; ++pass) {
    Kernel wider(kernel.size() + 2, 0.0);
    for (std::size_t i = 0; i < kernel.size(); ++i) {
      wider[i] += step.a * kernel[i];
      wider[i + 1] += (1.0 - 2.0 * step.a) * kernel[i];
      wider[i + 2] += step.a * kernel[i];
    }
    kernel = std::move(wider);
    while (kernel.size() > 3 && kernel.front() < 1e-9) {
      kernel.erase(kernel.begin());
      kernel.pop_back();
    }
  }
  return kernel;
}

/// Each temporal level's kernel on an endless line; sums are 1.
std::vector<Kernel> kernels_of(const Scales& scales) {
  std::vector<Kernel> kernels{convolved({1.0}, scales.first)};
  for (const TimeStep& step : scales.steps) kernels.push_back(convolved(kernels.back(), step));
  for (Kernel& k : kernels) {
    double sum = 0.0;
    for (const double w : k) sum += w;
    for (double& w : k) w /= sum;
  }
  return kernels;
}

/// The kernel around frame f on the frames there are: what falls beyond an end is mirrored.
void spread(const Kernel& kernel, std::ptrdiff_t f, std::vector<double>& to) {
  const auto count = static_cast<std::ptrdiff_t>(to.size());
  std::ranges::fill(to, 0.0);
  const auto reach = static_cast<std::ptrdiff_t>(kernel.size() / 2);
  for (std::ptrdiff_t j = -reach; j <= reach; ++j) {
    std::ptrdiff_t at = (f + j) % (2 * count);
    if (at < 0) at += 2 * count;
    if (at >= count) at = 2 * count - 1 - at;
    to[static_cast<std::size_t>(at)] += kernel[static_cast<std::size_t>(j + reach)];
  }
}

}  // namespace

TimeKernels::TimeKernels(const Scales& scales, std::size_t frames) : frames_(frames) {
  const std::vector<Kernel> kernels = kernels_of(scales);
  const auto count = static_cast<std::ptrdiff_t>(frames);
  std::vector<double> now(frames), then(frames);
  for (std::size_t l = 0; l < scales.tau_levels; ++l) {
    const auto reach = static_cast<std::ptrdiff_t>(kernels[l + 1].size() / 2);
    for (std::ptrdiff_t f = 0; f < count; ++f) {
      spread(kernels[l], f, now);
      spread(kernels[l + 1], f, then);
      const std::ptrdiff_t begin = std::max<std::ptrdiff_t>(0, f - reach);
      const Row row{.begin = static_cast<uint32_t>(begin),
                    .length = static_cast<uint32_t>(std::min(count, f + reach + 1) - begin),
                    .at = weights_.size()};
      for (std::size_t i = 0; i < row.length; ++i) {
        weights_.push_back(static_cast<float>(now[row.begin + i]));
      }
      for (std::size_t i = 0; i < row.length; ++i) {
        weights_.push_back(static_cast<float>(then[row.begin + i] - now[row.begin + i]));
      }
      rows_.push_back(row);
    }
  }
}

float TimeKernels::response(const Scales& scales, std::size_t k, std::size_t l, std::size_t frame,
                            const float* low, const float* high) const {
  const Row& row = rows_[l * frames_ + frame];
  const float* g = weights_.data() + row.at;
  return weighted_difference(g, g + row.length, low + row.begin, high + row.begin, row.length,
                             scales.space[scales.index(k, l)], scales.time[scales.index(k, l)]);
}

}  // namespace kinemesh::dog
