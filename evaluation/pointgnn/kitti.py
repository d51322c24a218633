"""KITTI's object benchmark: calibration, labels, and the camera's part of a scan."""

from dataclasses import dataclass

import numpy as np

# Frames differ by a few pixels; the images are not needed for more than their size.
IMAGE_WIDTH_PX, IMAGE_HEIGHT_PX = 1242, 375
NEAREST_M = 0.1


@dataclass(frozen=True)
class Calibration:
    """From the sensor's frame to the camera's (4x4), and from there to pixels (3x3)."""

    sensor_to_camera: np.ndarray
    camera_to_image: np.ndarray


@dataclass(frozen=True)
class Label:
    """One labelled object; `box` as in `boxes`, `height_px` of its box in the image."""

    kind: str
    box: np.ndarray
    height_px: float
    occlusion: int
    truncation: float


def read_calibration(path):
    """The left color camera's calibration."""
    rows = dict(line.split(":", 1) for line in path.read_text().splitlines() if ":" in line)
    matrix = {name: np.array(text.split(), dtype=np.float64) for name, text in rows.items()}
    projection = matrix["P2"].reshape(3, 4)
    sensor_to_rectified = np.vstack([matrix["Tr_velo_to_cam"].reshape(3, 4), [0, 0, 0, 1]])
    # P2 = K [I | t]: the color camera stands a few centimeters beside the one that calibration is about.
    rectified_to_camera = np.eye(4)
    rectified_to_camera[:3, :3] = matrix["R0_rect"].reshape(3, 3)
    rectified_to_camera[:3, 3] = np.linalg.solve(projection[:, :3], projection[:, 3])
    return Calibration(rectified_to_camera @ sensor_to_rectified, projection[:, :3])


def read_labels(path):
    """All labelled objects of a frame, 'DontCare' regions left out."""
    labels = []
    for line in path.read_text().splitlines():
        fields = line.split()
        if not fields or fields[0] == "DontCare":
            continue
        truncation, occlusion, _, _, top, _, bottom, height, width, length, x, y, z, yaw = map(float, fields[1:15])
        box = np.array([x, y, z, length, height, width, yaw])
        labels.append(Label(fields[0], box, bottom - top, int(occlusion), truncation))
    return labels


def to_camera(points, calibration):
    """Points of the sensor's frame in the camera's."""
    rotation, shift = calibration.sensor_to_camera[:3, :3], calibration.sensor_to_camera[:3, 3]
    return points @ rotation.T + shift


def to_image(points, calibration):
    """Pixels (column, row) of points of the camera's frame."""
    pixels = points @ calibration.camera_to_image.T
    return pixels[:, :2] / pixels[:, 2:]


def in_view(points, calibration):
    """Which points of the camera's frame it sees."""
    ahead = points[:, 2] > NEAREST_M
    seen = np.zeros(len(points), dtype=bool)
    pixels = to_image(points[ahead], calibration)
    seen[ahead] = ((pixels > 0) & (pixels < [IMAGE_WIDTH_PX, IMAGE_HEIGHT_PX])).all(axis=1)
    return seen
