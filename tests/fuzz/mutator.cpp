#include "tests/fuzz/mutator.h"

#include <algorithm>
#include <array>
#include <iterator>

namespace kinemesh::fuzz {
namespace {

// Where formats keep their structure: most mutations strike here.
constexpr std::size_t head_bytes = 2048;

std::size_t place(Random& r, std::size_t size, std::size_t begin) {
  if (size <= begin) return begin;
  const bool in_head = begin == 0 && r.below(3) != 0;
  return begin + r.below(in_head ? std::min(size, head_bytes) : size - begin);
}

void put(std::string& bytes, std::size_t at, std::string_view value) {
  for (std::size_t i = 0; i < value.size() && at + i < bytes.size(); ++i) bytes[at + i] = value[i];
}

/// Values that break counts, dimensions, offsets and floats, in either byte order.
std::string telling_value(Random& r) {
  using namespace std::string_literals;
  static const std::array<std::string, 16> values = {"\0"s,
                                                     "\x01"s,
                                                     "\x7F"s,
                                                     "\x80"s,
                                                     "\xFF"s,
                                                     "\0\0"s,
                                                     "\xFF\x7F"s,
                                                     "\x7F\xFF"s,
                                                     "\0\x80"s,
                                                     "\xFF\xFF"s,
                                                     "\0\0\xC0\x7F"s,
                                                     "\0\0\x80\x7F"s,
                                                     "\xFF\xFF\x7F\x7F"s,
                                                     "\0\0\x80\xBF"s,
                                                     "\xBF\x80\0\0"s,
                                                     "\xFF\xFF\xFF\xFF"s};
  return values[r.below(values.size())];
}

/// True for what looks like text: text formats get mutations of their own.
bool is_text(const std::string& bytes) {
  const std::string_view head = std::string_view(bytes).substr(0, head_bytes);
  return !head.empty() && std::ranges::none_of(head, [](char c) {
    return static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\r' && c != '\t';
  });
}

/// Words that break counts, indices and numbers written out.
std::string_view telling_word(Random& r) {
  static constexpr std::array<std::string_view, 24> words = {"0",
                                                             "-1",
                                                             "1",
                                                             "4294967295",
                                                             "4294967296",
                                                             "2147483648",
                                                             "18446744073709551615",
                                                             "99999999999999999999",
                                                             "nan",
                                                             "-inf",
                                                             "1e999",
                                                             "1e-400",
                                                             "1e38",
                                                             "0x10",
                                                             "1.5",
                                                             "-0",
                                                             "",
                                                             "\"",
                                                             "\t\t\t",
                                                             ",,,,",
                                                             "\r\n\r\n",
                                                             "[[[[",
                                                             "\xEF\xBB\xBF",
                                                             "null"};
  return words[r.below(words.size())];
}

/// Another word for one of the text, or a line twice, missing or at another place.
void change_text(std::string& bytes, Random& r) {
  if (bytes.empty()) return;
  const std::size_t at = place(r, bytes.size(), 0);
  const std::string_view blanks = " \t\r\n,;:\"/<>[]{}";
  if (r.below(4) != 0) {
    const std::size_t before = bytes.find_last_of(blanks, at);
    const std::size_t begin = before == std::string::npos ? 0 : before + 1;
    const std::size_t end = std::min(bytes.find_first_of(blanks, begin), bytes.size());
    bytes.replace(begin, end - begin, telling_word(r));
    return;
  }
  const std::size_t before = at == 0 ? std::string::npos : bytes.rfind('\n', at - 1);
  const std::size_t begin = before == std::string::npos ? 0 : before + 1;
  const std::size_t end = std::min(bytes.find('\n', at), bytes.size() - 1) + 1;
  const std::string line = bytes.substr(begin, end - begin);
  if (r.below(2) == 0) bytes.erase(begin, line.size());
  const std::size_t copies = r.below(3);
  const std::size_t where =
      r.below(2) == 0 ? std::min(begin, bytes.size()) : r.below(bytes.size() + 1);
  for (std::size_t i = 0; i < copies; ++i) bytes.insert(where, line);
}

/// Changes that keep the size.
void change(std::string& bytes, Random& r, std::size_t begin) {
  if (bytes.size() <= begin) return;
  const std::size_t at = place(r, bytes.size(), begin);
  switch (r.below(6)) {
    case 0: bytes[at] = static_cast<char>(bytes[at] ^ (1 << r.below(8))); break;
    case 1: bytes[at] = static_cast<char>(r.below(256)); break;
    case 2: put(bytes, at, telling_value(r)); break;
    case 3: bytes[at] = static_cast<char>(bytes[at] + static_cast<char>(r.below(9)) - 4); break;
    case 4: {
      const std::size_t length = std::min(bytes.size() - at, std::size_t{1} + r.below(64));
      std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), length,
                  static_cast<char>(r.below(3) == 0 ? 0xFF : 0));
      break;
    }
    default: {
      const std::size_t from = place(r, bytes.size(), begin);
      const std::string piece = bytes.substr(from, 1 + r.below(32));
      put(bytes, at, piece);
    }
  }
}

/// Changes of the size: truncation, missing and additional bytes, pieces of another seed.
void resize(std::string& bytes, Random& r, std::span<const Seed> seeds) {
  if (bytes.empty()) return;
  const std::size_t at = place(r, bytes.size(), 0);
  switch (r.below(5)) {
    case 0: bytes.resize(r.below(bytes.size() + 1)); break;
    case 1: bytes.erase(at, 1 + r.below(r.below(2) == 0 ? 4 : 1024)); break;
    case 2: bytes.insert(at, 1 + r.below(4), static_cast<char>(r.below(256))); break;
    case 3: bytes.insert(0, 1 + r.below(600), '\0'); break;
    default: {
      const std::string& other = seeds[r.below(seeds.size())].bytes;
      if (!other.empty()) bytes.insert(at, other.substr(r.below(other.size()), 1 + r.below(512)));
    }
  }
}

}  // namespace

uint64_t Random::next() {
  uint64_t z = (state_ += 0x9E3779B97F4A7C15U);
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
  return z ^ (z >> 31);
}

std::size_t Random::below(std::size_t bound) { return bound == 0 ? 0 : next() % bound; }

Mutant make_mutant(std::span<const Seed> seeds, uint64_t number) {
  Random r(number * 0x2545F4914F6CDD1DU + 1);
  Mutant mutant;
  mutant.seed = number % seeds.size();
  const Seed& seed = seeds[mutant.seed];
  mutant.bytes = seed.bytes;
  mutant.payload_only = seed.payload < seed.bytes.size() && r.below(4) == 0;
  const bool text = is_text(seed.bytes);
  const std::size_t changes = 1 + r.below(r.below(4) == 0 ? 24 : 3);
  for (std::size_t i = 0; i < changes; ++i) {
    if (text && r.below(2) == 0) {
      change_text(mutant.bytes, r);
    } else if (!mutant.payload_only && r.below(4) == 0) {
      resize(mutant.bytes, r, seeds);
    } else {
      change(mutant.bytes, r, mutant.payload_only ? seed.payload : 0);
    }
  }
  return mutant;
}

}  // namespace kinemesh::fuzz
