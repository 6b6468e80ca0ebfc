#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "config/error.h"
#include "config/text.h"
#include "mesh/formats/bytes.h"
#include "mesh/formats/gltf.h"
#include "mesh/formats/metadata.h"
#include "mesh/formats/morph_animation.h"
#include "mesh/movement.h"

namespace kinemesh {
namespace {

namespace fs = std::filesystem;
using OrderedJson = nlohmann::ordered_json;

constexpr int component_u8 = 5121, component_u16 = 5123, component_u32 = 5125, component_f32 = 5126;
constexpr int array_buffer = 34962, element_array_buffer = 34963;
/// Viewers keep morph targets in the layers of a texture array; WebGL 2 promises so many.
constexpr std::size_t targets_of_all_viewers = 256;

/// Colours of the viridis map (Smith & van der Walt 2015) at equal steps, sRGB.
constexpr std::array<std::array<double, 3>, 5> viridis{{{0.267, 0.005, 0.329},
                                                        {0.229, 0.322, 0.546},
                                                        {0.128, 0.567, 0.551},
                                                        {0.369, 0.789, 0.383},
                                                        {0.993, 0.906, 0.144}}};

double linear_of_srgb(double s) {
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

class GltfWriter {
 public:
  GltfWriter(const AnimatedMesh& mesh, const WriteOptions& options, const RunContext& ctx)
      : mesh_(mesh), options_(options), ctx_(ctx) {}

  GltfContent write(const std::string& buffer_uri) {
    prepare();
    GltfContent out;
    add_document(buffer_uri);
    out.binary = std::move(binary_);
    out.json = document_.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
    out.report.max_error_mm = animation_.max_error_mm;
    out.report.rms_error_mm = animation_.rms_error_mm;
    if (moves()) {
      out.report.notes.push_back(count_of(animation_.target_count, "morph target") + " and " +
                                 count_of(animation_.keys.size(), "key") + ": largest error " +
                                 format_fixed(animation_.max_error_mm, 4) + " mm, RMS " +
                                 format_fixed(animation_.rms_error_mm, 4) + " mm");
      if (animation_.target_count > targets_of_all_viewers) {
        out.report.notes.push_back(
            "not every viewer holds more than " + std::to_string(targets_of_all_viewers) +
            " morph targets; a smaller --budget or a larger --max-error gives fewer");
      }
      if (!(mesh_.rate_hz > 0)) {
        out.report.notes.emplace_back(
            "the frame rate is not known: played at 30 frames per second");
      }
    }
    return out;
  }

 private:
  bool moves() const { return mesh_.frame_count() > 1; }

  /// Chooses modes and keys; the JSON of a file without targets tells the cost of one with them.
  void prepare() {
    animation_.vertex_count = mesh_.vertex_count();
    animation_.base.resize(3 * mesh_.vertex_count());
    const float* p = mesh_.frame(0).data();
    for (std::size_t i = 0; i < animation_.base.size(); ++i) {
      animation_.base[i] = static_cast<float>(p[i] * 1e-3);
    }
    if (options_.gltf.colour == VertexColour::deformation) {
      colours_ = movement_of(mesh_, ctx_);
      const double largest = *std::ranges::max_element(colours_);
      if (largest > 0) {
        for (double& c : colours_) c /= largest;
      }
    }
    if (!moves()) return;
    GltfWriter still(mesh_, options_, ctx_);
    still.animation_ = animation_;
    still.colours_ = colours_;
    still.add_document("");
    constexpr std::size_t json_of_animation = 2000, json_of_target = 420;
    const MorphCost cost{
        still.document_.dump(-1, ' ', false, OrderedJson::error_handler_t::replace).size() +
            still.binary_.size() + json_of_animation,
        json_of_target};
    animation_ = morph_animation_of(mesh_, options_.gltf, cost, ctx_);
  }

  /// A vector with Y up.
  std::array<float, 3> turned(const float* v) const {
    if (options_.gltf.up == GltfUp::y) return {v[0], v[1], v[2]};
    return {v[0], v[2], -v[1]};
  }

  void align() { binary_.resize((binary_.size() + 3) / 4 * 4, '\0'); }

  /// Starts a buffer view at an aligned place; end_view() gives its length.
  void begin_view(int target, int stride = 0) {
    align();
    OrderedJson view{{"buffer", 0}, {"byteOffset", binary_.size()}, {"byteLength", 0}};
    if (stride > 0) view["byteStride"] = stride;
    if (target > 0) view["target"] = target;
    views_.push_back(std::move(view));
  }
  void end_view() {
    views_.back()["byteLength"] = binary_.size() - views_.back()["byteOffset"].get<std::size_t>();
  }

  std::size_t add_accessor(std::size_t offset, int component, std::size_t count, const char* type) {
    OrderedJson accessor{{"bufferView", views_.size() - 1},
                         {"byteOffset", offset},
                         {"componentType", component},
                         {"count", count},
                         {"type", type}};
    accessors_.push_back(std::move(accessor));
    return accessors_.size() - 1;
  }

  /// Appends vectors to the current view; with `bounds`, the accessor gets min and max.
  std::size_t add_vectors(const float* values, std::size_t count, bool bounds) {
    const std::size_t offset = binary_.size() - views_.back()["byteOffset"].get<std::size_t>();
    const std::size_t accessor = add_accessor(offset, component_f32, count, "VEC3");
    std::array<float, 3> low{}, high{};
    for (std::size_t v = 0; v < count; ++v) {
      const std::array<float, 3> value = turned(values + 3 * v);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        append_value(binary_, value[axis]);
        low[axis] = v == 0 ? value[axis] : std::min(low[axis], value[axis]);
        high[axis] = v == 0 ? value[axis] : std::max(high[axis], value[axis]);
      }
    }
    if (bounds) {
      accessors_[accessor]["min"] = low;
      accessors_[accessor]["max"] = high;
    }
    return accessor;
  }

  /// Of the first frame, which is what the initial weights show.
  std::vector<float> normals() const {
    std::vector<Eigen::Vector3d> sums(animation_.vertex_count, Eigen::Vector3d::Zero());
    const auto point = [this](VertexIndex v) {
      return Eigen::Vector3d(mesh_.position(0, v).cast<double>());
    };
    for (const Triangle& t : mesh_.topology().faces()) {
      const Eigen::Vector3d area = (point(t[1]) - point(t[0])).cross(point(t[2]) - point(t[0]));
      for (const VertexIndex v : t) sums[v] += area;
    }
    std::vector<float> out;
    out.reserve(3 * sums.size());
    for (const Eigen::Vector3d& sum : sums) {
      const double length = sum.norm();
      // Vertices without faces need a unit vector too.
      const Eigen::Vector3f n =
          (length > 0 ? Eigen::Vector3d(sum / length) : Eigen::Vector3d::UnitZ()).cast<float>();
      out.insert(out.end(), n.begin(), n.end());
    }
    return out;
  }

  std::size_t add_colours() {
    begin_view(array_buffer);
    for (const double value : colours_) {
      const double at = std::clamp(value, 0.0, 1.0) * (viridis.size() - 1);
      const auto i = std::min(static_cast<std::size_t>(at), viridis.size() - 2);
      for (std::size_t channel = 0; channel < 3; ++channel) {
        const double s = viridis[i][channel] + (at - static_cast<double>(i)) *
                                                   (viridis[i + 1][channel] - viridis[i][channel]);
        binary_ += static_cast<char>(static_cast<uint8_t>(std::lround(255 * linear_of_srgb(s))));
      }
      binary_ += static_cast<char>(uint8_t{255});
    }
    end_view();
    const std::size_t accessor = add_accessor(0, component_u8, colours_.size(), "VEC4");
    accessors_[accessor]["normalized"] = true;
    return accessor;
  }

  std::size_t add_indices() {
    const auto& faces = mesh_.topology().faces();
    const bool wide = mesh_.vertex_count() > 65535;  // 65535 itself restarts a primitive
    begin_view(element_array_buffer);
    for (const Triangle& t : faces) {
      for (const VertexIndex v : t) {
        if (wide) {
          append_value(binary_, v);
        } else {
          append_value(binary_, static_cast<uint16_t>(v));
        }
      }
    }
    end_view();
    return add_accessor(0, wide ? component_u32 : component_u16, 3 * faces.size(), "SCALAR");
  }

  OrderedJson primitive() {
    const std::size_t vertices = animation_.vertex_count;
    const bool surface = mesh_.topology().face_count() > 0;
    OrderedJson out{
        {"attributes", OrderedJson::object()}, {"mode", surface ? 4 : 0}, {"material", 0}};
    begin_view(array_buffer, 12);
    out["attributes"]["POSITION"] = add_vectors(animation_.base.data(), vertices, true);
    end_view();
    if (surface) {
      begin_view(array_buffer, 12);
      out["attributes"]["NORMAL"] = add_vectors(normals().data(), vertices, false);
      end_view();
      out["indices"] = add_indices();
    }
    if (!colours_.empty()) out["attributes"]["COLOR_0"] = add_colours();
    if (animation_.target_count == 0) return out;
    begin_view(array_buffer, 12);
    out["targets"] = OrderedJson::array();
    for (std::size_t k = 0; k < animation_.target_count; ++k) {
      out["targets"].push_back(
          {{"POSITION",
            add_vectors(animation_.targets.data() + 3 * k * vertices, vertices, true)}});
    }
    end_view();
    return out;
  }

  OrderedJson animation() {
    const double rate = mesh_.rate_hz > 0 ? mesh_.rate_hz : assumed_rate_hz;
    begin_view(0);
    float last = 0.0F;
    for (const std::size_t key : animation_.keys) {
      last = static_cast<float>(static_cast<double>(key) / rate);
      append_value(binary_, last);
    }
    end_view();
    const std::size_t input = add_accessor(0, component_f32, animation_.keys.size(), "SCALAR");
    accessors_[input]["min"] = {0.0};
    accessors_[input]["max"] = {last};
    begin_view(0);
    for (const float w : animation_.weights) append_value(binary_, w);
    end_view();
    const std::size_t output = add_accessor(0, component_f32, animation_.weights.size(), "SCALAR");
    return {{"name", "motion"},
            {"samplers", {{{"input", input}, {"interpolation", "LINEAR"}, {"output", output}}}},
            {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}}}};
  }

