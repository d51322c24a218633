"""LiDAR odometry on decoded clouds."""

import importlib.util
from math import comb


from .. import figures, odometry, paper_tasks, perception
from ..report import Section

# A difference that shuffling alone brings about this often is none.
CHANCE = 0.05
HEADINGS = ["configuration", "kB a scan", "step, mm", "over floor", "p", "step, deg", "path, mm", "path, deg", "end, mm"]
DECIMALS = [None, 1, 1, 2, 3, 3, 1, 3, 1]
PAPER_HEADINGS = ["frame", "A-LOAM: ATE, m", "ATE, deg", "RE, m", "RE, deg"]
PAPER_HEADINGS += ["ours, uniform: path, m", "path, deg", "step, m", "step, deg"]


def section(run):
    made = Section("odometry", "LiDAR odometry (KISS-ICP)")
    if importlib.util.find_spec("kiss_icp") is None:
        made.text("KISS-ICP is not installed: this section is left out.")
        return made
    drive, what = perception.sequence(run)
    chosen = perception.settings(run)
    poses = perception.trajectories(run, chosen)
    originals = poses[perception.ORIGINAL]
    results = {one.name: odometry.compare(poses[one.name], originals) for one in chosen}
    sizes = perception.mean_bytes(run, chosen)
    floor = {name: next(iter(results.values()))[f"{name}_floor"] for name in odometry.FIELDS}
    _explain(made, what, odometry.length_m(originals[0]), results, *perception.shuffles(run))
    _table(made, results, sizes, floor)
    made.plot(
        "odometry",
        "Difference of a step's translation from the original's own, against size. Gray: what shuffling the original does.",
        _figure(chosen, results, sizes, floor),
    )
    _paper(made, results, floor)
    made.numbers = {
        "scans": len(drive),
        "way_m": odometry.length_m(originals[0]),
        "simulated": "simulated" in what,
        "floor": floor,
        "configurations": results,
    }
    return made


def _explain(made, what, way_m, results, of_original, of_each):
    least_p = 1 / comb(of_original + of_each, of_each)
    made.text(
        f"{what}, {way_m:.1f} m of way: a small sample. Each cloud goes into the real KISS-ICP, with its standard settings and "
        "without motion compensation (decoded points have no times). It keeps the first points of a voxel, so that the order of "
        f"points alone moves its poses: every cloud is shuffled, the original {of_original} times, each "
        f"configuration's {of_each} times. <i>Step</i>: root mean square of the difference between the motions found "
        "from one scan to the next, mean over all pairs of a decoded and an original run; <i>path</i>: the same of the poses; "
        "<i>floor</i>: the same among runs of the original. <i>p</i>: how often exchanging runs at random gives as large an excess "
        f"over the floor; it cannot be less than {least_p:.3f}. There is no ground truth here: what is measured is whether a "
        "decoded cloud does as the original does."
    )
    same = [name for name, result in results.items() if result["step_p"] > CHANCE]
    other = [name for name, result in results.items() if result["step_p"] <= CHANCE]
    made.text(f"Not told from the original (p over {CHANCE:g}): {', '.join(same) or 'none'}. Told: {', '.join(other) or 'none'}.")


def _table(made, results, sizes, floor):
    rows = [["original, shuffled", None, *_cells(floor, 1.0, None)]]
    for name, result in results.items():
        rows.append([name, sizes[name] / 1000, *_cells(result, result["step_m"] / floor["step_m"], result["step_p"])])
    made.table("odometry", "Poses on decoded clouds against those on the original", HEADINGS, rows, DECIMALS)


def _cells(result, over_floor, p):
    step, path, end = (1000 * result[name] for name in ("step_m", "path_m", "end_m"))
    return [step, over_floor, p, result["step_deg"], path, result["path_deg"], end]


def _figure(chosen, results, sizes, floor):
    figure, axes = figures.figure(9, 4.5)
    perception.draw_against_size(axes, chosen, sizes, {name: 1000 * result["step_m"] for name, result in results.items()})
    axes.axhline(1000 * floor["step_m"], color="gray", linestyle="--", linewidth=1)
    axes.set(yscale="log", ylabel="step difference, mm")
    perception.plain_ticks(axes.yaxis)
    return figure


def _paper(made, results, floor):
    rows = []
    for frame, row in paper_tasks.LOAM.items():
        ours = floor if frame == "original" else results.get(f"uniform-{frame}", {})
        name = "original (ours: shuffled)" if frame == "original" else f"{frame}x64"
        rows.append([name, *row, *(ours.get(field) for field in ("path_m", "path_deg", "step_m", "step_deg"))])
    made.table(
        "paper_loam",
        "The paper's A-LOAM over 1101 scans, against ground truth, and ours beside it, against the original's own poses",
        PAPER_HEADINGS,
        rows,
        [None, 3, 2, 3, 2, 4, 4, 4, 4],
    )
    made.text(
        "The two are different questions. The paper's errors are those of the whole method against ground truth, ours those that "
        "compression adds. A-LOAM maps with cells of 0.4 m and 0.8 m, and its own error of 0.3 m hides what frames add down to 1024 "
        "columns; it even gets better at 2048, which is its noise. Against the original's own result differences of "
        "millimeters show, and the floor says which of them count. What both say: odometry bears coarse frames."
    )
