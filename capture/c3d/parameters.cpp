#include "capture/c3d/parameters.h"

#include <algorithm>
#include <cctype>

namespace kinemesh {
namespace {

bool same_name(std::string_view a, std::string_view b) {
  return std::ranges::equal(
      a, b, [](unsigned char x, unsigned char y) { return std::toupper(x) == std::toupper(y); });
}

template <class Groups>
auto* find_group(Groups& groups, std::string_view name) {
  const auto it =
      std::ranges::find_if(groups, [name](const auto& g) { return same_name(g.name, name); });
  return it == groups.end() ? nullptr : &*it;
}

template <class Group>
auto find_parameter(Group* group, std::string_view name) -> decltype(group->parameters.data()) {
  if (group == nullptr) return nullptr;
  const auto it = std::ranges::find_if(group->parameters,
                                       [name](const auto& p) { return same_name(p.name, name); });
  return it == group->parameters.end() ? nullptr : &*it;
}

}  // namespace

std::vector<std::string> C3dParameter::strings() const {
  std::vector<std::string> all;
  if (type != C3dType::text || characters.empty()) return all;
  const std::size_t width = dimensions.empty() ? characters.size() : dimensions[0];
  if (width == 0) return all;
  for (std::size_t at = 0; at + width <= characters.size(); at += width) {
    std::string text = characters.substr(at, width);
    // A NUL ends the text even when blanks or rubbish follow it.
    text.resize(std::min(text.size(), text.find('\0')));
    const auto last = text.find_last_not_of(' ');
    text.resize(last == std::string::npos ? 0 : last + 1);
    all.push_back(std::move(text));
  }
  return all;
}

const C3dGroup* C3dParameters::group(std::string_view name) const {
  return find_group(groups, name);
}

C3dGroup* C3dParameters::group(std::string_view name) { return find_group(groups, name); }

const C3dParameter* C3dParameters::find(std::string_view group_name, std::string_view name) const {
  return find_parameter(group(group_name), name);
}

C3dParameter* C3dParameters::find(std::string_view group_name, std::string_view name) {
  return find_parameter(group(group_name), name);
}

void C3dParameters::set(std::string_view group_name, C3dParameter parameter) {
  C3dGroup* owner = group(group_name);
  if (owner == nullptr) {
    int8_t id = 1;
    for (const C3dGroup& g : groups) id = std::max<int8_t>(id, static_cast<int8_t>(g.id + 1));
    groups.push_back({.name = std::string(group_name), .id = id});
    owner = &groups.back();
  }
  if (C3dParameter* existing = find_parameter(owner, parameter.name)) {
    *existing = std::move(parameter);
  } else {
    owner->parameters.push_back(std::move(parameter));
  }
}

}  // namespace kinemesh
