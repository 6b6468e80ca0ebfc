// What real files hold beside the plain case, and what damaged ones are told: line or byte, reason.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <functional>

#include "config/error.h"
#include "mesh/formats/bytes.h"
#include "mesh/formats/faces.h"
#include "mesh/formats/mesh_io.h"
#include "mesh/formats/npz.h"
#include "mesh/formats/npz_mesh.h"
#include "mesh/formats/obj.h"
#include "mesh/formats/off.h"
#include "mesh/formats/ply.h"
#include "mesh/formats/point_cache.h"
#include "mesh/formats/stl.h"
#include "mesh/formats/vtk_array.h"
#include "mesh/formats/vtp.h"
#include "tests/support/random_animation.h"
#include "tests/support/temporary_folder.h"

namespace kinemesh::formats_bad_input_test {
namespace {

using Decode = MeshData (*)(std::span<const std::byte>, const std::string&);

MeshData decode(Decode reader, std::string_view text) {
  return reader(std::as_bytes(std::span(text)), "f");
}

std::string refusal(Decode reader, std::string_view text) {
  try {
    decode(reader, text);
  } catch (const InputError& e) {
    return e.what();
  }
  return "no error";
}

#define EXPECT_REFUSED(reader, text, part) \
  EXPECT_NE(refusal(reader, text).find(part), std::string::npos) << refusal(reader, text)

const std::string ply_triangle =
    "ply\r\nformat ascii 1.0\r\ncomment made by hand\r\nobj_info num_cols 3\r\n"
    "element camera 1\r\nproperty float view_px\r\n"
    "element vertex 5\r\nproperty float nx\r\nproperty double x\r\nproperty float y\r\n"
    "property float z\r\nproperty uchar red\r\n"
    "element face 2\r\nproperty uchar flags\r\nproperty list uchar uint vertex_index\r\n"
    "property list uchar float texcoord\r\nelement extra 1\r\nproperty list int int what\r\n"
    "end_header\r\n7.5\r\n\r\n0 0 0 0 255\r\n0 1e0 +0 0 1\r\n0 1 1 0 1\r\n0 0 1 0 1\r\n"
    "0 5 5 5e-60 1\r\n1 4 0 1 2 3 2 0.5 0.5\r\n0 3 0 1 4 0\r\n2 8 9\r\n";

TEST(PlyReader, TakesUnknownElementsPropertiesCommentsPolygonsAndCrlf) {
  const MeshData data = decode(decode_ply, ply_triangle);
  ASSERT_EQ(data.vertex_count, 5U);
  EXPECT_EQ(data.positions[3], 1.0F);
  EXPECT_EQ(data.positions[14], 0.0F);  // too small for a float
  EXPECT_EQ(data.faces, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 1, 4}}));
  EXPECT_EQ(data.polygons, 1U);
}

TEST(PlyReader, TakesBinaryOfEveryTypeAndTriangleStrips) {
  std::string file =
      "ply\nformat binary_big_endian 1.0\nelement vertex 4\nproperty short x\nproperty double y\n"
      "property float z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n";
  for (int v = 0; v < 4; ++v) {
    append_value(file, static_cast<int16_t>(v - 2), true);
    append_value(file, 0.25 * v, true);
    append_value(file, 1.5F, true);
  }
  append_value(file, int32_t{5}, true);
  for (const int32_t v : {0, 1, 2, 3, -1}) append_value(file, v, true);
  const MeshData data = decode(decode_ply, file);
  EXPECT_EQ(data.positions[0], -2.0F);
  EXPECT_EQ(data.positions[10], 0.75F);
  EXPECT_EQ(data.faces, (std::vector<Triangle>{{0, 1, 2}, {2, 1, 3}}));
}

