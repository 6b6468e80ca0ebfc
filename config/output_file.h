// Files that appear whole or not at all: written under a temporary name beside their place, and
// renamed on commit.
#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace kinemesh {

/// Folders made for outputs: removed again, if they are empty, unless they are kept.
class NewFolders {
 public:
  NewFolders() = default;
  NewFolders(NewFolders&& other) noexcept : created_(std::move(other.created_)) {
    other.created_.clear();
  }
  NewFolders& operator=(NewFolders&&) = delete;
  ~NewFolders();
  /// Creates the folder and its parents where they are missing. Throws InputError.
  void create(const std::filesystem::path& folder);
  void take_over(NewFolders& other);
  void keep() { created_.clear(); }

 private:
  std::vector<std::filesystem::path> created_;  // parents first
};

/// One file being written. Destroyed without commit(), it leaves nothing behind.
class OutputFile {
 public:
  /// Creates the folder if it is missing. Throws InputError naming the path and the remedy when
  /// that is impossible or the folder is not writable, or when the path names something that is no
  /// regular file.
  explicit OutputFile(std::filesystem::path path);
  OutputFile(OutputFile&&) noexcept;
  OutputFile& operator=(OutputFile&&) = delete;
  ~OutputFile();

  const std::filesystem::path& path() const { return path_; }
  void write(std::string_view text);
  void write(const void* data, std::size_t bytes);
  template <class T>
  void write(std::span<const T> values) {
    write(values.data(), values.size_bytes());
  }
  /// Absolute position, for headers that are known only at the end.
  void seek(std::size_t position);
  std::size_t position() const { return position_; }

  /// Path of the temporary, for libraries that insist on a file name. Call release_handle() first.
  const std::filesystem::path& temporary() const { return temporary_; }
  /// Closes the handle, so that another library may write temporary().
  void release_handle();

  /// Flushes, closes and renames. Throws InputError on a full disk; then nothing is left.
  void commit();

 private:
  friend class OutputSet;
  void finish();   // flush and close
  void publish();  // rename
  [[noreturn]] void fail(const std::string& doing);

  NewFolders folders_;
  std::filesystem::path path_;
  std::filesystem::path temporary_;
  std::FILE* handle_ = nullptr;
  std::size_t position_ = 0;
  bool done_ = false;
};

/// Files that belong together (PLY + PC2, numbered frames): all are complete before the first is
/// renamed. Folders created for them are removed again when the set is not committed.
class OutputSet {
 public:
  OutputSet() = default;
  OutputSet(const OutputSet&) = delete;
  OutputSet& operator=(const OutputSet&) = delete;

  /// Creates the folder (and its parents) if it is missing.
  void create_folder(const std::filesystem::path& folder) { folders_.create(folder); }
  /// Adds a whole file at once and closes it, so that thousands can be pending.
  void add(const std::filesystem::path& path, std::string_view content);
  /// Adds a file that was written piece by piece.
  void add(OutputFile file);
  void commit();
  /// Paths added so far, in order.
  std::vector<std::filesystem::path> paths() const;

 private:
  NewFolders folders_;  // outlives the files in it
  std::vector<OutputFile> files_;
};

/// Throws UsageError when one of the outputs is one of the inputs, by whatever name (what was
/// recorded is never replaced), or two outputs have the same name. Empty paths and files that do
/// not exist are passed over.
void refuse_to_replace(const std::vector<std::filesystem::path>& inputs,
                       const std::vector<std::filesystem::path>& outputs);

/// Writes a whole file atomically.
void write_file(const std::filesystem::path& path, std::string_view content);

}  // namespace kinemesh
