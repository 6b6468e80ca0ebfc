#include "mesh/formats/npz_mesh.h"

#include <cmath>

#include "config/error.h"
#include "config/text.h"
#include "mesh/formats/bytes.h"
#include "mesh/formats/metadata.h"
#include "mesh/formats/npz.h"
#include "mesh/formats/registry.h"

namespace kinemesh {
namespace {

class NpzMeshReader {
 public:
  NpzMeshReader(std::span<const std::byte> bytes, const std::string& name)
      : name_(name), file_(parse_npz(text_of(bytes), name)) {}

  MeshData read() {
    read_positions();
    if (const NpyArray* faces = find("faces")) read_faces(*faces);
    if (const NpyArray* names = find("vertex_names")) {
      if (names->type != NpyType::text || names->texts.size() != data_.vertex_count) {
        fail("vertex_names", "it does not hold one text per vertex");
      }
      data_.vertex_names = names->texts;
    }
    read_numbers();
    read_samples();
    if (const NpyArray* lines = find("kinemesh")) {
      MetadataReader metadata;
      for (const std::string& line : lines->texts) metadata.read(line);
      metadata.apply(data_);
    }
    return std::move(data_);
  }

 private:
  [[noreturn]] void fail(const std::string& array, const std::string& what) const {
    throw InputError({.what = what, .file = name_, .place = "array '" + array + "'"});
  }

  const NpyArray* find(std::string_view array) const {
    const auto it = file_.find(array);
    return it == file_.end() ? nullptr : &it->second;
  }

  void read_positions() {
    const char* key = find("positions") != nullptr ? "positions" : "vertices";
    const NpyArray* array = find(key);
    if (array == nullptr) array = find("array");  // a single .npy
    if (array == nullptr) fail("positions", "the archive does not hold it");
    const auto& shape = array->shape;
    if ((shape.size() != 2 && shape.size() != 3) || shape.back() != 3) {
      fail(key, "its shape is neither frames × vertices × 3 nor vertices × 3");
    }
    if (array->type == NpyType::text) fail(key, "it holds texts, not numbers");
    if (array->size() == 0) fail(key, "it holds no frame or no vertex");
    data_.allocate(shape.size() == 3 ? shape[0] : 1, shape[shape.size() - 2]);
    if (array->type == NpyType::float32) {
      std::memcpy(data_.positions.data(), array->bytes.data(), data_.positions.size() * 4);
      return;
    }
    const std::vector<double> values = array->numbers();
    for (std::size_t i = 0; i < values.size(); ++i)
      data_.positions[i] = static_cast<float>(values[i]);
  }

  void read_faces(const NpyArray& faces) {
    if (faces.type == NpyType::text || faces.shape.size() != 2 || faces.shape[1] != 3) {
      fail("faces", "its shape is not faces × 3");
    }
    const std::vector<double> corners = faces.numbers();
    data_.faces.resize(faces.shape[0]);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const double v = corners[i];
      if (!(v >= 0 && v < static_cast<double>(data_.vertex_count)) || v != std::floor(v)) {
        fail("faces", "row " + std::to_string(i / 3) + " refers to vertex " + format_number(v) +
                          " (0-based), but there are only " + std::to_string(data_.vertex_count));
      }
      data_.faces[i / 3][i % 3] = static_cast<VertexIndex>(v);
    }
  }

  double single_number(std::string_view key) const {
    const NpyArray* array = find(key);
    if (array == nullptr || array->type == NpyType::text || array->size() != 1) return std::nan("");
    return array->numbers()[0];
  }

  void read_numbers() {
    const double rate = single_number("rate_hz");
    if (rate > 0 && std::isfinite(rate)) data_.rate_hz = rate;
    const double first = single_number("first_frame");
    if (std::abs(first) < 1e15) data_.first_frame = static_cast<int64_t>(first);
    const NpyArray* unit = find("unit");
    if (unit != nullptr && unit->texts.size() == 1) data_.unit = length_unit_of(unit->texts[0]);
  }

  void read_samples() {
    const std::size_t samples = data_.frame_count * data_.vertex_count;
    for (const char* key : {"filled", "uncertainty"}) {
      const NpyArray* array = find(key);
      if (array == nullptr) continue;
      if (array->type == NpyType::text || array->size() != samples) {
        fail(key, "its shape is not frames × vertices");
      }
      const std::vector<double> values = array->numbers();
      if (key[0] == 'f') {
        data_.filled = Buffer<uint8_t>(samples);
        for (std::size_t i = 0; i < samples; ++i) data_.filled[i] = values[i] != 0 ? 1 : 0;
      } else {
        data_.uncertainty = Buffer<float>(samples);
        for (std::size_t i = 0; i < samples; ++i)
          data_.uncertainty[i] = static_cast<float>(values[i]);
      }
    }
  }

  const std::string& name_;
  NpzFile file_;
  MeshData data_;
};

}  // namespace

MeshData decode_npz(std::span<const std::byte> bytes, const std::string& name) {
  return NpzMeshReader(bytes, name).read();
}

std::string encode_npz(const AnimatedMesh& mesh, const WriteOptions& options) {
  NpzWriter out;
  const std::size_t frames = mesh.frame_count(), vertices = mesh.vertex_count();
  const auto& faces = mesh.topology().faces();
  out.add("positions", {frames, vertices, 3}, mesh.positions());
  std::vector<int32_t> corners;
  corners.reserve(3 * faces.size());
  for (const Triangle& t : faces) {
    for (const VertexIndex v : t) corners.push_back(static_cast<int32_t>(v));
  }
  out.add("faces", {faces.size(), 3}, std::span<const int32_t>(corners));
  if (!mesh.vertex_names.empty()) {
    out.add("vertex_names", std::span<const std::string>(mesh.vertex_names));
  }
  out.add("rate_hz", mesh.rate_hz);
  out.add("first_frame", static_cast<double>(mesh.first_frame));
  out.add("unit", name_of(options.unit));
  if (!mesh.filled().empty()) out.add_booleans("filled", {frames, vertices}, mesh.filled());
  if (!mesh.uncertainty().empty()) out.add("uncertainty", {frames, vertices}, mesh.uncertainty());
  const std::vector<std::string> lines = metadata_lines(mesh, 0, options);
  out.add("kinemesh", std::span<const std::string>(lines));
  return out.bytes();
}

Format npz_format();
Format npz_format() {
  Format format = make_format("npz", ".npz", "NumPy archive", Keeps::everything(), "every float");
  format.decode = decode_npz;
  format.write = [](const AnimatedMesh& mesh, const std::filesystem::path& path,
                    const WriteOptions& options, OutputSet& files, const RunContext&) {
    files.add(path, encode_npz(mesh, options));
    return WriteReport{};
  };
  return format;
}

}  // namespace kinemesh
