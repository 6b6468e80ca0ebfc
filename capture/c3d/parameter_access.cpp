#include "capture/c3d/parameter_access.h"

#include <algorithm>
#include <cmath>

namespace kinemesh {

std::optional<double> first_number(const C3dParameters& tree, std::string_view group,
                                   std::string_view name) {
  const C3dParameter* p = tree.find(group, name);
  if (p == nullptr || p->numbers.empty() || !std::isfinite(p->numbers[0])) return std::nullopt;
  return p->numbers[0];
}

std::optional<uint64_t> first_count(const C3dParameters& tree, std::string_view group,
                                    std::string_view name) {
  const auto value = first_number(tree, group, name);
  if (!value) return std::nullopt;
  const bool is_integer = tree.find(group, name)->type == C3dType::integer;
  const double count = is_integer ? as_unsigned(*value) : std::round(*value);
  if (count < 0.0 || count > 4294967295.0) return std::nullopt;
  return static_cast<uint64_t>(count);
}

std::string first_string(const C3dParameters& tree, std::string_view group, std::string_view name) {
  const C3dParameter* p = tree.find(group, name);
  if (p == nullptr) return {};
  const std::vector<std::string> all = p->strings();
  return all.empty() ? std::string() : all.front();
}

std::vector<std::string> all_strings(const C3dParameters& tree, std::string_view group,
                                     const std::string& name) {
  std::vector<std::string> all;
  for (int part = 1; part <= 257; ++part) {
    const C3dParameter* p = tree.find(group, part == 1 ? name : name + std::to_string(part));
    if (p == nullptr) break;
    std::vector<std::string> some = p->strings();
    all.insert(all.end(), std::make_move_iterator(some.begin()),
               std::make_move_iterator(some.end()));
  }
  return all;
}

std::optional<uint64_t> long_count(const C3dParameters& tree, std::string_view group,
                                   std::string_view name) {
  const C3dParameter* p = tree.find(group, name);
  if (p == nullptr || p->type != C3dType::integer || p->numbers.size() < 2) {
    return first_count(tree, group, name);
  }
  return static_cast<uint64_t>(as_unsigned(p->numbers[0]) + 65536.0 * as_unsigned(p->numbers[1]));
}

C3dParameter real_parameter(std::string name, std::vector<double> values,
                            std::vector<uint8_t> dimensions) {
  return {.name = std::move(name),
          .type = C3dType::real,
          .dimensions = std::move(dimensions),
          .numbers = std::move(values)};
}

C3dParameter integer_parameter(std::string name, std::vector<double> values,
                               std::vector<uint8_t> dimensions) {
  return {.name = std::move(name),
          .type = C3dType::integer,
          .dimensions = std::move(dimensions),
          .numbers = std::move(values)};
}

void scale_force_plates(C3dParameters& tree, double factor) {
  for (const char* place : {"CORNERS", "ORIGIN"}) {
    C3dParameter* lengths = tree.find("FORCE_PLATFORM", place);
    if (lengths == nullptr || lengths->type != C3dType::real) continue;
    for (double& n : lengths->numbers) n *= factor;
  }
}

C3dParameter text_parameter(std::string name, std::string_view text) {
  text = text.substr(0, 255);
  return {.name = std::move(name),
          .type = C3dType::text,
          .dimensions = {static_cast<uint8_t>(text.size())},
          .characters = std::string(text)};
}

C3dParameter texts_parameter(std::string name, const std::vector<std::string>& texts) {
  std::size_t width = 1;
  for (const std::string& text : texts) width = std::max(width, text.size());
  width = std::min<std::size_t>(width, 255);
  const std::size_t count = std::min<std::size_t>(texts.size(), 255);
  C3dParameter p{.name = std::move(name),
                 .type = C3dType::text,
                 .dimensions = {static_cast<uint8_t>(width), static_cast<uint8_t>(count)}};
  for (std::size_t i = 0; i < count; ++i) {
    std::string text = texts[i];
    text.resize(width, ' ');
    p.characters += text;
  }
  return p;
}

}  // namespace kinemesh
