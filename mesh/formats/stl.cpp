#include "mesh/formats/stl.h"

#include <array>
#include <unordered_map>

#include "config/error.h"
#include "config/text.h"
#include "mesh/formats/bytes.h"
#include "mesh/formats/registry.h"
#include "mesh/formats/text_scanner.h"

namespace kinemesh {
namespace {

constexpr std::size_t header_size = 84;
constexpr std::size_t facet_size = 50;

/// Gives equal positions the same index.
class VertexMerger {
 public:
  explicit VertexMerger(std::size_t corners) { index_of_.reserve(corners / 6); }

  VertexIndex index_of(std::array<float, 3> position) {
    Key key{};
    for (float& value : position) value += 0.0F;  // −0 becomes 0
    std::memcpy(key.data(), position.data(), sizeof key);
    const auto [it, is_new] =
        index_of_.try_emplace(key, static_cast<VertexIndex>(positions_.size() / 3));
    if (is_new) positions_.insert(positions_.end(), position.begin(), position.end());
    return it->second;
  }

  const std::vector<float>& positions() const { return positions_; }

 private:
  using Key = std::array<uint32_t, 3>;
  struct Hash {
    std::size_t operator()(const Key& key) const {
      std::size_t h = 0;
      for (const uint32_t word : key) h = (h ^ word) * 0x9E3779B97F4A7C15U;
      return h ^ (h >> 32U);
    }
  };
  std::unordered_map<Key, VertexIndex, Hash> index_of_;
  std::vector<float> positions_;
};

MeshData finish(const VertexMerger& merger, std::vector<Triangle> faces) {
  MeshData data;
  data.allocate(1, merger.positions().size() / 3);
  std::copy(merger.positions().begin(), merger.positions().end(), data.positions.begin());
  data.faces = std::move(faces);
  return data;
}

MeshData decode_binary(std::span<const std::byte> bytes, const std::string& name) {
  ByteReader in(bytes, name);
  in.take(header_size - 4);
  const auto count = in.value<uint32_t>();
  in.require(std::size_t{count} * facet_size);
  VertexMerger merger(3 * std::size_t{count});
  std::vector<Triangle> faces(count);
  const std::byte* facet = bytes.data() + header_size;
  for (Triangle& face : faces) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      std::array<float, 3> position{};
      std::memcpy(position.data(), facet + 12 + 12 * corner, sizeof position);
      face[corner] = merger.index_of(position);
    }
    facet += facet_size;
  }
  return finish(merger, std::move(faces));
}

MeshData decode_ascii(std::span<const std::byte> bytes, const std::string& name) {
  TextScanner scan(text_of(bytes), name);
  VertexMerger merger(bytes.size() / 60);
  std::vector<Triangle> faces;
  Triangle face{};
  std::size_t corners = 0;
  bool in_facet = false;
  for (; !scan.at_end(); scan.next_line()) {
    const std::string word = lower(scan.word().substr(0, 20));
    if (word == "vertex") {
      if (!in_facet || corners == 3) scan.fail("a vertex stands outside a facet of three");
      std::array<float, 3> position{};
      for (float& value : position) value = scan.coordinate();
      face[corners++] = merger.index_of(position);
    } else if (word == "facet") {
      if (in_facet) scan.fail("a facet begins within another");
      in_facet = true;
      corners = 0;
    } else if (word == "endfacet") {
      if (!in_facet || corners != 3)
        scan.fail("a facet has " + count_of(corners, "vertex", "vertices"));
      faces.push_back(face);
      in_facet = false;
    } else if (!word.empty() && word != "outer" && word != "endloop" && word != "solid" &&
               word != "endsolid" && word != "color") {
      scan.fail("the line begins with '" + word + "', which is no word of STL");
    }
  }
  if (faces.empty() && !in_facet) scan.fail("the file holds no facet");
  if (in_facet) scan.fail("the file ends within a facet", "The file is damaged or incomplete");
  return finish(merger, std::move(faces));
}

}  // namespace

MeshData decode_stl(std::span<const std::byte> bytes, const std::string& name) {
  // Binary headers may begin with "solid" too: the size decides first.
  if (bytes.size() >= header_size &&
      bytes.size() == header_size + facet_size * std::size_t{load_value<uint32_t>(&bytes[80])}) {
    return decode_binary(bytes, name);
  }
  const std::string_view text = text_of(bytes);
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  if (begin != std::string_view::npos && lower(text.substr(begin, 5)) == "solid") {
    return decode_ascii(bytes, name);
  }
  return decode_binary(bytes, name);
}

Format stl_format();
Format stl_format() {
  Format format;
  format.name = "stl";
  format.extensions = {".stl"};
  format.description = "STL, ascii or binary";
  format.exactness = "every float, vertices merged";
  format.single_frame = true;
  format.decode = decode_stl;
  return format;
}

}  // namespace kinemesh
