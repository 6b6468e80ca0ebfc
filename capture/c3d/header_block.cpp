#include "capture/c3d/header_block.h"

#include <algorithm>
#include <cmath>

#include "capture/c3d/number_format.h"

namespace kinemesh {
namespace {

// Words are numbered from 1 in the format's description.
constexpr std::size_t word(std::size_t number) { return 2 * (number - 1); }

constexpr uint16_t event_key = 12345;
constexpr std::size_t max_events = 18;
constexpr std::size_t event_key_word = 150;
constexpr std::size_t event_count_word = 151;
constexpr std::size_t event_times_word = 153;
constexpr std::size_t event_flags_word = 189;
constexpr std::size_t event_labels_word = 199;

std::string label_at(std::span<const std::byte> block, std::size_t at) {
  std::string label;
  for (std::size_t i = 0; i < 4; ++i) label += static_cast<char>(block[at + i]);
  label.resize(std::min(label.size(), label.find('\0')));
  const std::size_t last = label.find_last_not_of(' ');
  label.resize(last == std::string::npos ? 0 : last + 1);
  return label;
}

void decode_events(std::span<const std::byte> block, Processor p, C3dHeader& header,
                   std::vector<C3dFinding>& findings) {
  if (block.size() < c3d_block || read_u16(&block[word(event_key_word)], p) != event_key) return;
  const std::size_t count =
      std::min<std::size_t>(read_u16(&block[word(event_count_word)], p), max_events);
  for (std::size_t e = 0; e < count; ++e) {
    const float time = read_real(&block[word(event_times_word) + 4 * e], p);
    const std::string label = label_at(block, word(event_labels_word) + 4 * e);
    if (!std::isfinite(time) || time < 0.0F || time > 1e7F) {
      findings.push_back(
          c3d_finding("C3D107", "header event " + std::to_string(e + 1) + " has no usable time",
                      "byte " + std::to_string(word(event_times_word) + 4 * e)));
      continue;
    }
    const auto flag = static_cast<uint8_t>(block[word(event_flags_word) + e]);
    header.events.push_back({.label = label, .time_s = time, .display_flag = flag});
  }
}

}  // namespace

C3dHeader decode_header(std::span<const std::byte> block, Processor p,
                        std::vector<C3dFinding>& findings) {
  std::array<std::byte, 24> start{};
  std::copy_n(block.begin(), std::min(block.size(), start.size()), start.begin());
  C3dHeader header;
  header.parameter_block = static_cast<uint8_t>(start[0]);
  header.key = static_cast<uint8_t>(start[1]);
  header.points = read_u16(&start[word(2)], p);
  header.analog_per_frame = read_u16(&start[word(3)], p);
  header.first_frame = read_u16(&start[word(4)], p);
  header.last_frame = read_u16(&start[word(5)], p);
  header.max_gap = read_u16(&start[word(6)], p);
  header.scale = read_real(&start[word(7)], p);
  header.data_block = read_u16(&start[word(9)], p);
  header.analog_samples = read_u16(&start[word(10)], p);
  header.rate_hz = read_real(&start[word(11)], p);
  decode_events(block, p, header, findings);
  return header;
}

std::string encode_header(const C3dHeader& header, Processor p) {
  std::string block;
  block += static_cast<char>(header.parameter_block);
  block += static_cast<char>(80);
  for (const uint16_t value : {header.points, header.analog_per_frame, header.first_frame,
                               header.last_frame, header.max_gap}) {
    append_u16(block, value, p);
  }
  append_real(block, header.scale, p);
  append_u16(block, header.data_block, p);
  append_u16(block, header.analog_samples, p);
  append_real(block, header.rate_hz, p);
  block.resize(word(event_key_word), '\0');
  const std::size_t count = std::min(header.events.size(), max_events);
  append_u16(block, event_key, p);
  append_u16(block, static_cast<uint16_t>(count), p);
  block.resize(word(event_times_word), '\0');
  for (std::size_t e = 0; e < count; ++e) {
    append_real(block, static_cast<float>(header.events[e].time_s), p);
  }
  block.resize(word(event_flags_word), '\0');
  for (std::size_t e = 0; e < count; ++e) block += static_cast<char>(header.events[e].display_flag);
  block.resize(word(event_labels_word), '\0');
  for (std::size_t e = 0; e < count; ++e) {
    std::string label = header.events[e].label;
    label.resize(4, ' ');
    block += label;
  }
  block.resize(c3d_block, '\0');
  return block;
}

}  // namespace kinemesh