TEST(PlyReader, DamagedFilesNameLineOrByte) {
  EXPECT_REFUSED(decode_ply, "", "f: line 1: this is no PLY file");
  EXPECT_REFUSED(decode_ply, "ply\nformat ascii 2.0\n", "line 3: the header has no end");
  EXPECT_REFUSED(decode_ply, "ply\nformat odd 1.0\nend_header\n", "line 2: the format 'odd'");
  EXPECT_REFUSED(decode_ply, "ply\nformat ascii 1.0\nend_header\n", "no element 'vertex'");
  EXPECT_REFUSED(decode_ply, "ply\nformat ascii 1.0\nelement vertex -4\nend_header\n", "line 3");
  const std::string head =
      "format ascii 1.0\nelement vertex 2\nproperty float x\n"
      "property float y\nproperty float z\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n";
  EXPECT_REFUSED(decode_ply, "ply\n" + head + "0 0 0\n0 0 zero\n3 0 1 0\n",
                 "f: line 11: 'zero' stands where a vertex's property should be");
  EXPECT_REFUSED(decode_ply, "ply\n" + head + "0 0 0\n0 0\n3 0 1 0\n", "line 11");
  EXPECT_REFUSED(decode_ply, "ply\n" + head + "0 0 0 9\n0 0 0\n3 0 1 0\n", "more values");
  EXPECT_REFUSED(decode_ply, "ply\n" + head + "0 0 0\n0 0 0\n3 0 1 2\n",
                 "line 12: a face refers to vertex 2 (0-based), but there are only 2");
  EXPECT_REFUSED(decode_ply, "ply\n" + head + "0 0 0\n0 0 0\n",
                 "line 12: the file ends within element 'face'");
  const std::string large =
      "ply\nformat binary_little_endian 1.0\nelement vertex 999999999999999999\n"
      "property float x\nproperty float y\nproperty float z\nend_header\n";
  EXPECT_REFUSED(decode_ply, large, "the file is too short for them");
  std::string cut =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\n"
      "property float y\nproperty float z\nelement face 2\n"
      "property list uchar int vertex_indices\nend_header\n";
  const std::size_t begin = cut.size();
  cut += std::string(12, '\0') + "\x03" + std::string(12, '\0');
  EXPECT_REFUSED(decode_ply, cut,
                 "byte " + std::to_string(begin + 25) +
                     ": the file ends within element 'face', at row 1 of 2");
  cut[begin + 13] = 9;
  EXPECT_REFUSED(decode_ply, cut + cut,
                 "byte " + std::to_string(begin + 13) + ": a face refers to vertex 9");
}

TEST(ObjReader, TakesNegativeIndicesPolygonsContinuationsAndUnknownStatements) {
  const MeshData data = decode(
      decode_obj,
      "# comment\r\nmtllib x.mtl\r\no thing\r\nv 0 0 0 1.0\r\nv 2 0 0\r\nvt 0 0\r\nvn 0 0 1\r\n"
      "v 2 2 0 0.5 0.5 0.5\r\nv 0 2 0\r\ng a b\r\nusemtl m\r\ns off\r\n"
      "f -4//-1 -3//1 -2//1 \\\r\n  -1//1\r\nf 1/1 2/1/1 3 # end\r\nl 1 2\r\ncurv2 1 2 \\\r\n 3 "
      "4\r\nf 4 2 3");
  EXPECT_EQ(data.vertex_count, 4U);
  EXPECT_EQ(data.faces, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 1, 2}, {3, 1, 2}}));
}

TEST(ObjReader, DamagedFilesNameTheLine) {
  EXPECT_REFUSED(decode_obj, "v 0 0 0\nv 1 0\n", "f: line 2: a coordinate is missing");
  EXPECT_REFUSED(decode_obj, "v 0 0 0\nf 1 2 3\nv 1 0 0\n",
                 "f: line 2: a face refers to vertex 3 (1-based), but there are only 2");
  EXPECT_REFUSED(decode_obj, "v 0 0 0\nf 0 1 1\n", "OBJ counts from 1");
  EXPECT_REFUSED(decode_obj, "v 0 0 0\nf 1 -2 1\n", "line 2: a face refers to vertex -2");
  EXPECT_REFUSED(decode_obj, "v 0 0 0\nf 1 1x 1\n", "line 2");
  EXPECT_REFUSED(decode_obj, std::string("\0\x01\x02", 3), "a word of OBJ");
}

