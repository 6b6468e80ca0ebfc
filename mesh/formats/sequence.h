// Numbered files: frame_0001.ply, frame_0002.ply, …
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace kinemesh {

struct NumberedFile {
  std::filesystem::path path;
  int64_t number = 0;
};

/// True when the file name holds a run of `#` or a printf pattern such as %04d.
bool is_number_pattern(const std::filesystem::path& path);

/// The existing files that match the pattern, by number. A run of n # matches n digits or more.
/// Throws InputError when there are none, or two have the same number.
std::vector<NumberedFile> files_of_pattern(const std::filesystem::path& pattern);

/// The existing files that match the pattern, in no particular order; none when the folder is not
/// there.
std::vector<NumberedFile> matching_files(const std::filesystem::path& pattern);

/// The numbered files of a folder, by number, of those whose extension is among `extensions`
/// (lower case, with the dot). Throws InputError when there are none or several sequences.
std::vector<NumberedFile> files_of_folder(const std::filesystem::path& folder,
                                          const std::vector<std::string>& extensions);

/// The pattern with the number in place of #### or %04d, padded with zeros; for a path without
/// one, "_####" is put before the extension. `digits` is the least width of the latter.
std::filesystem::path numbered_path(const std::filesystem::path& pattern, int64_t number,
                                    int digits = 4);

}  // namespace kinemesh
