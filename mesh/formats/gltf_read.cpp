#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "config/error.h"
#include "config/json_text.h"
#include "config/text.h"
#include "mesh/formats/bytes.h"
#include "mesh/formats/float_times.h"
#include "mesh/formats/gltf.h"
#include "mesh/formats/gltf_accessor.h"
#include "mesh/formats/metadata.h"
#include "mesh/formats/vtk_array.h"

namespace kinemesh {
namespace {

using gltf::accessor_values;
using gltf::Document;
using gltf::index_member;
using gltf::Json;
using gltf::none;

constexpr uint32_t glb_magic = 0x46546C67, chunk_json = 0x4E4F534A, chunk_binary = 0x004E4942;

/// Weights over time, of the mesh of one node.
struct Track {
  std::vector<double> times;
  std::vector<double> values;  ///< times × targets (× 3 for cubic splines)
  std::size_t targets = 0;
  enum class Kind : uint8_t { linear, step, cubic } kind = Kind::linear;

  double weight(double t, std::size_t target) const;
};

double Track::weight(double t, std::size_t target) const {
  const std::size_t per_key = kind == Kind::cubic ? 3 * targets : targets;
  const std::size_t middle = kind == Kind::cubic ? targets : 0;
  const auto value = [&](std::size_t key, std::size_t part) {
    return values[key * per_key + part + target];
  };
  const auto after = std::upper_bound(times.begin(), times.end(), t);
  if (after == times.begin()) return value(0, middle);
  const auto i = static_cast<std::size_t>(after - times.begin()) - 1;
  if (after == times.end() || kind == Kind::step) return value(i, middle);
  const double span = times[i + 1] - times[i];
  const double u = (t - times[i]) / span;
  if (kind == Kind::linear) return value(i, 0) + u * (value(i + 1, 0) - value(i, 0));
  // Hermite spline of the specification's appendix C: in-tangent, value, out-tangent per key.
  const double u2 = u * u, u3 = u2 * u;
  return (2 * u3 - 3 * u2 + 1) * value(i, middle) +
         span * (u3 - 2 * u2 + u) * value(i, 2 * targets) +
         (-2 * u3 + 3 * u2) * value(i + 1, middle) + span * (u3 - u2) * value(i + 1, 0);
}

/// One primitive as it stands in the scene.
struct Part {
  std::size_t first_vertex = 0, vertex_count = 0;
  std::vector<std::vector<double>> targets;  ///< transformed offsets, vertices × 3
  std::vector<double> weights;               ///< of the still mesh
  std::optional<Track> track;
};

class GltfReader {
 public:
  GltfReader(Document document, std::size_t file_bytes)
      : d_(std::move(document)), file_bytes_(file_bytes) {}

  MeshData read() {
    find_description();
    read_scene();
    if (positions_.empty()) d_.fail("scene", "it holds no mesh of triangles or points");
    sample();
    data_.unit = LengthUnit::m;
    return std::move(data_);
  }

 private:
  void find_description() {
    const auto asset = d_.json.find("asset");
    if (asset == d_.json.end() || !asset->is_object() ||
        !asset->value("version", std::string()).starts_with("2.")) {
      d_.fail("asset", "this is no glTF of version 2");
    }
    refuse_unknown_extensions();
    const auto extras = asset->find("extras");
    if (extras == asset->end() || !extras->is_object()) return;
    const auto ours = extras->find("kinemesh");
    if (ours != extras->end() && ours->is_object()) description_ = *ours;
  }

  /// Without an extension that a file requires its data would be read wrongly: compressed meshes
  /// have accessors without data, which mean zeros.
  void refuse_unknown_extensions() const {
    for (const Json& name : d_.json.value("extensionsRequired", Json::array())) {
      const bool harmless = name == "KHR_mesh_quantization" || name == "KHR_materials_unlit" ||
                            name == "KHR_texture_transform";
      if (harmless) continue;
      d_.fail("extensionsRequired", "the file requires the extension " + name.dump() +
                                        ", which is not read; save it without");
    }
  }

