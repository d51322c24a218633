"""The two tasks on original and decoded clouds; their sections and the comparison of metrics share the results.

These are kept by the clouds' own digests: a codec that gives the same cloud again need not be judged again.
"""

import functools
import multiprocessing
import os
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib import ticker

from . import configurations, figures, odometry, scans, store
from .pointgnn import agreement, boxes, checkpoint, detector, graph, kitti, merge, network

ORIGINAL = None
QUICK = ("uniform-1024", "dense-20mm")
# Shuffles of the original and of each configuration. More of the original: all are compared with them, and they make the floor.
SHUFFLES, QUICK_SHUFFLES = (6, 3), (5, 2)
# Detections of the original that count as cars there. Scores add up over the points that agree: below this, cars come and go
# with where the grid of voxels lies.
CAR_SCORE = 3.0
FOUND_SCORE = 1.0
# Quarter turns of drive scans before they are looked at: to the right, to the left. Ahead and behind of the drive's car there is
# hardly more than one near car each, which every cloud shows.
VIEWS = (1, 3)
# Where else the original's voxel grid is put, in voxels, for the noise floor.
GRIDS = ((0.25, 0.5, 0.75), (0.5, 0.75, 0.25))
DETECTOR_MODULES = (agreement, boxes, checkpoint, detector, graph, kitti, merge, network)


def settings(run):
    """Configurations that the tasks are done on."""
    chosen = [configurations.named(name) for name in QUICK] if run.quick else configurations.group("tasks")
    return [configuration for configuration in chosen if run.is_there(configuration)]


def read_cloud(path):
    """x, y, z and intensity of a KITTI file's points, as 32-bit floats; the 'no return' at the origin left out."""
    points = np.fromfile(path, "<f4").reshape(-1, 4)
    return points[np.any(points[:, :3] != 0, axis=1)]


def processes(run):
    """Worker processes, each with one thread: that uses the cores best, and sums then come in one order."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    return ProcessPoolExecutor(run.workers, mp_context=multiprocessing.get_context("spawn"))


# Odometry


def sequence(run):
    """Consecutive scans of a moving sensor, and what they are."""
    most = 6 if run.quick else 24
    if run.data and (run.data / "kitti" / "drive").is_dir():
        paths = sorted((run.data / "kitti" / "drive").glob("*.bin"))[:most]
        what = f"{len(paths)} consecutive scans of a real drive (kitti/drive)"
    else:
        most = min(most, 12)
        folder = run.store.folder / f"simulated-drive-{most}"
        if not folder.is_dir():
            part = folder.with_name(folder.name + ".part")
            part.mkdir(parents=True, exist_ok=True)
            run.flicr.run("simulate", "-o", part, "--seed", 7, "--turns", most)
            part.rename(folder)
        paths = sorted(folder.glob("*.bin"))
        what = f"{len(paths)} consecutive scans of a simulated drive (no kitti/drive below FLICR_DATA)"
    return [scans.Scan(f"{path.parent.name}/{path.stem}", path) for path in paths], what


def shuffles(run):
    """How often the original is shuffled, and each configuration's clouds."""
    return QUICK_SHUFFLES if run.quick else SHUFFLES


def trajectories(run, chosen):
    """By configuration's name (None for the original): poses (shuffles, N, 4, 4) over the sequence."""
    drive, _ = sequence(run)
    of_original, of_each = shuffles(run)
    jobs = [(ORIGINAL, seed) for seed in range(of_original)]
    jobs += [(configuration, 100 + seed) for configuration in chosen for seed in range(of_each)]
    clouds = _clouds(run, [ORIGINAL, *chosen], drive)
    version = store.source_digest(odometry)
    with processes(run) as pool:

        def poses(job):
            configuration, seed = job
            paths = [clouds[configuration, scan] for scan in drive]
            key = [[store.file_digest(path) for path in paths], seed, version]
            return run.store.get("odometry", key, lambda: pool.submit(_trajectory, paths, seed).result())

        found = run.map("odometry", poses, jobs)
    result = {}
    for (configuration, _), one in zip(jobs, found):
        result.setdefault(_name(configuration), []).append(np.array(one))
    return result


def _trajectory(paths, seed):
    return odometry.trajectory([read_cloud(path) for path in paths], seed).tolist()


# Detection


@dataclass(frozen=True)
class View:
    """What the detector is shown: a scan, turned so many quarters, as a camera with this calibration sees it. `labels`: a file."""

    scan: scans.Scan
    quarter_turns: int
    calibration: Path
    labels: Path | None = None


def detection_data(run):
    """Folder of the weights and views, or None where they are not at hand."""
    if not run.data:
        return None
    weights, objects = run.data / "pointgnn" / "car_auto_T1_train", run.data / "kitti" / "object"
    if not (weights / "config").is_file() or not (objects / "calib").is_dir():
        return None
    views = []
    for path in sorted(objects.glob("*.bin")):
        labels = objects / "label_2" / f"{path.stem}.txt"
        if any(label.kind == "Car" for label in kitti.read_labels(labels)):
            views.append(View(scans.Scan(f"object/{path.stem}", path), 0, objects / "calib" / f"{path.stem}.txt", labels))
    drive, turns = scans.spread(sorted((run.data / "kitti" / "drive").glob("*.bin")), 4), VIEWS
    if run.quick:
        drive, turns = drive[2:3], VIEWS[:1]
    # Raw drives have calibrations of their own, which are not here: any KITTI camera does to cut a view out.
    calibration = sorted((objects / "calib").glob("*.txt"))[0]
    views += [View(scans.Scan(f"drive/{path.stem}", path), turn, calibration) for path in drive for turn in turns]
    return weights, views