TEST(OffReader, TakesHeadersWithColoursNormalsCommentsAndNoKeyword) {
  const std::string rest =
      "4 1 0 # counts\n0 0 0 9 9\n\n1 0 0 9 9\n# between\n1 1 0\n0 1 0\n4 0 1 2 3 0.5 0.5 0.5\n";
  for (const std::string head : {"OFF\n", "COFF\r\n", "NOFF # x\n", "OFF ", ""}) {
    const MeshData data = decode(decode_off, head + rest);
    EXPECT_EQ(data.vertex_count, 4U) << head;
    EXPECT_EQ(data.faces.size(), 2U) << head;
  }
  EXPECT_REFUSED(decode_off, "OFF\n3 1 0\n0 0 0.00000\n1 0 0.00000\n",
                 "line 5: the file ends at vertex 2 of 3");
  EXPECT_REFUSED(decode_off, "OFF\n3000000 1 0\n0 0 0\n", "too short");
  EXPECT_REFUSED(decode_off, "4OFF\n1 0 0\n0 0 0 0\n", "other than three dimensions");
  EXPECT_REFUSED(decode_off, "OFF BINARY\n", "binary OFF is not read");
  EXPECT_REFUSED(decode_off, "OFX\n1 0 0\n0 0 0\n", "this is no OFF file");
  EXPECT_REFUSED(decode_off, "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n",
                 "line 6: a face refers to vertex 3");
}

TEST(StlReader, MergesEqualCornersOfBothKinds) {
  const std::string ascii =
      "solid x\nfacet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 1 0\n"
      " endloop\nendfacet\nfacet normal 0 0 1\n outer loop\n  vertex 1 0 0\n  vertex 1 1 0\n"
      "  vertex -0 1 0\n endloop\nendfacet\nendsolid x\n";
  const std::vector<Triangle> faces{{0, 1, 2}, {1, 3, 2}};
  EXPECT_EQ(decode(decode_stl, ascii).faces, faces);
  std::string binary = "solid that is binary" + std::string(60, ' ');
  append_value(binary, uint32_t{2});
  for (const float corner : {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}) {
    if ((binary.size() - 84) % 50 == 0) binary += std::string(12, '\0');
    append_value(binary, corner);
    if ((binary.size() - 84) % 50 == 48) binary += std::string(2, '\0');
  }
  const MeshData data = decode(decode_stl, binary);
  EXPECT_EQ(data.faces, faces);
  EXPECT_EQ(data.vertex_count, 4U);
  EXPECT_REFUSED(decode_stl, binary.substr(0, 100), "line 1");
  binary[0] = 'x';
  EXPECT_REFUSED(decode_stl, binary.substr(0, 100),
                 "byte 84: the file ends here, but 100 bytes should follow");
  EXPECT_REFUSED(decode_stl, "solid\nfacet\nvertex 1 2 3\nendfacet\n",
                 "line 4: a facet has 1 vertex");
}

TEST(PointCaches, DamagedFilesNameTheByte) {
  std::string pc2("POINTCACHE2\0\1\0\0\0", 16);
  append_value(pc2, int32_t{1000000});
  pc2 += std::string(8, '\0');
  append_value(pc2, int32_t{2000000});
  EXPECT_REFUSED(decode_pc2, pc2,
                 "byte 32: the file ends here, but the header promises 2000000 frames");
  EXPECT_REFUSED(decode_pc2, pc2.substr(0, 20), "within the header");
  EXPECT_REFUSED(decode_pc2, "x" + pc2, "this is no PC2 file");
  EXPECT_REFUSED(decode_mdd, std::string("\0\0\0\1\x7f\0\0\0zzzz", 12),
                 "the header promises 1 frame");
  EXPECT_REFUSED(decode_mdd, std::string("\xff\0\0\1\0\0\0\1", 8), "byte 0");
}

TEST(PointCaches, GeometryOfAnotherMeshIsRefused) {
  const test::TemporaryFolder folder;
  const FormatRegistry formats = builtin_mesh_formats();
  write_animation(formats, test::random_animation(4, 4, 3), folder.path() / "a.ply");
  write_mesh(formats, test::random_animation(5, 4, 1).mesh_at(0), folder.path() / "b.ply");
  std::filesystem::rename(folder.path() / "b.ply", folder.path() / "a.ply");
  EXPECT_THROW(read_animation(formats, folder.path() / "a.pc2"), InputError);
  std::filesystem::remove(folder.path() / "a.ply");
  EXPECT_EQ(read_animation(formats, folder.path() / "a.pc2").topology().face_count(), 0U);
}

