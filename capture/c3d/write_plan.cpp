#include "capture/c3d/write_plan.h"

#include <algorithm>
#include <cmath>

#include "capture/c3d/event_group.h"
#include "capture/c3d/header_block.h"
#include "capture/c3d/parameter_access.h"
#include "capture/c3d/parameter_section.h"
#include "config/error.h"
#include "config/text.h"

namespace kinemesh {
namespace {

constexpr double max_u16 = 65'535.0;
constexpr std::size_t max_entries = 255;

double first_word(uint64_t value) { return static_cast<double>(value & 0xFFFFU); }
double second_word(uint64_t value) { return static_cast<double>(value >> 16); }

std::string numbered(const std::string& name, std::size_t part) {
  return part == 0 ? name : name + std::to_string(part + 1);
}

void remove_rest(C3dParameters& tree, const char* group, const std::string& name,
                 std::size_t parts) {
  C3dGroup* owner = tree.group(group);
  for (std::size_t part = parts;
       owner != nullptr && tree.find(group, numbered(name, part)) != nullptr; ++part) {
    const C3dParameter* gone = tree.find(group, numbered(name, part));
    owner->parameters.erase(owner->parameters.begin() + (gone - owner->parameters.data()));
  }
}

/// Numbers of frames and of the first one, in every field that tells them.
void plan_frames(const MarkerSequence& take, C3dWritePlan& plan) {
  C3dParameters& tree = plan.parameters;
  const auto frames = static_cast<uint64_t>(take.frame_count());
  const auto first = static_cast<uint64_t>(std::max<int64_t>(take.first_frame, 1));
  const uint64_t last = first + frames - 1;  // without frames the one before the first
  if (last > 0xFFFFFFFFU) {
    throw UsageError({.what = "the last frame would have the number " + std::to_string(last) +
                              ", more than a C3D file can hold"});
  }
  if (first_count(tree, "POINT", "FRAMES") != frames) {
    update(tree, "POINT",
           integer_parameter("FRAMES", {std::min(static_cast<double>(frames), max_u16)}));
  }
  const bool has_long = tree.find("POINT", "LONG_FRAMES") != nullptr;
  if (frames > 65'535 || has_long)
    update(tree, "POINT", real_parameter("LONG_FRAMES", {static_cast<double>(frames)}));
  const bool has_fields = tree.find("TRIAL", "ACTUAL_START_FIELD") != nullptr ||
                          tree.find("TRIAL", "ACTUAL_END_FIELD") != nullptr;
  if (last > 65'535 || has_fields) {
    update(tree, "TRIAL",
           integer_parameter("ACTUAL_START_FIELD", {first_word(first), second_word(first)}, {2}));
    update(tree, "TRIAL",
           integer_parameter("ACTUAL_END_FIELD", {first_word(last), second_word(last)}, {2}));
  }
  plan.header.first_frame = static_cast<uint16_t>(std::min<uint64_t>(first, 65'535));
  plan.header.last_frame = static_cast<uint16_t>(std::min<uint64_t>(last, 65'535));
}

void plan_point_group(const MarkerSequence& take, C3dWritePlan& plan) {
  C3dParameters& tree = plan.parameters;
  update(tree, "POINT", integer_parameter("USED", {static_cast<double>(plan.points)}));
  update(tree, "POINT",
         real_parameter("SCALE", {static_cast<double>(static_cast<float>(plan.scale))}));
  update(tree, "POINT",
         real_parameter("RATE", {static_cast<double>(static_cast<float>(take.rate_hz))}));
  const auto screen = [&](const char* name, const std::string& axis) {
    if (!axis.empty() && trim(first_string(tree, "POINT", name)) != axis)
      update(tree, "POINT", text_parameter(name, axis));
  };
  screen("X_SCREEN", take.origin.x_screen);
  screen("Y_SCREEN", take.origin.y_screen);
}

void plan_rotations(const MarkerSequence& take, C3dWritePlan& plan) {
  C3dParameters& tree = plan.parameters;
  const RotationData& r = take.rotations;
  if (r.values.empty()) {
    if (first_count(tree, "ROTATION", "USED").value_or(0) == 0) return;
    update(tree, "ROTATION", integer_parameter("USED", {0.0}));
    plan.losses.push_back({.message = "the take no longer has the data of the rotations",
                           .place = "parameter ROTATION:USED"});
    return;
  }
  if (r.count > 65'535 || r.samples_per_frame > 65'535) {
    throw UsageError({.what = "a C3D file holds at most 65535 rotations and as many samples of "
                              "them a frame"});
  }
  update(tree, "ROTATION", integer_parameter("USED", {static_cast<double>(r.count)}));
  const auto samples = static_cast<double>(r.samples_per_frame);
  if (tree.find("ROTATION", "RATIO") != nullptr || tree.find("ROTATION", "RATE") == nullptr) {
    update(tree, "ROTATION", integer_parameter("RATIO", {samples}));
  }
  if (tree.find("ROTATION", "RATE") != nullptr) {
    update(
        tree, "ROTATION",
        real_parameter("RATE", {static_cast<double>(static_cast<float>(samples * take.rate_hz))}));
  }
}

/// Where the rotations begin. 16 bits point up to 32 MB into a file; a real goes further.
void plan_rotation_block(std::size_t block, C3dWritePlan& plan) {
  const auto value = static_cast<double>(block);
  if (block <= 65'535) {
    update(plan.parameters, "ROTATION", integer_parameter("DATA_START", {value}));
    return;
  }
  plan.parameters.set("ROTATION", real_parameter("DATA_START", {value}));
}

/// Encodes the section twice: its size decides the parameters DATA_START, which are part of it.
void plan_section(const MarkerSequence& take, C3dWritePlan& plan) {
  const std::size_t width = plan.storage == Storage::real ? 4 : 2;
  const std::size_t frame_bytes =
      (4 * std::size_t{plan.header.points} + plan.header.analog_per_frame) * width;
  const std::size_t point_blocks = (take.frame_count() * frame_bytes + c3d_block - 1) / c3d_block;
  const bool rotations = !take.rotations.values.empty();
  constexpr std::size_t most_blocks = 65'535;
  update(plan.parameters, "POINT", integer_parameter("DATA_START", {0.0}));
  // Of the type that the block is going to have.
  const bool far = point_blocks > most_blocks - 2 - 1024;
  if (rotations) plan_rotation_block(far ? most_blocks + 1 : 0, plan);
  std::vector<std::string> ignored;
  const std::size_t blocks =
      encode_section(plan.parameters, plan.processor, ignored).size() / c3d_block;
  const std::size_t data_block = 2 + blocks;
  if (data_block > most_blocks)
    throw UsageError({.what = "the parameters take over 32 MB, more than a C3D file can hold"});
  update(plan.parameters, "POINT",
         integer_parameter("DATA_START", {static_cast<double>(data_block)}));
  if (rotations && far) {
    plan.parameters.find("ROTATION", "DATA_START")->numbers = {
        static_cast<double>(data_block + point_blocks)};
    plan.losses.push_back({.message = "the rotations begin more than 32 MB into the file, where "
                                      "software that expects a 16-bit pointer does not find them",
                           .place = "parameter ROTATION:DATA_START"});
  } else if (rotations) {
    plan_rotation_block(data_block + point_blocks, plan);
  }
  std::vector<std::string> losses;
  plan.section = encode_section(plan.parameters, plan.processor, losses);
  for (std::string& loss : losses)
    plan.losses.push_back({.message = std::move(loss), .place = "parameters"});
  plan.header.data_block = static_cast<uint16_t>(data_block);
}

void plan_header(const MarkerSequence& take, C3dWritePlan& plan) {
  C3dHeader& h = plan.header;
  const std::size_t per_frame = plan.analog.channels.size() * take.analog.samples_per_frame;
  if (plan.points > 65'535 || per_frame > 65'535) {
    throw UsageError(
        {.what =
             "a C3D file holds at most 65535 points and as many analog values a frame; these are " +
             std::to_string(plan.points) + " and " + std::to_string(per_frame)});
  }
  h.parameter_block = 2;
  h.points = static_cast<uint16_t>(plan.points);
  h.analog_per_frame = static_cast<uint16_t>(per_frame);
  h.analog_samples = static_cast<uint16_t>(per_frame == 0 ? 0 : take.analog.samples_per_frame);
  h.max_gap = 10;
  h.scale = static_cast<float>(plan.scale);
  h.rate_hz = static_cast<float>(take.rate_hz);
  h.events = header_events_of(take.events);
}

bool same_values(const C3dParameter& a, const C3dParameter& b) {
  const auto number = [](double x) { return std::isnan(x) ? 0.0 : x < 0.0 ? x + 65536.0 : x; };
  const bool unsigned_alike = a.type == C3dType::integer && b.type == C3dType::integer;
  const bool same_numbers = unsigned_alike
                                ? std::ranges::equal(a.numbers, b.numbers, {}, number, number)
                                : a.numbers == b.numbers;
  if (!same_numbers) return false;
  // A count keeps the type it was given.
  if (a.type != C3dType::text && b.type != C3dType::text)
    return a.dimensions == b.dimensions || a.numbers.size() == 1;
  return a.type == b.type && a.strings() == b.strings();
}

}  // namespace

void update(C3dParameters& tree, const char* group, C3dParameter parameter) {
  if (const C3dParameter* old = tree.find(group, parameter.name)) {
    if (same_values(*old, parameter)) return;
    parameter.description = old->description;
    parameter.locked = old->locked;
    parameter.name = old->name;
  }
  tree.set(group, std::move(parameter));
}

void update_texts(C3dParameters& tree, const char* group, const std::string& name,
                  const std::vector<std::string>& texts) {
  const std::size_t parts =
      std::max<std::size_t>(1, (texts.size() + max_entries - 1) / max_entries);
  for (std::size_t part = 0; part < parts; ++part) {
    const auto begin = texts.begin() + static_cast<std::ptrdiff_t>(part * max_entries);
    const auto end = texts.begin() +
                     static_cast<std::ptrdiff_t>(std::min((part + 1) * max_entries, texts.size()));
    update(tree, group, texts_parameter(numbered(name, part), {begin, end}));
  }
  remove_rest(tree, group, name, parts);
}

void update_numbers(C3dParameters& tree, const char* group, const std::string& name, C3dType type,
                    const std::vector<double>& numbers) {
  const std::size_t parts =
      std::max<std::size_t>(1, (numbers.size() + max_entries - 1) / max_entries);
  for (std::size_t part = 0; part < parts; ++part) {
    const auto begin = numbers.begin() + static_cast<std::ptrdiff_t>(part * max_entries);
    const auto end = numbers.begin() + static_cast<std::ptrdiff_t>(
                                           std::min((part + 1) * max_entries, numbers.size()));
    update(tree, group,
           {.name = numbered(name, part),
            .type = type,
            .dimensions = {static_cast<uint8_t>(end - begin)},
            .numbers = {begin, end}});
  }
  remove_rest(tree, group, name, parts);
}

C3dWritePlan plan_c3d(const MarkerSequence& take, const C3dWriteOptions& options) {
  options.validate();
  C3dWritePlan plan;
  plan.parameters = take.parameters;
  if (plan.parameters.group("POINT") == nullptr)
    plan.parameters.groups.insert(plan.parameters.groups.begin(), C3dGroup{.name = "POINT"});
  plan_points(take, options, plan);
  plan_numbers(take, options, plan);
  plan_analog(take, plan);
  plan_frames(take, plan);
  plan_point_group(take, plan);
  encode_event_list(take.events, plan.parameters);
  plan_rotations(take, plan);
  plan_header(take, plan);
  plan_section(take, plan);
  return plan;
}

}  // namespace kinemesh
