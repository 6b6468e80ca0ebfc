#include <algorithm>

#include "config/error.h"
#include "config/parallel.h"
#include "config/text.h"
#include "mesh/formats/bytes.h"
#include "mesh/formats/join_frames.h"
#include "mesh/formats/metadata.h"
#include "mesh/formats/registry.h"
#include "mesh/formats/sequence.h"
#include "mesh/formats/vtp.h"
#include "mesh/formats/xml.h"

namespace kinemesh {
namespace fs = std::filesystem;
namespace {

template <class T>
constexpr const char* vtk_type() {
  if constexpr (std::is_same_v<T, float>) return "Float32";
  if constexpr (std::is_same_v<T, double>) return "Float64";
  if constexpr (std::is_same_v<T, uint8_t>) return "UInt8";
  return "Int32";
}

/// Builds the XML and, beside it, the appended data.
class VtpWriter {
 public:
  explicit VtpWriter(Encoding encoding)
      : ascii_(encoding == Encoding::ascii), big_(encoding == Encoding::binary_big) {
    xml_ = "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"";
    xml_ += big_ ? "BigEndian" : "LittleEndian";
    xml_ += "\" header_type=\"UInt64\">\n";
  }

  void line(const std::string& text) { xml_ += text + "\n"; }

  template <class T>
  void array(const std::string& name, std::span<const T> values, int components,
             const std::string& attributes = {}) {
    begin("DataArray", vtk_type<T>(), name, attributes);
    if (components > 0) xml_ += " NumberOfComponents=\"" + std::to_string(components) + "\"";
    if (ascii_) {
      xml_ += " format=\"ascii\">\n";
      for (std::size_t i = 0; i < values.size(); ++i) {
        if constexpr (std::is_integral_v<T>) {
          append_number(xml_, static_cast<int64_t>(values[i]));
        } else {
          append_number(xml_, values[i]);
        }
        xml_ += i % 12 == 11 ? '\n' : ' ';
      }
      xml_ += "\n</DataArray>\n";
      return;
    }
    offset(values.size() * sizeof(T));
    if (big_) {
      for (const T value : values) append_value(data_, value, true);
    } else {
      data_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    }
  }

  void texts(const std::string& name, const std::vector<std::string>& values,
             const std::string& attributes = {}) {
    std::string bytes;
    for (const std::string& text : values) bytes += text + '\0';
    begin("Array", "String", name, attributes);
    if (!ascii_) {
      offset(bytes.size());
      data_ += bytes;
      return;
    }
    xml_ += " format=\"ascii\">\n";
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      append_number(xml_, static_cast<int64_t>(static_cast<unsigned char>(bytes[i])));
      xml_ += i % 24 == 23 ? '\n' : ' ';
    }
    xml_ += "\n</Array>\n";
  }

  std::string finish() {
    if (!ascii_) xml_ += "<AppendedData encoding=\"raw\">\n_" + data_ + "\n</AppendedData>\n";
    return xml_ + "</VTKFile>\n";
  }

 private:
  void begin(const char* element, const char* type, const std::string& name,
             const std::string& attributes) {
    xml_ +=
        std::string("<") + element + " type=\"" + type + "\" Name=\"" + name + "\"" + attributes;
  }
  void offset(std::size_t bytes) {
    xml_ += " format=\"appended\" offset=\"" + std::to_string(data_.size()) + "\"/>\n";
    append_value(data_, static_cast<uint64_t>(bytes), big_);
  }