  void read_scene() {
    std::size_t scene = index_member(d_, d_.json, "scene", 0, "scene");
    if (d_.json.find("scenes") == d_.json.end()) {
      const auto nodes = d_.json.find("nodes");
      const std::size_t count = nodes != d_.json.end() && nodes->is_array() ? nodes->size() : 0;
      for (std::size_t n = 0; n < count; ++n) read_node(n, Eigen::Affine3d::Identity(), 0);
      return;
    }
    const Json& json = d_.element("scenes", scene);
    for (const Json& node : json.value("nodes", Json::array())) {
      read_node(node.get<std::size_t>(), Eigen::Affine3d::Identity(), 0);
    }
  }

  void read_node(std::size_t index, const Eigen::Affine3d& parent, int depth) {
    const std::string place = "node " + std::to_string(index);
    const Json& node = d_.element("nodes", index);
    if (depth > 64 || ++nodes_read_ > d_.json["nodes"].size()) {
      d_.fail(place, "the nodes form a cycle");
    }
    const Eigen::Affine3d transform = parent * transform_of(node, place);
    if (node.contains("mesh"))
      read_mesh(index_member(d_, node, "mesh", none, place), index, transform);
    if (node.contains("skin")) warn("a skin is left out");
    for (const Json& child : node.value("children", Json::array())) {
      read_node(child.get<std::size_t>(), transform, depth + 1);
    }
  }

  Eigen::Affine3d transform_of(const Json& node, const std::string& place) const {
    const auto numbers = [&](const char* key, std::vector<double> fallback) {
      const auto found = node.find(key);
      if (found == node.end()) return fallback;
      auto values = found->get<std::vector<double>>();
      if (values.size() != fallback.size()) {
        d_.fail(place, "'" + std::string(key) + "' has not " + std::to_string(fallback.size()) +
                           " numbers");
      }
      return values;
    };
    Eigen::Affine3d transform = Eigen::Affine3d::Identity();
    if (node.contains("matrix")) {
      const auto m = numbers("matrix", std::vector<double>(16, 0.0));
      transform.matrix() = Eigen::Map<const Eigen::Matrix4d>(m.data());
      return transform;
    }
    const auto t = numbers("translation", {0, 0, 0}), r = numbers("rotation", {0, 0, 0, 1}),
               s = numbers("scale", {1, 1, 1});
    transform.translate(Eigen::Vector3d(t[0], t[1], t[2]));
    transform.rotate(Eigen::Quaterniond(r[3], r[0], r[1], r[2]).normalized());
    transform.scale(Eigen::Vector3d(s[0], s[1], s[2]));
    return transform;
  }

  void read_mesh(std::size_t index, std::size_t node, const Eigen::Affine3d& transform) {
    const Json& mesh = d_.element("meshes", index);
    for (const Json& primitive : mesh.at("primitives")) {
      const std::size_t mode =
          index_member(d_, primitive, "mode", 4, "mesh " + std::to_string(index));
      if (mode != 4 && mode != 0) {
        warn("a primitive that is neither triangles nor points is left out");
        continue;
      }
      Part part;
      part.first_vertex = positions_.size() / 3;
      const std::size_t accessor =
          index_member(d_, primitive.at("attributes"), "POSITION", none, "mesh");
      append_points(accessor_values(d_, accessor, 3), transform);
      part.vertex_count = positions_.size() / 3 - part.first_vertex;
      if (mode == 4) read_faces(primitive, part, transform.linear().determinant() < 0);
      for (const Json& target : primitive.value("targets", Json::array())) {
        read_target(target, part, transform);
      }
      part.weights = mesh.value("weights", std::vector<double>(part.targets.size(), 0.0));
      part.weights.resize(part.targets.size(), 0.0);
      if (!part.targets.empty()) read_track(node, part);
      parts_.push_back(std::move(part));
    }
  }

  /// Many nodes may show the same data: what is unpacked is bounded by the file's size, though.
  void require_room(std::size_t values) const {
    if (values > std::max(file_bytes_, std::size_t{1} << 20)) {
      d_.fail("scene", "its meshes have more values than the file has bytes");
    }
  }

  void append_points(const std::vector<double>& points, const Eigen::Affine3d& transform) {
    require_room(positions_.size() + points.size());
    for (std::size_t i = 0; i < points.size(); i += 3) {
      const Eigen::Vector3d p =
          transform * Eigen::Vector3d(points[i], points[i + 1], points[i + 2]);
      positions_.insert(positions_.end(), p.begin(), p.end());
    }
  }

