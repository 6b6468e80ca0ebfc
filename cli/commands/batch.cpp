// kinemesh batch: many sessions are converted with one set of options, each in a process of its
// own, so that one that fails harms no other.
#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "capture/formats/mesh_formats.h"
#include "cli/child_process.h"
#include "cli/commands/commands.h"
#include "config/output_file.h"
#include "config/text.h"
#include "config/version.h"
#include "mesh/formats/mesh_io.h"
#include "reconstruct/batch_journal.h"
#include "reconstruct/batch_manifest.h"
#include "reconstruct/convert_files.h"

namespace kinemesh::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

struct Arguments {
  std::string manifest, folder;
  std::string jobs = "0";
  bool resume = false, dry_run = false;
  ConvertFilesOptions options;
};

enum class State { waiting, running, done, finished_before, failed, cancelled };

const char* word_of(State state) {
  switch (state) {
    case State::waiting: return "not begun";
    case State::running: return "running";
    case State::done: return "done";
    case State::finished_before: return "finished before";
    case State::failed: return "failed";
    case State::cancelled: return "cancelled";
  }
  return "";
}

struct Outcome {
  State state = State::waiting;
  int exit_code = 0;
  std::string reason;
  double seconds = 0.0;
  BatchRecord record;
};

/// "not found" out of "kinemesh: error: session.c3d: not found\n…".
std::string reason_of(const ChildProcess& child, const fs::path& session) {
  if (child.signal() != 0) {
    return "the conversion was ended by signal " + std::to_string(child.signal());
  }
  const std::string text = child.err();
  constexpr std::string_view mark = "error: ";
  const std::size_t at = text.rfind(mark);
  std::string_view rest = at == std::string::npos ? std::string_view(text)
                                                  : std::string_view(text).substr(at + mark.size());
  const std::string name = session.string() + ": ";
  if (rest.starts_with(name)) rest.remove_prefix(name.size());
  return std::string(trim(rest));
}

int number_of_jobs(const std::string& text) {
  int jobs = -1;
  const char* end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, jobs);
  if (error != std::errc() || at != end || jobs < 0 || jobs > 1024) {
    throw UsageError({.what = "--jobs: '" + text + "' is no number from 0 to 1024"});
  }
  return jobs;
}

class Batch {
 public:
  Batch(const Arguments& arguments, Terminal& terminal)
      : terminal_(terminal),
        manifest_(read_batch_manifest(arguments.manifest, {.folder = arguments.folder})),
        journal_(beside(".journal"), arguments.resume || arguments.dry_run),
        outcomes_(manifest_.sessions.size()) {
    const FormatRegistry formats = all_formats();
    for (std::size_t i = 0; i < outcomes_.size(); ++i) {  // said before any work is done
      check_format(formats, i, arguments.options.writing);
    }
    const int asked = number_of_jobs(arguments.jobs);
    const int sessions = static_cast<int>(std::min<std::size_t>(outcomes_.size(), 1024));
    jobs_ = std::clamp(asked > 0 ? asked : terminal.run.threads(), 1, sessions);
    if (arguments.options.anonymous) {
      terminal.run.warn(
          "the names of the results, the journal and the outcomes keep the names of the sessions' "
          "files: name each 'output' without a person's, and pass on neither of the two");
    }
    keys_.resize(outcomes_.size());
    for (std::size_t i = 0; i < outcomes_.size(); ++i) {
      key_of(i);
      if (!arguments.resume) continue;
      if (const BatchRecord* record = journal_.finished(journal_.name_of(output(i)), keys_[i])) {
        outcomes_[i].state = State::finished_before;
        outcomes_[i].record = *record;
      }
    }
  }

  void run() {
    fs::create_directories(manifest_.folder);
    write_file(beside("_options.toml"), terminal_.options_toml);
    std::vector<Running> running;
    while (!terminal_.run.cancelled()) {
      while (running.size() < static_cast<std::size_t>(jobs_) && start_next(running)) {
      }
      if (running.empty()) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      std::erase_if(running, [this](Running& r) { return collect(r); });
    }
    stop(running);
    write_file(beside("_outcomes.json"), json());
  }

