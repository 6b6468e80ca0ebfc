// The one context through which a stage reports progress, logs, is cancelled, and learns its
// seed and thread count. Free of Qt; cheap to copy; safe to use from any thread.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace kinemesh {

enum class LogLevel { debug, info, warning, error };

/// Called with the level and one line of text without a newline; calls are serialised.
using LogSink = std::function<void(LogLevel, std::string_view)>;
/// Called with the overall fraction in [0, 1], which never goes back, and the stage's name.
using ProgressSink = std::function<void(double fraction, std::string_view stage)>;

class RunContext {
 public:
  RunContext();

  /// Seed of every random choice; the same seed gives the same bytes.
  uint64_t seed() const { return seed_; }
  RunContext& set_seed(uint64_t seed);

  /// Number of threads a stage may use, at least 1. Results never depend on it.
  int threads() const { return threads_; }
  /// 0 means as many as the machine has.
  RunContext& set_threads(int threads);

  RunContext& set_log(LogSink sink);
  RunContext& set_progress(ProgressSink sink);

  void log(LogLevel level, std::string_view text) const;
  /// A context like this one that tells `listener`, too, what is logged through it and its parts.
  RunContext overheard_by(LogSink listener) const;
  void info(std::string_view text) const { log(LogLevel::info, text); }
  void warn(std::string_view text) const { log(LogLevel::warning, text); }

  /// Reports that `fraction` in [0, 1] of this context's part is done.
  void progress(double fraction) const;

  /// A context for a part of the work: its progress 0..1 maps to [begin, end] of this one's.
  /// Shares sinks, cancel state, seed and threads.
  RunContext part(double begin, double end, std::string stage) const;

  /// Requests a stop; lock-free, so a signal handler may call it.
  void cancel() const noexcept;
  bool cancelled() const noexcept;
  /// Throws CancelledError when a stop was requested. Stages call it at least every 0.1 s.
  void check_cancelled() const;

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
  uint64_t seed_ = 0;
  int threads_ = 1;
  double begin_ = 0.0;
  double end_ = 1.0;
  std::string stage_;
  LogSink listener_;
};

}  // namespace kinemesh
