// Resolving a path to files, and reading them into one mesh.
#include <system_error>

#include "config/error.h"
#include "config/text.h"
#include "mesh/formats/beside.h"
#include "mesh/formats/bytes.h"
#include "mesh/formats/join_frames.h"
#include "mesh/formats/mesh_io.h"
#include "mesh/formats/sequence.h"

namespace kinemesh {
namespace fs = std::filesystem;
namespace {

struct Input {
  const Format* format = nullptr;
  std::vector<NumberedFile> files;
  bool numbered = false;
};

const Format& known_reader(const FormatRegistry& formats, const fs::path& path) {
  const Format* format = formats.reader_for(path);
  if (format != nullptr) return *format;
  throw InputError({.what = path.has_extension()
                                ? "no reader for files named *" + path.extension().string()
                                : std::string("the name has no extension that tells the format"),
                    .file = path.string(),
                    .remedy = "Readable are " + join(formats.read_extensions(), ", ", " and ")});
}

std::vector<std::string> sequence_extensions(const FormatRegistry& formats) {
  std::vector<std::string> all;
  for (const Format& format : formats.formats()) {
    if (!format.single_frame || !format.can_read()) continue;
    all.insert(all.end(), format.extensions.begin(), format.extensions.end());
  }
  return all;
}

/// The positions of `path` (x.pc2 beside x.ply) when it is the geometry of an animation.
fs::path animation_beside(const FormatRegistry& formats, const fs::path& path) {
  const std::vector<fs::path> caches = caches_beside(formats, path);
  return caches.empty() ? path : caches.front();
}

Input resolve(const FormatRegistry& formats, const fs::path& path) {
  std::error_code ignored;
  Input input;
  if (fs::is_directory(path, ignored)) {
    input.files = files_of_folder(path, sequence_extensions(formats));
    input.numbered = true;
  } else if (is_number_pattern(path) && !fs::exists(path, ignored)) {
    input.files = files_of_pattern(path);
    input.numbered = true;
  } else {
    input.files = {{animation_beside(formats, path), 0}};
  }
  input.format = &known_reader(formats, input.files.front().path);
  if (input.numbered && !input.format->single_frame) {
    throw InputError({.what = input.format->description + " holds a whole animation",
                      .file = path.string(),
                      .remedy = "Give one of its files"});
  }
  return input;
}

MeshData load(const Format& format, const fs::path& path, const ReadOptions& options,
              const RunContext& ctx) {
  if (format.read) return format.read(path, options, ctx);
  const Buffer<std::byte> bytes = load_bytes(path);
  return format.decode(bytes.span(), path.string());
}

/// Errors about a mesh (a face out of range) get the file's name.
template <class Action>
auto naming(const fs::path& path, Action action) {
  try {
    return action();
  } catch (const InputError& e) {
    if (!e.details().file.empty()) throw;
    ErrorDetails details = e.details();
    details.file = path.string();
    throw InputError(details);
  }
}

/// All files of a numbered sequence as one.
MeshData load_sequence(const Input& input, const ReadOptions& options, const RunContext& ctx) {
  MeshData all = join_frames(
      input.files.size(),
      [&](std::size_t i) { return load(*input.format, input.files[i].path, options, ctx); },
      [&](std::size_t i) { return input.files[i].path.string(); }, ctx);
  if (!all.first_frame) all.first_frame = input.files[0].number;
  const auto& files = input.files;
  const auto missing = static_cast<std::size_t>(files.back().number - files.front().number) + 1;
  if (missing != files.size() && (missing - 1) % (files.size() - 1) != 0) {
    ctx.warn(files.front().path.string() + ": the numbers of the sequence have gaps: " +
             count_of(files.size(), "file") + " from " + std::to_string(files.front().number) +
             " to " + std::to_string(files.back().number) + " are taken as consecutive frames");
  }
  return all;
}

}  // namespace

AnimationFile read_animation_file(const FormatRegistry& formats, const fs::path& path,
                                  const ReadOptions& options, const RunContext& ctx) {
  options.validate();
  const Input input = resolve(formats, path);
  const fs::path& first = input.files[0].path;
  MeshData data = input.numbered ? load_sequence(input, options, ctx)
                                 : load(*input.format, first, options, ctx);
  AnimationFile file;
  file.format = input.format->name;
  file.unit = data.unit;
  for (const NumberedFile& f : input.files) file.files.push_back(f.path);
  if (!input.numbered) {
    const std::vector<fs::path> more = files_read_with(*input.format, first);
    file.files.insert(file.files.end(), more.begin(), more.end());
  }
  file.mesh = naming(
      first, [&] { return to_animated_mesh(std::move(data), options, first.string(), ctx); });
  return file;
}

AnimatedMesh read_animation(const FormatRegistry& formats, const fs::path& path,
                            const ReadOptions& options, const RunContext& ctx) {
  return read_animation_file(formats, path, options, ctx).mesh;
}

MeshSequence read_mesh_sequence(const FormatRegistry& formats, const fs::path& path,
                                const ReadOptions& options, const RunContext& ctx) {
  options.validate();
  const Input input = resolve(formats, path);
  MeshSequence sequence;
  if (!input.numbered) {
    const AnimatedMesh mesh = read_animation(formats, path, options, ctx);
    for (std::size_t f = 0; f < mesh.frame_count(); ++f) sequence.frames.push_back(mesh.mesh_at(f));
    sequence.rate_hz = mesh.rate_hz;
    return sequence;
  }
  std::shared_ptr<const Topology> previous;
  MeshData first;  // its faces alone
  for (const NumberedFile& file : input.files) {
    ctx.check_cancelled();
    MeshData data = load(*input.format, file.path, options, ctx);
    if (sequence.frames.empty()) {
      sequence.rate_hz = data.rate_hz > 0 ? data.rate_hz : options.rate_hz;
      first.vertex_count = data.vertex_count;
      first.faces = data.faces;
      first.polygons = data.polygons;
    } else if (same_faces(first, data)) {
      data.faces = first.faces;  // polygons are cut as in the first file
    }
    sequence.frames.push_back(naming(file.path, [&] {
      return to_mesh(std::move(data), options, file.path.string(), previous, ctx);
    }));
    previous = sequence.frames.back().topology;
    ctx.progress(static_cast<double>(sequence.frames.size()) /
                 static_cast<double>(input.files.size()));
  }
  return sequence;
}

Mesh read_mesh(const FormatRegistry& formats, const fs::path& path, const ReadOptions& options,
               const RunContext& ctx) {
  options.validate();
  const Format& format = known_reader(formats, path);
  MeshData data = load(format, path, options, ctx);
  return naming(path,
                [&] { return to_mesh(std::move(data), options, path.string(), nullptr, ctx); });
}

}  // namespace kinemesh
