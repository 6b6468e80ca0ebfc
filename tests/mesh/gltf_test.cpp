// glTF: strict validity as the specification of glTF 2.0 demands it, and how much of the motion is
// kept for how many bytes.
#include "mesh/formats/gltf.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "config/error.h"
#include "config/input_file.h"
#include "mesh/formats/bytes.h"
#include "mesh/formats/mesh_io.h"
#include "mesh/formats/morph_animation.h"
#include "mesh/movement.h"
#include "tests/support/random_animation.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::gltf_test {
namespace {

using Json = nlohmann::json;
using test::TemporaryFolder;

struct Glb {
  Json json;
  std::string binary;
};

/// Section 4.4: the container.
Glb parse_glb(const std::string& file) {
  Glb glb;
  const auto word = [&file](std::size_t at) { return load_value<uint32_t>(&file.at(at)); };
  EXPECT_EQ(file.substr(0, 4), "glTF");
  EXPECT_EQ(word(4), 2U);
  EXPECT_EQ(word(8), file.size());
  const uint32_t json = word(12);
  EXPECT_EQ(file.substr(16, 4), "JSON");
  EXPECT_EQ(json % 4, 0U);
  glb.json = Json::parse(file.substr(20, json));
  const uint32_t binary = word(20 + json);
  EXPECT_EQ(file.substr(24 + json, 4), std::string("BIN\0", 4));
  EXPECT_EQ(binary % 4, 0U);
  EXPECT_EQ(28 + json + binary, file.size());
  glb.binary = file.substr(28 + json);
  const auto length = glb.json["buffers"][0]["byteLength"].get<std::size_t>();
  EXPECT_LE(length, binary);
  EXPECT_LE(binary - length, 3U);
  return glb;
}

std::size_t component_size(int type) {
  return type == 5120 || type == 5121 ? 1 : type == 5122 || type == 5123 ? 2 : 4;
}

std::size_t components(const std::string& type) {
  return type == "SCALAR" ? 1 : type == "VEC3" ? 3 : type == "VEC4" ? 4 : 0;
}

/// The values of an accessor, its place and alignment checked (section 3.6.2).
std::vector<double> values_of(const Glb& glb, std::size_t index) {
  const Json& accessor = glb.json.at("accessors").at(index);
  const Json& view = glb.json.at("bufferViews").at(accessor.at("bufferView").get<std::size_t>());
  const std::size_t size = component_size(accessor.at("componentType"));
  const std::size_t n = components(accessor.at("type"));
  const auto count = accessor.at("count").get<std::size_t>();
  EXPECT_GE(count, 1U);
  EXPECT_GT(n, 0U);
  const std::size_t offset = accessor.value("byteOffset", std::size_t{0});
  const auto begin = view.at("byteOffset").get<std::size_t>();
  const auto length = view.at("byteLength").get<std::size_t>();
  const std::size_t stride = view.value("byteStride", size * n);
  EXPECT_GE(length, 1U);
  EXPECT_EQ(offset % size, 0U);
  EXPECT_EQ((begin + offset) % size, 0U);
  if (view.contains("byteStride")) {
    EXPECT_GE(stride, 4U);
    EXPECT_LE(stride, 252U);
    EXPECT_EQ(stride % 4, 0U);
  }
  EXPECT_LE(offset + stride * (count - 1) + size * n, length);
  EXPECT_LE(begin + length, glb.json["buffers"][0]["byteLength"].get<std::size_t>());
  std::vector<double> out;
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t c = 0; c < n; ++c) {
      const char* at = glb.binary.data() + begin + offset + i * stride + c * size;
      const int type = accessor.at("componentType");
      out.push_back(type == 5126   ? static_cast<double>(load_value<float>(at))
                    : type == 5125 ? static_cast<double>(load_value<uint32_t>(at))
                    : type == 5123 ? static_cast<double>(load_value<uint16_t>(at))
                                   : static_cast<double>(load_value<uint8_t>(at)));
    }
  }
  if (accessor.contains("min")) {  // must be the actual bounds, to the bit
    for (std::size_t c = 0; c < n; ++c) {
      double low = out[c], high = out[c];
      for (std::size_t i = c; i < out.size(); i += n) {
        low = std::min(low, out[i]);
        high = std::max(high, out[i]);
      }
      EXPECT_EQ(accessor["min"][c].get<double>(), low);
      EXPECT_EQ(accessor["max"][c].get<double>(), high);
    }
  }
  for (const double v : out) EXPECT_TRUE(std::isfinite(v));
  return out;
}

