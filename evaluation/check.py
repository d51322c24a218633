"""The metrics once more, by SciPy: what `flicr compare` says must be what another implementation finds."""

import math

import numpy
from scipy.spatial import cKDTree

# Of each other, relative. Both sum the same float32 coordinates' distances in 64 bits.
TOLERANCE = 1e-6
PEAK_M = 80.0
ALPHA, BETA = -0.15, 0.5


def read_returns(path):
    """Points of a KITTI file, but those at the origin."""
    points = numpy.fromfile(path, "<f4").reshape(-1, 4)[:, :3].astype(float)
    return points[(points ** 2).sum(axis=1) > 0]


def measures(original, decoded):
    """The same names as of `flicr compare`."""
    forward, _ = cKDTree(original).query(decoded)
    reverse, _ = cKDTree(decoded).query(original)
    mse, mse_reverse = (forward ** 2).mean(), (reverse ** 2).mean()
    found = {
        "points": len(original), "decoded": len(decoded), "psnr_db": psnr(mse), "psnr_reverse_db": psnr(mse_reverse), "cd_m2": mse + mse_reverse,
        "cd_mean_m": 0.5 * (forward.mean() + reverse.mean()), "max_error_m": forward.max(), "max_error_reverse_m": reverse.max(),
        "se": None, "epsnr_db": None,
    }
    if len(decoded) <= len(original):
        found["se"] = se = 1 - len(decoded) / len(original)
        found["epsnr_db"] = found["psnr_db"] and found["psnr_db"] * (1 - se * lost_share(se))
    return found


def psnr(mse):
    return 10 * math.log10(PEAK_M ** 2 / mse) if mse else None


def lost_share(se):
    return min(1.0, max(0.0, math.exp(-(1 - se) / BETA) + ALPHA))


def disagreements(said, found):
    """Names of what is not the same, with both values."""
    return [f"{name}: {said[name]} and {value}" for name, value in found.items() if not same(said[name], value)]


def same(one, other):
    if one is None or other is None:
        return one is other
    # Distances of a few micrometers hang on the last digits of float32 coordinates.
    return math.isclose(one, other, rel_tol=TOLERANCE, abs_tol=1e-9)
