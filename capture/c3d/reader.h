// Reads a C3D file of any processor and storage, damaged or not.
//
// Everything that a damaged file allows is read, and each deviation becomes a finding; a file is
// refused (InputError) only when nothing sensible can be decoded: it is no regular file, has no
// C3D header, or its layout fits no data. Changes in the data section alone never lead to that.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "capture/c3d/finding.h"
#include "capture/c3d/layout.h"
#include "capture/marker_sequence.h"
#include "config/parameter.h"
#include "config/run_context.h"
#include "mesh/formats/options.h"

namespace kinemesh {

enum class C3dReader : uint8_t { own, ezc3d };

/// What a point at exactly (0, 0, 0) with a residual ≥ 0 means. The format calls it valid; some
/// tools write it for a gap. Angles, forces, moments, powers and scalars are always valid there.
enum class ZeroPolicy : uint8_t { gap, valid };

struct C3dReadOptions {
  C3dReader reader = C3dReader::own;
  ZeroPolicy zero_points = ZeroPolicy::gap;
  ReadOptions unstated;  ///< unit and rate of files that do not say theirs; the ezc3d reader too
  void declare(ParameterSet& p);
  /// Throws UsageError.
  void validate() const;
};

struct C3dReadResult {
  MarkerSequence take;
  C3dHeader header;
  C3dLayout layout;
  std::vector<C3dFinding> findings;  ///< in the order of the file
};

/// Header and parameters without the data section: `take` stays without frames but has labels,
/// rate, origin, events and parameters.
using C3dHeadResult = C3dReadResult;

/// Throws InputError when the file cannot be read at all (see above).
C3dReadResult read_c3d(const std::filesystem::path& path, const C3dReadOptions& options = {},
                       const RunContext& ctx = {});
/// The same from memory; `name` stands for the path in messages. Own reader only.
C3dReadResult read_c3d(std::span<const std::byte> bytes, const std::string& name,
                       const C3dReadOptions& options = {}, const RunContext& ctx = {});

/// Cheap: reads some 100 kB at most, whatever the size of the file.
C3dHeadResult read_c3d_head(const std::filesystem::path& path, const C3dReadOptions& options = {});
C3dHeadResult read_c3d_head(std::span<const std::byte> bytes, const std::string& name,
                            const C3dReadOptions& options = {});

}  // namespace kinemesh
