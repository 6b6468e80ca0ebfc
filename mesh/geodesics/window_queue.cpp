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

void WindowQueue::push(const Window& window, double key) {
  // The bound keeps the conversion defined for any ratio of distance to bucket width.
  const auto wanted = static_cast<int64_t>(std::min(key * per_width_, 1e18));
  const int64_t index = std::max(wanted, current_);
  if (index - current_ < bucket_count) {
    buckets_[index % bucket_count].push_back(window);
  } else {
    distant_.push_back({window, index});
    nearest_distant_ = std::min(nearest_distant_, index);
  }
  peak_ = std::max(peak_, ++waiting_);
}

bool WindowQueue::advance() {
  if (waiting_ == 0) return false;
  int64_t step = 0;
  while (step < bucket_count && buckets_[(current_ + step) % bucket_count].empty()) ++step;
  current_ = step < bucket_count ? current_ + step : nearest_distant_;
  if (nearest_distant_ <= current_) {
    current_ = nearest_distant_;
    call_distant();
  }
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
      distant_.push_back(d);
      nearest_distant_ = std::min(nearest_distant_, d.index);
    }
  }
}

void WindowQueue::clear_bucket() {
  std::vector<Window>& bucket = buckets_[current_ % bucket_count];
  waiting_ -= bucket.size();
  bucket.clear();
}

}  // namespace kinemesh::geodesics
