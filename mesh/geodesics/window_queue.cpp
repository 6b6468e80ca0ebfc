#include <algorithm>

#include "mesh/geodesics/window_propagation.h"

namespace kinemesh::geodesics {

void WindowQueue::reset(double bucket_width) {
  for (std::vector<Window>& bucket : buckets_) bucket.clear();
  distant_.clear();
  nearest_distant_ = std::numeric_limits<int64_t>::max();
  current_ = 0;
  per_width_ = 1.0 / bucket_width;
  waiting_ = peak_ = 0;
}

void WindowQueue::defer(const Window& window, int64_t index) {
  distant_.push_back({window, index});
  nearest_distant_ = std::min(nearest_distant_, index);
}

bool WindowQueue::take_bucket(std::vector<Window>& bucket) {
  bucket.clear();
  if (waiting_ == 0) return false;
  peak_ = std::max(peak_, waiting_);
  int64_t step = 0;
  while (step < bucket_count && buckets_[(current_ + step) % bucket_count].empty()) ++step;
  current_ = step < bucket_count ? current_ + step : nearest_distant_;
  if (nearest_distant_ <= current_) {
    current_ = nearest_distant_;
    call_distant();
  }
  bucket.swap(buckets_[current_ % bucket_count]);
  waiting_ -= bucket.size();
  return true;
}

void WindowQueue::call_distant() {
  std::vector<Distant> waiting;
  waiting.swap(distant_);
  nearest_distant_ = std::numeric_limits<int64_t>::max();
  for (const Distant& d : waiting) {
    if (d.index - current_ < bucket_count) {
      buckets_[d.index % bucket_count].push_back(d.window);
    } else {
      defer(d.window, d.index);
    }
  }
}

}  // namespace kinemesh::geodesics
