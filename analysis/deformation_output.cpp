#include "analysis/deformation_output.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>

#include "config/error.h"
#include "config/text.h"
#include "mesh/formats/npz.h"
#include "report/colour.h"

namespace kinemesh {
namespace {

namespace fs = std::filesystem;

template <class T>
void append(std::string& bytes, const T& value) {
  std::array<char, sizeof(T)> raw{};
  std::memcpy(raw.data(), &value, sizeof(T));
  bytes.append(raw.data(), raw.size());
}

std::string numbered(const fs::path& path, std::size_t frame, const char* extension) {
  std::string number = std::to_string(frame);
  number.insert(0, number.size() < 4 ? 4 - number.size() : 0, '0');
  return path.stem().string() + "_" + number + extension;
}

std::string npz_bytes(const AnimatedMesh& animation, const DeformationResult& d) {
  const std::size_t vertices = d.values.vertex_count, frames = d.values.frame_count;
  std::vector<double> rest, times;
  for (const Eigen::Vector3d& p : d.rest) rest.insert(rest.end(), p.data(), p.data() + 3);
  for (std::size_t f = 0; f < frames; ++f) times.push_back(animation.time_s(f));
  NpzWriter npz;
  npz.add("deformation", {vertices, frames}, d.values.values.span());
  npz.add("rest", {vertices, 3}, std::span<const double>(rest));
  npz.add("time_s", {frames}, std::span<const double>(times));
  if (!d.directions.empty()) npz.add("direction", {vertices, frames, 3}, d.directions.span());
  return npz.bytes();
}

std::string csv_text(const DeformationResult& d) {
  std::string text = "vertex";
  for (std::size_t f = 0; f < d.values.frame_count; ++f) text += "," + std::to_string(f);
  text += "\n";
  std::array<char, 32> number{};
  for (std::size_t v = 0; v < d.values.vertex_count; ++v) {
    text += std::to_string(v);
    for (const float value : d.values.of(v)) {
      const auto end = std::to_chars(number.data(), number.data() + number.size(), value).ptr;
      text += ",";
      text.append(number.data(), end);
    }
    text += "\n";
  }
  return text;
}

std::string ply_bytes(const AnimatedMesh& animation, const DeformationResult& d, std::size_t frame,
                      const ColourScale& scale) {
  const Topology& topology = animation.topology();
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\ncomment quality: deformation\n"
      "element vertex " +
      std::to_string(animation.vertex_count()) +
      "\nproperty float x\nproperty float y\nproperty float z\n"
      "property float quality\nproperty uchar red\nproperty uchar green\n"
      "property uchar blue\nelement face " +
      std::to_string(topology.face_count()) +
      "\nproperty list uchar int vertex_indices\nend_header\n";
  for (std::size_t v = 0; v < animation.vertex_count(); ++v) {
    const Eigen::Vector3f p = animation.position(frame, static_cast<VertexIndex>(v));
    for (int axis = 0; axis < 3; ++axis) append(bytes, p[axis]);
    const float value = d.values.of(v)[frame];
    append(bytes, value);
    const Colour colour = scale(static_cast<double>(value));
    for (const double c : {colour.r, colour.g, colour.b}) {
      append(bytes, static_cast<uint8_t>(c * 255.0 + 0.5));
    }
  }
  for (const Triangle& face : topology.faces()) {
    append(bytes, uint8_t{3});
    for (const VertexIndex v : face) append(bytes, static_cast<int32_t>(v));
  }
  return bytes;
}

/// Appended raw data: each array after its number of bytes.
std::string vtp_bytes(const AnimatedMesh& animation, const DeformationResult& d,
                      std::size_t frame) {
  const Topology& topology = animation.topology();
  std::string data;
  const auto begin_array = [&](std::size_t bytes) {
    const std::size_t offset = data.size();
    append(data, static_cast<uint64_t>(bytes));
    return std::to_string(offset);
  };
  const std::size_t count = animation.vertex_count();
  const std::string points = begin_array(count * 12);
  const auto frame_positions = animation.positions().subspan(frame * count * 3, count * 3);
  data.append(reinterpret_cast<const char*>(frame_positions.data()), frame_positions.size_bytes());
  const std::string values = begin_array(count * 4);
  for (std::size_t v = 0; v < count; ++v) append(data, d.values.of(v)[frame]);
  const std::string corners = begin_array(topology.face_count() * 12);
  for (const Triangle& face : topology.faces()) {
    for (const VertexIndex v : face) append(data, static_cast<int32_t>(v));
  }
  const std::string offsets = begin_array(topology.face_count() * 4);
  for (std::size_t t = 1; t <= topology.face_count(); ++t)
    append(data, static_cast<int32_t>(3 * t));
  const auto array = [](const char* type, const char* name, int components,
                        const std::string& offset) {
    return std::string("<DataArray type=\"") + type + "\" Name=\"" + name +
           "\" NumberOfComponents=\"" + std::to_string(components) +
           "\" format=\"appended\" offset=\"" + offset + "\"/>\n";
  };
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" "
         "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<PolyData>\n<Piece "
         "NumberOfPoints=\"" +
         std::to_string(count) + "\" NumberOfPolys=\"" + std::to_string(topology.face_count()) +
         "\">\n<PointData Scalars=\"deformation\">\n" + array("Float32", "deformation", 1, values) +
         "</PointData>\n<Points>\n" + array("Float32", "Points", 3, points) +
         "</Points>\n<Polys>\n" + array("Int32", "connectivity", 1, corners) +
         array("Int32", "offsets", 1, offsets) +
         "</Polys>\n</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_" + data +
         "\n</AppendedData>\n</VTKFile>\n";
}

std::string pvd_text(const fs::path& path, const AnimatedMesh& animation) {
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\">\n"
      "<Collection>\n";
  for (std::size_t f = 0; f < animation.frame_count(); ++f) {
    const double time = animation.rate_hz > 0 ? animation.time_s(f) : static_cast<double>(f);
    text += "<DataSet timestep=\"" + format_number(time) + "\" file=\"" +
            numbered(path, f, ".vtp") + "\"/>\n";
  }
  return text + "</Collection>\n</VTKFile>\n";
}

}  // namespace

double colour_limit(const DeformationResult& deformation) {
  std::vector<float> values(deformation.values.values.begin(), deformation.values.values.end());
  if (values.empty()) return 1.0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 995 / 1000);
  std::nth_element(values.begin(), at, values.end());
  return *at > 0.0F ? static_cast<double>(*at) : std::max(1e-6, double{deformation.largest});
}

