"""The graph that the network works on: key points a voxel apart, and edges to all within a radius."""

import numpy as np
from scipy.spatial import cKDTree


# The two points of a voxel of two are as near to their mean as each other: the one further this way is taken, so that neither the
# order of points nor a last digit decides. Far above rounding, far below any distance.
TIE_BREAK_M = np.array([1e-6, 0.7e-6, 0.4e-6])


def key_points(points, voxel_size_m, grid_origin=(0.0, 0.0, 0.0)):
    """Indices of the points nearest to the mean of each occupied voxel.

    The voxels' corner is `grid_origin`, not the cloud's least corner as in the authors' code: one point more or less at the rim
    would move every voxel, and with them every detection.
    """
    voxels = np.floor((points - np.asarray(grid_origin)) / voxel_size_m).astype(np.int64)
    voxels -= voxels.min(axis=0)
    dims = voxels.max(axis=0) + 1
    key = (voxels[:, 0] * dims[1] + voxels[:, 1]) * dims[2] + voxels[:, 2]
    _, group, count = np.unique(key, return_inverse=True, return_counts=True)
    sums = np.column_stack([np.bincount(group, weights=points[:, axis]) for axis in range(3)])
    return cKDTree(points).query(sums / count[:, None] + TIE_BREAK_M)[1]


def radius_edges(sources, centers, radius_m):
    """Edges from each source to every center within `radius_m`: source and center indices, ordered by center, then source."""
    pairs = cKDTree(centers).sparse_distance_matrix(cKDTree(sources), radius_m, output_type="ndarray")
    order = np.lexsort((pairs["j"], pairs["i"]))
    return pairs["j"][order], pairs["i"][order]
