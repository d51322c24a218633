"""Boxes: corners, overlap, and the form in which the network gives them.

A box is x, y, z (middle of the bottom face), length, height, width, yaw; y points down, so that a box spans y - height to y.
"""

import numpy as np

# Length, height, width of the median car of KITTI's training labels: the unit in which the network's boxes are given.
CAR_SIZE_M = np.array([3.88, 1.5, 1.63])
QUARTER_TURN = np.pi / 2
YAW_UNIT = np.pi / 4


def encode(boxes, vertices, side_on):
    """Boxes as seen from `vertices`, in the network's units. Cars across the view (`side_on`) count their yaw from 90 degrees."""
    boxes = np.asarray(boxes, dtype=np.float64)
    center = (boxes[:, :3] - vertices) / CAR_SIZE_M
    size = np.log(boxes[:, 3:6] / CAR_SIZE_M)
    yaw = (boxes[:, 6] - np.where(side_on, QUARTER_TURN, 0.0)) / YAW_UNIT
    return np.column_stack([center, size, yaw])


def decode(encoded, vertices, side_on):
    """The inverse of `encode`."""
    center = encoded[:, :3] * CAR_SIZE_M + vertices
    size = np.exp(encoded[:, 3:6]) * CAR_SIZE_M
    yaw = encoded[:, 6] * YAW_UNIT + np.where(side_on, QUARTER_TURN, 0.0)
    return np.column_stack([center, size, yaw])


def ground_corners(boxes):
    """x and z of the bottom face's corners, (N, 4, 2), all in one turning direction."""
    boxes = np.atleast_2d(boxes)
    along = boxes[:, 3, None] / 2 * np.array([1, 1, -1, -1])
    across = boxes[:, 5, None] / 2 * np.array([1, -1, -1, 1])
    cos, sin = np.cos(boxes[:, 6, None]), np.sin(boxes[:, 6, None])
    x = boxes[:, 0, None] + along * cos + across * sin
    z = boxes[:, 2, None] - along * sin + across * cos
    return np.stack([x, z], axis=-1)


def corners(boxes):
    """All eight corners, (N, 8, 3): the bottom face, then the top."""
    boxes = np.atleast_2d(boxes)
    ground = ground_corners(boxes)
    faces = []
    for y in (boxes[:, 1], boxes[:, 1] - boxes[:, 4]):
        faces.append(np.stack([ground[..., 0], np.repeat(y[:, None], 4, axis=1), ground[..., 1]], axis=-1))
    return np.concatenate(faces, axis=1)


def iou(box, others, ground_only=False):
    """Intersection over union of a box with each of `others`: of volumes, or of the areas seen from above."""
    box, others = np.asarray(box, dtype=np.float64), np.atleast_2d(np.asarray(others, dtype=np.float64))
    if len(others) == 0:
        return np.zeros(0)
    shared = np.zeros(len(others))
    reach = np.hypot(box[3], box[5]) / 2 + np.hypot(others[:, 3], others[:, 5]) / 2
    near = np.hypot(others[:, 0] - box[0], others[:, 2] - box[2]) < reach
    shared[near] = _shared_area(ground_corners(box)[0], ground_corners(others[near]))
    own, theirs = box[3] * box[5], others[:, 3] * others[:, 5]
    if not ground_only:
        top = np.maximum(box[1] - box[4], others[:, 1] - others[:, 4])
        shared = shared * np.clip(np.minimum(box[1], others[:, 1]) - top, 0, None)
        own, theirs = own * box[4], theirs * others[:, 4]
    return shared / np.maximum(own + theirs - shared, 1e-12)


def _shared_area(quad, quads):
    """Area shared by a rectangle and each of N others. The shared region is convex: its vertices are the corners of one inside
    the other and the crossings of edges, in order of their direction from their middle."""
    count = len(quads)
    crossings, crosses = _edge_crossings(quad, quads)
    points = np.concatenate([np.broadcast_to(quad, (count, 4, 2)), quads, crossings], axis=1)
    inside = np.concatenate([_inside(np.broadcast_to(quad, (count, 4, 2)), quads), _inside(quads, quad[None]), crosses], axis=1)
    number = inside.sum(axis=1)
    middle = (points * inside[..., None]).sum(axis=1) / np.maximum(number, 1)[:, None]
    points = points - middle[:, None]
    direction = np.where(inside, np.arctan2(points[..., 1], points[..., 0]), np.inf)
    order = np.argsort(direction, axis=1)
    points = np.take_along_axis(points, order[..., None], axis=1)
    # Points outside come last; each becomes the first vertex again, which adds no area.
    kept = np.arange(points.shape[1]) < number[:, None]
    points = np.where(kept[..., None], points, points[:, :1])
    following = np.roll(points, -1, axis=1)
    area = (points[..., 0] * following[..., 1] - points[..., 1] * following[..., 0]).sum(axis=1) / 2
    return np.where(number > 2, np.abs(area), 0.0)


def _inside(points, quads, slack=1e-9):
    """Which points lie in their convex quadrilateral, whichever way it turns."""
    edge = np.roll(quads, -1, axis=1) - quads
    to_point = points[:, :, None] - quads[:, None]
    side = edge[:, None, :, 0] * to_point[..., 1] - edge[:, None, :, 1] * to_point[..., 0]
    return (side >= -slack).all(axis=-1) | (side <= slack).all(axis=-1)


def _edge_crossings(quad, quads):
    """Where the four edges of one rectangle cross those of each other, (N, 16, 2), and whether they do."""
    start, edge = quad[None, :, None], (np.roll(quad, -1, axis=0) - quad)[None, :, None]
    other_start, other_edge = quads[:, None], (np.roll(quads, -1, axis=1) - quads)[:, None]
    cross = edge[..., 0] * other_edge[..., 1] - edge[..., 1] * other_edge[..., 0]
    gap = other_start - start
    parallel = np.abs(cross) < 1e-12
    cross = np.where(parallel, 1.0, cross)
    along = (gap[..., 0] * other_edge[..., 1] - gap[..., 1] * other_edge[..., 0]) / cross
    along_other = (gap[..., 0] * edge[..., 1] - gap[..., 1] * edge[..., 0]) / cross
    crosses = ~parallel & (along >= 0) & (along <= 1) & (along_other >= 0) & (along_other <= 1)
    points = start + along[..., None] * edge
    return points.reshape(len(quads), 16, 2), crosses.reshape(len(quads), 16)
