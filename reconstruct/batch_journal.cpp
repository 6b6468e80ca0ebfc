#include "reconstruct/batch_journal.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>

#include "config/error.h"
#include "config/input_file.h"

namespace kinemesh {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

[[noreturn]] void fail(const fs::path& file, const char* doing) {
  throw InputError({.what = std::string("cannot ") + doing + ": " + std::strerror(errno),
                    .file = file.string()});
}

/// Waits until the disk has it.
void flush_to_disk(const fs::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return;
  ::fsync(fd);
  ::close(fd);
}

void append_line(const fs::path& file, const std::string& line) {
  const int fd = ::open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (fd < 0) fail(file, "write");
  const bool written = ::write(fd, line.data(), line.size()) == static_cast<ssize_t>(line.size()) &&
                       ::fsync(fd) == 0;
  if (::close(fd) != 0 || !written) fail(file, "write");
}

Json json_of(const BatchRecord& record) {
  Json files = Json::array();
  for (const BatchRecord::File& file : record.files) files.push_back({file.path, file.bytes});
  return {{"output", record.output},     {"key", record.key},       {"files", files},
          {"vertices", record.vertices}, {"frames", record.frames}, {"warnings", record.warnings}};
}

BatchRecord record_of(const Json& json) {
  BatchRecord record;
  record.output = json.at("output").get<std::string>();
  record.key = json.at("key").get<std::string>();
  for (const Json& file : json.at("files")) {
    record.files.push_back({file.at(0).get<std::string>(), file.at(1).get<uint64_t>()});
  }
  record.vertices = json.at("vertices").get<std::size_t>();
  record.frames = json.at("frames").get<std::size_t>();
  record.warnings = json.at("warnings").get<std::size_t>();
  return record;
}

}  // namespace

std::string batch_key(const std::vector<fs::path>& inputs, const std::string& options,
                      const std::string& program) {
  std::string text = program + "\n" + options + "\n";
  for (const fs::path& input : inputs) {
    std::error_code ignored;
    text += fs::is_regular_file(input, ignored) ? sha256_of_file(input) : input.string();
    text += '\n';
  }
  return sha256_of(text);
}

BatchJournal::BatchJournal(fs::path file, bool resume) : file_(std::move(file)) {
  std::error_code ignored;
  if (!fs::exists(file_, ignored)) return;
  if (!resume) {
    if (!fs::remove(file_, ignored)) fail(file_, "remove");
    return;
  }
  std::istringstream lines(read_file(file_));
  for (std::string line; std::getline(lines, line);) {
    try {
      const BatchRecord record = record_of(Json::parse(line));
      records_[record.output] = record;
    } catch (const Json::exception&) {
      continue;  // cut off by a crash: that session is done again
    }
  }
}

std::string BatchJournal::name_of(const fs::path& path) const {
  const fs::path folder = fs::absolute(file_).lexically_normal().parent_path();
  return fs::absolute(path).lexically_normal().lexically_proximate(folder).string();
}

const BatchRecord* BatchJournal::finished(const std::string& output, const std::string& key) const {
  const auto at = records_.find(output);
  if (at == records_.end() || at->second.key != key) return nullptr;
  for (const BatchRecord::File& file : at->second.files) {
    std::error_code error;
    const auto size = fs::file_size(file_.parent_path() / file.path, error);
    if (error || size != file.bytes) return nullptr;
  }
  return &at->second;
}

void BatchJournal::note(BatchRecord record) {
  const fs::path folder = file_.parent_path();
  for (const BatchRecord::File& file : record.files) flush_to_disk(folder / file.path);
  if (!record.files.empty()) {
    const fs::path first = folder / record.files.front().path;
    flush_to_disk(first.has_parent_path() ? first.parent_path() : fs::path("."));
  }
  // A line that was cut off before must not swallow this one.
  append_line(file_,
              "\n" + json_of(record).dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
  records_[record.output] = std::move(record);
}

}  // namespace kinemesh