  bool ascii_, big_;
  std::string xml_, data_;
};

void write_fields(VtpWriter& out, const AnimatedMesh& mesh, std::size_t frame,
                  const WriteOptions& options) {
  const std::vector<std::string> lines =
      metadata_lines(mesh, frame, options, {.description = frame == 0, .filled_runs = false});
  out.line("<FieldData>");
  const double time = mesh.rate_hz > 0 ? mesh.time_s(frame) : static_cast<double>(frame);
  out.array<double>("TimeValue", std::span(&time, 1), 0, " NumberOfTuples=\"1\"");
  out.texts("kinemesh", lines, " NumberOfTuples=\"" + std::to_string(lines.size()) + "\"");
  out.line("</FieldData>");
}

void write_point_data(VtpWriter& out, const AnimatedMesh& mesh, std::size_t frame) {
  const std::size_t vertices = mesh.vertex_count();
  out.line("<PointData>");
  if (!mesh.filled().empty()) {
    out.array<uint8_t>("filled", mesh.filled().subspan(frame * vertices, vertices), 0);
  }
  if (!mesh.uncertainty().empty()) {
    out.array<float>("uncertainty", mesh.uncertainty().subspan(frame * vertices, vertices), 0);
  }
  if (!mesh.vertex_names.empty()) out.texts("vertex_name", mesh.vertex_names);
  out.line("</PointData>");
}

void write_faces(VtpWriter& out, const Topology& topology) {
  std::vector<int32_t> corners, offsets;
  corners.reserve(3 * topology.face_count());
  offsets.reserve(topology.face_count());
  for (const Triangle& t : topology.faces()) {
    for (const VertexIndex v : t) corners.push_back(static_cast<int32_t>(v));
    offsets.push_back(static_cast<int32_t>(corners.size()));
  }
  out.line("<Polys>");
  out.array<int32_t>("connectivity", corners, 0);
  out.array<int32_t>("offsets", offsets, 0);
  out.line("</Polys>");
}

/// The text of the collection; files are relative to it.
std::string encode_pvd(const std::vector<PvdEntry>& entries) {
  std::string out =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" "
      "byte_order=\"LittleEndian\">\n<Collection>\n";
  for (const PvdEntry& entry : entries) {
    out += "<DataSet timestep=\"" + format_number(entry.timestep) +
           "\" group=\"\" part=\"0\" file=\"" + escape_xml(entry.file) + "\"/>\n";
  }
  return out + "</Collection>\n</VTKFile>\n";
}

WriteReport write_pvd(const AnimatedMesh& mesh, const fs::path& path, const WriteOptions& options,
                      OutputSet& files, const RunContext& ctx) {
  const fs::path folder = path.stem().string() + "_frames";
  const fs::path name = path.stem().string() + ".vtp";
  files.create_folder(path.parent_path() / folder);
  const auto frames = static_cast<int64_t>(mesh.frame_count());
  const int64_t first = std::max<int64_t>(0, mesh.first_frame);
  const int digits = std::max<int>(4, static_cast<int>(std::to_string(first + frames).size()));
  std::vector<PvdEntry> entries;
  constexpr std::size_t block = 64;
  std::vector<std::string> contents(block);
  for (std::size_t begin = 0; begin < mesh.frame_count(); begin += block) {
    const std::size_t size = std::min(block, mesh.frame_count() - begin);
    parallel_for(ctx, size, 4,
                 [&](std::size_t i) { contents[i] = encode_vtp(mesh, begin + i, options); });
    for (std::size_t i = 0; i < size; ++i) {
      const std::size_t f = begin + i;
      const fs::path file = folder / numbered_path(name, first + static_cast<int64_t>(f), digits);
      files.add(path.parent_path() / file, contents[i]);
      const double time = mesh.rate_hz > 0 ? mesh.time_s(f) : static_cast<double>(f);
      entries.push_back({time, file.generic_string()});
    }
    ctx.progress(static_cast<double>(begin + size) / static_cast<double>(mesh.frame_count()));
  }
  files.add(path, encode_pvd(entries));
  return {};
}

MeshData read_pvd(const fs::path& path, const ReadOptions&, const RunContext& ctx) {
  const Buffer<std::byte> bytes = load_bytes(path);
  const std::vector<PvdEntry> entries = decode_pvd(bytes.span(), path.string());
  const auto file = [&](std::size_t i) { return path.parent_path() / entries[i].file; };
  MeshData data = join_frames(
      entries.size(),
      [&](std::size_t i) {
        const Buffer<std::byte> content = load_bytes(file(i));
        return decode_vtp(content.span(), file(i).string());
      },
      [&](std::size_t i) { return file(i).string(); }, ctx);
  const double span = entries.back().timestep - entries.front().timestep;
  const auto steps = static_cast<double>(entries.size() - 1);
  // Timesteps 0, 1, 2, … number the files of a series without times, ours too.
  const bool numbered = entries.front().timestep == 0.0 && span == steps;
  if (!(data.rate_hz > 0) && span > 0 && !numbered) data.rate_hz = steps / span;
  return data;
}

}  // namespace

std::string encode_vtp(const AnimatedMesh& mesh, std::size_t frame, const WriteOptions& options) {
  const std::size_t values = mesh.vertex_count() * 3;
  VtpWriter out(options.encoding);
  out.line("<PolyData>");
  write_fields(out, mesh, frame, options);
  out.line("<Piece NumberOfPoints=\"" + std::to_string(mesh.vertex_count()) +
           "\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"" +
           std::to_string(mesh.topology().face_count()) + "\">");
  write_point_data(out, mesh, frame);
  out.line("<Points>");
  out.array<float>("Points", mesh.positions().subspan(frame * values, values), 3);
  out.line("</Points>");
  write_faces(out, mesh.topology());
  out.line("</Piece>\n</PolyData>");
  return out.finish();
}

Format vtp_format();
Format vtp_format() {
  return make_single_frame_format("vtp", ".vtp", "VTK PolyData; numbered for animations",
                                  Keeps::everything(), "every float", decode_vtp, encode_vtp);
}

Format pvd_format();
Format pvd_format() {
  Format format = make_format("pvd", ".pvd", "ParaView collection of VTP files",
                              Keeps::everything(), "every float");
  format.read = read_pvd;
  format.write = write_pvd;
  return format;
}

}  // namespace kinemesh