  /// The outcome of all: that of the first session that failed.
  ExitCode exit_code() const {
    if (terminal_.run.cancelled()) return ExitCode::cancelled;
    for (const Outcome& o : outcomes_) {
      if (o.state == State::failed) return static_cast<ExitCode>(o.exit_code);
    }
    return ExitCode::done;
  }

  std::string json() const {
    Json sessions = Json::array();
    for (std::size_t i = 0; i < outcomes_.size(); ++i) {
      const Outcome& o = outcomes_[i];
      Json files = Json::array();
      for (const BatchRecord::File& file : o.record.files) {
        files.push_back((manifest_.folder / file.path).string());
      }
      sessions.push_back({{"session", manifest_.sessions[i].session.string()},
                          {"output", output(i)},
                          {"outcome", word_of(o.state)},
                          {"exit_code", o.exit_code},
                          {"reason", o.reason},
                          {"vertices", o.record.vertices},
                          {"frames", o.record.frames},
                          {"warnings", o.record.warnings},
                          {"seconds", std::round(1000 * o.seconds) / 1000},
                          {"files", files}});
    }
    const Json document = {{"program", program_version()},
                           {"manifest", manifest_.file.string()},
                           {"sessions", sessions}};
    return document.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
  }

  std::string table() const {
    std::size_t widest = 0;
    for (const BatchSession& s : manifest_.sessions) {
      widest = std::max(widest, s.session.string().size());
    }
    std::string text;
    std::map<std::string, std::size_t> counts;
    for (std::size_t i = 0; i < outcomes_.size(); ++i) {
      const Outcome& o = outcomes_[i];
      ++counts[word_of(o.state)];
      std::string line = manifest_.sessions[i].session.string();
      line.resize(widest + 2, ' ');
      line += word_of(o.state);
      line.resize(widest + 19, ' ');
      if (o.state == State::failed) {
        line += o.reason;
      } else if (o.record.vertices > 0) {
        line += count_of(o.record.vertices, "vertex", "vertices") + ", " +
                count_of(o.record.frames, "frame") + ", " + count_of(o.record.warnings, "warning");
        if (o.seconds > 0) line += ", " + format_fixed(o.seconds, 1) + " s";
      } else if (!o.reason.empty()) {
        line += o.reason;
      }
      text += line + "\n";
    }
    std::vector<std::string> parts;
    for (const auto& [word, count] : counts) parts.push_back(std::to_string(count) + " " + word);
    return text + count_of(outcomes_.size(), "session") + ": " + join(parts, ", ") + "\n";
  }

  /// What would be done, for --dry-run.
  void plan() {
    for (std::size_t i = 0; i < outcomes_.size(); ++i) {
      Outcome& o = outcomes_[i];
      if (o.state == State::finished_before) continue;
      const BatchSession& s = manifest_.sessions[i];
      std::error_code ignored;
      if (!fs::is_regular_file(s.session, ignored)) {
        fail(o, ExitCode::invalid_input, "there is no such file");
      } else if (!s.topology.empty() && !s.after && !fs::is_regular_file(s.topology, ignored)) {
        fail(o, ExitCode::invalid_input, "there is no topology " + s.topology.string());
      } else {
        o.reason = "to " + output(i) + (s.after ? ", after " + output(*s.after) : "");
      }
    }
  }

 private:
  struct Running {
    std::size_t index;
    std::unique_ptr<ChildProcess> child;
    Clock::time_point since;
  };

  std::string output(std::size_t i) const { return manifest_.sessions[i].output.string(); }
  fs::path beside(const std::string& suffix) const {
    return manifest_.folder / (manifest_.file.stem().string() + suffix);
  }

  void check_format(const FormatRegistry& formats, std::size_t i,
                    const WriteOptions& writing) const {
    try {
      output_format(formats, output(i), writing, 2);
    } catch (const UsageError& e) {
      ErrorDetails details = e.details();
      details.file = manifest_.file.string();
      details.place = "line " + std::to_string(manifest_.sessions[i].line);
      throw UsageError(details);
    }
  }

