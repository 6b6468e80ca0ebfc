// Typed errors. The library never prints and never exits: it throws one of these, and the
// program that called it decides what to show and with which exit code to end.
#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>

namespace kinemesh {

/// What went wrong and where. Everything but `what` may be empty.
struct ErrorDetails {
  std::string what;                ///< one sentence without a full stop
  std::string file{};              ///< path of the file concerned
  std::string place{};             ///< "line 12", "byte 512", "parameter POINT:RATE"
  std::string marker{};            ///< label of the marker concerned
  std::optional<int64_t> frame{};  ///< frame number as in the file (1-based in C3D)
  std::string remedy{};            ///< what the user can do about it
};

/// Process exit codes, the same for every command.
enum class ExitCode : int {
  done = 0,
  internal_error = 1,
  usage = 2,
  invalid_input = 3,  ///< unreadable or invalid input, or an output that cannot be written
  no_result = 4,      ///< the input is sound but allows no result
  cancelled = 130,
};

/// Base of all errors thrown by Kinemesh; `what()` reads as one or two sentences.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, ErrorDetails details);
  const ErrorDetails& details() const noexcept { return details_; }
  ExitCode exit_code() const noexcept { return code_; }

 private:
  ErrorDetails details_;
  ExitCode code_;
};

/// A wrong option, argument or combination of them.
class UsageError : public Error {
 public:
  explicit UsageError(ErrorDetails d) : Error(ExitCode::usage, std::move(d)) {}
};

/// A file that cannot be read, is malformed, or cannot be written.
class InputError : public Error {
 public:
  explicit InputError(ErrorDetails d) : Error(ExitCode::invalid_input, std::move(d)) {}
};

/// Sound input from which no result can be computed.
class NoResultError : public Error {
 public:
  explicit NoResultError(ErrorDetails d) : Error(ExitCode::no_result, std::move(d)) {}
};

/// The user asked to stop.
class CancelledError : public Error {
 public:
  CancelledError() : Error(ExitCode::cancelled, {.what = "cancelled"}) {}
};

/// A broken promise inside Kinemesh: a bug, never the user's fault.
class InternalError : public Error {
 public:
  explicit InternalError(std::string what)
      : Error(ExitCode::internal_error,
              {.what = std::move(what), .remedy = "This is a bug in Kinemesh: please report it"}) {}
};

}  // namespace kinemesh
