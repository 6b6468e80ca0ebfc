"""trimesh and meshio: loads outputs and writes their vertices as JSON.

python3 in_python.py trimesh|meshio JOBS.json ANSWERS.json
"""
import json
import sys
import traceback

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
answers = {}
with open(jobs_path) as file:
    jobs = json.load(file)
for job in jobs:
    if job["kind"] not in kinds:
        continue
    try:
        answers[job["kind"]] = {"positions": [load(path) for path in job["files"]]}
    except Exception as error:
        traceback.print_exc()
        answers[job["kind"]] = {"error": str(error)}
with open(answers_path, "w") as file:
    json.dump({"version": version, "answers": answers}, file)