  /// Found once for each session: its files are read for it.
  const std::string& key_of(std::size_t i) {
    if (!keys_[i].empty()) return keys_[i];
    const BatchSession& s = manifest_.sessions[i];
    std::vector<fs::path> inputs{s.session};
    std::string options =
        terminal_.options_toml + "seed " + std::to_string(terminal_.run.seed()) + "\n";
    // A topology that this batch makes is known by what it is made from.
    if (s.after) {
      options += key_of(*s.after);
    } else if (!s.topology.empty()) {
      inputs.push_back(s.topology);
    }
    return keys_[i] = batch_key(inputs, options, program_version());
  }

  static void fail(Outcome& o, ExitCode code, const std::string& reason) {
    o.state = State::failed;
    o.exit_code = static_cast<int>(code);
    o.reason = reason;
  }

  /// False when nothing can be started now.
  bool start_next(std::vector<Running>& running) {
    for (std::size_t i = 0; i < outcomes_.size(); ++i) {
      if (outcomes_[i].state != State::waiting) continue;
      if (const auto after = manifest_.sessions[i].after) {
        const State before = outcomes_[*after].state;
        if (before == State::waiting || before == State::running) continue;
        if (before == State::failed) {
          fail(outcomes_[i], ExitCode::invalid_input,
               "the session whose topology it takes failed: " + output(*after));
          return true;
        }
      }
      start(i, running);
      return true;
    }
    return false;
  }

  void start(std::size_t i, std::vector<Running>& running) {
    const BatchSession& s = manifest_.sessions[i];
    remove_leftovers(s.output);
    std::error_code ignored;
    fs::create_directories(s.output.parent_path(), ignored);
    const int threads = std::max(1, terminal_.run.threads() / jobs_);
    std::vector<std::string> words{"convert", s.session.string(), "-o", s.output.string()};
    if (!s.topology.empty()) words.insert(words.end(), {"--topology", s.topology.string()});
    words.insert(words.end(),
                 {"--config", beside("_options.toml").string(), "--json", "--seed",
                  std::to_string(terminal_.run.seed()), "--threads", std::to_string(threads)});
    outcomes_[i].state = State::running;
    running.push_back({i, std::make_unique<ChildProcess>(words), Clock::now()});
  }

  /// Whether the process that writes `.NAME.PID-N.tmp` still runs: then the file is its own.
  static bool is_being_written(const std::string& name) {
    const std::size_t end = name.rfind('-'), begin = name.rfind('.', end);
    if (end == std::string::npos || begin == std::string::npos) return false;
    const long pid = std::strtol(name.c_str() + begin + 1, nullptr, 10);
    return pid > 0 && (::kill(static_cast<pid_t>(pid), 0) == 0 || errno == EPERM);
  }

  /// Temporary files of a run that was cut short.
  static void remove_leftovers(const fs::path& output) {
    const std::string begin = "." + output.stem().string();
    std::error_code ignored;
    std::vector<fs::path> found;
    for (const auto& entry : fs::directory_iterator(output.parent_path(), ignored)) {
      const std::string name = entry.path().filename().string();
      if (name.starts_with(begin) && name.ends_with(".tmp") && !is_being_written(name)) {
        found.push_back(entry.path());
      }
    }
    for (const fs::path& path : found) fs::remove(path, ignored);
  }

