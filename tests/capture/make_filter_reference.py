#!/usr/bin/env python3
"""Writes filter_reference.inc: what SciPy makes of a test signal, pinned for filter_test.cpp.

    pip install scipy && python3 tests/capture/make_filter_reference.py > tests/capture/filter_reference.inc
"""
import numpy as np
import scipy
from scipy import ndimage, signal

RATE = 100.0


def wave(n):
    i = np.arange(n, dtype=float)
    return 5 * np.sin(0.13 * i) + 0.7 * np.sin(1.9 * i) + 0.3 * np.cos(2.7 * i * i) + 800


def butterworth(n, order, cutoff):
    sos = signal.butter(order, cutoff, output="sos", fs=RATE)
    return signal.sosfiltfilt(sos, wave(n), padlen=min(n - 1, 3 * (order + 1)))


CASES = [
    ("butterworth", 40, dict(order=1, cutoff=10.0)),
    ("butterworth", 40, dict(order=2, cutoff=6.0)),
    ("butterworth", 40, dict(order=5, cutoff=12.0)),
    ("butterworth", 40, dict(order=8, cutoff=20.0)),
    ("butterworth", 10, dict(order=4, cutoff=6.0)),
    ("savitzky_golay", 40, dict(window=7, degree=3)),
    ("savitzky_golay", 40, dict(window=15, degree=2)),
    ("savitzky_golay", 9, dict(window=9, degree=5)),
    ("moving_average", 40, dict(window=5)),
    ("moving_average", 3, dict(window=7)),
    ("median", 40, dict(window=7)),
]

print(f"// Written by make_filter_reference.py with SciPy {scipy.__version__}.")
for method, n, given in CASES:
    if method == "butterworth":
        y = butterworth(n, given["order"], given["cutoff"])
    elif method == "savitzky_golay":
        y = signal.savgol_filter(wave(n), given["window"], given["degree"], mode="interp")
    elif method == "moving_average":
        y = ndimage.uniform_filter1d(wave(n), given["window"], mode="nearest")
    else:
        y = ndimage.median_filter(wave(n), given["window"], mode="nearest")
    values = ", ".join(f"{v:.10f}" for v in y)
    print(f"{{FilterMethod::{method}, {given.get('cutoff', 0.0)}, {given.get('order', 2)}, {given.get('window', 7)}, "
          f"{given.get('degree', 3)}, {{{values}}}}},")