  OrderedJson description() const {
    OrderedJson out{{"frame_count", mesh_.frame_count()},
                    {"rate_hz", mesh_.rate_hz},
                    {"up", options_.gltf.up == GltfUp::y ? "y" : "z"},
                    {"max_error_mm", animation_.max_error_mm},
                    {"rms_error_mm", animation_.rms_error_mm}};
    WriteOptions metres = options_;
    metres.unit = LengthUnit::m;
    out["lines"] = metadata_lines(mesh_, 0, metres, {.description = true, .filled_runs = true});
    return out;
  }

  void add_document(const std::string& buffer_uri) {
    OrderedJson mesh{{"name", "mesh"}, {"primitives", OrderedJson::array({primitive()})}};
    if (animation_.target_count > 0) {
      const auto first = animation_.weights.begin();
      mesh["weights"] =
          std::vector<float>(first, first + static_cast<std::ptrdiff_t>(animation_.target_count));
      for (std::size_t k = 0; k < animation_.target_count; ++k) {
        mesh["extras"]["targetNames"].push_back("mode " + std::to_string(k + 1));
      }
    }
    document_ = {
        {"asset",
         {{"version", "2.0"},
          {"generator", mesh_.provenance.program.empty() ? "kinemesh" : mesh_.provenance.program},
          {"extras", {{"kinemesh", description()}}}}},
        {"scene", 0},
        {"scenes", {{{"nodes", {0}}}}},
        {"nodes", {{{"mesh", 0}, {"name", "mesh"}}}},
        {"meshes", OrderedJson::array({mesh})},
        {"materials",
         {{{"name", "skin"},
           {"doubleSided", true},
           {"pbrMetallicRoughness",
            {{"baseColorFactor", {0.8, 0.8, 0.8, 1.0}},
             {"metallicFactor", 0.0},
             {"roughnessFactor", 0.8}}}}}}};
    if (!colours_.empty()) {
      document_["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = {1.0, 1.0, 1.0, 1.0};
    }
    if (animation_.target_count > 0) document_["animations"] = OrderedJson::array({animation()});
    align();
    document_["accessors"] = std::move(accessors_);
    document_["bufferViews"] = std::move(views_);
    OrderedJson buffer{{"byteLength", binary_.size()}};
    if (!buffer_uri.empty()) buffer["uri"] = buffer_uri;
    document_["buffers"] = OrderedJson::array({buffer});
  }

  const AnimatedMesh& mesh_;
  const WriteOptions& options_;
  const RunContext& ctx_;
  MorphAnimation animation_;
  std::vector<double> colours_;
  std::string binary_;
  OrderedJson document_;
  OrderedJson accessors_ = OrderedJson::array(), views_ = OrderedJson::array();
};

/// A file name as a relative URI (RFC 3986).
std::string percent_encoded(const std::string& name) {
  static constexpr std::string_view plain = "-._~";
  static constexpr std::string_view digits = "0123456789ABCDEF";
  std::string out;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    const bool keep =
        (byte < 128 && std::isalnum(byte) != 0) || plain.find(c) != std::string_view::npos;
    if (keep) {
      out += c;
    } else {
      out += '%';
      out += digits[byte >> 4U];
      out += digits[byte & 15U];
    }
  }
  return out;
}

