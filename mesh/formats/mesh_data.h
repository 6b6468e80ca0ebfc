// What a reader found in one file, before units are settled and adjacency is built.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "config/buffer.h"
#include "config/run_context.h"
#include "mesh/animated_mesh.h"
#include "mesh/formats/options.h"
#include "mesh/formats/units.h"

namespace kinemesh {

/// A vertex that is filled in the frames `first` to `last` (0-based, both included).
struct FilledRun {
  std::size_t vertex = 0, first = 0, last = 0;
};

/// Standard deviations in mm of a vertex from frame `first` (0-based) on, one a frame.
struct UncertaintyRun {
  std::size_t vertex = 0, first = 0;
  std::vector<float> mm;
};

struct MeshData {
  std::size_t vertex_count = 0;
  std::size_t frame_count = 1;
  Buffer<float> positions;      ///< frames × vertices × 3, in `unit`
  std::vector<Triangle> faces;  ///< indices 0-based and below vertex_count
  Buffer<uint8_t> filled;       ///< empty, or frames × vertices
  Buffer<float> uncertainty;    ///< empty, or frames × vertices, in `unit`
  /// Another way to say which samples are filled; used when `filled` is empty.
  std::optional<std::vector<FilledRun>> filled_runs;
  /// Another way to say how uncertain samples are; used when `uncertainty` is empty. 0 elsewhere.
  std::optional<std::vector<UncertaintyRun>> uncertainty_runs;
  std::optional<LengthUnit> unit;  ///< empty when the file does not say
  double rate_hz = 0.0;            ///< 0 when the file does not say
  std::optional<int64_t> first_frame;
  std::vector<Event> events;
  std::vector<std::string> vertex_names;  ///< empty, or one per vertex
  Provenance provenance;
  std::vector<std::string> warnings;  ///< what the reader had to leave out
  std::size_t polygons = 0;           ///< faces of more than three corners, triangulated
  std::size_t dropped_faces = 0;      ///< faces that repeat a vertex, left out

  /// Allocates positions, uninitialised.
  void allocate(std::size_t frames, std::size_t vertices);
};

/// Positions in mm, adjacency, names; `options` supplies what the file did not say. Throws
/// InputError naming `file` (vertex and frame too) for a position that is no finite number.
/// Logs what was triangulated or left out, and which unit was assumed.
AnimatedMesh to_animated_mesh(MeshData data, const ReadOptions& options, const std::string& file,
                              const RunContext& ctx = {});

/// The first frame of `data`; shares `topology` instead of building one when the faces are equal.
Mesh to_mesh(MeshData data, const ReadOptions& options, const std::string& file,
             const std::shared_ptr<const Topology>& topology = nullptr, const RunContext& ctx = {});

}  // namespace kinemesh
