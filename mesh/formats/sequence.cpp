#include "mesh/formats/sequence.h"

#include <algorithm>
#include <charconv>
#include <map>

#include "config/error.h"
#include "config/text.h"

namespace kinemesh {
namespace fs = std::filesystem;
namespace {

/// A file name with a number in it: what stands before and after, and its least width.
struct NamePattern {
  std::string before, after;
  std::size_t width = 1;
};

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// The parts of "a_####.ply" or "a_%04d.ply"; width 0 when there is no number pattern.
NamePattern parse_pattern(const std::string& name) {
  NamePattern pattern{name, "", 0};
  if (const auto hash = name.rfind('#'); hash != std::string::npos) {
    std::size_t begin = hash;
    while (begin > 0 && name[begin - 1] == '#') --begin;
    return {name.substr(0, begin), name.substr(hash + 1), hash + 1 - begin};
  }
  const auto percent = name.find('%');
  if (percent == std::string::npos) return pattern;
  std::size_t end = percent + 1;
  while (end < name.size() && is_digit(name[end])) ++end;
  if (end >= name.size() || name[end] != 'd') return pattern;
  std::size_t width = 1;
  if (end > percent + 1) std::from_chars(&name[percent + 1], &name[end], width);
  return {name.substr(0, percent), name.substr(end + 1), std::clamp<std::size_t>(width, 1, 18)};
}

fs::path folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

/// The number in `digits`, or −1 when it is none or too long.
int64_t number_of(std::string_view digits) {
  if (digits.empty() || !std::all_of(digits.begin(), digits.end(), is_digit)) return -1;
  int64_t number = -1;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  return error == std::errc() ? number : -1;
}

std::vector<fs::path> entries_of(const fs::path& folder) {
  std::vector<fs::path> all;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    all.push_back(it->path());
  }
  if (error) {
    throw InputError({.what = "cannot read the folder: " + error.message(),
                      .file = folder.string(),
                      .remedy = "Check the path and its spelling"});
  }
  std::sort(all.begin(), all.end());
  return all;
}

std::vector<NumberedFile> sorted(std::vector<NumberedFile> files) {
  std::stable_sort(files.begin(), files.end(), [](const NumberedFile& a, const NumberedFile& b) {
    return a.number < b.number;
  });
  for (std::size_t i = 1; i < files.size(); ++i) {
    if (files[i].number != files[i - 1].number) continue;
    throw InputError({.what = "two files of the sequence have the number " +
                              std::to_string(files[i].number) + ": this one and " +
                              files[i - 1].path.filename().string(),
                      .file = files[i].path.string(),
                      .remedy = "Name the files by a pattern such as face_####.ply"});
  }
  return files;
}

}  // namespace

bool is_number_pattern(const fs::path& path) {
  return parse_pattern(path.filename().string()).width > 0;
}

std::vector<NumberedFile> matching_files(const fs::path& path) {
  std::error_code ignored;
  if (!fs::is_directory(folder_of(path), ignored)) return {};
  const NamePattern pattern = parse_pattern(path.filename().string());
  std::vector<NumberedFile> found;
  for (const fs::path& entry : entries_of(folder_of(path))) {
    const std::string name = entry.filename().string();
    if (name.size() < pattern.before.size() + pattern.width + pattern.after.size()) continue;
    if (!name.starts_with(pattern.before) || !name.ends_with(pattern.after)) continue;
    const int64_t number = number_of(std::string_view(name).substr(
        pattern.before.size(), name.size() - pattern.before.size() - pattern.after.size()));
    if (number >= 0) found.push_back({path.parent_path() / entry.filename(), number});
  }
  return found;
}

std::vector<NumberedFile> files_of_pattern(const fs::path& path) {
  std::vector<NumberedFile> found = matching_files(path);
  if (found.empty()) {
    throw InputError({.what = "no file matches this pattern",
                      .file = path.string(),
                      .remedy = "Every # stands for one digit, the last for one or more"});
  }
  return sorted(std::move(found));
}

std::vector<NumberedFile> files_of_folder(const fs::path& folder,
                                          const std::vector<std::string>& extensions) {
  std::map<std::string, std::vector<NumberedFile>> sequences;  // by name without the number
  for (const fs::path& entry : entries_of(folder)) {
    const std::string extension = entry.extension().string();
    if (std::find(extensions.begin(), extensions.end(), lower(extension)) == extensions.end()) {
      continue;
    }
    const std::string stem = entry.stem().string();
    if (stem.starts_with('.')) continue;
    std::size_t digits = stem.size();
    while (digits > 0 && is_digit(stem[digits - 1])) --digits;
    const int64_t number = number_of(std::string_view(stem).substr(digits));
    if (number < 0) continue;
    sequences[stem.substr(0, digits) + "####" + extension].push_back({entry, number});
  }
  if (sequences.size() == 1) return sorted(std::move(sequences.begin()->second));
  if (sequences.empty()) {
    throw InputError({.what = "the folder holds no numbered mesh files",
                      .file = folder.string(),
                      .remedy = "Readable are " + join(extensions, ", ", " and ")});
  }
  std::vector<std::string> names;
  for (const auto& [name, files] : sequences) names.push_back(name);
  if (names.size() > 8) names.resize(8);
  throw InputError({.what = "the folder holds several numbered sequences: " + join(names, ", "),
                    .file = folder.string(),
                    .remedy = "Name one of them by its pattern"});
}

fs::path numbered_path(const fs::path& path, int64_t number, int digits) {
  NamePattern pattern = parse_pattern(path.filename().string());
  if (pattern.width == 0) {
    pattern = {path.stem().string() + "_", path.extension().string(),
               static_cast<std::size_t>(std::max(digits, 1))};
  }
  std::string text = std::to_string(number);
  if (text.size() < pattern.width) text.insert(0, pattern.width - text.size(), '0');
  return path.parent_path() / (pattern.before + text + pattern.after);
}

}  // namespace kinemesh
