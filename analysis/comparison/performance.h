// One side of a comparison: an animated face, whether read as a mesh or recorded as markers.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "capture/marker_sequence.h"
#include "capture/session.h"
#include "mesh/animated_mesh.h"
#include "mesh/formats/mesh_io.h"
#include "reconstruct/convert.h"

namespace kinemesh {

/// A hole of the surface with its name: "mouth", "left eye", "right eye", "opening 4".
struct NamedLoop {
  std::string name;
  std::vector<VertexIndex> vertices;
};

struct Performance {
  AnimatedMesh mesh;               ///< the head's motion taken out
  std::vector<NamedLoop> loops;    ///< without the rim
  std::vector<std::string> notes;  ///< what is doubtful, in full sentences
  std::string path, sha256;
  MarkerSequence session;  ///< empty for a mesh
};

struct PerformanceOptions {
  SessionReadOptions reading;  ///< its unstated units hold for meshes, too
  ConvertOptions convert;
  bool steady = true;  ///< take the head's motion out
  void declare(ParameterSet& p);
  void validate() const;
};

/// A session (C3D, TRC, Motive, QTM) is converted as `kinemesh convert` does, its head held still
/// by its rigid markers; everything else is read as a mesh and held still by what moves least.
/// Throws as read_session, convert_session and read_animation.
Performance read_performance(const FormatRegistry& formats, const std::filesystem::path& path,
                             const PerformanceOptions& options = {}, const RunContext& ctx = {});

/// Each frame moved rigidly onto the first one, by the vertices that move least (iteratively
/// reweighted least squares).
void hold_still(AnimatedMesh& mesh, const RunContext& ctx = {});

/// The holes of a mesh but the longest, named by where they lie when they are three.
std::vector<NamedLoop> name_loops(const AnimatedMesh& mesh);

}  // namespace kinemesh
