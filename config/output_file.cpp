#include "config/output_file.h"

#include <algorithm>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <utility>

#include "config/error.h"

namespace kinemesh {
namespace fs = std::filesystem;
namespace {

fs::path folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

std::string remedy_for(int error) {
  switch (error) {
    case ENOENT: return "Check the spelling of the folder";
    case EACCES:
    case EPERM:
    case EROFS: return "Choose a folder in which you may write";
    case ENOSPC:
    case EDQUOT: return "Free some disk space, or write to another disk";
    default: return "";
  }
}

/// A name that no other process or thread uses.
fs::path temporary_for(const fs::path& path) {
  static std::atomic<unsigned> counter{0};
  return folder_of(path) / ("." + path.filename().string() + "." + std::to_string(::getpid()) +
                            "-" + std::to_string(counter++) + ".tmp");
}

}  // namespace

NewFolders::~NewFolders() {
  std::error_code ignored;
  for (; !created_.empty(); created_.pop_back()) {
    fs::remove(created_.back(), ignored);  // only when empty
  }
}

void NewFolders::create(const fs::path& folder) {
  std::error_code error;
  if (folder.empty() || fs::is_directory(folder, error)) return;
  create(folder.parent_path());
  fs::create_directory(folder, error);
  if (error) {
    throw InputError({.what = "cannot create the folder: " + error.message(),
                      .file = folder.string(),
                      .remedy = remedy_for(error.value())});
  }
  created_.push_back(folder);
}

void NewFolders::take_over(NewFolders& other) {
  created_.insert(created_.end(), other.created_.begin(), other.created_.end());
  other.created_.clear();
}

OutputFile::OutputFile(fs::path path) : path_(std::move(path)), temporary_(temporary_for(path_)) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path_, ignored);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw InputError({.what = fs::is_directory(status) ? "cannot write: this is a folder"
                                                       : "cannot write: this is no regular file",
                      .file = path_.string(),
                      .remedy = "Give the name of a file"});
  }
  folders_.create(folder_of(path_));
  const int fd = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (fd >= 0) handle_ = ::fdopen(fd, "wb");
  if (handle_ == nullptr) {
    const int error = errno;
    if (fd >= 0) ::close(fd);
    throw InputError({.what = std::string("cannot write: ") + std::strerror(error),
                      .file = path_.string(),
                      .remedy = remedy_for(error)});
  }
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : folders_(std::move(other.folders_)),
      path_(std::move(other.path_)),
      temporary_(std::move(other.temporary_)),
      handle_(std::exchange(other.handle_, nullptr)),
      position_(other.position_),
      done_(std::exchange(other.done_, true)) {}

OutputFile::~OutputFile() {
  if (handle_ != nullptr) std::fclose(handle_);
  if (!done_) ::unlink(temporary_.c_str());
}

void OutputFile::fail(const std::string& doing) {
  const int error = errno;
  throw InputError({.what = "cannot " + doing + ": " + std::strerror(error),
                    .file = path_.string(),
                    .remedy = remedy_for(error)});
}

void OutputFile::write(std::string_view text) { write(text.data(), text.size()); }

void OutputFile::write(const void* data, std::size_t bytes) {
  if (bytes == 0) return;
  if (handle_ == nullptr) throw InternalError("writing to a closed output file");
  if (std::fwrite(data, 1, bytes, handle_) != bytes) fail("write");
  position_ += bytes;
}

void OutputFile::seek(std::size_t position) {
  if (::fseeko(handle_, static_cast<off_t>(position), SEEK_SET) != 0) fail("write");
  position_ = position;
}

void OutputFile::release_handle() {
  if (handle_ == nullptr) return;
  if (std::fclose(std::exchange(handle_, nullptr)) != 0) fail("write");
}

void OutputFile::finish() { release_handle(); }

void OutputFile::publish() {
  if (::rename(temporary_.c_str(), path_.c_str()) != 0) fail("write");
  done_ = true;
  folders_.keep();
}

void OutputFile::commit() {
  finish();
  publish();
}

void OutputSet::add(const fs::path& path, std::string_view content) {
  OutputFile file(path);
  file.write(content);
  add(std::move(file));
}

void OutputSet::add(OutputFile file) {
  file.finish();
  folders_.take_over(file.folders_);
  files_.push_back(std::move(file));
}

void OutputSet::commit() {
  for (OutputFile& file : files_) file.publish();
  folders_.keep();
}

std::vector<fs::path> OutputSet::paths() const {
  std::vector<fs::path> all;
  all.reserve(files_.size());
  for (const OutputFile& file : files_) all.push_back(file.path());
  return all;
}

void refuse_to_replace(const std::vector<fs::path>& inputs, const std::vector<fs::path>& outputs) {
  for (const fs::path& output : outputs) {
    for (const fs::path& input : inputs) {
      std::error_code ignored;
      if (input.empty() || output.empty() || !fs::equivalent(input, output, ignored)) continue;
      throw UsageError({.what = "the output would replace the input",
                        .file = output.string(),
                        .remedy = "Give another name for what is written"});
    }
    if (!output.empty() && std::ranges::count(outputs, output) > 1) {
      throw UsageError({.what = "two outputs have the same name", .file = output.string()});
    }
  }
}

void write_file(const fs::path& path, std::string_view content) {
  OutputFile file(path);
  file.write(content);
  file.commit();
}

}  // namespace kinemesh
