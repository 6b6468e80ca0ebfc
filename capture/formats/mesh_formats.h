// Recordings in the registry of mesh formats: C3D, TRC and CSV, whose vertices are the markers.
#pragma once

#include "capture/marker_sequence.h"
#include "mesh/animated_mesh.h"
#include "mesh/formats/registry.h"

namespace kinemesh {

/// Adds C3D, TRC and CSV. They hold no faces: what is read is an animation of points.
void add_capture_formats(FormatRegistry& formats);

/// All formats of the mesh and capture modules.
FormatRegistry all_formats();

/// The vertices as measured markers with the mesh's names ("v0", "v1", … where it has none), filled
/// flags, uncertainty and events. A name "subject:label" is split.
MarkerSequence markers_of(const AnimatedMesh& mesh);

}  // namespace kinemesh
