"""From a scan to cars."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from . import boxes as box_math
from . import graph, kitti, merge
from .checkpoint import read_checkpoint
from .network import Network

# A car seen along its length and one seen across it are classes of their own.
LENGTHWISE, ACROSS = 1, 2
MAX_TRUNCATION = 0.4


@dataclass(frozen=True)
class Detections:
    """Boxes (N, 7) in the camera's frame and their scores, best first. Scores add up over the key points that agree: cars with
    many points score above 10, single votes below 1."""

    boxes: np.ndarray
    scores: np.ndarray

    def above(self, score):
        """Those with at least this score."""
        keep = self.scores >= score
        return Detections(self.boxes[keep], self.scores[keep])


class Detector:
    """Point-GNN with the checkpoint in a folder (`config`, `model-*.index`, `model-*.data-*`)."""

    def __init__(self, folder):
        folder = Path(folder)
        config = json.loads((folder / "config").read_text())
        graphs = config["runtime_graph_gen_kwargs"]
        pooling, messages = (level["graph_gen_kwargs"]["radius"] for level in graphs["level_configs"][:2])
        scale = graphs["level_configs"][0]["graph_scale"]
        self.voxel_size_m = graphs["base_voxel_size"] * scale
        self.pooling_radius_m, self.message_radius_m = pooling, messages
        self.overlap = config["nms_overlapped_thres"]
        index = sorted(folder.glob("model-*.index"))[-1]
        self.network = Network(read_checkpoint(index.with_suffix("")))

    def __call__(self, points, intensities, calibration, grid_origin=(0.0, 0.0, 0.0)):
        """Cars in the camera's view of a scan: points (N, 3) in the sensor's frame, intensities (N,) of 0 to 1."""
        camera_points = kitti.to_camera(np.asarray(points, dtype=np.float64), calibration)
        seen = kitti.in_view(camera_points, calibration)
        if not seen.any():
            return Detections(np.zeros((0, 7)), np.zeros(0))
        camera_points = camera_points[seen]
        indices = graph.key_points(camera_points, self.voxel_size_m, grid_origin)
        keys = camera_points[indices]
        probabilities, encoded = self.network(
            camera_points,
            np.asarray(intensities)[seen],
            indices,
            graph.radius_edges(camera_points, keys, self.pooling_radius_m),
            graph.radius_edges(keys, keys, self.message_radius_m) if self.network.rounds else None,
        )
        return self._select(probabilities, encoded, keys, calibration)

    def _select(self, probabilities, encoded, keys, calibration):
        """The boxes of the likely cars, merged, those that the image's rim cuts left out."""
        vertex, kind = np.nonzero(probabilities[:, [LENGTHWISE, ACROSS]] > 1 / self.network.classes)
        kind += LENGTHWISE
        votes = probabilities[vertex, kind].astype(np.float64)
        candidates = box_math.decode(encoded[vertex, kind].astype(np.float64), keys[vertex], kind == ACROSS)
        boxes, scores = merge.merge(candidates, votes, self.overlap)
        whole = [index for index, box in enumerate(boxes) if _truncation(box, calibration) <= MAX_TRUNCATION]
        boxes, scores = boxes[whole], scores[whole]
        scores = scores * [1 + merge.coverage(box, keys[vertex]) for box in boxes]
        order = np.argsort(-scores, kind="stable")
        return Detections(boxes[order], scores[order])


def _truncation(box, calibration):
    """Share of a box's image that lies outside the picture."""
    pixels = kitti.to_image(box_math.corners(box)[0], calibration)
    least, most = pixels.min(axis=0), pixels.max(axis=0)
    inside = np.clip(most, 0, [kitti.IMAGE_WIDTH_PX, kitti.IMAGE_HEIGHT_PX]) - np.clip(
        least, 0, [kitti.IMAGE_WIDTH_PX, kitti.IMAGE_HEIGHT_PX]
    )
    return 1 - np.prod(inside) / np.prod(most - least)