void expect_bounds(const Glb& glb, std::size_t accessor) {
  EXPECT_TRUE(glb.json["accessors"][accessor].contains("min"));
  EXPECT_TRUE(glb.json["accessors"][accessor].contains("max"));
}

/// A view serves one purpose, with the target that goes with it (3.6.1.2, 3.7.2.1).
void expect_view_target(const Glb& glb, std::size_t accessor, int target) {
  const auto view = glb.json["accessors"][accessor]["bufferView"].get<std::size_t>();
  EXPECT_EQ(glb.json["bufferViews"][view].value("target", 0), target);
}

void expect_valid_attributes(const Glb& glb, const Json& primitive, std::size_t vertices) {
  const Json& attributes = primitive.at("attributes");
  const auto position = attributes.at("POSITION").get<std::size_t>();
  expect_bounds(glb, position);
  expect_view_target(glb, position, 34962);
  EXPECT_EQ(values_of(glb, position).size(), 3 * vertices);
  const std::vector<double> normals = values_of(glb, attributes.at("NORMAL"));
  ASSERT_EQ(normals.size(), 3 * vertices);
  for (std::size_t i = 0; i < normals.size(); i += 3) {
    EXPECT_NEAR(std::hypot(normals[i], normals[i + 1], normals[i + 2]), 1.0, 1e-5);
  }
  if (!attributes.contains("COLOR_0")) return;
  const Json& colour = glb.json["accessors"][attributes["COLOR_0"].get<std::size_t>()];
  EXPECT_EQ(colour["type"], "VEC4");
  EXPECT_TRUE(colour["normalized"].get<bool>());
  EXPECT_EQ(colour["count"], vertices);
  values_of(glb, attributes["COLOR_0"]);
}

void expect_valid_animation(const Glb& glb, std::size_t targets) {
  for (const Json& animation : glb.json.value("animations", Json::array())) {
    std::set<std::string> used;
    for (const Json& channel : animation.at("channels")) {
      const Json& target = channel.at("target");
      EXPECT_TRUE(used.insert(target.dump()).second);
      EXPECT_EQ(target.at("path"), "weights");
      const Json& sampler = animation.at("samplers").at(channel.at("sampler").get<std::size_t>());
      const auto input = sampler.at("input").get<std::size_t>();
      expect_bounds(glb, input);
      expect_view_target(glb, input, 0);
      EXPECT_EQ(glb.json["accessors"][input]["componentType"], 5126);
      const std::vector<double> times = values_of(glb, input);
      EXPECT_GE(times.front(), 0.0);
      for (std::size_t i = 1; i < times.size(); ++i) EXPECT_GT(times[i], times[i - 1]);
      EXPECT_EQ(values_of(glb, sampler.at("output")).size(), times.size() * targets);
      EXPECT_EQ(sampler.value("interpolation", "LINEAR"), "LINEAR");
    }
  }
}

