// What a batch has finished, kept so that it can go on after Ctrl-C or a power cut.
//
// A file of one JSON object a line, appended to and flushed to the disk after each session; a line
// that was cut off is ignored. A session counts as finished when its last line was written for the
// same input, the same options and the same program, and its outputs are there with their sizes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace kinemesh {

/// Paths are relative to the journal's folder, so that it serves from any working folder and goes
/// with the folder when that is moved.
struct BatchRecord {
  struct File {
    std::string path;
    uint64_t bytes = 0;
  };
  std::string output;  ///< of the mesh: which session this is
  std::string key;     ///< batch_key() of what it was made from
  std::vector<File> files;
  std::size_t vertices = 0, frames = 0, warnings = 0;
};

/// Changes with the content of the inputs, the options and the program's version. Missing files
/// count by their name.
std::string batch_key(const std::vector<std::filesystem::path>& inputs, const std::string& options,
                      const std::string& program);

class BatchJournal {
 public:
  /// Reads what is there, or (with `resume` false) begins anew. Throws InputError when the file
  /// can be neither read nor written.
  BatchJournal(std::filesystem::path file, bool resume);
  /// `path` as records name it.
  std::string name_of(const std::filesystem::path& path) const;
  /// The finished session of this output and key, or null.
  const BatchRecord* finished(const std::string& output, const std::string& key) const;
  /// Flushes the files of the record to the disk, then notes it.
  void note(BatchRecord record);

 private:
  std::filesystem::path file_;
  std::map<std::string, BatchRecord> records_;
};

}  // namespace kinemesh
