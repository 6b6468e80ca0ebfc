"""trimesh and meshio: loads outputs and writes their vertices as JSON.

python3 in_python.py trimesh|meshio JOBS.json ANSWERS.json
"""
import sys

import answers

library, jobs_path, answers_path = sys.argv[1:4]


def with_trimesh(path):
    mesh = trimesh.load(path, process=False, maintain_order=True)
    if isinstance(mesh, trimesh.Scene):
        mesh = mesh.to_mesh()
    return mesh.vertices.tolist()


def with_meshio(path):
    return meshio.read(path).points.tolist()


if library == "trimesh":
    import trimesh
    version, load, kinds = trimesh.__version__, with_trimesh, ("ply", "ply ascii", "ply big-endian", "obj", "off", "glb of one frame")
else:
    import meshio
    version, load, kinds = meshio.__version__, with_meshio, ("ply", "ply ascii", "ply big-endian", "obj", "off")
answers.write(jobs_path, answers_path, version, {kind: lambda job: [load(path) for path in job["files"]] for kind in kinds})
