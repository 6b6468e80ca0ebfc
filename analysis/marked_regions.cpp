#include "analysis/marked_regions.h"

#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "config/error.h"
#include "config/input_file.h"
#include "config/json_text.h"
#include "config/text.h"
#include "mesh/formats/ply_header.h"

namespace kinemesh {
namespace {

[[noreturn]] void refuse(const std::string& file, const std::string& what) {
  throw InputError({.what = what,
                    .file = file,
                    .remedy = "Give a JSON list of vertices, or a PLY with vertex colours"});
}

void mark_json(const nlohmann::json& entry, std::vector<uint8_t>& marked, const std::string& file,
               int depth) {
  if (entry.is_array() && depth < 8) {
    for (const auto& item : entry) mark_json(item, marked, file, depth + 1);
    return;
  }
  const double value = entry.is_number() ? entry.get<double>() : -1.0;
  if (!(value >= 0.0) || value != std::floor(value) ||
      value >= static_cast<double>(marked.size())) {
    refuse(file, "an entry is no vertex of the mesh, which has " + std::to_string(marked.size()));
  }
  marked[static_cast<std::size_t>(value)] = 1;
}

/// Red, green and blue of each vertex, ASCII or binary.
void mark_ply(const std::string& text, std::vector<uint8_t>& marked, const std::string& file) {
  const PlyHeader header = parse_ply_header(text, file);
  if (header.elements.empty() || header.elements[0].name != "vertex" ||
      header.elements[0].has_list()) {
    refuse(file, "the vertices do not come first");
  }
  const PlyElement& vertices = header.elements[0];
  if (vertices.count != marked.size()) {
    refuse(file, "it has " + std::to_string(vertices.count) + " vertices, but the mesh " +
                     std::to_string(marked.size()));
  }
  const std::array<int, 3> channels{vertices.find("red"), vertices.find("green"),
                                    vertices.find("blue")};
  for (const int c : channels) {
    if (c < 0 || vertices.properties[static_cast<std::size_t>(c)].type != PlyType::u8) {
      refuse(file, "the vertices have no colours of 8 bits");
    }
  }
  std::string_view rest = std::string_view(text).substr(std::min(header.size, text.size()));
  for (std::size_t v = 0; v < marked.size(); ++v) {
    std::array<int, 3> colour{};
    if (header.order == PlyHeader::Order::ascii) {
      const std::size_t end = std::min(rest.find('\n'), rest.size());
      std::string_view line = rest.substr(0, end);
      rest.remove_prefix(std::min(end + 1, rest.size()));
      for (int p = 0; p < static_cast<int>(vertices.properties.size()); ++p) {
        line.remove_prefix(std::min(line.find_first_not_of(" \t\r"), line.size()));
        const std::size_t word = std::min(line.find_first_of(" \t\r"), line.size());
        for (std::size_t c = 0; c < 3; ++c) {
          if (channels[c] != p) continue;
          if (std::from_chars(line.data(), line.data() + word, colour[c]).ec != std::errc()) {
            refuse(file, "the colour of vertex " + std::to_string(v) + " cannot be read");
          }
        }
        line.remove_prefix(word);
      }
    } else {
      if (rest.size() < vertices.stride()) refuse(file, "it ends within its vertices");
      for (std::size_t c = 0; c < 3; ++c) {
        std::size_t offset = 0;
        for (int p = 0; p < channels[c]; ++p) {
          offset += size_of(vertices.properties[static_cast<std::size_t>(p)].type);
        }
        colour[c] = static_cast<unsigned char>(rest[offset]);
      }
      rest.remove_prefix(vertices.stride());
    }
    marked[v] = colour[0] != colour[1] || colour[1] != colour[2] ? 1 : 0;
  }
}

}  // namespace

std::vector<double> read_marked_regions(const std::vector<std::filesystem::path>& files,
                                        std::size_t vertex_count) {
  std::vector<double> share(vertex_count, 0.0);
  for (const auto& file : files) {
    const std::string text = read_file(file, std::size_t{1} << 31U);
    std::vector<uint8_t> marked(vertex_count, 0);
    if (lower(file.extension().string()) == ".ply") {
      mark_ply(text, marked, file.string());
    } else {
      refuse_deep_json(text, file.string());
      const auto json = nlohmann::json::parse(text, nullptr, false);
      if (json.is_discarded()) refuse(file.string(), "the file is not JSON");
      mark_json(json.is_object() && json.contains("regions") ? json["regions"] : json, marked,
                file.string(), 0);
    }
    for (std::size_t v = 0; v < vertex_count; ++v) {
      share[v] += marked[v] != 0 ? 1.0 / static_cast<double>(files.size()) : 0.0;
    }
  }
  return share;
}

}  // namespace kinemesh
