#include "mesh/formats/beside.h"

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>

#include "config/text.h"
#include "mesh/formats/bytes.h"
#include "mesh/formats/gltf.h"
#include "mesh/formats/vtp.h"

namespace kinemesh {
namespace fs = std::filesystem;
namespace {

/// Files of the buffers of a glTF file that was read before; none of a GLB file.
std::vector<fs::path> buffer_files(const fs::path& path) {
  const Buffer<std::byte> bytes = load_bytes(path);
  const std::string_view text = text_of(bytes.span());
  const auto json = nlohmann::json::parse(text.begin(), text.end(), nullptr, false);
  std::vector<fs::path> files;
  if (!json.is_object() || !json.contains("buffers") || !json["buffers"].is_array()) return files;
  for (const auto& buffer : json["buffers"]) {
    if (!buffer.is_object() || !buffer.contains("uri") || !buffer["uri"].is_string()) continue;
    const auto uri = buffer["uri"].get<std::string>();
    if (!uri.starts_with("data:")) files.push_back(path.parent_path() / decoded_uri(uri));
  }
  return files;
}

std::vector<fs::path> collected_files(const fs::path& path) {
  const Buffer<std::byte> bytes = load_bytes(path);
  std::vector<fs::path> files;
  for (const PvdEntry& entry : decode_pvd(bytes.span(), path.string())) {
    files.push_back(path.parent_path() / entry.file);
  }
  return files;
}

}  // namespace

std::optional<fs::path> file_beside(const fs::path& path, const std::string& extension) {
  std::string capitals = extension;
  std::ranges::transform(capitals, capitals.begin(),
                         [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  for (const std::string& written : {extension, capitals}) {
    fs::path beside = path;
    beside.replace_extension(written);
    std::error_code ignored;
    if (fs::is_regular_file(beside, ignored)) return beside;
  }
  return std::nullopt;
}

std::vector<fs::path> files_read_with(const Format& format, const fs::path& path) {
  if (format.name == "gltf") return buffer_files(path);
  if (format.name == "pvd") return collected_files(path);
  for (const std::string& extension : format.geometry_extensions) {
    if (const auto geometry = file_beside(path, extension)) return {*geometry};
  }
  return {};
}

std::vector<fs::path> caches_beside(const FormatRegistry& formats, const fs::path& path) {
  const std::string extension = lower(path.extension().string());
  std::vector<fs::path> caches;
  for (const Format& format : formats.formats()) {
    const auto& geometry = format.geometry_extensions;
    if (!format.can_read() || std::ranges::count(geometry, extension) == 0) continue;
    if (const auto cache = file_beside(path, format.extensions.front())) caches.push_back(*cache);
  }
  return caches;
}

}  // namespace kinemesh
