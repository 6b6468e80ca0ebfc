#include "mesh/formats/registry.h"

#include <algorithm>

#include "config/error.h"
#include "config/text.h"

namespace kinemesh {
namespace {

bool has_extension(const Format& format, const std::string& extension) {
  return std::find(format.extensions.begin(), format.extensions.end(), extension) !=
         format.extensions.end();
}

template <class Can>
const Format* by_extension(const std::vector<Format>& formats, const std::filesystem::path& path,
                           Can can) {
  const std::string extension = lower(path.extension().string());
  for (const Format& format : formats) {
    if (can(format) && has_extension(format, extension)) return &format;
  }
  return nullptr;
}

template <class Can>
std::vector<std::string> all_extensions(const std::vector<Format>& formats, Can can) {
  std::vector<std::string> all;
  for (const Format& format : formats) {
    if (can(format)) all.insert(all.end(), format.extensions.begin(), format.extensions.end());
  }
  return all;
}

constexpr auto readable = [](const Format& f) { return f.can_read(); };
constexpr auto writable = [](const Format& f) { return f.can_write(); };

}  // namespace

Keeps Keeps::content_of(const AnimatedMesh& mesh) {
  const auto any = [](auto values) {
    return std::ranges::any_of(values, [](auto value) { return value != 0; });
  };
  return {.faces = mesh.topology().face_count() > 0,
          .names = !mesh.vertex_names.empty(),
          .rate = mesh.rate_hz > 0,
          .first_frame = mesh.first_frame != 1,
          .events = !mesh.events.empty(),
          .filled = any(mesh.filled()),
          .uncertainty = any(mesh.uncertainty()),
          .provenance = !mesh.provenance.program.empty() || !mesh.provenance.inputs.empty()};
}

std::vector<std::string> Keeps::lost_of(const Keeps& content) const {
  std::vector<std::string> lost;
  const auto note = [&lost](bool kept, bool there, const char* what) {
    if (!kept && there) lost.emplace_back(what);
  };
  note(faces, content.faces, "faces");
  note(names, content.names, "vertex names");
  note(unit, content.unit, "unit");
  note(rate, content.rate, "rate");
  note(first_frame, content.first_frame, "first frame");
  note(events, content.events, "events");
  note(filled, content.filled, "filled flags");
  note(uncertainty, content.uncertainty, "uncertainty");
  note(provenance, content.provenance, "provenance");
  return lost;
}

std::string Format::loses() const { return join(keeps.lost_of(Keeps::everything()), ", "); }

Format make_format(std::string name, std::string extension, std::string description, Keeps keeps,
                   std::string exactness) {
  Format format;
  format.name = std::move(name);
  format.extensions = {std::move(extension)};
  format.description = std::move(description);
  format.keeps = keeps;
  format.exactness = std::move(exactness);
  return format;
}

Format make_single_frame_format(std::string name, std::string extension, std::string description,
                                Keeps keeps, std::string exactness, Format::Decode decode,
                                Format::Encode encode) {
  Format format = make_format(std::move(name), std::move(extension), std::move(description), keeps,
                              std::move(exactness));
  format.single_frame = true;
  format.decode = std::move(decode);
  format.encode = std::move(encode);
  return format;
}

void FormatRegistry::add(Format format) {
  if (find(format.name) != nullptr) {
    throw InternalError("the format '" + format.name + "' is registered twice");
  }
  for (const std::string& extension : format.extensions) {
    if ((format.can_read() && reader_for("x" + extension) != nullptr) ||
        (format.can_write() && writer_for("x" + extension) != nullptr)) {
      throw InternalError("two formats take the extension " + extension);
    }
  }
  formats_.push_back(std::move(format));
}

const Format* FormatRegistry::find(std::string_view name) const {
  for (const Format& format : formats_) {
    if (format.name == name) return &format;
  }
  return nullptr;
}

const Format* FormatRegistry::reader_for(const std::filesystem::path& path) const {
  return by_extension(formats_, path, readable);
}

const Format* FormatRegistry::writer_for(const std::filesystem::path& path) const {
  return by_extension(formats_, path, writable);
}

std::vector<std::string> FormatRegistry::read_extensions() const {
  return all_extensions(formats_, readable);
}

std::vector<std::string> FormatRegistry::write_extensions() const {
  return all_extensions(formats_, writable);
}

}  // namespace kinemesh
