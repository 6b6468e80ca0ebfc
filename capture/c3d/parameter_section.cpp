#include "capture/c3d/parameter_section.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <set>

#include "capture/c3d/header_block.h"
#include "capture/c3d/number_format.h"
#include "config/text.h"

namespace kinemesh {
namespace {

// A section of 255 blocks has 130 kB; longer ones exist, absurd ones are cut here.
constexpr std::size_t max_section_bytes = std::size_t{4} << 20;
constexpr std::size_t max_records = 16'384;
constexpr std::size_t preamble = 4;  // two reserved bytes, block count, processor

std::string at_byte(std::size_t byte) { return "byte " + std::to_string(byte); }

/// True when the bytes can be a record: a name of letters, digits and the like, and a group.
bool plausible_record(std::span<const std::byte> bytes, std::size_t at) {
  if (at + 4 > bytes.size()) return false;
  const int length = std::abs(static_cast<int8_t>(bytes[at]));
  if (length == 0 || bytes[at + 1] == std::byte{0} || at + 4 + length > bytes.size()) return false;
  return std::all_of(bytes.begin() + static_cast<std::ptrdiff_t>(at + 2),
                     bytes.begin() + static_cast<std::ptrdiff_t>(at + 2 + length),
                     [](std::byte b) { return b >= std::byte{32} && b != std::byte{127}; });
}

/// Records of the chain that are plausible, counted to `enough`. The zero that ends a chain counts
/// as one.
std::size_t chain_length(std::span<const std::byte> bytes, std::size_t at, Processor p,
                         std::size_t enough) {
  std::size_t count = 0;
  while (count < enough && plausible_record(bytes, at)) {
    ++count;
    const std::size_t field =
        at + 2 + static_cast<std::size_t>(std::abs(static_cast<int8_t>(bytes[at])));
    const std::size_t next = read_u16(&bytes[field], p);
    if (next == 0) return count + 1;
    at = field + next;
    if (at < bytes.size() && bytes[at] == std::byte{0}) return count + 1;
  }
  return count;
}

/// The processor of a section that may begin here, found without a pointer: its byte must name the
/// processor, and its first records must have plain names, one of them POINT's.
std::optional<Processor> unpointed_processor(std::span<const std::byte> bytes, std::size_t begin) {
  if (begin + preamble >= bytes.size()) return std::nullopt;
  const auto named = processor_from(static_cast<uint8_t>(bytes[begin + 3]));
  if (!named || chain_length(bytes, begin + preamble, *named, 3) < 3) return std::nullopt;
  const auto length =
      static_cast<std::size_t>(std::abs(static_cast<int8_t>(bytes[begin + preamble])));
  const auto name = bytes.subspan(begin + preamble + 2, length);
  const bool plain = std::ranges::all_of(name, [](std::byte b) {
    const int c = static_cast<int>(b);
    return std::isalnum(c) != 0 || c == '_';
  });
  constexpr std::string_view point = "POINT";
  const auto near = bytes.subspan(begin, std::min<std::size_t>(8192, bytes.size() - begin));
  const bool has_points =
      std::search(near.begin(), near.end(), point.begin(), point.end(), [](std::byte byte, char c) {
        return std::toupper(static_cast<int>(byte)) == c;
      }) != near.end();
  return plain && has_points ? named : std::nullopt;
}

/// The processor of the section at `begin`: as its byte says, if the chain follows in that byte
/// order; the other byte order where only that one gives a chain.
std::optional<Processor> section_processor(std::span<const std::byte> bytes, std::size_t begin) {
  if (begin + preamble > bytes.size()) return std::nullopt;
  const auto named = processor_from(static_cast<uint8_t>(bytes[begin + 3]));
  const std::size_t first = begin + preamble;
  if (named && chain_length(bytes, first, *named, 2) >= 2) return named;
  if (chain_length(bytes, first, Processor::intel, 3) >= 3) {
    return named && *named != Processor::sgi ? named : Processor::intel;
  }
  if (chain_length(bytes, first, Processor::sgi, 3) >= 3) return Processor::sgi;
  return std::nullopt;
}

void note_processor(std::span<const std::byte> bytes, std::size_t base, C3dSectionStart start,
                    std::vector<C3dFinding>& findings) {
  const auto byte = static_cast<uint8_t>(bytes[start.begin - base + 3]);
  if (byte == processor_byte(start.processor)) return;
  findings.push_back(c3d_finding("C3D202",
                                 "the processor byte is " + std::to_string(byte) +
                                     "; the records follow each other as in a file of processor " +
                                     std::string(name_of(start.processor)),
                                 at_byte(start.begin + 3)));
}

// ---- records ------------------------------------------------------------------------------------

struct Parser {
  std::span<const std::byte> bytes;  // from the section's begin to its limit
  std::size_t base = 0;              // absolute byte of bytes[0]
  Processor processor = Processor::intel;
  std::vector<C3dFinding>& findings;