  void read_target(const Json& target, Part& part, const Eigen::Affine3d& transform) {
    // Targets without data are zeros: their memory is bounded by the file's size too.
    target_values_ += 3 * part.vertex_count;
    if (target_values_ > file_bytes_) {
      d_.fail("morph targets", "they have more values than the file has bytes");
    }
    const std::size_t accessor = index_member(d_, target, "POSITION", none, "morph target");
    if (accessor == none) {  // it moves normals alone
      part.targets.emplace_back(3 * part.vertex_count, 0.0);
      return;
    }
    std::vector<double> offsets = accessor_values(d_, accessor, 3);
    if (offsets.size() != 3 * part.vertex_count) {
      d_.fail("morph target", "it has not as many vertices as its mesh");
    }
    for (std::size_t i = 0; i < offsets.size(); i += 3) {
      Eigen::Map<Eigen::Vector3d> offset(&offsets[i]);
      offset = (transform.linear() * offset).eval();
    }
    part.targets.push_back(std::move(offsets));
  }

  void read_faces(const Json& primitive, const Part& part, bool mirrored) {
    std::vector<double> corners;
    if (primitive.contains("indices")) {
      corners = accessor_values(d_, index_member(d_, primitive, "indices", none, "mesh"), 1);
    } else {
      corners.resize(part.vertex_count);
      for (std::size_t i = 0; i < corners.size(); ++i) corners[i] = static_cast<double>(i);
    }
    if (corners.size() % 3 != 0)
      d_.fail("mesh", "the number of its corners is no multiple of three");
    require_room(3 * data_.faces.size() + corners.size());
    for (std::size_t i = 0; i < corners.size(); i += 3) {
      Triangle t{};
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const double v = corners[i + corner];
        if (!(v >= 0 && v < static_cast<double>(part.vertex_count)) || v != std::floor(v)) {
          d_.fail("mesh", "triangle " + std::to_string(i / 3) + " refers to vertex " +
                              format_number(v) + " (0-based), but there are only " +
                              std::to_string(part.vertex_count));
        }
        t[corner] = static_cast<VertexIndex>(part.first_vertex + static_cast<std::size_t>(v));
      }
      if (mirrored) std::swap(t[1], t[2]);
      data_.faces.push_back(t);
    }
  }

  /// The weights of `node` in the first animation.
  void read_track(std::size_t node, Part& part) {
    const auto animations = d_.json.find("animations");
    if (animations == d_.json.end() || animations->empty()) return;
    if (animations->size() > 1) warn("animations after the first are left out");
    const Json& animation = animations->at(0);
    for (const Json& channel : animation.at("channels")) {
      const Json& target = channel.at("target");
      if (target.value("path", "") != "weights") {
        warn("moving nodes stay where they are");
        continue;
      }
      if (index_member(d_, target, "node", none, "animation") != node) continue;
      const Json& samplers = animation.at("samplers");
      const std::size_t index = index_member(d_, channel, "sampler", none, "animation");
      if (index >= samplers.size()) d_.fail("animation", "a channel has no sampler");
      part.track = read_sampler(samplers[index], part.targets.size());
      return;
    }
  }

  Track read_sampler(const Json& sampler, std::size_t targets) const {
    Track track;
    track.targets = targets;
    track.times = accessor_values(d_, index_member(d_, sampler, "input", none, "sampler"), 1);
    track.values = accessor_values(d_, index_member(d_, sampler, "output", none, "sampler"), 1);
    const std::string kind = sampler.value("interpolation", "LINEAR");
    track.kind = kind == "STEP"          ? Track::Kind::step
                 : kind == "CUBICSPLINE" ? Track::Kind::cubic
                                         : Track::Kind::linear;
    const std::size_t per_key = (track.kind == Track::Kind::cubic ? 3 : 1) * targets;
    if (track.times.empty() || track.values.size() != track.times.size() * per_key) {
      d_.fail("sampler", "it has not one weight per key and morph target");
    }
    for (std::size_t i = 0; i < track.times.size(); ++i) {
      if (!std::isfinite(track.times[i]) || (i > 0 && !(track.times[i] > track.times[i - 1]))) {
        d_.fail("sampler", "the times of its keys do not increase");
      }
    }
    return track;
  }

