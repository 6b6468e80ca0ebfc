#include "config/error.h"

namespace kinemesh {
namespace {

std::string compose(const ErrorDetails& d) {
  std::string text;
  const auto prefix = [&text](const std::string& part) {
    if (!part.empty()) text += part + ": ";
  };
  prefix(d.file);
  prefix(d.place);
  if (!d.marker.empty()) prefix("marker '" + d.marker + "'");
  if (d.frame) prefix("frame " + std::to_string(*d.frame));
  text += d.what;
  if (!d.remedy.empty()) text += ". " + d.remedy;
  return text;
}

}  // namespace

Error::Error(ExitCode code, ErrorDetails details)
    : std::runtime_error(compose(details)), details_(std::move(details)), code_(code) {}

}  // namespace kinemesh
