#include "config/input_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "config/error.h"

namespace kinemesh {
namespace {

std::string kind_of(mode_t mode) {
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISFIFO(mode)) return "a named pipe";
  if (S_ISSOCK(mode)) return "a socket";
  return "a device";
}

}  // namespace

InputFile::InputFile(std::filesystem::path path) : path_(std::move(path)) {
  const auto refuse = [this](const std::string& what, const std::string& remedy) {
    if (fd_ >= 0) ::close(fd_);
    throw InputError({.what = what, .file = path_.string(), .remedy = remedy});
  };
  // O_NONBLOCK: opening a FIFO that nobody writes to must not hang.
  fd_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd_ < 0) {
    const int error = errno;
    refuse(std::string("cannot read: ") + std::strerror(error),
           error == ENOENT ? "Check the path and its spelling" : "");
  }
  struct stat status {};
  if (::fstat(fd_, &status) != 0) refuse(std::string("cannot read: ") + std::strerror(errno), "");
  if (!S_ISREG(status.st_mode)) {
    refuse("cannot read: this is " + kind_of(status.st_mode) + ", not a file", "Give a file");
  }
  size_ = static_cast<std::size_t>(status.st_size);
}

InputFile::~InputFile() {
  if (fd_ >= 0) ::close(fd_);
}

std::size_t InputFile::read_at(std::size_t offset, void* into, std::size_t bytes) const {
  std::size_t done = 0;
  while (done < bytes) {
    const ssize_t got = ::pread(fd_, static_cast<char*>(into) + done, bytes - done,
                                static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) {
      throw InputError({.what = std::string("cannot read: ") + std::strerror(errno),
                        .file = path_.string(),
                        .place = "byte " + std::to_string(offset + done)});
    }
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  return done;
}

std::string read_file(const std::filesystem::path& path, std::size_t max_bytes) {
  const InputFile file(path);
  if (file.size() > max_bytes) {
    throw InputError({.what = "the file has " + std::to_string(file.size()) +
                              " bytes, more than the " + std::to_string(max_bytes) +
                              " that such a file can have",
                      .file = path.string()});
  }
  std::string content(file.size(), '\0');
  content.resize(file.read_at(0, content.data(), content.size()));
  return content;
}

}  // namespace kinemesh