/// Everything that the standard demands of what we write.
void expect_valid(const Glb& glb, std::size_t vertices) {
  EXPECT_EQ(glb.json.at("asset").at("version"), "2.0");
  EXPECT_FALSE(glb.json.contains("extensionsRequired"));
  const Json& mesh = glb.json.at("meshes").at(0);
  const Json& primitive = mesh.at("primitives").at(0);
  expect_valid_attributes(glb, primitive, vertices);
  const auto indices = primitive.at("indices").get<std::size_t>();
  expect_view_target(glb, indices, 34963);
  const bool wide = glb.json["accessors"][indices]["componentType"] == 5125;
  for (const double v : values_of(glb, indices)) {
    EXPECT_LT(v, static_cast<double>(vertices));
    EXPECT_NE(v, wide ? 4294967295.0 : 65535.0);
  }
  const std::size_t targets = primitive.value("targets", Json::array()).size();
  for (const Json& target : primitive.value("targets", Json::array())) {
    expect_bounds(glb, target.at("POSITION"));
    expect_view_target(glb, target.at("POSITION"), 34962);
    EXPECT_EQ(values_of(glb, target.at("POSITION")).size(), 3 * vertices);
  }
  if (targets > 0) {
    EXPECT_EQ(mesh.at("weights").size(), targets);
    EXPECT_EQ(mesh.at("extras").at("targetNames").size(), targets);
    for (const Json& weight : mesh.at("weights")) {
      EXPECT_GE(weight.get<double>(), 0.0);
      EXPECT_LE(weight.get<double>(), 1.0);
    }
  }
  for (const Json& node : glb.json.at("nodes")) EXPECT_EQ(node.at("mesh"), 0);
  EXPECT_EQ(glb.json["scenes"][glb.json["scene"].get<std::size_t>()]["nodes"], Json({0}));
  EXPECT_LT(primitive.value("material", 0), glb.json.at("materials").size());
  expect_valid_animation(glb, targets);
}

double largest_distance(const AnimatedMesh& a, const AnimatedMesh& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.positions().size(); i += 3) {
    largest = std::max(largest, std::hypot(double{a.positions()[i]} - b.positions()[i],
                                           double{a.positions()[i + 1]} - b.positions()[i + 1],
                                           double{a.positions()[i + 2]} - b.positions()[i + 2]));
  }
  return largest;
}

/// Writes, checks validity, and reads back.
struct Written {
  WriteReport report;
  std::size_t bytes = 0;
  Json json;
  AnimatedMesh back;
};

Written round_trip(const AnimatedMesh& mesh, const GltfOptions& options) {
  const TemporaryFolder folder;
  const FormatRegistry formats = builtin_mesh_formats();
  Written w;
  const auto path = folder.path() / "a.glb";
  w.report = write_animation(formats, mesh, path, {.gltf = options}).report;
  const std::string content = read_file(path);
  w.bytes = content.size();
  const Glb glb = parse_glb(content);
  expect_valid(glb, mesh.vertex_count());
  w.json = glb.json;
  w.back = read_animation(formats, path);
  return w;
}

TEST(Gltf, IsValidAndComesBackWithinTheErrorItStates) {
  AnimatedMesh mesh = test::smooth_animation(14, 12, 300, 120.0);
  mesh.vertex_names.assign(mesh.vertex_count(), "name");
  mesh.first_frame = 17;
  const Written w = round_trip(mesh, {.budget_mb = 0.1, .colour = VertexColour::deformation});
  EXPECT_LE(w.bytes, 100000U);
  EXPECT_GT(w.report.max_error_mm, 0.0);
  EXPECT_LT(w.report.rms_error_mm, 0.05);
  ASSERT_EQ(w.back.frame_count(), 300U);
  EXPECT_EQ(w.back.rate_hz, 120.0);
  test::expect_same_description(mesh, w.back);
  // The reader plays in double: single precision makes up the small rest.
  EXPECT_NEAR(largest_distance(mesh, w.back), w.report.max_error_mm, 2e-4);
  EXPECT_EQ(w.json["asset"]["extras"]["kinemesh"]["max_error_mm"], w.report.max_error_mm);
}

TEST(Gltf, IsInMetresWithYUp) {
  const AnimatedMesh mesh = test::smooth_animation(4, 4, 1, 60.0);
  const Written w = round_trip(mesh, {});
  EXPECT_LT(largest_distance(mesh, w.back), 1e-4);
  const Json& position = w.json["accessors"][0];
  EXPECT_NEAR(position["max"][0].get<double>(), 0.030, 1e-6);   // x stays
  EXPECT_NEAR(position["min"][2].get<double>(), -0.030, 1e-6);  // y goes to −z
  const Written y_up = round_trip(mesh, {.up = GltfUp::y});
  EXPECT_NEAR(y_up.json["accessors"][0]["max"][1].get<double>(), 0.030, 1e-6);
  EXPECT_LT(largest_distance(mesh, y_up.back), 1e-4);
}

