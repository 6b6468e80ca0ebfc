// Choosing a format for an output path, and writing all of its files or none.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>

#include "config/changed_parameters.h"
#include "config/error.h"
#include "config/parallel.h"
#include "config/text.h"
#include "mesh/formats/beside.h"
#include "mesh/formats/frame_choice.h"
#include "mesh/formats/mesh_io.h"
#include "mesh/formats/sequence.h"

namespace kinemesh {
namespace fs = std::filesystem;
namespace {

bool names_folder(const fs::path& path) {
  std::error_code ignored;
  return !path.has_filename() || fs::is_directory(path, ignored);
}

const Format& named_format(const FormatRegistry& formats, std::string name) {
  constexpr std::string_view suffix = "-sequence";
  name = lower(name);
  if (name.ends_with(suffix)) name.resize(name.size() - suffix.size());
  const Format* format = formats.find(name);
  if (format != nullptr && format->can_write()) return *format;
  std::vector<std::string> words;
  for (const Format& f : formats.formats()) {
    if (f.can_write()) words.push_back(f.name);
  }
  const std::string nearest = nearest_word(name, words);
  throw UsageError({.what = format != nullptr ? "the format '" + name + "' can only be read"
                                              : "there is no format '" + name + "'",
                    .remedy = nearest.empty() ? "Writable are " + join(words, ", ", " and ")
                                              : "Did you mean '" + nearest + "'?"});
}

/// PLY of many frames is PLY + PC2: the first format whose geometry is written as `path` is.
const Format* animation_format_for(const FormatRegistry& formats, const fs::path& path) {
  const std::string extension = lower(path.extension().string());
  for (const Format& format : formats.formats()) {
    if (format.can_write() && !format.geometry_extensions.empty() &&
        format.geometry_extensions.front() == extension) {
      return &format;
    }
  }
  return nullptr;
}

/// The path with the extension of `format` where it has none. Throws UsageError for another one.
fs::path with_extension(const Format& format, const fs::path& path, std::size_t frame_count) {
  if (names_folder(path)) {
    if (format.single_frame) return path / ("frame_####" + format.extensions.front());
    throw UsageError({.what = "'" + path.string() + "' is a folder, but " + format.description +
                              " is written to a file",
                      .remedy = "Give a name such as " +
                                (path / ("face" + format.extensions.front())).string()});
  }
  if (!path.has_extension()) {
    if (format.single_frame && frame_count > 1) return with_extension(format, path / "", 2);
    return path.string() + format.extensions.front();
  }
  const std::string extension = lower(path.extension().string());
  auto allowed = format.extensions;
  allowed.insert(allowed.end(), format.geometry_extensions.begin(),
                 format.geometry_extensions.end());
  if (std::find(allowed.begin(), allowed.end(), extension) != allowed.end()) return path;
  throw UsageError({.what = "the output '" + path.string() +
                            "' does not end like files of the format '" + format.name + "'",
                    .remedy = "End it with " + join(format.extensions, ", ", " or ")});
}

/// Numbers the frames of a lower rate so that the first keeps its time; what rounding leaves goes
/// to the events.
void keep_time(const AnimatedMesh& mesh, const FrameChoice& range, AnimatedMesh& out) {
  const auto step = static_cast<double>(range.step);
  const double number = static_cast<double>(out.first_frame - 1) / step;
  out.first_frame = 1 + std::llround(number);
  if (mesh.rate_hz <= 0) return;
  const double later = (std::round(number) - number) * step / mesh.rate_hz;
  for (Event& event : out.events) event.time_s += later;
}

/// Leaves out the events (seconds since recorded frame 1) more than half a frame before the first
/// or behind the last frame; their number. A mesh without a rate keeps all.
std::size_t drop_events_outside(AnimatedMesh& mesh) {
  if (mesh.rate_hz <= 0 || mesh.frame_count() == 0) return 0;
  const double slack = 0.5 / mesh.rate_hz + 1e-9;
  const double first = static_cast<double>(mesh.first_frame - 1) / mesh.rate_hz;
  const double begin = first - slack;
  const double end = first + mesh.time_s(mesh.frame_count() - 1) + slack;
  return std::erase_if(
      mesh.events, [&](const Event& event) { return event.time_s < begin || event.time_s > end; });
}

/// A copy of the frames asked for, lengths multiplied by `factor`.
AnimatedMesh converted(const AnimatedMesh& mesh, const FrameChoice& range, double factor) {
  const std::size_t vertices = mesh.vertex_count();
  AnimatedMesh out(mesh.shared_topology(), range.count,
                   mesh.rate_hz / static_cast<double>(range.step));
  out.first_frame = mesh.first_frame + static_cast<int64_t>(range.first);
  out.events = mesh.events;
  if (range.step > 1) keep_time(mesh, range, out);
  out.vertex_names = mesh.vertex_names;
  out.provenance = mesh.provenance;
  if (!mesh.filled().empty()) out.add_filled();
  if (!mesh.uncertainty().empty()) out.add_uncertainty();
  const auto scaled = [factor](float v) { return static_cast<float>(v * factor); };
  for (std::size_t f = 0; f < range.count; ++f) {
    const std::size_t from = (range.first + f * range.step) * vertices;
    const std::size_t to = f * vertices;
    std::transform(&mesh.positions()[3 * from], &mesh.positions()[3 * from] + 3 * vertices,
                   &out.positions()[3 * to], scaled);
    if (!mesh.filled().empty()) std::copy_n(&mesh.filled()[from], vertices, &out.filled()[to]);
    if (!mesh.uncertainty().empty()) {
      std::transform(&mesh.uncertainty()[from], &mesh.uncertainty()[from] + vertices,
                     &out.uncertainty()[to], scaled);
    }
  }
  return out;
}

int digits_of(int64_t largest) {
  return std::max<int>(4, static_cast<int>(std::to_string(largest).size()));
}

/// Encodes `count` files in parallel, a block at a time, and adds them to `files` in order.
template <class EncodeFile>
void add_numbered(const fs::path& pattern, std::size_t count, int64_t first, int64_t step,
                  EncodeFile encode, OutputSet& files, const RunContext& ctx) {
  const int digits = digits_of(first + step * static_cast<int64_t>(count));
  files.create_folder(pattern.parent_path());
  constexpr std::size_t block = 64;
  std::vector<std::string> contents(block);
  for (std::size_t begin = 0; begin < count; begin += block) {
    const std::size_t size = std::min(block, count - begin);
    parallel_for(ctx, size, 4, [&](std::size_t i) { contents[i] = encode(begin + i); });
    for (std::size_t i = 0; i < size; ++i) {
      const int64_t number = first + step * static_cast<int64_t>(begin + i);
      files.add(numbered_path(pattern, number, digits), contents[i]);
    }
    ctx.progress(static_cast<double>(begin + size) / static_cast<double>(count));
  }
}

/// Older files of the same pattern would be read together with the new ones.
void note_older_files(const fs::path& pattern, WriteResult& result) {
  const fs::path any = is_number_pattern(pattern)
                           ? pattern
                           : pattern.parent_path() /
                                 (pattern.stem().string() + "_####" + pattern.extension().string());
  const std::set<fs::path> written(result.files.begin(), result.files.end());
  const std::vector<NumberedFile> present = matching_files(any);
  const auto older = std::ranges::count_if(
      present, [&written](const NumberedFile& file) { return !written.contains(file.path); });
  if (older == 0) return;
  result.report.notes.push_back(
      count_of(static_cast<std::size_t>(older), "older file") + " matching " + any.string() +
      (older == 1 ? " remains" : " remain") + " beside the new ones and will be read with them");
}

/// An older point cache beside a new mesh file would be read as its motion.
void note_older_caches(const FormatRegistry& formats, WriteResult& result) {
  for (const fs::path& written : result.files) {
    for (const fs::path& cache : caches_beside(formats, written)) {
      if (std::ranges::count(result.files, cache) > 0) continue;
      result.report.notes.push_back("the older " + cache.string() + " remains beside " +
                                    written.filename().string() +
                                    " and will be read with it: remove it if it is of another "
                                    "mesh or other frames");
    }
  }
}

/// Options that say something about glTF alone have no effect on other formats.
void note_unused_options(const Format& format, const WriteOptions& options, WriteResult& result) {
  if (format.name == "glb" || format.name == "gltf") return;
  GltfOptions given = options.gltf;
  given.up = GltfUp::automatic;  // a session may set it
  const std::vector<std::string> unused = changed_options(given);
  if (unused.empty()) return;
  result.report.notes.push_back(join(unused, ", ", " and ") +
                                (unused.size() == 1 ? " is" : " are") +
                                " for glTF: without effect on " + format.name);
}

}  // namespace

const Format& output_format(const FormatRegistry& formats, const fs::path& path,
                            const WriteOptions& options, std::size_t frame_count) {
  if (!options.format.empty()) return named_format(formats, options.format);
  if (names_folder(path)) {
    throw UsageError({.what = "'" + path.string() + "' is a folder: the format is not known",
                      .remedy = "Name it, as in --format ply"});
  }
  if (frame_count > 1 && !is_number_pattern(path)) {
    if (const Format* format = animation_format_for(formats, path)) return *format;
  }
  if (const Format* format = formats.writer_for(path)) return *format;
  throw UsageError({.what = "no writer for files named like '" + path.filename().string() + "'",
                    .remedy = "Writable are " + join(formats.write_extensions(), ", ", " and ")});
}

WriteResult add_animation(const FormatRegistry& formats, const AnimatedMesh& mesh,
                          const fs::path& path, const WriteOptions& options, OutputSet& files,
                          const RunContext& ctx) {
  options.validate();
  if (mesh.frame_count() == 0) {
    throw InputError({.what = "there is no frame to write", .file = path.string()});
  }
  const FrameChoice range = chosen_frames(options.frames, mesh.first_frame, mesh.frame_count());
  const Format& format = output_format(formats, path, options, range.count);
  const fs::path target = with_extension(format, path, range.count);
  if (format.fixed_unit && options.unit != LengthUnit::mm) {
    throw UsageError(
        {.what = format.description + " prescribes its unit", .remedy = "Leave --output-unit out"});
  }
  std::optional<AnimatedMesh> copy;
  std::size_t dropped = 0;
  if (range.count != mesh.frame_count() || options.unit != LengthUnit::mm) {
    copy = converted(mesh, range, 1.0 / millimetres_per(options.unit));
    if (!options.frames.empty()) dropped = drop_events_outside(*copy);
  }
  const AnimatedMesh& source = copy ? *copy : mesh;
  WriteResult result;
  result.format = format.name;
  const std::size_t before = files.paths().size();
  const bool numbered = format.single_frame && (range.count > 1 || is_number_pattern(target));
  if (numbered) {
    const bool own_numbers = options.first_number >= 0;
    const int64_t first =
        own_numbers ? options.first_number
                    : std::max<int64_t>(0, mesh.first_frame + static_cast<int64_t>(range.first));
    add_numbered(
        target, range.count, first, own_numbers ? 1 : static_cast<int64_t>(range.step),
        [&](std::size_t f) { return format.encode(source, f, options); }, files, ctx);
  } else if (format.single_frame) {
    files.add(target, format.encode(source, 0, options));
  } else {
    result.report = format.write(source, target, options, files, ctx);
  }
  ctx.check_cancelled();
  const std::vector<fs::path> all = files.paths();
  result.files.assign(all.begin() + static_cast<std::ptrdiff_t>(before), all.end());
  result.report.lost = format.keeps.lost_of(Keeps::content_of(source));
  note_unused_options(format, options, result);
  if (dropped > 0) {
    result.report.notes.push_back(count_of(dropped, "event") +
                                  " outside the frames written left out");
  }
  if (numbered) {
    note_older_files(target, result);
  } else {
    note_older_caches(formats, result);
  }
  return result;
}

WriteResult write_animation(const FormatRegistry& formats, const AnimatedMesh& mesh,
                            const fs::path& path, const WriteOptions& options,
                            const RunContext& ctx) {
  OutputSet files;
  WriteResult result = add_animation(formats, mesh, path, options, files, ctx);
  files.commit();
  return result;
}

namespace {

AnimatedMesh animation_of(const Mesh& mesh, double rate_hz, int64_t number) {
  AnimatedMesh out(mesh.topology, 1, rate_hz);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    out.position(0, static_cast<VertexIndex>(v)) = mesh.positions[v];
  }
  out.vertex_names = mesh.vertex_names;
  out.first_frame = number;
  return out;
}

}  // namespace