  /// True when it has ended.
  bool collect(Running& r) {
    if (!r.child->ended()) return false;
    Outcome& o = outcomes_[r.index];
    o.seconds = std::chrono::duration<double>(Clock::now() - r.since).count();
    o.exit_code = r.child->exit_code();
    if (o.exit_code == 0) {
      succeed(r.index, r.child->out());
    } else if (terminal_.run.cancelled()) {
      o.state = State::cancelled;
    } else {
      fail(o, o.exit_code > 0 ? static_cast<ExitCode>(o.exit_code) : ExitCode::internal_error,
           reason_of(*r.child, manifest_.sessions[r.index].session));
    }
    if (!terminal_.run.cancelled()) {
      terminal_.run.info(manifest_.sessions[r.index].session.string() + ": " + word_of(o.state) +
                         (o.reason.empty() ? "" : ": " + o.reason));
    }
    const auto ended = std::ranges::count_if(outcomes_, [](const Outcome& other) {
      return other.state != State::waiting && other.state != State::running;
    });
    terminal_.run.progress(static_cast<double>(ended) / static_cast<double>(outcomes_.size()));
    return true;
  }

  void succeed(std::size_t i, const std::string& summary) {
    Outcome& o = outcomes_[i];
    const Json json = Json::parse(summary, nullptr, false);
    if (json.is_discarded()) {
      fail(o, ExitCode::internal_error, "the conversion said nothing about its result");
      return;
    }
    o.state = State::done;
    o.record.output = journal_.name_of(output(i));
    o.record.key = keys_[i];
    auto names = json.at("written").at("mesh_files").get<std::set<std::string>>();
    for (const Json& path : json.at("outputs")) names.insert(path.get<std::string>());
    for (const std::string& name : names) {
      std::error_code ignored;
      o.record.files.push_back({journal_.name_of(name), fs::file_size(name, ignored)});
    }
    o.record.vertices = json.at("mesh").at("vertices").get<std::size_t>();
    o.record.frames = json.at("session").at("frames").get<std::size_t>();
    o.record.warnings = json.at("doubtful").size();
    journal_.note(o.record);
  }

  /// After Ctrl-C: the conversions are asked to stop, and ended when they do not.
  void stop(std::vector<Running>& running) {
    for (const Running& r : running) r.child->interrupt();
    for (int waited = 0; waited < 40 && !running.empty(); ++waited) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      std::erase_if(running, [this](Running& r) { return collect(r); });
    }
    for (const Running& r : running) outcomes_[r.index].state = State::cancelled;
    running.clear();
  }

  Terminal& terminal_;
  BatchManifest manifest_;
  BatchJournal journal_;
  std::vector<Outcome> outcomes_;
  std::vector<std::string> keys_;
  int jobs_ = 1;
};

ExitCode run_batch(const Arguments& arguments, Terminal& terminal) {
  Batch batch(arguments, terminal);
  if (arguments.dry_run) {
    batch.plan();
  } else {
    batch.run();
  }
  terminal.run.progress(1.0);
  terminal.print(terminal.json ? batch.json() : batch.table());
  if (terminal.run.cancelled()) terminal.run.warn("cancelled; --resume goes on from here");
  return batch.exit_code();
}

}  // namespace

CommandSpec batch_command() {
  return {.path = "batch",
          .summary = "Convert many sessions with one set of options",
          .example =
              "kinemesh batch study.toml --jobs 4\n"
              "kinemesh batch study.csv -o results --config options.toml --resume",
          .setup = [](CommandLine& line) -> Action {
            auto args = std::make_shared<Arguments>();
            line.positional(
                "MANIFEST", args->manifest,
                "The sessions: TOML ([[session]] tables) or CSV (session,output,topology)");
            line.option("-o,--output", args->folder, "FOLDER",
                        "Where the results go, instead of the folder that the manifest names");
            line.option("--jobs", args->jobs, "N",
                        "Sessions at the same time; 0 means as many as there are threads");
            line.flag("--resume", args->resume,
                      "Leave out what was finished before from the same input and options");
            line.flag("--dry-run", args->dry_run, "Say what would be done, and do nothing");
            line.parameters([args](ParameterSet& p) { args->options.declare(p); },
                            [args]() -> ConfigText {
                              if (args->manifest.empty()) return {};  // --dump-config, or an error
                              const BatchManifest m = read_batch_manifest(args->manifest);
                              return {m.options_toml, args->manifest};
                            });
            line.json_output();
            return [args](Terminal& terminal) { return run_batch(*args, terminal); };
          }};
}

}  // namespace kinemesh::cli