TEST(Gltf, AnErrorAskedForIsKeptBySmallFiles) {
  const AnimatedMesh mesh = test::smooth_animation(12, 12, 240, 120.0);
  std::size_t previous = std::numeric_limits<std::size_t>::max();
  for (const double error : {0.005, 0.05, 0.5}) {
    const Written w = round_trip(mesh, {.max_error_mm = error});
    EXPECT_LE(w.report.max_error_mm, error);
    EXPECT_LE(largest_distance(mesh, w.back), error + 2e-4);
    EXPECT_LT(w.bytes, previous);
    previous = w.bytes;
  }
  EXPECT_THROW(round_trip(mesh, {.max_error_mm = 1e-9}), NoResultError);
  EXPECT_THROW(round_trip(test::smooth_animation(40, 40, 5, 60.0), {.budget_mb = 0.01}),
               NoResultError);
}

TEST(Gltf, MoreBudgetMeansLessErrorUntilItIsNegligible) {
  const AnimatedMesh mesh = test::random_animation(12, 12, 100);
  double previous = std::numeric_limits<double>::infinity();
  for (const double budget : {0.06, 0.1, 0.2}) {
    const Written w = round_trip(mesh, {.budget_mb = budget});
    EXPECT_LE(static_cast<double>(w.bytes), budget * 1e6);
    EXPECT_LT(w.report.rms_error_mm, previous);
    previous = w.report.rms_error_mm;
  }
}

TEST(Gltf, MoreMorphTargetsThanEveryViewerHoldsAreSaid) {
  const auto said = [](std::size_t frames) {
    const Written w = round_trip(test::random_animation(12, 12, frames), {});
    return std::ranges::any_of(w.report.notes, [](const std::string& note) {
      return note.find("not every viewer holds") != std::string::npos;
    });
  };
  EXPECT_FALSE(said(200));
  EXPECT_TRUE(said(300));  // no two frames are alike: a target for each but one
}

TEST(Gltf, TwoFilesAndDataUrisAreRead) {
  const AnimatedMesh mesh = test::smooth_animation(6, 6, 20, 60.0);
  const TemporaryFolder folder;
  const FormatRegistry formats = builtin_mesh_formats();
  const auto path = folder.path() / "a b.gltf";
  const WriteResult result = write_animation(formats, mesh, path);
  ASSERT_EQ(result.files.size(), 2U);
  EXPECT_EQ(result.files[1].filename(), "a b.bin");
  EXPECT_LT(largest_distance(mesh, read_animation(formats, path)), 0.01);
  const std::string json = R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0,"scale":[2,2,2]}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
    "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":
    "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})";
  write_file(folder.path() / "c.gltf", json);
  const AnimatedMesh triangle = read_animation(formats, folder.path() / "c.gltf");
  ASSERT_EQ(triangle.topology().face_count(), 1U);
  EXPECT_EQ(triangle.position(0, 1), Eigen::Vector3f(2000, 0, 0));
  EXPECT_EQ(triangle.position(0, 2), Eigen::Vector3f(0, 0, 2000));  // Y up becomes Z up
}

TEST(Gltf, DamagedFilesAreExplained) {
  const auto message = [](std::string text) {
    try {
      decode_gltf(std::as_bytes(std::span(text)), "x.gltf");
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string("no error");
  };
  EXPECT_NE(message("{\"asset\"").find("the JSON of the file is malformed"), std::string::npos);
  EXPECT_NE(message("{}").find("no glTF of version 2"), std::string::npos);
  EXPECT_NE(message(R"({"asset":{"version":"2.0"},"nodes":[{"children":[0]}]})").find("cycle"),
            std::string::npos);
  EXPECT_NE(message(R"({"asset":{"version":"2.0"},"nodes":[{"mesh":7}]})").find("meshes[7]"),
            std::string::npos);
  EXPECT_NE(message(R"({"asset":{"version":"2.0"},"nodes":[{"mesh":"x"}]})").find("whole number"),
            std::string::npos);
  EXPECT_NE(message(R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{"primitives":
    [{"attributes":{"POSITION":0}}]}],"accessors":[{"componentType":5126,"type":"VEC3",
    "count":1000000000000}]})")
                .find("more elements than the file has bytes"),
            std::string::npos);
  const std::string deep(300000, '[');
  EXPECT_NE(message(R"({"asset":{"version":"2.0"},"scenes":[{"nodes":)" + deep).find("nested"),
            std::string::npos);
}