  /// Times of the frames: ours as described, otherwise the keys if they are evenly spaced, or
  /// 30 frames per second over their span.
  std::vector<double> frame_times() {
    const Track* longest = nullptr;
    for (const Part& part : parts_) {
      if (part.track && (longest == nullptr || part.track->times.size() > longest->times.size())) {
        longest = &*part.track;
      }
    }
    if (longest == nullptr) return still_times();
    const std::vector<double>& keys = longest->times;
    const double span = keys.back() - keys.front();
    double rate = description_.value("rate_hz", 0.0);
    std::size_t count = index_member(d_, description_, "frame_count", 0, "extras");
    const bool ours = count > 0 && rate >= 0;
    if (ours) {
      data_.rate_hz = rate;
      if (!(rate > 0)) rate = assumed_rate_hz;
    } else if (keys.size() > 1 && evenly_spaced(keys)) {
      rate = static_cast<double>(keys.size() - 1) / span;
      count = keys.size();
      data_.rate_hz = rate_from_float_times(keys.front(), keys.back(), count - 1);
    } else {
      rate = assumed_rate_hz;
      data_.rate_hz = rate;
      count = span < 1e6 ? static_cast<std::size_t>(std::floor(span * rate)) + 1 : file_bytes_;
    }
    if (count > 64 * keys.size() + 1 ||
        count * positions_.size() / 2048 > file_bytes_) {  // 4 bytes each: at most 8192 to 1
      d_.fail("animation",
              "it unpacks to " + std::to_string(count) + " frames, too many for the file's size");
    }
    std::vector<double> times(count);
    for (std::size_t f = 0; f < count; ++f) times[f] = keys.front() + static_cast<double>(f) / rate;
    return times;
  }

  /// Our own files without motion have no keys, but say how many frames there were.
  std::vector<double> still_times() {
    const std::size_t count = index_member(d_, description_, "frame_count", 0, "extras");
    const double rate = description_.value("rate_hz", 0.0);
    if (rate > 0 && count > 0) data_.rate_hz = rate;
    if (count < 2) return {0.0};
    if (count / 1024 > file_bytes_ || count * positions_.size() / 256 > file_bytes_) {
      warn(std::to_string(count) + " frames without motion are read as one");
      return {0.0};
    }
    return std::vector<double>(count, 0.0);
  }

  static bool evenly_spaced(const std::vector<double>& keys) {
    const double step = (keys.back() - keys.front()) / static_cast<double>(keys.size() - 1);
    for (std::size_t i = 0; i < keys.size(); ++i) {
      const double expected = keys.front() + step * static_cast<double>(i);
      if (std::abs(keys[i] - expected) > 0.02 * step) return false;
    }
    return true;
  }

  void sample() {
    const std::vector<double> times = frame_times();
    data_.allocate(times.size(), positions_.size() / 3);
    const bool z_up = description_.value("up", "z") == "z";
    std::vector<double> frame;
    for (std::size_t f = 0; f < times.size(); ++f) {
      frame = positions_;
      for (const Part& part : parts_) add_targets(part, times[f], frame);
      float* out = data_.positions.data() + f * frame.size();
      for (std::size_t i = 0; i < frame.size(); i += 3) {
        out[i] = static_cast<float>(frame[i]);
        out[i + 1] = static_cast<float>(z_up ? -frame[i + 2] : frame[i + 1]);
        out[i + 2] = static_cast<float>(z_up ? frame[i + 1] : frame[i + 2]);
      }
    }
    MetadataReader metadata;
    for (const Json& line : description_.value("lines", Json::array())) {
      if (line.is_string()) metadata.read(line.get_ref<const std::string&>());
    }
    metadata.apply(data_);
  }

  static void add_targets(const Part& part, double time, std::vector<double>& frame) {
    for (std::size_t k = 0; k < part.targets.size(); ++k) {
      const double w = part.track ? part.track->weight(time, k) : part.weights[k];
      if (w == 0) continue;
      double* at = frame.data() + 3 * part.first_vertex;
      const std::vector<double>& target = part.targets[k];
      for (std::size_t i = 0; i < target.size(); ++i) at[i] += w * target[i];
    }
  }

  void warn(const std::string& text) {
    auto& warnings = data_.warnings;
    if (std::find(warnings.begin(), warnings.end(), text) == warnings.end())
      warnings.push_back(text);
  }

