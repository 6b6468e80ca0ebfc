"""Reads C3D files with the Python package c3d and writes what it finds as plain binary.

Usage: read_with_python_c3d.py PACKAGE_FOLDER FILE... For each FILE, FILE.bin holds, little-endian: uint32 frames,
points, analog channels, samples per frame, first frame; float64 rate; then per frame points x (x, y,
z, residual, cameras) and channels x samples as float64; then the labels, one a line, as UTF-8.
"""
import struct
import sys
import warnings

sys.path.insert(0, sys.argv[1])
warnings.simplefilter("ignore")
import c3d  # noqa: E402
import numpy as np  # noqa: E402



def dump(path):
    with open(path, "rb") as handle:
        reader = c3d.Reader(handle)
        frames = [(points, analog) for _, points, analog in reader.read_frames(copy=True)]
    points = frames[0][0].shape[0] if frames else 0
    channels, samples = frames[0][1].shape if frames and frames[0][1].ndim == 2 else (0, 0)
    with open(path + ".bin", "wb") as out:
        out.write(struct.pack("<5Id", len(frames), points, channels, samples, reader.first_frame, reader.point_rate))
        for p, a in frames:
            out.write(np.ascontiguousarray(p, dtype="<f8").tobytes())
            out.write(np.ascontiguousarray(a, dtype="<f8").tobytes() if channels else b"")
        out.write("\n".join(label.strip() for label in reader.point_labels).encode("utf-8"))


for name in sys.argv[2:]:
    dump(name)