TEST(Gltf, RequiredExtensionsThatAreNotReadAreRefused) {
  const std::string zeros(16, 'A');
  const auto read = [&](const std::string& extension) {
    const std::string text = R"({"asset":{"version":"2.0"},"extensionsRequired":[")" + extension +
                             R"("],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"mode":0,
      "attributes":{"POSITION":0}}]}],"accessors":[{"bufferView":0,"componentType":5120,
      "count":4,"type":"VEC3"}],"bufferViews":[{"buffer":0,"byteLength":12}],"buffers":[
      {"byteLength":12,"uri":"data:application/octet-stream;base64,)" +
                             zeros + R"("}]})";
    return decode_gltf(std::as_bytes(std::span(text)), "x.gltf").vertex_count;
  };
  EXPECT_EQ(read("KHR_mesh_quantization"), 4U);
  EXPECT_THROW(read("KHR_draco_mesh_compression"), InputError);
  EXPECT_THROW(read("EXT_meshopt_compression"), InputError);
}

TEST(Gltf, FramesWithoutMotionComeBack) {
  AnimatedMesh mesh = test::smooth_animation(6, 6, 100, 60.0);
  for (std::size_t f = 1; f < 100; ++f) mesh.frame(f) = mesh.frame(0);
  const Written w = round_trip(mesh, {});
  EXPECT_EQ(w.back.frame_count(), 100U);
  EXPECT_EQ(w.back.rate_hz, 60.0);
}

TEST(Gltf, DataThatManyNodesShareAreBounded) {
  const std::string zeros(4000, 'A');  // base64 of 3,000 zero bytes: 1,000 points of bytes
  std::string text = R"({"asset":{"version":"2.0"},"meshes":[{"primitives":[{"mode":0,"attributes":
    {"POSITION":0}}]}],"accessors":[{"bufferView":0,"componentType":5121,"count":1000,"type":"VEC3"}],
    "bufferViews":[{"buffer":0,"byteLength":3000}],"buffers":[{"byteLength":3000,"uri":
    "data:application/octet-stream;base64,)" +
                     zeros + R"("}],"nodes":[{"mesh":0})";
  const auto read = [&](int nodes) {
    std::string all = text;
    for (int i = 1; i < nodes; ++i) all += R"(,{"mesh":0})";
    all += "]}";
    return decode_gltf(std::as_bytes(std::span(all)), "x.gltf").vertex_count;
  };
  EXPECT_EQ(read(3), 3000U);
  EXPECT_THROW(read(2000), InputError);
}

TEST(MorphAnimation, SplineThroughStraightPiecesIsExact) {
  const std::vector<std::size_t> keys = key_frames(10, 4);
  EXPECT_EQ(keys, (std::vector<std::size_t>{0, 4, 8, 9}));
  std::vector<double> values;
  for (int f = 0; f < 10; ++f) values.push_back(f <= 4 ? 3.0 * f : 12.0 - 2.0 * (f - 4));
  const std::vector<double> fit = fit_linear_spline(values, keys);
  ASSERT_EQ(fit.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(fit[i], values[keys[i]], 1e-12);
}

TEST(Movement, LeavesRigidMotionOut) {
  AnimatedMesh mesh = test::smooth_animation(6, 6, 8, 60.0);
  for (std::size_t f = 0; f < 8; ++f) {
    mesh.frame(f) = mesh.frame(0);
    mesh.position(f, 20).z() += f % 2 == 0 ? 3.0F : -3.0F;
    const Eigen::Matrix3f turn =
        Eigen::AngleAxisf(0.3F * static_cast<float>(f), Eigen::Vector3f::UnitY())
            .toRotationMatrix();
    mesh.frame(f) = (mesh.frame(f) * turn.transpose()).eval();
  }
  const std::vector<double> moved = movement_of(mesh);
  for (std::size_t v = 0; v < 36; ++v) {
    if (v == 20) continue;
    EXPECT_LT(moved[v], 0.6) << v;
  }
  EXPECT_NEAR(moved[20], 3.0, 0.5);  // its own motion turns the frame a little
}

}  // namespace
}  // namespace kinemesh::gltf_test
