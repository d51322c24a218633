"""Merging of the boxes that neighboring key points give for one car."""

import numpy as np

from . import boxes as box_math


def merge(boxes, scores, threshold):
    """Boxes and scores after merging: the best box takes in all that overlap it by more than `threshold`.

    It becomes their median, and its score grows by each one's score times its overlap with that median: a car on which many
    points agree scores far above 1.
    """
    order = np.argsort(-scores, kind="stable")
    boxes, scores = boxes[order].copy(), scores[order].copy()
    kept_boxes, kept_scores = [], []
    while len(boxes):
        overlap = box_math.iou(boxes[0], boxes[1:])
        same = np.concatenate([[True], overlap > threshold])
        median = np.median(boxes[same], axis=0)
        others = same.copy()
        others[0] = False
        kept_boxes.append(median)
        kept_scores.append(scores[0] + np.sum(scores[others] * box_math.iou(median, boxes[others])))
        boxes, scores = boxes[~same], scores[~same]
    return np.array(kept_boxes).reshape(-1, 7), np.array(kept_scores)


def coverage(box, vertices):
    """Share of the box that the extent of the vertices in it fills, 0 to 1: a box that its points fill is the likelier car."""
    cos, sin = np.cos(box[6]), np.sin(box[6])
    offset = vertices - box[:3]
    along = offset[:, 0] * cos - offset[:, 2] * sin
    across = offset[:, 0] * sin + offset[:, 2] * cos
    local = np.column_stack([along / box[3], -offset[:, 1] / box[4] - 0.5, across / box[5]])
    inside = local[(np.abs(local) < 0.5).all(axis=1)]
    if len(inside) == 0:
        return 0.0
    return float(np.prod(inside.max(axis=0) - inside.min(axis=0)))