  struct Record {
    bool is_group = false;
    int id = 0;
    std::size_t at = 0;
    std::size_t data = 0;
    bool overflow = false;   // it has more entries than its last dimension can say
    C3dParameter parameter;  // name, description and lock serve groups too
  };
  std::vector<Record> records;
  std::size_t end = preamble;

  uint8_t byte(std::size_t at) const { return static_cast<uint8_t>(bytes[at]); }
  std::string text(std::size_t at, std::size_t length) const {
    return {reinterpret_cast<const char*>(bytes.data()) + at, length};
  }
  void note(std::string_view code, std::string message, std::size_t at) {
    findings.push_back(c3d_finding(code, std::move(message), at_byte(base + at)));
  }

  void run();
  std::size_t parse_record(std::size_t at);
  std::size_t parse_values(Record& record, std::size_t at, std::size_t stop);
  std::size_t parse_description(Record& record, std::size_t at, std::size_t stop);
  std::size_t overflowed_count(const C3dParameter& p, std::size_t count, std::size_t at,
                               std::size_t stop) const;
  void split_overflow(Record record);
};

void Parser::run() {
  std::size_t at = preamble;
  while (at < bytes.size() && bytes[at] != std::byte{0}) {
    if (!plausible_record(bytes, at)) {
      note("C3D203", "the chain of records ends in bytes that are no record", at);
      break;
    }
    if (records.size() == max_records) {
      note("C3D212", "the section has over " + std::to_string(max_records) + " records", at);
      break;
    }
    const std::size_t next = parse_record(at);
    if (next <= at) break;
    at = next;
  }
  if (at >= bytes.size() && bytes.size() >= max_section_bytes) {
    note("C3D212", "the section has over 4 MiB", bytes.size());
  }
}

/// Returns where the next record begins; 0 at the end of the chain.
std::size_t Parser::parse_record(std::size_t at) {
  Record record;
  const auto length = static_cast<int8_t>(bytes[at]);
  const auto name_bytes = static_cast<std::size_t>(std::abs(length));
  record.at = at;
  record.parameter.locked = length < 0;
  record.parameter.name = text(at + 2, name_bytes);
  const auto id = static_cast<int8_t>(bytes[at + 1]);
  record.is_group = id < 0;
  record.id = std::abs(id);
  const std::size_t field = at + 2 + name_bytes;
  const std::size_t offset = read_u16(&bytes[field], processor);
  std::size_t stop = offset == 0 ? bytes.size() : field + offset;
  const bool astray = stop > bytes.size() || stop < field + 2;
  if (astray) stop = bytes.size();
  std::size_t cursor = field + 2;
  if (!record.is_group) cursor = parse_values(record, cursor, stop);
  if (cursor != 0) cursor = parse_description(record, cursor, stop);
  if (astray) {
    const bool last = cursor != 0 && cursor < bytes.size() && byte(cursor) == 0;
    note(last ? "C3D213" : "C3D203",
         "the pointer of " + record.parameter.name + " leads out of the section", field);
  }
  end = std::max(end, offset == 0 || stop == bytes.size() ? std::max(cursor, field + 2) : stop);
  const bool followed = offset != 0 && stop < bytes.size();
  // A pointer into rubbish, while a record follows where this one ends: the pointer is wrong.
  std::size_t next = followed ? stop : 0;
  const bool leads_nowhere =
      offset != 0 && (!followed || (byte(stop) != 0 && !plausible_record(bytes, stop)));
  if (leads_nowhere && cursor != 0 && cursor < bytes.size() && cursor != stop &&
      chain_length(bytes, cursor, processor, 2) >= 2) {
    note("C3D203",
         "the pointer of " + record.parameter.name +
             " leads to no record; the next one follows at byte " + std::to_string(base + cursor),
         field);
    next = cursor;
  }
  if (record.overflow) {
    split_overflow(std::move(record));
  } else if (record.is_group || record.parameter.type != C3dType{}) {
    records.push_back(std::move(record));
  }
  return next;
}

/// Characters of a text, values of a row: all dimensions but the last; at most a section's size.
std::size_t values_per_entry(const C3dParameter& p) {
  std::size_t count = 1;
  for (std::size_t d = 0; d + 1 < p.dimensions.size(); ++d) {
    count = std::min(count * p.dimensions[d], max_section_bytes);
  }
  return count;
}

/// Values of an array with more entries than the 8 bits of its last dimension can count: a writer
/// that cuts the number keeps its low byte, or 255. Such an array is known by its record's pointer,
/// which leads exactly behind that many entries and the description. 0 for any other record.
std::size_t Parser::overflowed_count(const C3dParameter& p, std::size_t count, std::size_t at,
                                     std::size_t stop) const {
  const auto width = static_cast<std::size_t>(std::abs(static_cast<int>(p.type)));
  const bool list = p.dimensions.size() > (p.type == C3dType::text ? 1U : 0U);
  const auto ends_at = [&](std::size_t values) {
    const std::size_t behind = at + values * width;
    return behind < stop && behind + 1 + byte(behind) == stop;
  };
  if (!list || stop >= bytes.size() || ends_at(count)) return 0;
  const std::size_t entry = values_per_entry(p);
  const std::size_t declared = p.dimensions.back();
  const std::size_t step = declared == 255 ? 1 : 256;
  if (entry == 0) return 0;
  for (std::size_t n = declared + step; n * entry * width < stop - at; n += step) {
    if (ends_at(n * entry)) return n * entry;
  }
  return 0;
}

/// The first 255 entries under the parameter's name, the next under NAME2, and so on.
void Parser::split_overflow(Record record) {
  const C3dParameter whole = record.parameter;
  const std::size_t entry = values_per_entry(whole);
  const std::size_t values = std::max(whole.characters.size(), whole.numbers.size());
  for (std::size_t from = 0, part = 1; from < values; from += 255 * entry, ++part) {
    const std::size_t count = std::min(255 * entry, values - from);
    C3dParameter& p = record.parameter;
    p = whole;
    if (part > 1) p.name += std::to_string(part);
    p.dimensions.back() = static_cast<uint8_t>(count / entry);
    if (whole.type == C3dType::text) {
      p.characters = whole.characters.substr(from, count);
    } else {
      p.numbers.assign(whole.numbers.begin() + static_cast<std::ptrdiff_t>(from),
                       whole.numbers.begin() + static_cast<std::ptrdiff_t>(from + count));
    }
    records.push_back(record);
  }
}

/// Type, dimensions and values. Returns the byte behind them, or 0 when the type is unknown (then
/// the type is left at C3dType{}).
std::size_t Parser::parse_values(Record& record, std::size_t at, std::size_t stop) {
  C3dParameter& p = record.parameter;
  p.type = C3dType{};
  if (at + 2 > stop) {
    note("C3D204", "parameter " + p.name + " has no room for its type", record.at);
    return 0;
  }
  const auto type = static_cast<int8_t>(bytes[at]);
  if (type != -1 && type != 1 && type != 2 && type != 4) {
    note("C3D205", "parameter " + p.name + " has the type " + std::to_string(type), at);
    return 0;
  }
  p.type = static_cast<C3dType>(type);
  const std::size_t dimensions = std::min<std::size_t>(byte(at + 1), stop - at - 2);
  std::size_t count = 1;
  for (std::size_t d = 0; d < dimensions; ++d) {
    p.dimensions.push_back(byte(at + 2 + d));
    count = std::min(count * p.dimensions.back(), max_section_bytes);
  }
  at += 2 + dimensions;
  record.data = at;
  const auto width = static_cast<std::size_t>(std::abs(type));
  if (const std::size_t all = overflowed_count(p, count, at, stop); all != 0) {
    note("C3D214",
         "the dimensions of " + p.name + " say " + std::to_string(p.dimensions.back()) +
             " entries, its record holds " + std::to_string(all / values_per_entry(p)),
         record.at);
    record.overflow = true;
    count = all;
  }
  if (count * width > stop - at) {
    note("C3D204",
         "the dimensions of " + p.name + " claim " + std::to_string(count * width) +
             " bytes where its record has " + std::to_string(stop - at),
         record.at);
    count = (stop - at) / width;
  }
  if (type == -1) {
    p.characters = text(at, count);
    return at + count;
  }
  p.numbers.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::byte* value = &bytes[at + i * width];
    p.numbers[i] = type == 1   ? static_cast<double>(static_cast<uint8_t>(*value))
                   : type == 2 ? static_cast<double>(read_i16(value, processor))
                               : static_cast<double>(read_real(value, processor));
  }
  return at + count * width;
}

/// Returns the byte behind the description.
std::size_t Parser::parse_description(Record& record, std::size_t at, std::size_t stop) {
  const std::string& name = record.parameter.name;
  if (at >= stop) {
    if (stop < bytes.size()) {
      note("C3D207", "the record of " + name + " ends without the length of its description",
           record.at);
    }
    return at;
  }
  std::size_t length = byte(at);
  if (length > stop - at - 1) {
    note("C3D209",
         "the description of " + name + " claims " + std::to_string(length) +
             " bytes where its record has " + std::to_string(stop - at - 1),
         at);
    length = stop - at - 1;
  }
  record.parameter.description = text(at + 1, length);
  const std::size_t behind = at + 1 + length;
  // The last record may have a pointer to the zero that ends the chain.
  if (stop < bytes.size() && behind < stop && byte(stop) != 0) {
    note("C3D211", "the pointer of " + name + " skips " + count_of(stop - behind, "byte"), behind);
  }
  return behind;
}

// ---- the tree -----------------------------------------------------------------------------------

C3dGroup& group_of(C3dParameters& tree, int id) {
  const auto it = std::ranges::find_if(tree.groups, [id](const C3dGroup& g) { return g.id == id; });
  if (it != tree.groups.end()) return *it;
  tree.groups.push_back({.name = "GROUP" + std::to_string(id), .id = static_cast<int8_t>(id)});
  return tree.groups.back();
}

void add_groups(Parser& parser, C3dParameters& tree) {
  for (const Parser::Record& r : parser.records) {
    if (!r.is_group) continue;
    const bool known = tree.group(r.parameter.name) != nullptr;
    const bool taken =
        std::ranges::any_of(tree.groups, [&r](const C3dGroup& g) { return g.id == r.id; });
    if (known || taken) {
      parser.note("C3D208",
                  "the group " + r.parameter.name +
                      (known ? " is declared twice" : " has the number of another one"),
                  r.at);
    }
    if (taken) continue;
    tree.groups.push_back({.name = r.parameter.name,
                           .description = r.parameter.description,
                           .locked = r.parameter.locked,
                           .id = static_cast<int8_t>(std::min(r.id, 127))});
  }
}

C3dSection build(Parser& parser) {
  C3dSection section;
  add_groups(parser, section.parameters);
  std::set<std::string> names;
  for (Parser::Record& r : parser.records) {
    if (r.is_group) continue;
    const std::size_t declared = section.parameters.groups.size();
    C3dGroup& group = group_of(section.parameters, r.id);
    if (section.parameters.groups.size() > declared) {
      parser.note("C3D206",
                  "parameter " + r.parameter.name + " belongs to group " + std::to_string(r.id) +
                      ", which is not declared",
                  r.at);
    }
    if (!names.insert(std::to_string(r.id) + ':' + lower(r.parameter.name)).second) {
      parser.note("C3D208",
                  "the parameter " + group.name + ":" + r.parameter.name + " stands there twice",
                  r.at);
    }
    section.places.push_back({.group = group.name,
                              .name = r.parameter.name,
                              .record = parser.base + r.at,
                              .data = parser.base + r.data});
    group.parameters.push_back(std::move(r.parameter));
  }
  section.end = parser.base + parser.end;
  return section;
}

}  // namespace

