#include "cli/console.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>

namespace kinemesh::cli {
namespace {

using Clock = std::chrono::steady_clock;

spdlog::level::level_enum spdlog_level(LogLevel level) {
  switch (level) {
    case LogLevel::debug: return spdlog::level::debug;
    case LogLevel::info: return spdlog::level::info;
    case LogLevel::warning: return spdlog::level::warn;
    case LogLevel::error: return spdlog::level::err;
  }
  return spdlog::level::info;
}

spdlog::level::level_enum threshold(Verbosity verbosity) {
  switch (verbosity) {
    case Verbosity::quiet: return spdlog::level::err;
    case Verbosity::normal: return spdlog::level::info;
    case Verbosity::verbose: return spdlog::level::debug;
  }
  return spdlog::level::info;
}

}  // namespace

struct Console::State {
  explicit State(Verbosity v)
      : verbosity(v),
        terminal(::isatty(STDERR_FILENO) != 0),
        logger("kinemesh", std::make_shared<spdlog::sinks::stderr_sink_mt>()) {
    logger.set_pattern("kinemesh: %v");
    logger.set_level(threshold(v));
    logger.flush_on(spdlog::level::trace);
  }

  void clear_bar() {
    if (!bar_shown) return;
    std::fputs("\r\033[K", stderr);
    bar_shown = false;
  }

  void log(LogLevel level, std::string_view text) {
    clear_bar();
    const std::string prefix = level == LogLevel::warning ? "warning: "
                               : level == LogLevel::error ? "error: "
                                                          : "";
    logger.log(spdlog_level(level), "{}{}", prefix, text);
  }

  void progress(double fraction, std::string_view stage) {
    if (verbosity == Verbosity::quiet) return;
    if (terminal) {
      draw_bar(fraction, stage);
    } else {
      print_line(fraction, stage);
    }
  }

  void draw_bar(double fraction, std::string_view stage) {
    const auto now = Clock::now();
    if (bar_shown && fraction < 1.0 && now - last_drawn < std::chrono::milliseconds(50)) return;
    last_drawn = now;
    constexpr int width = 30;
    const int done = static_cast<int>(std::lround(fraction * width));
    const std::string bar = std::string(static_cast<std::size_t>(done), '#') +
                            std::string(static_cast<std::size_t>(width - done), '.');
    std::fprintf(stderr, "\r\033[K[%s] %3.0f %%  %.*s", bar.c_str(), 100.0 * fraction,
                 static_cast<int>(stage.size()), stage.data());
    std::fflush(stderr);
    bar_shown = true;
    if (fraction >= 1.0) clear_bar();
  }

  void print_line(double fraction, std::string_view stage) {
    // A run shorter than a second needs no progress lines in a log file.
    const auto now = Clock::now();
    if (now - started < std::chrono::seconds(1) || stage.empty() || stage == last_stage) return;
    last_stage = stage;
    std::fprintf(stderr, "kinemesh: %3.0f %%  %.*s\n", 100.0 * fraction,
                 static_cast<int>(stage.size()), stage.data());
  }

  Verbosity verbosity;
  bool terminal;
  bool bar_shown = false;
  Clock::time_point started = Clock::now();
  Clock::time_point last_drawn;
  std::string last_stage;
  spdlog::logger logger;
};

Console::Console(Verbosity verbosity) : state_(std::make_unique<State>(verbosity)) {}

Console::~Console() { finish(); }

void Console::attach(RunContext& context) {
  context.set_log([this](LogLevel level, std::string_view text) { state_->log(level, text); });
  context.set_progress(
      [this](double fraction, std::string_view stage) { state_->progress(fraction, stage); });
}

void Console::error(const std::string& message) { state_->log(LogLevel::error, message); }

void Console::finish() { state_->clear_bar(); }

}  // namespace kinemesh::cli
