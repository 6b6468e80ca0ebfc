#include "mesh/formats/point_cache.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "config/error.h"
#include "config/input_file.h"
#include "config/text.h"
#include "mesh/formats/beside.h"
#include "mesh/formats/bytes.h"
#include "mesh/formats/float_times.h"
#include "mesh/formats/obj.h"
#include "mesh/formats/off.h"
#include "mesh/formats/ply.h"
#include "mesh/formats/registry.h"

namespace kinemesh {
namespace fs = std::filesystem;
namespace {

/// A file, or bytes in memory: read at an offset.
struct Source {
  std::string name;
  std::size_t size = 0;
  std::function<void(std::size_t offset, void* into, std::size_t bytes)> read;
};

Source source_of(std::span<const std::byte> bytes, const std::string& name) {
  return {name, bytes.size(), [bytes](std::size_t offset, void* into, std::size_t count) {
            if (count > 0) std::memcpy(into, bytes.data() + offset, count);
          }};
}

Source source_of(const InputFile& file) {
  return {file.path().string(), file.size(),
          [&file](std::size_t offset, void* into, std::size_t count) {
            if (file.read_at(offset, into, count) == count) return;
            throw InputError({.what = "the file became shorter while it was read",
                              .file = file.path().string()});
          }};
}

[[noreturn]] void fail(const Source& source, std::size_t byte, const std::string& what,
                       const std::string& remedy = {}) {
  throw InputError({.what = what,
                    .file = source.name,
                    .place = "byte " + std::to_string(byte),
                    .remedy = remedy});
}

/// Checks counts against the size of the file and allocates.
MeshData allocate(const Source& source, int32_t frames, int32_t vertices, std::size_t header,
                  std::size_t bytes_beside_each_frame) {
  if (frames <= 0 || vertices <= 0) {
    fail(source, 0,
         "the header promises " + std::to_string(frames) + " frames of " +
             std::to_string(vertices) + " vertices");
  }
  const std::size_t frame_bytes = std::size_t(vertices) * 12 + bytes_beside_each_frame;
  if (std::size_t(frames) > (source.size - header) / frame_bytes) {
    fail(source, source.size,
         "the file ends here, but the header promises " + count_of(frames, "frame") + " of " +
             count_of(vertices, "vertex", "vertices") + ", " +
             std::to_string(header + frames * frame_bytes) + " bytes",
         "The file is damaged or incomplete");
  }
  MeshData data;
  data.allocate(static_cast<std::size_t>(frames), static_cast<std::size_t>(vertices));
  return data;
}

MeshData read_pc2(const Source& source) {
  constexpr std::size_t header_size = 32;
  std::array<std::byte, header_size> header{};
  if (source.size < header_size)
    fail(source, source.size, "the file ends within the header of 32 bytes");
  source.read(0, header.data(), header_size);
  if (std::memcmp(header.data(), "POINTCACHE2\0", 12) != 0) {
    fail(source, 0, "this is no PC2 file: it does not begin with POINTCACHE2");
  }
  if (load_value<int32_t>(&header[12]) != 1) {
    fail(source, 12,
         "version " + std::to_string(load_value<int32_t>(&header[12])) +
             " of PC2 is not known; 1 is");
  }
  MeshData data = allocate(source, load_value<int32_t>(&header[28]),
                           load_value<int32_t>(&header[16]), header_size, 0);
  source.read(header_size, data.positions.data(), data.positions.size() * sizeof(float));
  return data;
}

/// Frames per second from the times of the frames; 0 when they are not evenly spaced.
double rate_of(const std::vector<float>& times) {
  if (times.size() < 2) return 0.0;
  const double step =
      (double{times.back()} - times.front()) / static_cast<double>(times.size() - 1);
  if (!(step > 0) || !std::isfinite(step)) return 0.0;
  for (std::size_t f = 0; f < times.size(); ++f) {
    const double expected = times.front() + step * static_cast<double>(f);
    if (!(std::abs(times[f] - expected) < 0.1 * step)) return 0.0;
  }
  return rate_from_float_times(times.front(), times.back(), times.size() - 1);
}

MeshData read_mdd(const Source& source) {
  constexpr std::size_t header_size = 8;
  std::array<std::byte, header_size> header{};
  if (source.size < header_size)
    fail(source, source.size, "the file ends within the header of 8 bytes");
  source.read(0, header.data(), header_size);
  const auto frames = load_value<int32_t>(header.data(), true);
  MeshData data =
      allocate(source, frames, load_value<int32_t>(&header[4], true), header_size, sizeof(float));
  std::vector<float> times(data.frame_count);
  source.read(header_size, times.data(), times.size() * sizeof(float));
  copy_swapped(times.data(), times.data(), times.size());
  data.rate_hz = rate_of(times);
  // Swapped a piece at a time while it is in the cache.
  constexpr std::size_t piece = 1 << 16;
  const std::size_t begin = header_size + times.size() * sizeof(float);
  for (std::size_t i = 0; i < data.positions.size(); i += piece) {
    const std::size_t count = std::min(piece, data.positions.size() - i);
    float* at = data.positions.data() + i;
    source.read(begin + i * sizeof(float), at, count * sizeof(float));
    copy_swapped(at, at, count);
  }
  return data;
}

const std::vector<std::string> geometry_extensions{".ply", ".obj", ".off"};

/// The mesh file of the same stem, or nothing.
MeshData geometry_beside(const fs::path& path, bool& found) {
  found = true;
  for (const std::string& extension : geometry_extensions) {
    const auto beside = file_beside(path, extension);
    if (!beside) continue;
    const Buffer<std::byte> bytes = load_bytes(*beside);
    const auto decode = extension == ".ply"   ? decode_ply
                        : extension == ".obj" ? decode_obj
                                              : decode_off;
    return decode(bytes.span(), beside->string());
  }
  found = false;
  return {};
}

/// Faces and description from the geometry, positions from the cache.
MeshData combine(MeshData positions, const fs::path& path, const RunContext& ctx) {
  bool found = false;
  MeshData geometry = geometry_beside(path, found);
  if (!found) {
    ctx.warn(path.string() + ": no file of the same name ends with " +
             join(geometry_extensions, ", ", " or ") + ": read as points without faces");
    return positions;
  }
  if (geometry.vertex_count != positions.vertex_count) {
    throw InputError({.what = "it has " + count_of(positions.vertex_count, "vertex", "vertices") +
                              ", the geometry beside it " + std::to_string(geometry.vertex_count),
                      .file = path.string(),
                      .remedy = "The two files do not belong together"});
  }
  geometry.frame_count = positions.frame_count;
  geometry.positions = std::move(positions.positions);
  geometry.uncertainty = {};  // of one frame
  geometry.filled = {};
  if (!(geometry.rate_hz > 0)) geometry.rate_hz = positions.rate_hz;
  return geometry;
}

/// The .ply of the first frame, with the description of all of them.
void add_geometry(const AnimatedMesh& mesh, const fs::path& path, const WriteOptions& options,
                  OutputSet& files) {
  fs::path beside = path;
  beside.replace_extension(".ply");
  files.add(beside, encode_ply(mesh, 0, options,
                               {.description = true,
                                .filled_runs = true,
                                .uncertainty = true,
                                .to_mm = millimetres_per(options.unit)}));
}

WriteReport write_pc2(const AnimatedMesh& mesh, const fs::path& path, const WriteOptions& options,
                      OutputSet& files, const RunContext& ctx) {
  add_geometry(mesh, path, options, files);
  fs::path cache = path;
  OutputFile out(cache.replace_extension(".pc2"));
  std::string header("POINTCACHE2\0", 12);
  append_value(header, int32_t{1});
  append_value(header, static_cast<int32_t>(mesh.vertex_count()));
  append_value(header, 0.0F);
  append_value(header, 1.0F);
  append_value(header, static_cast<int32_t>(mesh.frame_count()));
  out.write(header);
  for (std::size_t f = 0; f < mesh.frame_count(); ++f) {
    ctx.check_cancelled();
    out.write(mesh.frame(f).data(), mesh.vertex_count() * 3 * sizeof(float));
  }
  files.add(std::move(out));
  return {};
}

WriteReport write_mdd(const AnimatedMesh& mesh, const fs::path& path, const WriteOptions& options,
                      OutputSet& files, const RunContext& ctx) {
  add_geometry(mesh, path, options, files);
  fs::path cache = path;
  OutputFile out(cache.replace_extension(".mdd"));
  std::string header;
  append_value(header, static_cast<int32_t>(mesh.frame_count()), true);
  append_value(header, static_cast<int32_t>(mesh.vertex_count()), true);
  for (std::size_t f = 0; f < mesh.frame_count(); ++f) {
    const double time = mesh.rate_hz > 0 ? mesh.time_s(f) : static_cast<double>(f);
    append_value(header, static_cast<float>(time), true);
  }
  out.write(header);
  Buffer<float> swapped(mesh.vertex_count() * 3);
  for (std::size_t f = 0; f < mesh.frame_count(); ++f) {
    ctx.check_cancelled();
    copy_swapped(mesh.frame(f).data(), swapped.data(), swapped.size());
    out.write(std::span<const float>(swapped.span()));
  }
  files.add(std::move(out));
  return {};
}

Format point_cache_format(std::string name, std::string extension, std::string description) {
  Format format = make_format(std::move(name), std::move(extension), std::move(description),
                              Keeps::everything(), "every float");
  format.geometry_extensions = geometry_extensions;
  return format;
}

}  // namespace

Format pc2_format();
Format pc2_format() {
  Format format =
      point_cache_format("ply+pc2", ".pc2", "PLY with a Point Cache 2 of the same stem");
  format.read = [](const fs::path& path, const ReadOptions&, const RunContext& ctx) {
    return combine(read_pc2_positions(path), path, ctx);
  };
  format.write = write_pc2;
  return format;
}

Format mdd_format();
Format mdd_format() {
  Format format = point_cache_format("mdd", ".mdd", "MDD point cache with a PLY of the same stem");
  format.read = [](const fs::path& path, const ReadOptions&, const RunContext& ctx) {
    return combine(read_mdd_positions(path), path, ctx);
  };
  format.write = write_mdd;
  return format;
}

MeshData decode_pc2(std::span<const std::byte> bytes, const std::string& name) {
  return read_pc2(source_of(bytes, name));
}
MeshData decode_mdd(std::span<const std::byte> bytes, const std::string& name) {
  return read_mdd(source_of(bytes, name));
}
MeshData read_pc2_positions(const fs::path& path) { return read_pc2(source_of(InputFile(path))); }
MeshData read_mdd_positions(const fs::path& path) { return read_mdd(source_of(InputFile(path))); }

}  // namespace kinemesh
