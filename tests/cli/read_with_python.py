#!/usr/bin/env python3
"""Others read what we write: trimesh, meshio, and VTK for VTP, which neither of the two knows; for
glTF animations, which none of them plays, a reader written here from the specification.

read_with_python.py KINEMESH SESSION DEPS: converts some frames of the session into every format and
compares with the NumPy archive. Ends with 77 (skipped) when the packages are not installed, unless
KINEMESH_REQUIRE_DATA is set.
"""

import json
import os
import struct
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

FRAMES = 3


def check(holds, what):
    if not holds:
        raise AssertionError(what)
    print("ok:", what)


class Converted:
    """Frames 1 to 3 of the session in each format asked for."""

    def __init__(self, program, session, folder):
        self.program, self.session, self.folder = program, session, folder

    def write(self, name, *options, frames=f"1:{FRAMES}"):
        path = os.path.join(self.folder, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        subprocess.run([self.program, "convert", self.session, "-o", path, "--no-pictures", "--no-report", "-q",
                        "--frames", frames, *options], check=True, stdout=subprocess.DEVNULL)
        return path


def numbered(path, frame):
    stem, extension = os.path.splitext(path)
    return f"{stem}_{frame + 1:04d}{extension}"


def by_trimesh(path):
    import trimesh
    mesh = trimesh.load(path, process=False, maintain_order=True)
    if isinstance(mesh, trimesh.Scene):
        mesh = mesh.to_mesh()
    return mesh.vertices, mesh.faces


def by_meshio(path):
    import meshio
    mesh = meshio.read(path)
    return mesh.points, mesh.cells_dict["triangle"]


def by_vtk_specification(path):
    """https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html, appended raw data."""
    import numpy
    with open(path, "rb") as file:
        data = file.read()
    begin = data.index(b"_", data.index(b"<AppendedData")) + 1
    end = data.rindex(b"</AppendedData>")
    root = xml.etree.ElementTree.fromstring(data[:begin] + data[end:])
    order = "<" if root.get("byte_order") == "LittleEndian" else ">"
    header = {"UInt32": "u4", "UInt64": "u8"}[root.get("header_type", "UInt32")]
    kinds = {"Float32": "f4", "Float64": "f8", "Int32": "i4", "Int64": "i8", "UInt8": "u1"}

    def array(element):
        at = begin + int(element.get("offset"))
        (size,) = numpy.frombuffer(data, order + header, 1, at)
        kind = numpy.dtype(order + kinds[element.get("type")])
        return numpy.frombuffer(data, kind, int(size) // kind.itemsize, at + int(header[1]))

    piece = root.find("PolyData/Piece")
    points = array(piece.find("Points/DataArray")).reshape(-1, 3)
    polys = {a.get("Name"): array(a) for a in piece.findall("Polys/DataArray")}
    check(len(points) == int(piece.get("NumberOfPoints")), "VTP: as many points as it says")
    check((polys["offsets"] == 3 * (1 + numpy.arange(int(piece.get("NumberOfPolys"))))).all(), "VTP: triangles")
    return points, polys["connectivity"].reshape(-1, 3)


def by_vtk(path):
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader
    reader = vtkXMLPolyDataReader()
    reader.SetFileName(path)
    reader.Update()
    mesh = reader.GetOutput()
    names = mesh.GetPointData().GetAbstractArray("vertex_name")
    check(names is not None and names.GetNumberOfValues() == mesh.GetNumberOfPoints(), "VTP: VTK knows the vertices' names")
    return vtk_to_numpy(mesh.GetPoints().GetData()), vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)


class Glb:
    """An animated mesh by the glTF 2.0 specification: base positions, morph targets, weights."""

    def __init__(self, path):
        with open(path, "rb") as file:
            data = file.read()
        magic, version, length = struct.unpack_from("<4sII", data)
        check(magic == b"glTF" and version == 2 and length == len(data), "GLB: header")
        size, kind = struct.unpack_from("<I4s", data, 12)
        check(kind == b"JSON", "GLB: JSON comes first")
        self.json = json.loads(data[20:20 + size])
        self.binary = data[20 + size + 8:]

    def accessor(self, index):
        import numpy
        a = self.json["accessors"][index]
        kind, scale = {5126: ("<f4", 1), 5120: ("i1", 127), 5122: ("<i2", 32767), 5121: ("u1", 255), 5123: ("<u2", 65535),
                       5125: ("<u4", 1)}[a["componentType"]]
        parts = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[a["type"]]
        view = self.json["bufferViews"][a["bufferView"]]
        at = view.get("byteOffset", 0) + a.get("byteOffset", 0)
        item = numpy.dtype(kind).itemsize * parts
        stride = view.get("byteStride", item)
        rows = [numpy.frombuffer(self.binary, kind, parts, at + i * stride) for i in range(a["count"])]
        values = numpy.array(rows)
        if a.get("normalized"):
            values = numpy.maximum(values / scale, -1.0)
        return values[:, 0] if parts == 1 else values

    def frame(self, time):
        import numpy
        primitive = self.json["meshes"][0]["primitives"][0]
        points = self.accessor(primitive["attributes"]["POSITION"]).astype(float)
        sampler = self.json["animations"][0]["samplers"][0]
        times = self.accessor(sampler["input"])
        targets = primitive["targets"]
        weights = self.accessor(sampler["output"]).reshape(len(times), len(targets))
        for k, target in enumerate(targets):
            points = points + numpy.interp(time, times, weights[:, k]) * self.accessor(target["POSITION"])
        return self.upright(points)

    def upright(self, points):
        import numpy
        node = next(n for n in self.json["nodes"] if "mesh" in n)
        check("matrix" not in node, "GLB: no matrix")
        x, y, z, w = node.get("rotation", (0, 0, 0, 1))
        turn = numpy.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
        return (points * node.get("scale", (1, 1, 1))) @ turn.T + node.get("translation", (0, 0, 0))


def millimetres(metres):
    """glTF has metres and Y up, our data Z up."""
    import numpy
    x, y, z = 1000 * numpy.asarray(metres).T
    return numpy.stack([x, -z, y], axis=1)


def compare(converted, truth, faces):
    import numpy
    readers = {"trimesh": by_trimesh, "meshio": by_meshio, "VTK": by_vtk, "the specification": by_vtk_specification}
    for name, options, who in (("ply/a.ply", ["--format", "ply"], ("trimesh", "meshio")),
                               ("ascii/a.ply", ["--format", "ply", "--encoding", "ascii"], ("trimesh", "meshio")),
                               ("big/a.ply", ["--format", "ply", "--encoding", "binary-big"], ("trimesh", "meshio")),
                               ("a.obj", [], ("trimesh", "meshio")),
                               ("a.off", [], ("trimesh", "meshio")),
                               ("a.vtp", [], ("VTK", "the specification")),
                               ("ascii/a.vtp", ["--encoding", "ascii"], ("VTK",))):
        path = converted.write(name, *options)
        for reader in who:
            for frame in range(FRAMES):
                points, triangles = readers[reader](numbered(path, frame))
                equal = (numpy.asarray(points, numpy.float32) == truth[frame]).all()
                check(equal and (numpy.asarray(triangles) == faces).all(), f"{name}, frame {frame + 1}: {reader} reads equal values")


def compare_glb(converted, everything, faces, rate):
    import numpy
    still = converted.write("still.glb", frames="2")
    points, triangles = by_trimesh(still)
    worst = abs(millimetres(points) - everything[1]).max()
    check(worst < 1e-4 and (triangles == faces).all(), f"GLB of one frame: trimesh reads equal values ({worst:.1e} mm)")
    limit = 0.05
    moving = Glb(converted.write("moving.glb", "--max-error", str(limit), frames=""))
    for frame in (0, len(everything) // 3, len(everything) - 1):
        found = millimetres(moving.frame(frame / rate))
        worst = numpy.linalg.norm(found - everything[frame], axis=1).max()
        check(worst <= limit, f"GLB, frame {frame + 1}: morph targets within --max-error ({worst:.4f} mm)")
    points, triangles = by_trimesh(os.path.join(converted.folder, "moving.glb"))
    check(len(points) == len(everything[0]) and (triangles == faces).all(), "animated GLB: trimesh reads its shape")


def main():
    program, session, deps = sys.argv[1:4]
    sys.path[:0] = [os.path.join(deps, "python_trimesh"), os.path.join(deps, "python_meshio")]
    try:
        import numpy
        import meshio  # noqa: F401
        import trimesh  # noqa: F401
        import vtkmodules.vtkIOXML  # noqa: F401
    except ImportError as missing:
        print("skipped:", missing)
        return 1 if os.environ.get("KINEMESH_REQUIRE_DATA") else 77
    with tempfile.TemporaryDirectory() as folder:
        converted = Converted(program, session, folder)
        archive = numpy.load(converted.write("truth.npz", frames=""))
        everything, faces = archive["positions"], archive["faces"]
        compare(converted, everything, faces)
        compare_glb(converted, everything, faces, float(archive["rate_hz"]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