WriteResult write_mesh(const FormatRegistry& formats, const Mesh& mesh, const fs::path& path,
                       const WriteOptions& options, const RunContext& ctx) {
  return write_animation(formats, animation_of(mesh, 0.0, 1), path, options, ctx);
}

WriteResult write_mesh_sequence(const FormatRegistry& formats, const MeshSequence& sequence,
                                const fs::path& path, const WriteOptions& options,
                                const RunContext& ctx) {
  options.validate();
  if (sequence.frames.empty()) {
    throw InputError({.what = "there is no frame to write", .file = path.string()});
  }
  const Format& format = output_format(formats, path, options, 1);
  if (!format.single_frame) {
    throw UsageError({.what = format.description + " cannot hold frames of differing topology",
                      .remedy = "Write a numbered sequence, as in face_####.ply"});
  }
  const fs::path target = with_extension(format, path, 2);
  const double factor = 1.0 / millimetres_per(options.unit);
  const int64_t first = options.first_number >= 0 ? options.first_number : 1;
  WriteResult result;
  result.format = format.name;
  OutputSet files;
  add_numbered(
      target, sequence.frames.size(), first, 1,
      [&](std::size_t f) {
        const AnimatedMesh frame =
            animation_of(sequence.frames[f], sequence.rate_hz, first + static_cast<int64_t>(f));
        return format.encode(converted(frame, {0, 1, 1}, factor), 0, options);
      },
      files, ctx);
  result.files = files.paths();
  files.commit();
  note_older_files(target, result);
  return result;
}

}  // namespace kinemesh