std::string glb_of(const GltfContent& content) {
  std::string json = content.json, binary = content.binary;
  json.resize((json.size() + 3) / 4 * 4, ' ');
  binary.resize((binary.size() + 3) / 4 * 4, '\0');
  std::string out = "glTF";
  append_value(out, uint32_t{2});
  append_value(out, static_cast<uint32_t>(12 + 8 + json.size() + 8 + binary.size()));
  append_value(out, static_cast<uint32_t>(json.size()));
  out += "JSON" + json;
  append_value(out, static_cast<uint32_t>(binary.size()));
  out += std::string("BIN\0", 4) + binary;
  return out;
}

WriteReport write_glb(const AnimatedMesh& mesh, const fs::path& path, const WriteOptions& options,
                      OutputSet& files, const RunContext& ctx) {
  GltfContent content = encode_gltf(mesh, options, "", ctx);
  if (content.binary.size() > 0xF0000000U) {
    throw InputError({.what = "a GLB file holds at most 4 GiB", .file = path.string()});
  }
  files.add(path, glb_of(content));
  return content.report;
}

WriteReport write_gltf(const AnimatedMesh& mesh, const fs::path& path, const WriteOptions& options,
                       OutputSet& files, const RunContext& ctx) {
  fs::path beside = path;
  beside.replace_extension(".bin");
  GltfContent content =
      encode_gltf(mesh, options, percent_encoded(beside.filename().string()), ctx);
  files.add(path, content.json);
  files.add(beside, content.binary);
  return content.report;
}

}  // namespace

