// Mends what can be mended safely in a C3D file: a new header and parameter section that say what
// the file holds, before the data section as it is.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "capture/c3d/check.h"
#include "config/run_context.h"

namespace kinemesh {

/// One deviation that the repaired file no longer has.
struct C3dMend {
  C3dFinding finding;  ///< as found in the original
  std::string done;    ///< what was done about it; one sentence without a full stop
};

struct C3dRepairResult {
  std::string file, output;
  std::vector<C3dFinding> before;  ///< what reading the original found
  std::vector<C3dMend> mended;
  C3dCheckResult after;         ///< the repaired file, checked
  bool copied = false;          ///< nothing needed repair: the output is a plain copy
  bool data_verbatim = false;   ///< the data section's bytes were kept, but for marked gaps
  std::size_t frames = 0;       ///< complete frames kept
  std::size_t frames_lost = 0;  ///< declared, but cut off in the original
  std::size_t samples = 0;      ///< points × frames kept
  std::size_t gaps_marked = 0;  ///< samples whose unusable values were marked as gaps
  std::size_t changed = 0;      ///< other samples and analog values that read differently now
  bool healthy() const { return !after.has_errors(); }
};

/// Reads `path` and writes a repaired copy to `output`. Every sample outside the damage keeps its
/// value: the data section is copied byte for byte, and the result is read again and compared.
/// Throws UsageError when `output` is `path` itself or `path` is no C3D file, and InputError when
/// nothing can be read or the output cannot be written.
C3dRepairResult repair_c3d(const std::filesystem::path& path, const std::filesystem::path& output,
                           const C3dCheckOptions& options = {}, const RunContext& ctx = {});

/// The repaired file in memory, from the bytes of a damaged one; `name` stands for its path.
std::string repaired_bytes(std::string_view bytes, const std::string& name,
                           const C3dReadOptions& options, C3dRepairResult& result);

/// For a person.
std::string repair_text(const C3dRepairResult& result);
/// The document that docs/c3d.md describes.
std::string repair_json(const C3dRepairResult& result);

}  // namespace kinemesh