std::string vtp(const std::string& root, const std::string& points, const std::string& appended) {
  return "<?xml version=\"1.0\"?><!-- c --><VTKFile type=\"PolyData\" " + root +
         "><PolyData><Piece NumberOfPoints=\"3\"><Points>" + points +
         "</Points><Polys><DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2"
         "</DataArray><DataArray type=\"UInt8\" Name=\"offsets\">3</DataArray></Polys></Piece>"
         "</PolyData>" +
         appended + "</VTKFile>";
}

/// Nine floats 0 … 8 as base64, the length in front as VTK writes it; and zlib-compressed.
const std::string base64_points = "JAAAAAAAAAAAAIA/AAAAQAAAQEAAAIBAAACgQAAAwEAAAOBAAAAAQQ==";

TEST(VtpReader, TakesTextBase64AndZlib) {
  const std::string attributes = "type=\"Float32\" Name=\"p\" NumberOfComponents=\"3\" ";
  const auto check = [](const std::string& file) {
    const MeshData data = decode(decode_vtp, file);
    ASSERT_EQ(data.vertex_count, 3U);
    for (std::size_t i = 0; i < 9; ++i) EXPECT_EQ(data.positions[i], static_cast<float>(i));
    EXPECT_EQ(data.faces, (std::vector<Triangle>{{0, 1, 2}}));
  };
  check(vtp("version=\"0.1\"",
            "<DataArray " + attributes + "format=\"ascii\">0 1 2\n 3 4 5 6 7 8 </DataArray>", ""));
  check(
      vtp("version=\"0.1\"",
          "<DataArray " + attributes + "format=\"binary\">\n  " + base64_points + "\n</DataArray>",
          ""));
  check(vtp("version=\"0.1\"", "<DataArray " + attributes + "format=\"appended\" offset=\"4\"/>",
            "<AppendedData encoding=\"base64\">\n _AAAA" + base64_points + "</AppendedData>"));
  // Block count 1, block size 36, size of a last partial block 0, compressed size; then the block.
  const std::string zlib = "AQAAACQAAAAAAAAAHwAAAA==eJxjYACBBnsg4QBEQNwAxAuA+AAQPwBiBkcAUQgFgQ==";
  const auto compressed = [&](const std::string& content) {
    return vtp("version=\"1.0\" compressor=\"vtkZLibDataCompressor\"",
               "<DataArray " + attributes + "format=\"binary\">" + content + "</DataArray>", "");
  };
  check(compressed(zlib));
  std::string damaged = zlib;
  damaged[40] = damaged[40] == 'A' ? 'B' : 'A';
  EXPECT_REFUSED(decode_vtp, compressed(damaged), "cannot be decompressed");
}

TEST(VtpReader, DamagedFilesAreExplained) {
  EXPECT_REFUSED(decode_vtp, "<VTKFile><PolyData>\n</Poly>",
                 "line 2: </Poly> closes no open element");
  EXPECT_REFUSED(decode_vtp, "<a b=c/>", "line 1: the value of 'b' is not quoted");
  EXPECT_REFUSED(decode_vtp, "<svg/>", "no VTK XML file");
  EXPECT_REFUSED(decode_vtp, "", "there is no element");
  EXPECT_REFUSED(decode_vtp, vtp("compressor=\"vtkLZ4DataCompressor\"", "", ""),
                 "vtkLZ4DataCompressor is not read");
  EXPECT_REFUSED(decode_vtp,
                 vtp("x=\"\"", "<DataArray Name=\"p\" format=\"binary\">////fwAA</DataArray>", ""),
                 "array 'p'");
  EXPECT_REFUSED(decode_vtp, vtp("x=\"\"", "<DataArray Name=\"p\">0 0 0 1 1 1</DataArray>", ""),
                 "refers to point 2");
  EXPECT_REFUSED(decode_vtp,
                 vtp("x=\"\"", "<DataArray Name=\"p\" format=\"appended\" offset=\"99\"/>",
                     "<AppendedData encoding=\"raw\">_123</AppendedData>"),
                 "behind the end");
  std::string deep;
  for (int i = 0; i < 100000; ++i) deep += "<a>";
  EXPECT_REFUSED(decode_vtp, deep, "nested too deeply");
  EXPECT_EQ(decode_base64("TWE=TWFu"), "MaMan");  // VTK pads in the middle
}

