#include "reconstruct/output_names.h"

#include "config/input_file.h"

namespace kinemesh {

namespace fs = std::filesystem;

fs::path stem_of_output(const fs::path& output) {
  const fs::path file = output.has_filename() ? output : output.parent_path();
  std::string name = file.stem().string();
  while (!name.empty() && (name.back() == '#' || name.back() == '_')) name.pop_back();
  return (output.has_filename() ? file.parent_path() : file) / (name.empty() ? "mesh" : name);
}

fs::path beside(const fs::path& stem, const std::string& suffix) {
  return stem.parent_path() / (stem.filename().string() + suffix);
}

Provenance provenance_of(const std::string& program, const std::string& command,
                         const std::string& options_toml, const std::vector<fs::path>& inputs) {
  Provenance p{program, command, options_toml, {}, {}};
  for (const fs::path& path : inputs) {
    std::error_code ignored;
    if (!fs::is_regular_file(path, ignored)) continue;
    p.inputs.push_back({path.string(), sha256_of_file(path)});
  }
  return p;
}

}  // namespace kinemesh
