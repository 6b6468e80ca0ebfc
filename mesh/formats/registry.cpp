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

std::string Format::loses() const {
  std::vector<std::string> lost;
  const auto note = [&lost](bool kept, const char* what) {
    if (!kept) lost.emplace_back(what);
  };
  note(keeps.faces, "faces");
  note(keeps.names, "vertex names");
  note(keeps.unit, "unit");
  note(keeps.rate, "rate");
  note(keeps.first_frame, "first frame");
  note(keeps.events, "events");
  note(keeps.filled, "filled flags");
  note(keeps.uncertainty, "uncertainty");
  note(keeps.provenance, "provenance");
  return join(lost, ", ");
}

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