void add_deformation_files(OutputSet& files, const fs::path& path, const AnimatedMesh& animation,
                           const DeformationResult& deformation, const RunContext& ctx) {
  const std::string extension = lower(path.extension().string());
  if (extension == ".npz") {
    files.add(path, npz_bytes(animation, deformation));
  } else if (extension == ".csv") {
    files.add(path, csv_text(deformation));
  } else if (extension == ".pvd" || extension == ".vtp") {
    for (std::size_t f = 0; f < animation.frame_count(); ++f) {
      ctx.check_cancelled();
      files.add(path.parent_path() / numbered(path, f, ".vtp"),
                vtp_bytes(animation, deformation, f));
    }
    files.add(fs::path(path).replace_extension(".pvd"), pvd_text(path, animation));
  } else if (extension == ".ply") {
    ColourScale scale;
    scale.high = colour_limit(deformation);
    for (std::size_t f = 0; f < animation.frame_count(); ++f) {
      ctx.check_cancelled();
      files.add(path.parent_path() / numbered(path, f, ".ply"),
                ply_bytes(animation, deformation, f, scale));
    }
  } else {
    throw UsageError({.what = "deformation is not written as '" + extension + "'",
                      .file = path.string(),
                      .remedy = "Give a name that ends in .npz, .csv, .pvd or .ply"});
  }
}

}  // namespace kinemesh
