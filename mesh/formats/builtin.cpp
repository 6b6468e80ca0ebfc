// The one list of the mesh module's formats: each is a function `Format NAME_format()` in its .cpp.
// Where two formats could be meant, the first is taken.
#include "mesh/formats/registry.h"

#define KINEMESH_MESH_FORMATS(FORMAT) \
  FORMAT(ply)                         \
  FORMAT(pc2)                         \
  FORMAT(mdd)                         \
  FORMAT(obj)                         \
  FORMAT(off)                         \
  FORMAT(vtp)                         \
  FORMAT(pvd)                         \
  FORMAT(stl)                         \
  FORMAT(npz)                         \
  FORMAT(glb)                         \
  FORMAT(gltf)

namespace kinemesh {

#define KINEMESH_DECLARE(name) Format name##_format();
KINEMESH_MESH_FORMATS(KINEMESH_DECLARE)
#undef KINEMESH_DECLARE

FormatRegistry builtin_mesh_formats() {
  FormatRegistry registry;
#define KINEMESH_ADD(name) registry.add(name##_format());
  KINEMESH_MESH_FORMATS(KINEMESH_ADD)
#undef KINEMESH_ADD
  return registry;
}

}  // namespace kinemesh