  Document d_;
  std::size_t file_bytes_;
  Json description_ = Json::object();
  MeshData data_;
  std::vector<double> positions_;
  std::vector<Part> parts_;
  std::size_t nodes_read_ = 0, target_values_ = 0;
};

/// The JSON text of a file, and the binary chunk of a GLB.
struct Chunks {
  std::string_view json;
  std::optional<std::string_view> binary;
};

Chunks chunks_of(std::span<const std::byte> bytes, const std::string& name) {
  if (bytes.size() < 4 || load_value<uint32_t>(bytes.data()) != glb_magic)
    return {text_of(bytes), {}};
  ByteReader in(bytes, name);
  in.take(4);
  if (const auto version = in.value<uint32_t>(); version != 2) {
    in.fail("version " + std::to_string(version) + " of GLB is not read; 2 is");
  }
  const auto length = in.value<uint32_t>();
  if (length > bytes.size()) {
    in.fail("the header promises " + std::to_string(length) + " bytes, but the file has only " +
            std::to_string(bytes.size()));
  }
  Chunks chunks;
  while (in.remaining() >= 8) {
    const auto size = in.value<uint32_t>();
    const auto type = in.value<uint32_t>();
    const std::string_view content = text_of(in.take(size));
    if (type == chunk_json && chunks.json.empty()) chunks.json = content;
    if (type == chunk_binary && !chunks.binary) chunks.binary = content;
  }
  return chunks;
}

/// Bytes of every buffer; `owned` keeps those that are not in the file as they are.
void load_buffers(Document& d, const std::optional<std::string_view>& binary,
                  const std::function<std::string(const std::string&)>& load,
                  std::vector<std::string>& owned) {
  const Json buffers = d.json.value("buffers", Json::array());
  owned.reserve(buffers.size());
  for (std::size_t i = 0; i < buffers.size(); ++i) {
    const std::string place = "buffer " + std::to_string(i);
    const Json& buffer = buffers[i];
    const std::size_t length = index_member(d, buffer, "byteLength", 0, place);
    std::string_view bytes;
    if (!buffer.contains("uri")) {
      if (i != 0 || !binary) d.fail(place, "its data are not in the file");
      bytes = *binary;
    } else {
      const auto& uri = buffer.at("uri").get_ref<const std::string&>();
      const std::size_t comma = uri.find(";base64,");
      if (uri.starts_with("data:") && comma != std::string::npos) {
        owned.push_back(decode_base64(std::string_view(uri).substr(comma + 8)));
      } else if (load) {
        owned.push_back(load(decoded_uri(uri)));
      } else {
        d.fail(place, "its data are in another file");
      }
      bytes = owned.back();
    }
    if (bytes.size() < length) d.fail(place, "it is shorter than the file says");
    d.buffers.push_back(bytes.substr(0, length));
  }
}

}  // namespace

MeshData decode_gltf(std::span<const std::byte> bytes, const std::string& name,
                     const std::function<std::string(const std::string& uri)>& load) {
  try {
    const Chunks chunks = chunks_of(bytes, name);
    Document document;
    document.name = name;
    const std::size_t begin = chunks.json.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
    if (begin == std::string_view::npos || chunks.json[begin] != '{') {
      document.fail("byte 0", "this is neither a GLB file nor the JSON of a glTF file");
    }
    refuse_deep_json(chunks.json, name);
    document.json = Json::parse(chunks.json);
    std::vector<std::string> owned;
    load_buffers(document, chunks.binary, load, owned);
    std::size_t total = bytes.size();
    for (const std::string& buffer : owned) total += buffer.size();
    return GltfReader(std::move(document), total).read();
  } catch (const Json::parse_error& e) {
    throw InputError({.what = "the JSON of the file is malformed",
                      .file = name,
                      .place = "byte " + std::to_string(e.byte) + " of the JSON"});
  } catch (const Json::exception& e) {
    throw InputError(
        {.what = std::string("the file does not follow glTF 2.0: ") + e.what(), .file = name});
  }
}

MeshData decode_gltf(std::span<const std::byte> bytes, const std::string& name) {
  return decode_gltf(bytes, name, {});
}

}  // namespace kinemesh
