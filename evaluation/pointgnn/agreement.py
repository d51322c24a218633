"""How well detections find given boxes: labels, or what was detected in the original cloud."""

import numpy as np

from . import boxes as box_math

IOU_THRESHOLDS = (0.3, 0.5, 0.7)


def best_iou(wanted, found, ground_only=False):
    """For each wanted box, the best overlap with any found one; a found box may serve one wanted box only, the best pair first."""
    overlap = np.array([box_math.iou(box, found, ground_only) for box in wanted]).reshape(len(wanted), len(found))
    best = np.zeros(len(wanted))
    for _ in range(min(overlap.shape)):
        row, column = np.unravel_index(np.argmax(overlap), overlap.shape)
        if overlap[row, column] <= 0:
            break
        best[row] = overlap[row, column]
        overlap[row, :], overlap[:, column] = -1, -1
    return best


def recall(best, thresholds=IOU_THRESHOLDS):
    """Share of boxes found with at least each overlap; nan where there are none."""
    best = np.asarray(best)
    return {threshold: float((best >= threshold).mean()) if len(best) else float("nan") for threshold in thresholds}


def invented(found, wanted):
    """How many of the found boxes touch none of the wanted ones, seen from above."""
    return sum(1 for box in found if box_math.iou(box, wanted, ground_only=True).max(initial=0) == 0)


def nearest_values(points, originals, values):
    """For each point the value (intensity) of the nearest original point: what a codec of geometry alone is judged on."""
    from scipy.spatial import cKDTree

    return values[cKDTree(originals).query(points)[1]]


def turned(points, quarter_turns):
    """Points turned about the vertical axis, so that the camera's view takes in another part of the scan."""
    cos, sin = ((1, 0), (0, 1), (-1, 0), (0, -1))[quarter_turns % 4]
    turned_points = np.array(points, copy=True)
    turned_points[:, 0] = cos * points[:, 0] - sin * points[:, 1]
    turned_points[:, 1] = sin * points[:, 0] + cos * points[:, 1]
    return turned_points
