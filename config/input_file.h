// Reading regular files, and nothing else: folders, FIFOs and devices are refused with a reason.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace kinemesh {

/// A regular file opened for reading. Reads never map memory, so a file that shrinks meanwhile
/// gives a short read, not a signal.
class InputFile {
 public:
  /// Throws InputError naming the path when it is missing, unreadable, or no regular file.
  explicit InputFile(std::filesystem::path path);
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;
  ~InputFile();

  const std::filesystem::path& path() const { return path_; }
  /// Size when it was opened, in bytes.
  std::size_t size() const { return size_; }
  /// Reads up to `bytes` at `offset`; returns how many there were. Throws InputError on I/O errors.
  std::size_t read_at(std::size_t offset, void* into, std::size_t bytes) const;

 private:
  std::filesystem::path path_;
  int fd_ = -1;
  std::size_t size_ = 0;
};

/// The whole file. Throws InputError, also when it is larger than `max_bytes`.
std::string read_file(const std::filesystem::path& path,
                      std::size_t max_bytes = std::size_t{1} << 40);

/// SHA-256 of a regular file as 64 lower-case hex digits.
std::string sha256_of_file(const std::filesystem::path& path);
std::string sha256_of(std::string_view bytes);

}  // namespace kinemesh
