"""Inside Blender: loads outputs and writes their vertices at some frames as JSON.

blender -b --factory-startup -P in_blender.py -- JOBS.json ANSWERS.json
JOBS: list of {"kind", "path", "files", "frames", "rate"}; positions are as Blender's world has them.
"""
import os
import sys

import bpy
import numpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import answers  # noqa: E402

# Debian's Blender 3.4 imports glTF with a name that Debian's NumPy has dropped.
numpy.bool = bool

jobs_path, answers_path = sys.argv[sys.argv.index("--") + 1:]


def empty(rate):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.fps = int(rate)
    bpy.context.scene.render.fps_base = 1.0


def the_mesh():
    return next(o for o in bpy.data.objects if o.type == "MESH")


def vertices():
    graph = bpy.context.evaluated_depsgraph_get()
    found = the_mesh().evaluated_get(graph)
    mesh = found.to_mesh()
    return [list(found.matrix_world @ v.co) for v in mesh.vertices]


def cached(job, kind):
    bpy.ops.import_mesh.ply(filepath=job["geometry"])
    modifier = the_mesh().modifiers.new("cache", "MESH_CACHE")
    modifier.cache_format, modifier.filepath = kind, job["path"]
    modifier.forward_axis, modifier.up_axis = "POS_Y", "POS_Z"
    modifier.frame_start = 0.0
    result = []
    for frame in job["frames"]:
        bpy.context.scene.frame_set(frame)
        result.append(vertices())
    return result


def imported(job):
    bpy.ops.import_scene.gltf(filepath=job["path"])
    result = []
    for frame in job["frames"]:
        bpy.context.scene.frame_set(frame)
        result.append(vertices())
    return result


def each(job, load):
    result = []
    for path in job["files"]:
        empty(job["rate"])
        load(path)
        result.append(vertices())
    return result


def load_obj(path):
    bpy.ops.wm.obj_import(filepath=path, forward_axis="Y", up_axis="Z")


def load_ply(path):
    bpy.ops.import_mesh.ply(filepath=path)


def load_gltf(path):
    bpy.ops.import_scene.gltf(filepath=path)


LOADERS = {"ply": lambda j: each(j, load_ply), "ply ascii": lambda j: each(j, load_ply), "ply big-endian": lambda j: each(j, load_ply),
           "obj": lambda j: each(j, load_obj), "ply+pc2": lambda j: cached(j, "PC2"), "mdd": lambda j: cached(j, "MDD"),
           "glb": imported, "gltf": imported, "glb of one frame": lambda j: each(j, load_gltf)}

answers.write(jobs_path, answers_path, bpy.app.version_string, LOADERS, before=lambda job: empty(job["rate"]))
