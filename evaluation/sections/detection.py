"""Car detection on decoded clouds."""

import numpy as np

from .. import figures, paper_tasks, perception
from ..perception import Variant
from ..pointgnn import agreement
from ..report import Section

THRESHOLDS = agreement.IOU_THRESHOLDS
FOUND = [f"IoU {threshold:g}" for threshold in THRESHOLDS]


def section(run):
    made = Section("detection", "Car detection (Point-GNN)")
    data = perception.detection_data(run)
    if data is None:
        made.text(
            "Needs Point-GNN's weights and KITTI's calibrations below FLICR_DATA (pointgnn/car_auto_T1_train, kitti/object): "
            "left out."
        )
        _paper(made, {})
        return made
    labelled, drive = ([view for view in data[1] if bool(view.labels) == wanted] for wanted in (True, False))
    chosen = perception.settings(run)
    found = perception.detections(run, chosen, data)
    variants = {one.name: Variant(one) for one in chosen}
    labels = {name: perception.overlaps(found, one, labelled) for name, one in {"original": Variant(), **variants}.items()}
    floor = _mean([agreement_of(found, variant, drive) for variant in perception.floor_variants(run)])
    agreements = {name: agreement_of(found, variant, drive) for name, variant in variants.items()}
    cars = sum(len(perception.wanted_boxes(found, view)) for view in drive)
    _explain(made, labelled, drive, len(labels["original"]), cars)
    _labels(made, labels)
    _agreement(made, floor, agreements)
    made.plot(
        "detection",
        "Cars of the original found again in decoded clouds, against size. Gray: found when only the voxel grid moves.",
        _figure(perception.mean_bytes(run, chosen), chosen, floor, agreements),
    )
    _paper(made, agreements)
    made.numbers = {
        "labelled_cars": len(labels["original"]),
        "drive_cars": cars,
        "drive_views": len(drive),
        "labels": {name: _recalls(best) for name, best in labels.items()},
        "floor": floor,
        "agreement": agreements,
    }
    return made


def agreement_of(found, variant, views):
    """How a variant's cars agree with those of the original: recall by overlap, mean overlap, cars that are in none."""
    best = perception.overlaps(found, variant, views)
    above = perception.overlaps(found, variant, views, ground_only=True)
    return {
        **_recalls(best),
        "ground_0.7": agreement.recall(above)[0.7],
        "mean_iou": float(best.mean()) if len(best) else float("nan"),
        "invented": perception.invented(found, variant, views),
    }


def _recalls(best):
    return {f"recall_{threshold:g}": share for threshold, share in agreement.recall(best).items()}


def _mean(results):
    return {key: float(np.mean([one[key] for one in results])) for key in results[0]}


def _explain(made, labelled, drive, labelled_cars, cars):
    scans = len({view.scan for view in drive})
    made.text(
        "Point-GNN (T1, the authors' weights), run by code of our own on a CPU. Its voxel grid is anchored at the camera, so that a "
        "point at the rim moves nothing. Frames hold no intensity; each decoded point gets that of the nearest original one. Two "
        f"looks, both small samples: {len(labelled)} labelled frames with {labelled_cars} cars, and {len(drive)} views out of "
        f"{scans} drive scans (to the right and to the left, cut out as the camera would), with {cars} cars that the detector finds "
        f"in the original with a score of at least {perception.CAR_SCORE:g}. Those have no labels: there, what counts is whether "
        "decoded clouds give the same cars. The floor is the original itself with the voxel grid moved. <i>Invented</i>: cars "
        "of that score where the original gave none of any score."
    )


def _labels(made, labels):
    rows = []
    for name, best in labels.items():
        rows.append([name, *(f"{int((best >= threshold).sum())} of {len(best)}" for threshold in THRESHOLDS), float(best.mean())])
    headings = ["configuration", *FOUND, "mean IoU"]
    made.table("detection_labels", "Labelled cars found (overlap of volumes)", headings, rows, [None, None, None, None, 3])


def _agreement(made, floor, agreements):
    rows = []
    for name, result in {"original, grid moved": floor, **agreements}.items():
        shares = [100 * result[key] for key in (*(f"recall_{threshold:g}" for threshold in THRESHOLDS), "ground_0.7")]
        rows.append([name, *shares, result["mean_iou"], result["invented"]])
    headings = ["configuration", *(f"{one}, %" for one in FOUND), "IoU 0.7 from above, %", "mean IoU", "invented"]
    made.table("detection", "Cars of the original on drive scans found again", headings, rows, [None, 0, 0, 0, 0, 3, 1])


def _figure(sizes, chosen, floor, agreements):
    figure, axes = figures.figure(9, 4.5)
    perception.draw_against_size(axes, chosen, sizes, {name: 100 * result["recall_0.7"] for name, result in agreements.items()})
    axes.axhline(100 * floor["recall_0.7"], color="gray", linestyle="--", linewidth=1)
    axes.set(ylabel="found again with IoU 0.7, %", ylim=(0, 104))
    return figure


def _paper(made, agreements):
    rows, theirs = [], set()
    for threshold, models in paper_tasks.RECALL.items():
        for model, row in models.items():
            theirs.add(len(rows))
            rows.append([f"{threshold:g}", model, *row])
        for preset in ("paper", "uniform"):
            ours = [agreements.get(f"{preset}-{width}") for width in paper_tasks.WIDTHS]
            if any(ours):
                shares = [100 * one[f"recall_{threshold:g}"] if one else None for one in ours]
                rows.append([f"{threshold:g}", f"ours: Point-GNN, preset {preset}", 100.0, *shares])
    made.table(
        "paper_detection",
        "The paper's recall in percent (six detectors, 7518 scans), and ours beside it (the original's own cars found again)",
        ["IoU", "model", "original", *(f"{width}x64" for width in paper_tasks.WIDTHS)],
        rows,
        [None, None, *[1] * 7],
        frozenset(theirs),
    )
    made.text(
        "The paper's frames lose much at an IoU of 0.7 even at 4500 columns: 8 bits are steps of 31 cm, and points are put at a cell's "
        "corner. Its recalls are of cars, pedestrians and cyclists in thousands of labelled frames, ours of cars alone, few of "
        "them, against what the detector says of the original: only the fall along a row can be compared."
    )
