#!/usr/bin/env python3
"""How far two pictures are apart: difference.py A.exr B.exr (needs the packages numpy and OpenEXR).

Prints the share of pixels that differ, the root of the mean squared difference over the mean of A, the relative
difference of the means, and how many pixels are off by more than a ten-thousandth of A's mean, with their part of the
squared difference.
"""
import sys

import numpy as np
import OpenEXR


def load(path):
    channels = OpenEXR.File(path).channels()
    if "RGB" in channels:
        return channels["RGB"].pixels.astype(np.float64)
    return np.stack([channels[name].pixels for name in "RGB"], -1).astype(np.float64)


a, b = (load(path) for path in sys.argv[1:3])
if a.shape != b.shape:
    sys.exit(f"{sys.argv[1]} is {a.shape} but {sys.argv[2]} is {b.shape}")
squares = (b - a) ** 2
mean = a.mean()
off = np.abs(b - a).max(-1) > 1e-4 * mean
part = squares[off].sum() / squares.sum() if squares.any() else 0.0
print(f"pixels that differ: {np.any(a != b, -1).mean():.4f}")
print(f"RMS difference over the mean: {np.sqrt(squares.mean()) / mean:.3e}")
print(f"difference of the means: {b.mean() / mean - 1:.3e}")
print(f"pixels off by more than 1e-4 of the mean: {off.sum()} of {off.size}, {part:.6f} of the squared difference")