@dataclass(frozen=True)
class Variant:
    """A view's cloud as it goes into the detector: decoded by a configuration or the original, with the voxel grid moved or not."""

    configuration: object = ORIGINAL
    grid: tuple = (0.0, 0.0, 0.0)


def detections(run, chosen, data):
    """By variant and view: `detector.Detections`. Variants: the original, the original on moved grids, each configuration."""
    weights, views = data
    variants = [*floor_variants(run), Variant(), *(Variant(configuration) for configuration in chosen)]
    clouds = _clouds(run, [ORIGINAL, *chosen], list(dict.fromkeys(view.scan for view in views)))
    version = [store.source_digest(*DETECTOR_MODULES), *(store.file_digest(path) for path in sorted(weights.iterdir()))]
    with processes(run) as pool:

        def one(job):
            variant, view = job
            cloud = clouds[variant.configuration, view.scan]
            digests = [store.file_digest(path) for path in (view.scan.path, cloud, view.calibration)]
            key = [*digests, view.quarter_turns, variant.grid, version]
            call = (_detect, weights, view.scan.path, cloud, view.quarter_turns, view.calibration, variant.grid)
            return run.store.get("detections", key, lambda: pool.submit(*call).result())

        jobs = [(variant, view) for view in views for variant in variants]
        found = run.map("detection", one, jobs)
    return {job: _detections(result) for job, result in zip(jobs, found)}


def _detections(result):
    return detector.Detections(np.array(result["boxes"]).reshape(-1, 7), np.array(result["scores"]))


def floor_variants(run):
    return [Variant(grid=grid) for grid in (GRIDS[:1] if run.quick else GRIDS)]


@functools.lru_cache(maxsize=1)
def _detector(folder):
    return detector.Detector(folder)


def _detect(weights, original_path, cloud_path, quarter_turns, calibration_path, grid):
    """Decoded clouds get the intensity of the nearest original point: frames hold none, and the network was trained with it."""
    find = _detector(weights)
    cloud, original = read_cloud(cloud_path), read_cloud(original_path)
    intensities = cloud[:, 3]
    if cloud_path != original_path:
        intensities = agreement.nearest_values(cloud[:, :3], original[:, :3], original[:, 3])
    turned = agreement.turned(cloud[:, :3], quarter_turns)
    found = find(turned, intensities, kitti.read_calibration(calibration_path), np.array(grid) * find.voxel_size_m)
    return {"boxes": found.boxes.tolist(), "scores": found.scores.tolist()}


def wanted_boxes(found, view):
    """Labelled cars where the view has labels, else what was found in the original."""
    if view.labels:
        boxes_ = [label.box for label in kitti.read_labels(view.labels) if label.kind == "Car"]
        return np.array(boxes_).reshape(-1, 7)
    return found[Variant(), view].above(CAR_SCORE).boxes


def overlaps(found, variant, views, ground_only=False):
    """For each wanted box of the views, its overlap with the best box that the variant gave."""
    best = [np.zeros(0)]
    for view in views:
        boxes_ = found[variant, view].above(FOUND_SCORE).boxes
        best.append(agreement.best_iou(wanted_boxes(found, view), boxes_, ground_only))
    return np.concatenate(best)


def invented(found, variant, views):
    """Cars that the variant gave where the original gave not even a doubtful one."""
    pairs = [(found[variant, view].above(CAR_SCORE).boxes, found[Variant(), view].boxes) for view in views]
    return sum(agreement.invented(boxes_, original) for boxes_, original in pairs)


def measured(run, chosen):
    """What `run.measure` says of three scans of the drive that the tasks are done on, by configuration's name."""
    drive, _ = sequence(run)
    return run.measured(chosen, scans.spread(drive, 3))


def mean_bytes(run, chosen):
    """Bytes of a frame, mean over those scans, by configuration's name."""
    return {name: float(np.mean([one["bytes"] for one in own])) for name, own in measured(run, chosen).items()}


def draw_against_size(axes, chosen, sizes, values):
    """A line for each system through its configurations: values over kilobytes a scan."""
    for system in dict.fromkeys(one.system for one in chosen):
        own = [one.name for one in chosen if one.system == system]
        color, marker = figures.look(system)
        sizes_kb = [sizes[name] / 1000 for name in own]
        axes.plot(sizes_kb, [values[name] for name in own], color=color, marker=marker, label=system, markersize=5)
        for name in own:
            at = sizes[name] / 1000, values[name]
            axes.annotate(name, at, fontsize=6, textcoords="offset points", xytext=(3, 3))
    axes.set(xscale="log", xlabel="kB a scan")
    plain_ticks(axes.xaxis)
    axes.legend()


def plain_ticks(axis):
    """1, 2, 5, 10 along a logarithmic axis."""
    axis.set_major_locator(ticker.LogLocator(subs=(1, 2, 5)))
    axis.set_major_formatter(ticker.FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(ticker.NullFormatter())


def _clouds(run, chosen, wanted):
    """Paths of all clouds, by configuration (None for the original) and scan; decoded on all workers first."""
    pairs = [(configuration, scan) for configuration in chosen for scan in wanted]


    def path(pair):
        configuration, scan = pair
        return scan.path if configuration is ORIGINAL else run.decoded(configuration, scan)

    return dict(zip(pairs, run.map("clouds", path, pairs)))


def _name(configuration):
    return ORIGINAL if configuration is ORIGINAL else configuration.name
