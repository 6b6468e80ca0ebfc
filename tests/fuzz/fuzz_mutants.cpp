// Runs the readers on deterministic mutants and reports what became of them.
//
//   fuzz_mutants [--target NAME] [--mutants N] [--seconds S] [--first N] [--data FOLDER]
//                [--keep FOLDER]
//
// Without --target all targets share the seconds. Exit status: 0 when every mutant was read or
// refused in time and within memory, 1 when not, 2 for wrong arguments, 77 without any seed. One
// line of JSON per target. A mutant is determined by its number and the seeds: --first N
// --mutants 1 repeats it, --keep writes offending ones to a folder.
#include <signal.h>
#include <sys/time.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <optional>

#include "tests/fuzz/memory_account.h"
#include "tests/fuzz/mutator.h"
#include "tests/fuzz/target.h"
#include "tests/support/data.h"

namespace kinemesh::fuzz {
namespace {

constexpr double max_cpu_seconds = 1.0;
constexpr int hang_cpu_seconds = 10;  // then the process gives up

struct Arguments {
  std::string target;
  uint64_t mutants = UINT64_MAX;
  double seconds = 60.0;
  uint64_t first = 0;
  std::filesystem::path data = test::data_folder();
  std::filesystem::path keep;
};

// For the signal handler: what is running.
char running[256];

void on_fatal_signal(int number) {
  char text[400];
  const int length = std::snprintf(text, sizeof text, "\nfuzz: signal %d (%s) in %s\n", number,
                                   number == SIGPROF ? "hangs" : "crashes", running);
  const auto written = ::write(STDERR_FILENO, text, static_cast<std::size_t>(length));
  (void)written;
  ::_exit(1);
}

/// In seconds of CPU time, so that a busy machine raises no false alarm; 0 switches it off.
void set_hang_alarm(int seconds) {
  const itimerval timer{.it_interval = {}, .it_value = {.tv_sec = seconds, .tv_usec = 0}};
  ::setitimer(ITIMER_PROF, &timer, nullptr);
}

double cpu_seconds() {
  timespec now{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Report {
  uint64_t mutants = 0, read = 0, with_findings = 0, refused = 0, offences = 0;
  double slowest_s = 0.0;
  double worst_memory = 0.0;  // share of the limit
};

class Runner {
 public:
  Runner(const Target& target, const Arguments& arguments)
      : target_(target), arguments_(arguments), seeds_(seeds_of(target, arguments.data)) {}
  bool has_seeds() const { return !seeds_.empty(); }
  Report run(double seconds);

 private:
  void run_one(uint64_t number);
  void offend(uint64_t number, const Mutant& mutant, const std::string& what);

  const Target& target_;
  const Arguments& arguments_;
  std::vector<Seed> seeds_;
  Report report_;
};

void Runner::offend(uint64_t number, const Mutant& mutant, const std::string& what) {
  ++report_.offences;
  std::cerr << "fuzz: " << target_.name << " mutant " << number << " of "
            << seeds_[mutant.seed].name << ": " << what << '\n';
  if (arguments_.keep.empty()) return;
  std::filesystem::create_directories(arguments_.keep);
  std::ofstream(arguments_.keep / (target_.name + "-" + std::to_string(number)), std::ios::binary)
      << mutant.bytes;
}

void Runner::run_one(uint64_t number) {
  const Mutant mutant = make_mutant(seeds_, number);
  std::snprintf(running, sizeof running, "%s mutant %llu of %s", target_.name.c_str(),
                static_cast<unsigned long long>(number), seeds_[mutant.seed].name.c_str());
  const std::size_t limit = 4 * mutant.bytes.size() + (std::size_t{64} << 20);
  set_hang_alarm(hang_cpu_seconds);
  const double start = cpu_seconds();
  begin_account(limit);
  std::optional<Outcome> outcome;
  std::string escaped;
  try {
    outcome = run_target(target_, std::as_bytes(std::span(mutant.bytes)));
  } catch (const std::exception& e) {
    escaped = e.what();
  }
  const Account account = end_account();
  const double seconds = cpu_seconds() - start;
  set_hang_alarm(0);
  ++report_.mutants;
  report_.slowest_s = std::max(report_.slowest_s, seconds);
  report_.worst_memory = std::max(report_.worst_memory,
                                  static_cast<double>(account.peak) / static_cast<double>(limit));
  if (!outcome) offend(number, mutant, "an exception escaped: " + escaped);
  if (account.exceeded) offend(number, mutant, "it asked for more than 4 × the file + 64 MiB");
  if (seconds > max_cpu_seconds)
    offend(number, mutant, "it took " + std::to_string(seconds) + " s");
  if (!outcome) return;
  report_.read += *outcome == Outcome::read ? 1 : 0;
  report_.with_findings += *outcome == Outcome::read_with_findings ? 1 : 0;
  report_.refused += *outcome == Outcome::refused ? 1 : 0;
  if (mutant.payload_only && *outcome == Outcome::refused)
    offend(number, mutant, "a change in the data alone made the reader refuse it");
}

Report Runner::run(double seconds) {
  using clock = std::chrono::steady_clock;
  const auto stop = clock::now() + std::chrono::duration<double>(seconds);
  for (uint64_t n = 0; n < arguments_.mutants && clock::now() < stop; ++n)
    run_one(arguments_.first + n);
  return report_;
}

void print(const Target& target, const Report& r) {
  std::printf(
      "{\"target\": \"%s\", \"mutants\": %llu, \"read\": %llu, \"read_with_findings\": %llu, "
      "\"refused\": %llu, \"offences\": %llu, "
      "\"slowest_s\": %.4f, \"peak_memory_of_limit\": %.3f}\n",
      target.name.c_str(), static_cast<unsigned long long>(r.mutants),
      static_cast<unsigned long long>(r.read), static_cast<unsigned long long>(r.with_findings),
      static_cast<unsigned long long>(r.refused), static_cast<unsigned long long>(r.offences),
      r.slowest_s, r.worst_memory);
  std::fflush(stdout);
}

bool parse(int argc, char** argv, Arguments& a) {
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string name = argv[i];
    const char* value = argv[i + 1];
    if (name == "--target")
      a.target = value;
    else if (name == "--mutants")
      a.mutants = std::strtoull(value, nullptr, 10);
    else if (name == "--seconds")
      a.seconds = std::strtod(value, nullptr);
    else if (name == "--first")
      a.first = std::strtoull(value, nullptr, 10);
    else if (name == "--data")
      a.data = value;
    else if (name == "--keep")
      a.keep = value;
    else
      return false;
  }
  return argc % 2 == 1;
}

int run_all(const Arguments& arguments) {
  for (const int number : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGPROF})
    ::signal(number, on_fatal_signal);
  std::vector<const Target*> chosen;
  for (const Target& t : targets()) {
    if (arguments.target.empty() || arguments.target == t.name) chosen.push_back(&t);
  }
  if (chosen.empty()) {
    std::cerr << "fuzz: there is no target " << arguments.target << '\n';
    return 2;
  }
  uint64_t offences = 0;
  bool any = false;
  for (const Target* target : chosen) {
    Runner runner(*target, arguments);
    if (!runner.has_seeds()) continue;
    any = true;
    const Report report = runner.run(arguments.seconds / static_cast<double>(chosen.size()));
    print(*target, report);
    offences += report.offences;
  }
  if (!any) return 77;
  return offences == 0 ? 0 : 1;
}

}  // namespace
}  // namespace kinemesh::fuzz

int main(int argc, char** argv) {
  kinemesh::fuzz::Arguments arguments;
  if (!kinemesh::fuzz::parse(argc, argv, arguments)) {
    std::cerr << "usage: fuzz_mutants [--target NAME] [--mutants N] [--seconds S] [--first N] "
                 "[--data FOLDER] [--keep FOLDER]\n";
    return 2;
  }
  return kinemesh::fuzz::run_all(arguments);
}
