#include "config/run_context.h"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <thread>

#include "config/error.h"

namespace kinemesh {

struct RunContext::Shared {
  std::atomic<bool> cancelled{false};
  std::mutex mutex;  // guards what follows, and serialises the sinks
  LogSink log;
  ProgressSink progress;
  double reported = -1.0;
};

RunContext::RunContext() : shared_(std::make_shared<Shared>()) { set_threads(0); }

RunContext& RunContext::set_seed(uint64_t seed) {
  seed_ = seed;
  return *this;
}

RunContext& RunContext::set_threads(int threads) {
  if (threads < 0) {
    throw UsageError(
        {.what = "the number of threads must not be negative, but is " + std::to_string(threads)});
  }
  const int available = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  threads_ = threads == 0 ? available : threads;
  return *this;
}

RunContext& RunContext::set_log(LogSink sink) {
  const std::lock_guard lock(shared_->mutex);
  shared_->log = std::move(sink);
  return *this;
}

RunContext& RunContext::set_progress(ProgressSink sink) {
  const std::lock_guard lock(shared_->mutex);
  shared_->progress = std::move(sink);
  return *this;
}

void RunContext::log(LogLevel level, std::string_view text) const {
  const std::lock_guard lock(shared_->mutex);
  if (shared_->log) shared_->log(level, text);
  if (listener_) listener_(level, text);
}

RunContext RunContext::overheard_by(LogSink listener) const {
  RunContext context = *this;
  context.listener_ = std::move(listener);
  return context;
}

void RunContext::progress(double fraction) const {
  const double overall = begin_ + (end_ - begin_) * std::clamp(fraction, 0.0, 1.0);
  const std::lock_guard lock(shared_->mutex);
  if (overall <= shared_->reported) return;
  shared_->reported = overall;
  if (shared_->progress) shared_->progress(overall, stage_);
}

RunContext RunContext::part(double begin, double end, std::string stage) const {
  RunContext sub = *this;
  const double width = end_ - begin_;
  sub.begin_ = begin_ + width * begin;
  sub.end_ = begin_ + width * end;
  sub.stage_ = std::move(stage);
  return sub;
}

void RunContext::cancel() const noexcept { shared_->cancelled.store(true); }

bool RunContext::cancelled() const noexcept { return shared_->cancelled.load(); }

void RunContext::check_cancelled() const {
  if (cancelled()) throw CancelledError();
}

}  // namespace kinemesh
