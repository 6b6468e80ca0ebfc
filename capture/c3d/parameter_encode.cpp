// encode_section() of parameter_section.h.
#include <algorithm>
#include <array>
#include <cmath>

#include "capture/c3d/header_block.h"
#include "capture/c3d/number_format.h"
#include "capture/c3d/parameter_section.h"

namespace kinemesh {
namespace {

constexpr std::size_t max_name = 127;
constexpr std::size_t max_text = 255;
constexpr std::size_t max_record = 65'535;

struct Encoder {
  Processor processor;
  std::vector<std::string>& losses;
  std::string bytes;

  std::string name_of(const std::string& name) {
    if (name.size() <= max_name) return name;
    losses.push_back("the name " + name.substr(0, 20) + "… is cut to 127 bytes");
    return name.substr(0, max_name);
  }
  std::string description_of(const std::string& name, const std::string& text) {
    if (text.size() <= max_text) return text;
    losses.push_back("the description of " + name + " is cut to 255 bytes");
    return text.substr(0, max_text);
  }

  /// One record: name, group, pointer over `body` and the description, body, description.
  void record(const std::string& full_name, bool locked, int id, const std::string& body,
              const std::string& text) {
    const std::string name = name_of(full_name);
    const std::string description = description_of(full_name, text);
    const std::size_t pointer = 2 + body.size() + 1 + description.size();
    if (name.empty()) return;
    if (pointer > max_record) {
      losses.push_back("parameter " + full_name + " has over 65535 bytes and is left out");
      return;
    }
    const auto length = static_cast<int>(name.size());
    bytes += static_cast<char>(locked ? -length : length);
    bytes += static_cast<char>(id);
    bytes += name;
    append_u16(bytes, static_cast<uint16_t>(pointer), processor);
    bytes += body;
    bytes += static_cast<char>(description.size());
    bytes += description;
  }

  void parameter(const C3dGroup& group, const C3dParameter& p, int id);
  void append_number(C3dType type, double value, bool& clipped);
  std::string values;  // of the parameter being encoded
};

void Encoder::append_number(C3dType type, double value, bool& clipped) {
  if (type == C3dType::real) {
    append_real(values, static_cast<float>(value), processor);
    return;
  }
  // Integers may be meant as unsigned: everything that 16 bits can mean is kept.
  const double low = type == C3dType::byte ? -128.0 : -32768.0;
  const double high = type == C3dType::byte ? 255.0 : 65535.0;
  const double kept = std::isfinite(value) ? std::clamp(std::round(value), low, high) : 0.0;
  clipped = clipped || kept != value;
  const auto integer = static_cast<int32_t>(kept);
  if (type == C3dType::byte) {
    values += static_cast<char>(integer & 0xFF);
  } else {
    append_u16(values, static_cast<uint16_t>(integer & 0xFFFF), processor);
  }
}

void Encoder::parameter(const C3dGroup& group, const C3dParameter& p, int id) {
  const std::string name = group.name + ":" + p.name;
  const std::size_t dimensions = std::min<std::size_t>(p.dimensions.size(), 255);
  std::size_t count = 1;
  for (std::size_t d = 0; d < dimensions; ++d) {
    count = std::min<std::size_t>(count * p.dimensions[d], max_record + 1);
  }
  if (count > max_record) {
    losses.push_back("parameter " + name + " has over 65535 bytes and is left out");
    return;
  }
  values.clear();
  values += static_cast<char>(p.type);
  values += static_cast<char>(dimensions);
  for (std::size_t d = 0; d < dimensions; ++d) values += static_cast<char>(p.dimensions[d]);
  bool clipped = false;
  if (p.type == C3dType::text) {
    std::string text = p.characters;
    text.resize(count, ' ');
    values += text;
  } else {
    for (std::size_t i = 0; i < count; ++i) {
      append_number(p.type, i < p.numbers.size() ? p.numbers[i] : 0.0, clipped);
    }
  }
  if (clipped) losses.push_back("parameter " + name + " holds values that its type cannot");
  record(p.name, p.locked, id, values, p.description);
}

/// Group numbers as given where they are positive and unique, others anew.
std::vector<int> group_numbers(const C3dParameters& tree) {
  std::array<bool, 128> used{};
  std::vector<int> ids;
  for (const C3dGroup& g : tree.groups) {
    const bool fresh = g.id > 0 && !used[static_cast<std::size_t>(g.id)];
    ids.push_back(fresh ? g.id : 0);
    if (fresh) used[static_cast<std::size_t>(g.id)] = true;
  }
  for (int& id : ids) {
    if (id != 0) continue;
    const auto* const free = std::find(used.begin() + 1, used.end(), false);
    if (free == used.end()) break;
    id = static_cast<int>(free - used.begin());
    used[static_cast<std::size_t>(id)] = true;
  }
  return ids;
}

}  // namespace

std::string encode_section(const C3dParameters& tree, Processor processor,
                           std::vector<std::string>& losses) {
  Encoder encoder{.processor = processor, .losses = losses};
  encoder.bytes = std::string("\1\x50\0", 3) + static_cast<char>(processor_byte(processor));
  const std::vector<int> ids = group_numbers(tree);
  for (std::size_t g = 0; g < tree.groups.size(); ++g) {
    const C3dGroup& group = tree.groups[g];
    if (ids[g] == 0) {
      losses.push_back("group " + group.name + " is left out: a file has at most 127 groups");
      continue;
    }
    encoder.record(group.name, group.locked, -ids[g], {}, group.description);
    for (const C3dParameter& p : group.parameters) encoder.parameter(group, p, ids[g]);
  }
  std::string bytes = std::move(encoder.bytes);
  bytes += '\0';
  const std::size_t blocks = (bytes.size() + c3d_block - 1) / c3d_block;
  bytes.resize(blocks * c3d_block, '\0');
  bytes[2] = static_cast<char>(std::min<std::size_t>(blocks, 255));
  if (blocks > 255) {
    losses.push_back("the parameters take " + std::to_string(blocks) +
                     " blocks, more than the 255 that other software looks for");
  }
  return bytes;
}

}  // namespace kinemesh
