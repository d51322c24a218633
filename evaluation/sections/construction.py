"""What making each intermediate representation takes."""

import json

from .. import paper_numbers, rivals
from ..figures import figure, median
from ..report import Section

# Ours and others': (key, label, the paper's name for the same).
KINDS = (
    ("authors", "range image, the authors’ way (libm a point)", "range image"),
    ("scalar", "range image, flicr, no vectors", None),
    ("one_thread", "range image, flicr", None),
    ("two_threads", "range image, flicr, 2 threads", "range image, parallel"),
    ("own_grid", "range image, flicr, on the sensor’s own grid", None),
    ("pcl_range_image", "range image, PCL (spherical)", None),
    ("octree", "octree, PCL, 1 cm", "octree"),
    ("kd_tree", "k-d tree, PCL", "k-d tree"),
    ("mesh", "mesh, PCL (normals and greedy triangulation)", "mesh"),
)
RUNS = 15


def section(run):
    made = Section("construction", "Range image, octree, k-d tree, mesh")
    found = [measured(run, scan) for scan in run.timed_scans]
    values = {key: median([one.get(key) for one in found]) for key, _, _ in KINDS}
    desktop, jetson = paper_numbers.CONSTRUCTION["desktop"], paper_numbers.CONSTRUCTION["Jetson"]
    rows = [[label, values[key], share(values[key], values["authors"]), desktop.get(name), jetson.get(name)] for key, label, name in KINDS]
    made.numbers = {key: value for key, value in values.items() if value is not None}
    made.text(
        "The paper’s Table II: an intermediate representation from points in memory, 4500 x 64 for range images. Processor "
        "time of the fastest of several runs, of two threads the time on the clock; the mesh is made once.")
    made.table("construction", "Construction, ms", ["representation", "ms here", "of the authors’ way", "paper, desktop", "paper, Jetson AGX"],
               rows, [None, 2, 2, 2, 2])
    if made.numbers:
        drawn(made, values)
    else:
        made.text("None of the drivers is built on this machine: nothing could be timed.")
    made.text(
        "flicr’s projection has no library call in it: tables and polynomials over blocks of points, which the compiler turns into "
        "vector instructions. Two threads pay for being started (some tens of microseconds) and for merging two images; at this size a "
        "second core is better spent on the next frame. PCL’s octree has leaves of 1 cm here, as its codec has, and its mesh 20 neighbors to a "
        "normal; the paper states neither. The authors’ program times the conversion in its own data structures, which "
        "is why their 11.8 ms is more than the plain loop here.")
    return made


def share(value, whole):
    return None if value is None or not whole else value / whole


def measured(run, scan):
    """`{kind: ms}` of one scan; without what is not built."""
    program = run.rivals_folder / "release" / "flicr-rivals"
    found = {}
    said = timing(run, scan, [program, "project", "4500", scan.path, RUNS])
    for key in ("authors", "one_thread", "two_threads", "own_grid"):
        found[key] = ms(said, key)
    found["scalar"] = ms(timing(run, scan, [run.rivals_folder / "scalar" / "release" / "flicr-rivals", "project", "4500", scan.path, RUNS]), "one_thread")
    said = timing(run, scan, [run.rivals_folder / "pcl", "construct", scan.path, RUNS])
    for key, name in (("octree", "octree"), ("kd_tree", "kd_tree"), ("mesh", "mesh"), ("pcl_range_image", "range_image")):
        found[key] = ms(said, name)
    return found


def timing(run, scan, command):
    built = rivals.Built(command[0], [])
    try:
        key = [built.digest(), command[1:-2], RUNS, scan.digest]
    except rivals.Missing as why:
        run.missing[command[0].name] = str(why)
        return {}
    return run.store.get("construction", key, lambda: json.loads(rivals.output_of(command)))


def ms(said, key):
    # What two threads take together says nothing of how long one waits for them.
    clock = "ns" if key == "two_threads" else "cpu_ns"
    return said[key][clock] / 1e6 if key in said else None


def drawn(made, values):
    kinds = [(label, values[key], key) for key, label, _ in KINDS if values[key] is not None][::-1]
    fig, axes = figure(9, 3.6)
    ours = {"one_thread", "two_threads", "own_grid", "scalar"}
    bars = axes.barh([label for label, _, _ in kinds], [value for _, value, _ in kinds],
                     color=["#0b6e75" if key in ours else "#b0bac5" for _, _, key in kinds])
    axes.bar_label(bars, labels=[f"{value:.2f}" if value < 10 else f"{value:,.0f}" for _, value, _ in kinds], padding=3)
    axes.set_xscale("log")
    axes.set_xlabel("ms, logarithmic")
    axes.grid(axis="y", visible=False)
    made.plot("construction_plot", "Time to make each representation of one scan.", fig)
