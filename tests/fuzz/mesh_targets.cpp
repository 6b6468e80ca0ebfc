// The readers of the mesh formats as fuzz targets. Each grows from files that we write ourselves
// and from small files of its kind below the data folder.
#include "tests/fuzz/mesh_targets.h"

#include <filesystem>

#include "config/input_file.h"
#include "mesh/formats/bytes.h"
#include "mesh/formats/gltf.h"
#include "mesh/formats/mesh_io.h"
#include "mesh/formats/point_cache.h"
#include "mesh/formats/vtp.h"
#include "report/image.h"
#include "tests/support/random_animation.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::fuzz {
namespace {

/// The files of a small animation in this format, as one seed for each encoding.
std::vector<Seed> seeds_by_writing(const std::string& file, const std::string& extension,
                                   const std::vector<Encoding>& encodings) {
  const FormatRegistry formats = builtin_mesh_formats();
  std::vector<Seed> seeds;
  for (const Encoding encoding : encodings) {
    const test::TemporaryFolder folder;
    WriteOptions options;
    options.encoding = encoding;
    const AnimatedMesh mesh = extension == ".glb" ? test::smooth_animation(5, 4, 40, 60.0)
                                                  : test::random_animation(5, 4, 2);
    for (const auto& path : write_animation(formats, mesh, folder.path() / file, options).files) {
      if (path.extension() != extension) continue;
      seeds.push_back({.name = "made-" + path.filename().string() + "-" +
                               std::to_string(static_cast<int>(encoding)),
                       .bytes = read_file(path)});
      break;
    }
  }
  return seeds;
}

/// Decodes, and builds the mesh: faces and units are checked there.
Outcome build(MeshData data) {
  return to_animated_mesh(std::move(data), {}, "mutant").frame_count() > 0
             ? Outcome::read
             : Outcome::read_with_findings;
}

Target target_of(const std::string& format_name, const std::string& file,
                 const std::vector<Encoding>& encodings) {
  const FormatRegistry formats = builtin_mesh_formats();
  const Format format = *formats.find(format_name);
  const std::string extension = format.extensions.front();
  return {.name = format_name,
          .extensions = {extension},
          .run =
              [format](std::span<const std::byte> bytes) {
                return build(format.decode(bytes, "mutant"));
              },
          .own_seeds = [=] { return seeds_by_writing(file, extension, encodings); },
          .payload = {},
          .max_seed_bytes = std::size_t{1} << 17};
}

std::vector<Seed> stl_seeds() {
  std::string binary(80, 'x');
  append_value(binary, uint32_t{3});
  for (int i = 0; i < 3 * 12; ++i) {
    append_value(binary, static_cast<float>(i % 5));
    if (i % 12 == 11) binary += std::string(2, '\0');
  }
  return {{.name = "made-binary", .bytes = binary},
          {.name = "made-ascii",
           .bytes =
               "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
               "endloop\nendfacet\nendsolid a\n"}};
}

Target bytes_target(const std::string& name, const std::string& file, const std::string& extension,
                    MeshData (*decode)(std::span<const std::byte>, const std::string&)) {
  return {
      .name = name,
      .extensions = {extension},
      .run = [decode](std::span<const std::byte> bytes) { return build(decode(bytes, "mutant")); },
      .own_seeds = [=] { return seeds_by_writing(file, extension, {Encoding::binary}); },
      .payload = {},
      .max_seed_bytes = std::size_t{1} << 17};
}

Outcome read_pvd_bytes(std::span<const std::byte> bytes) {
  decode_pvd(bytes, "mutant.pvd");
  return Outcome::read;
}

std::string written(const AnimatedMesh& mesh, const std::string& file) {
  const test::TemporaryFolder folder;
  write_animation(builtin_mesh_formats(), mesh, folder.path() / "a.gltf");
  return read_file(folder.path() / file);
}

/// The JSON form: its numbers in a file beside it, and the same inside as base64.
std::vector<Seed> gltf_seeds() {
  const AnimatedMesh mesh = test::smooth_animation(5, 4, 40, 60.0);
  std::string inside = written(mesh, "a.gltf");
  const std::size_t at = inside.find("\"a.bin\"");
  inside.replace(at, 7,
                 "\"data:application/octet-stream;base64," + base64(written(mesh, "a.bin")) + '"');
  return {{.name = "made-beside", .bytes = written(mesh, "a.gltf")},
          {.name = "made-inside", .bytes = inside}};
}

Target gltf_target() {
  return {
      .name = "gltf",
      .extensions = {".gltf"},
      .run =
          [](std::span<const std::byte> bytes) {
            static const std::string beside =
                written(test::smooth_animation(5, 4, 40, 60.0), "a.bin");
            return build(decode_gltf(bytes, "mutant", [](const std::string&) { return beside; }));
          },
      .own_seeds = gltf_seeds,
      .payload = {},
      .max_seed_bytes = std::size_t{1} << 17};
}

}  // namespace

std::vector<Target> mesh_targets() {
  const std::vector<Encoding> all{Encoding::binary, Encoding::binary_big, Encoding::ascii};
  std::vector<Target> targets{target_of("ply", "a_##.ply", all),
                              target_of("obj", "a_##.obj", {Encoding::ascii}),
                              target_of("off", "a_##.off", {Encoding::ascii}),
                              target_of("vtp", "a_##.vtp", all),
                              target_of("npz", "a.npz", {Encoding::binary}),
                              target_of("glb", "a.glb", {Encoding::binary}),
                              bytes_target("pc2", "a.pc2", ".pc2", decode_pc2),
                              bytes_target("mdd", "a.mdd", ".mdd", decode_mdd)};
  targets.push_back(gltf_target());
  Target stl = target_of("stl", "", {});
  stl.own_seeds = stl_seeds;
  targets.push_back(stl);
  targets.push_back(
      {.name = "pvd",
       .extensions = {".pvd"},
       .run = read_pvd_bytes,
       .own_seeds = [] { return seeds_by_writing("a.pvd", ".pvd", {Encoding::binary}); },
       .payload = {},
       .max_seed_bytes = std::size_t{1} << 17});
  return targets;
}

}  // namespace kinemesh::fuzz
