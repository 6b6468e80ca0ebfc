"""Inside ParaView: loads outputs and writes their vertices at some frames as JSON.

pvpython in_paraview.py JOBS.json ANSWERS.json; JOBS as for in_blender.py.
"""
import os
import shutil
import sys

from paraview import servermanager, simple

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import answers  # noqa: E402

simple._DisableFirstRenderCameraReset()
jobs_path, answers_path = sys.argv[1:3]


def points_of(data):
    if data.IsA("vtkMultiBlockDataSet") or data.IsA("vtkPartitionedDataSetCollection"):
        walk = data.NewIterator()
        walk.InitTraversal()
        while not walk.IsDoneWithTraversal():
            block = walk.GetCurrentDataObject()
            if block.GetNumberOfPoints() > 0:
                return points_of(block)
            walk.GoToNextItem()
    return [list(data.GetPoint(i)) for i in range(data.GetNumberOfPoints())]


def at_times(reader, times):
    result = []
    for time in times:
        reader.UpdatePipeline(time)
        result.append(points_of(servermanager.Fetch(reader)))
    return result


def each(job, make):
    result = []
    for path in job["files"]:
        reader = make(path)
        reader.UpdatePipeline()
        result.append(points_of(servermanager.Fetch(reader)))
    return result


def pvd(job):
    return at_times(simple.PVDReader(FileName=job["path"]), [f / job["rate"] for f in job["frames"]])


def gltf(job):
    reader = simple.glTFReader(FileName=job["path"])
    reader.Framerate = int(job["rate"])
    reader.AnimationStatus = ["motion", "1"]
    reader.UpdatePipelineInformation()
    return at_times(reader, [f / job["rate"] for f in job["frames"]])


def still_gltf(path):
    return simple.glTFReader(FileName=path)


def csv(job):
    table = simple.CSVReader(FileName=[job["path"]])
    table.UpdatePipeline()
    return {"rows": servermanager.Fetch(table).GetNumberOfRows()}


def vtp(path):
    return simple.XMLPolyDataReader(FileName=[path])


def ply(path):
    # A name ending in a number would be taken for one of a series.
    copy = os.path.join(os.path.dirname(path), "still.ply")
    shutil.copyfile(path, copy)
    return simple.PLYReader(FileNames=[copy])


LOADERS = {"vtp": lambda j: each(j, vtp), "pvd": pvd, "ply": lambda j: each(j, ply), "ply ascii": lambda j: each(j, ply),
           "ply big-endian": lambda j: each(j, ply),
           "obj": lambda j: each(j, lambda p: simple.WavefrontOBJReader(FileName=p)), "glb": gltf, "gltf": gltf,
           "glb of one frame": lambda j: each(j, still_gltf), "csv": csv}

answers.write(jobs_path, answers_path, str(servermanager.vtkSMProxyManager.GetParaViewSourceVersion()), LOADERS)
