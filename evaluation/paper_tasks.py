"""The paper's own figures on perception: numbers from its tables."""

from . import paper_numbers

WIDTHS = tuple(paper_numbers.WIDTHS)
SE, PSNR_DB, EPSNR_DB = (tuple(row[key] for row in paper_numbers.WIDTHS.values()) for key in ("se", "psnr_db", "epsnr_db"))

# Recall in percent by IoU threshold and model: on the original scans, then at each width.
RECALL = {
    0.3: {
        "Part-A2 Net": (95.1, 88.4, 88.3, 87.9, 76.2, 75.5, 56.1),
        "PointPillars": (94, 92.6, 92.4, 91.5, 82, 76.1, 54.8),
        "PointRCNN": (89.8, 70.7, 71.2, 71.7, 68.8, 62.9, 47.5),
        "PV-RCNN": (96.8, 94.6, 94.4, 94, 89.9, 82.8, 70.2),
        "SECOND": (94.9, 92.7, 92.6, 92.1, 88.4, 79.4, 60.2),
        "Voxel R-CNN": (95.4, 93.6, 93.6, 93.5, 89, 87.5, 76.1),
    },
    0.5: {
        "Part-A2 Net": (91.2, 82.3, 82.2, 81.1, 71.4, 63.7, 41.3),
        "PointPillars": (88.7, 82.7, 82.5, 81, 69.8, 57.8, 30.8),
        "PointRCNN": (87.1, 65.5, 66, 66.2, 63.8, 57, 38.5),
        "PV-RCNN": (93.4, 88.9, 88.8, 87.6, 81.8, 71.2, 53),
        "SECOND": (89.1, 83.8, 83.7, 82.3, 76.8, 61.9, 38),
        "Voxel R-CNN": (94.9, 91.1, 91.1, 90.5, 85.2, 79.4, 58.4),
    },
    0.7: {
        "Part-A2 Net": (73.6, 59.9, 59.8, 57.4, 46, 38.1, 21.6),
        "PointPillars": (63.9, 49.6, 49.3, 46, 33.4, 18.4, 5.5),
        "PointRCNN": (73.3, 46.8, 47.3, 46.9, 43.9, 36.4, 20.8),
        "PV-RCNN": (75.9, 60.6, 60.4, 57.4, 49, 33.3, 16.7),
        "SECOND": (66.5, 52.4, 52.3, 49.1, 41.5, 26.3, 10.3),
        "Voxel R-CNN": (84.6, 67.9, 67.9, 64, 54.1, 37.1, 16.4),
    },
}

# A-LOAM over 1101 scans, against ground truth: absolute trajectory error in m and degrees, relative error in m and degrees.
LOAM = {
    "original": (0.316, 0.57, 0.389, 0.82),
    4500: (0.321, 0.2, 0.387, 0.83),
    4096: (0.313, 0.21, 0.39, 0.84),
    2048: (0.294, 0.17, 0.388, 0.82),
    1024: (0.394, 0.17, 0.388, 0.82),
    512: (0.610, 0.17, 0.388, 0.82),
    256: (0.596, 0.2, 0.387, 0.82),
}


def mean_share(threshold):
    """By width: recall as a share of the same model's on the original, mean over the models."""
    models = RECALL[threshold].values()
    return [sum(row[index + 1] / row[0] for row in models) / len(models) for index in range(len(WIDTHS))]