std::string decoded_uri(const std::string& uri) {
  std::string out;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] == '%' && i + 2 < uri.size()) {
      out += static_cast<char>(std::strtol(uri.substr(i + 1, 2).c_str(), nullptr, 16));
      i += 2;
    } else {
      out += uri[i];
    }
  }
  return out;
}

GltfContent encode_gltf(const AnimatedMesh& mesh, const WriteOptions& options,
                        const std::string& buffer_uri, const RunContext& ctx) {
  return GltfWriter(mesh, options, ctx).write(buffer_uri);
}

Format glb_format();
Format glb_format() {
  Format format =
      make_format("glb", ".glb", "glTF 2.0, one file, morph targets",
                  Keeps::description_and_filled(), "PCA of the motion within a budget or an error");
  format.fixed_unit = true;
  format.decode = [](std::span<const std::byte> bytes, const std::string& name) {
    return decode_gltf(bytes, name);
  };
  format.write = write_glb;
  return format;
}

Format gltf_format();
Format gltf_format() {
  Format format = glb_format();
  format.name = "gltf";
  format.extensions = {".gltf"};
  format.description = "glTF 2.0 with a .bin of the same stem, morph targets";
  format.read = [](const fs::path& path, const ReadOptions&, const RunContext&) {
    const Buffer<std::byte> bytes = load_bytes(path);
    return decode_gltf(bytes.span(), path.string(), [&path](const std::string& uri) {
      const Buffer<std::byte> buffer = load_bytes(path.parent_path() / uri);
      return std::string(text_of(buffer.span()));
    });
  };
  format.write = write_gltf;
  return format;
}

}  // namespace kinemesh