std::optional<C3dSectionStart> find_section(const ByteSource& source, std::size_t leading,
                                            std::size_t block, std::vector<C3dFinding>& findings) {
  const std::size_t pointed = leading + (block == 0 ? 1 : block - 1) * c3d_block;
  const std::vector<std::byte> start = source.bytes_at(0, std::size_t{256} * c3d_block + 4096);
  if (const auto p = section_processor(start, pointed); p && block != 0) {
    note_processor(start, 0, {pointed, *p}, findings);
    return C3dSectionStart{pointed, *p};
  }
  const auto found = [&](std::size_t begin, Processor p) {
    findings.push_back(c3d_finding("C3D103",
                                   "the header points to byte " + std::to_string(pointed) +
                                       ", but the parameter section begins at byte " +
                                       std::to_string(begin),
                                   at_byte(leading)));
    note_processor(start, 0, {begin, p}, findings);
    return C3dSectionStart{begin, p};
  };
  for (std::size_t begin = leading + c3d_block; begin < start.size(); begin += c3d_block) {
    if (const auto p = unpointed_processor(start, begin)) return found(begin, *p);
  }
  // Not at a block's border: look everywhere.
  for (std::size_t begin = 0; begin < start.size(); ++begin) {
    if (const auto p = unpointed_processor(start, begin)) return found(begin, *p);
  }
  // An empty section still names the processor.
  if (block != 0 && pointed + preamble < start.size() &&
      start[pointed + preamble] == std::byte{0}) {
    if (const auto p = processor_from(static_cast<uint8_t>(start[pointed + 3]))) {
      return C3dSectionStart{pointed, *p};
    }
  }
  return std::nullopt;
}

C3dSection parse_section(const ByteSource& source, const C3dSectionStart& start, std::size_t limit,
                         std::vector<C3dFinding>& findings) {
  limit = std::min({limit, source.size(), start.begin + max_section_bytes});
  const std::vector<std::byte> bytes = source.bytes_at(start.begin, limit - start.begin);
  if (bytes.size() < preamble) return {.end = start.begin + bytes.size()};
  Parser parser{
      .bytes = bytes, .base = start.begin, .processor = start.processor, .findings = findings};
  parser.run();
  C3dSection section = build(parser);
  const std::size_t blocks = parser.byte(2);
  if (!parser.records.empty() && section.end > start.begin + blocks * c3d_block) {
    findings.push_back(c3d_finding(
        "C3D201",
        "the section says it has " + std::to_string(blocks) + " blocks, its records take " +
            std::to_string((section.end - start.begin + c3d_block - 1) / c3d_block),
        at_byte(start.begin + 2)));
  }
  return section;
}

}  // namespace kinemesh
