#!/usr/bin/env python3
"""Values that tests/metrics.rs expects, computed by SciPy's cKDTree in float64.

Usage: metrics_scipy.py [FOLDER_WITH_REAL_DATA]     (needs numpy and scipy; tried with numpy 2.4, scipy 1.17)

The synthetic clouds are made by the same integer formula on both sides: every coordinate is a multiple of 2^-16 m
that an f32 holds exactly. Prints one Rust `Quality` literal per comparison.
"""
import sys
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

MAX_RANGE_M = 80.0


def random_words(seed):
    state = seed
    while True:
        state = (state * 1664525 + 1013904223) % 2**32
        yield state


def cloud(points, seed, shape):
    """The original: coordinates in 2^-16 m, each from the upper 24 bits of one step of the generator."""
    words = random_words(seed)
    ticks = np.array([[(next(words) >> 8) - 2**23 for _ in range(3)] for _ in range(points)], dtype=np.int64)
    if shape == "flat":
        ticks[:, 2] = -113_000
    elif shape == "line":
        ticks[:, :2] = 65_536
    elif shape == "repeated":
        ticks = ticks[np.arange(points) % 7]
    return ticks


def reconstruct(ticks, seed):
    """Every third point lost, the others moved by less than 1/8 m along each axis."""
    words = random_words(seed)
    moved = [point + [(next(words) >> 18) - 2**13 for _ in range(3)] for i, point in enumerate(ticks) if i % 3]
    return np.array(moved)


def meters(ticks):
    return ticks / 65536.0


def kitti(path):
    return np.fromfile(path, dtype="<f4").reshape(-1, 4)[:, :3].astype(np.float64)


def lattice(points):
    """Coordinates rounded down to multiples of 1/8 m: exact in f32."""
    return np.floor(points * 8.0) / 8.0


def psnr_db(mse_m2):
    return 10.0 * np.log10(MAX_RANGE_M**2 / mse_m2) if mse_m2 > 0.0 else np.inf


def rust(value):
    return repr(float(value)) if np.isfinite(value) else "f64::INFINITY"


def print_expected(name, original, reconstructed):
    forward = cKDTree(original).query(reconstructed)[0]
    reverse = cKDTree(reconstructed).query(original)[0]
    mse, mse_reverse = np.mean(forward**2), np.mean(reverse**2)
    print(f'// {name}: {len(original)} and {len(reconstructed)} points')
    print("Quality {")
    for field, value in [
        ("mse_m2", mse),
        ("mse_reverse_m2", mse_reverse),
        ("psnr_db", psnr_db(mse)),
        ("psnr_reverse_db", psnr_db(mse_reverse)),
        ("cd_m2", mse + mse_reverse),
        ("cd_mean_m", (forward.mean() + reverse.mean()) / 2),
        ("max_error_m", forward.max()),
        ("max_error_reverse_m", reverse.max()),
    ]:
        print(f"    {field}: {rust(value)},")
    print("}")


def main():
    for name, points, shape in [
        ("small", 10, "solid"),
        ("solid", 2000, "solid"),
        ("flat", 2000, "flat"),
        ("line", 2000, "line"),
        ("repeated", 2000, "repeated"),
        ("large", 20000, "solid"),
    ]:
        original = cloud(points, 1, shape)
        print_expected(name, meters(original), meters(reconstruct(original, 2)))
    if len(sys.argv) > 1:
        drive = Path(sys.argv[1]) / "kitti" / "drive"
        scan = kitti(drive / "000000.bin")
        print_expected("next turn", scan, kitti(drive / "000001.bin"))
        print_expected("lattice of 1/8 m", scan, lattice(scan))
        print_expected("every fifth point", scan, scan[::5])


if __name__ == "__main__":
    main()
