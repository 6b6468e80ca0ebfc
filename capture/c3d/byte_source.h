// Bytes of a C3D file, from disk or from memory, read piece by piece.
#pragma once

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "config/input_file.h"

namespace kinemesh {

class ByteSource {
 public:
  ByteSource() = default;
  ByteSource(const ByteSource&) = delete;
  ByteSource& operator=(const ByteSource&) = delete;
  virtual ~ByteSource() = default;
  virtual std::string name() const = 0;
  virtual std::size_t size() const = 0;
  /// Returns how many bytes there were; fewer than asked for at the end of the source.
  virtual std::size_t read_at(std::size_t offset, void* into, std::size_t bytes) const = 0;

  /// Up to `bytes` bytes from `offset`; shorter where the source ends.
  std::vector<std::byte> bytes_at(std::size_t offset, std::size_t bytes) const {
    std::vector<std::byte> all(offset < size() ? std::min(bytes, size() - offset) : 0);
    if (!all.empty()) all.resize(read_at(offset, all.data(), all.size()));
    return all;
  }
};

class FileSource final : public ByteSource {
 public:
  /// Throws InputError as InputFile does.
  explicit FileSource(const std::filesystem::path& path) : file_(path) {}
  std::string name() const override { return file_.path().string(); }
  std::size_t size() const override { return file_.size(); }
  std::size_t read_at(std::size_t offset, void* into, std::size_t bytes) const override {
    return file_.read_at(offset, into, bytes);
  }

 private:
  InputFile file_;
};

class MemorySource final : public ByteSource {
 public:
  MemorySource(std::span<const std::byte> bytes, std::string name)
      : bytes_(bytes), name_(std::move(name)) {}
  std::string name() const override { return name_; }
  std::size_t size() const override { return bytes_.size(); }
  std::size_t read_at(std::size_t offset, void* into, std::size_t bytes) const override {
    if (offset >= bytes_.size()) return 0;
    const std::size_t count = std::min(bytes, bytes_.size() - offset);
    std::copy_n(bytes_.data() + offset, count, static_cast<std::byte*>(into));
    return count;
  }

 private:
  std::span<const std::byte> bytes_;
  std::string name_;
};

}  // namespace kinemesh