TEST(Polygons, ConvexOnesBecomeFansConcaveOnesKeepTheirShape) {
  // An L seen from above; a fan from corner 0 would leave it.
  const std::vector<float> l{1, 1, 0, 0, 1, 0, 0, 0, 0, 3, 0, 0, 3, 3, 0, 1, 3, 0};
  std::vector<Triangle> out;
  triangulate_polygon(std::vector<VertexIndex>{0, 1, 2, 3, 4, 5}, l.data(), out);
  ASSERT_EQ(out.size(), 4U);
  double area = 0;
  for (const Triangle& t : out) {
    const auto p = [&l](VertexIndex v) { return Eigen::Vector2f(l[3 * v], l[3 * v + 1]); };
    const Eigen::Vector2f a = p(t[1]) - p(t[0]), b = p(t[2]) - p(t[0]);
    const float twice = a.x() * b.y() - a.y() * b.x();
    EXPECT_GT(twice, 0.0F);
    area += 0.5 * twice;
  }
  EXPECT_NEAR(area, 7.0, 1e-6);
}

TEST(Formats, AFullDiskLeavesNothingBehind) {
  const FormatRegistry formats = builtin_mesh_formats();
  const AnimatedMesh mesh = test::random_animation(20, 20, 8);
  std::signal(SIGXFSZ, SIG_IGN);
  struct rlimit before {};
  getrlimit(RLIMIT_FSIZE, &before);
  for (const char* name :
       {"a.ply", "a.mdd", "a_####.ply", "sub/a_##.obj", "a.pvd", "a.npz", "a.glb", "a.gltf"}) {
    const test::TemporaryFolder folder;
    const struct rlimit small { 4096, before.rlim_max };
    setrlimit(RLIMIT_FSIZE, &small);
    EXPECT_THROW(write_animation(formats, mesh, folder.path() / name), InputError) << name;
    setrlimit(RLIMIT_FSIZE, &before);
    EXPECT_EQ(folder.entry_count(), 0U) << name;
  }
  std::signal(SIGXFSZ, SIG_DFL);
}

TEST(NpzReader, WrongArraysAreNamed) {
  EXPECT_REFUSED(decode_npz, "no archive", "f");
  const std::string good = encode_npz(test::random_animation(3, 3, 2), {});
  EXPECT_EQ(decode(decode_npz, good).vertex_count, 9U);
  EXPECT_REFUSED(decode_npz, std::string_view(good).substr(0, good.size() / 2), "f");
  NpzWriter none;
  none.add("positions", {0, std::size_t{1} << 60U, 3}, std::span<const float>());
  none.add("kinemesh",
           std::span<const std::string>(std::vector<std::string>{"kinemesh vertex_name 0 \"A\""}));
  EXPECT_REFUSED(decode_npz, none.bytes(), "it holds no frame or no vertex");
}

TEST(Readers, SayWhatIsLeftOutAndTakeAMarkOfUtf8) {
  const MeshData obj = decode(decode_obj, "\xEF\xBB\xBFv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_EQ(obj.faces.size(), 1U);
  const MeshData ply = decode(decode_ply,
                              "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                              "property float y\nproperty float z\nelement face 1\n"
                              "property list uchar int vertex_idx\nend_header\n"
                              "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  ASSERT_EQ(ply.warnings.size(), 1U);
  EXPECT_NE(ply.warnings[0].find("1 face left out"), std::string::npos);
}

TEST(FilledRuns, OverlappingOnesSetEverySampleOnce) {
  MeshData data;
  data.allocate(2000, 2);
  std::ranges::fill(data.positions.span(), 0.0F);
  data.filled_runs.emplace();
  for (std::size_t i = 0; i < 200000; ++i) data.filled_runs->push_back({1, 10 + i % 3, 1997});
  data.filled_runs->push_back({0, 5, 6});
  data.filled_runs->push_back({0, 4, 4});
  data.filled_runs->push_back({7, 0, 1});
  const AnimatedMesh mesh = to_animated_mesh(std::move(data), {}, "f");
  std::size_t filled = 0;
  for (const uint8_t f : mesh.filled()) filled += f;
  EXPECT_EQ(filled, 1988U + 3U);
  EXPECT_EQ(mesh.filled()[8], 1);
  EXPECT_EQ(mesh.filled()[14], 0);
}

}  // namespace
}  // namespace kinemesh::formats_bad_input_test
