"""Numbers over scans, and how plots look."""

import statistics

from matplotlib import rcParams
from matplotlib.figure import Figure

rcParams.update({
    "font.family": "sans-serif", "font.size": 9.5, "axes.spines.top": False, "axes.spines.right": False,
    "axes.grid": True, "grid.color": "#e3e7ec", "grid.linewidth": 0.7, "axes.edgecolor": "#5b6675", "axes.titlesize": 10.5,
    "axes.axisbelow": True, "legend.frameon": False, "svg.hashsalt": "flicr", "svg.fonttype": "none", "lines.linewidth": 1.8,
})

# One look a system, in all plots. Ours are lines in strong colors, others are thinner.
LOOKS = {
    "flicr, dense": ("#0b6e75", "o"), "flicr, small": ("#15a3a0", "s"), "flicr, fast": ("#7cc6a2", "^"),
    "flicr, preset uniform": ("#e07b39", "D"), "flicr, preset paper": ("#f2b134", "v"),
    "FLiCR, the authors' way": ("#c0392b", "X"), "Draco": ("#34495e", "P"), "PCL octree": ("#8e44ad", "*"),
    "cloudini": ("#2e86de", "h"), "LASzip": ("#95a5a6", "<"), "H.264": ("#d6336c", ">"), "G-PCC": ("#5f3dc4", "p"),
    "RT-ST": ("#795548", "d"), "bytes as they are": ("#adb5bd", "."), "G-PCC octree": ("#9775fa", "p"),
}


def look(system):
    """Color and marker."""
    return LOOKS.get(system, ("#868e96", "."))


def figure(width=9, height=5, rows=1, columns=1, **kwargs):
    """A figure and its axes."""
    made = Figure(figsize=(width, height), layout="constrained")
    return made, made.subplots(rows, columns, **kwargs)


def median(values):
    """Of those that are there; None of none."""
    values = [value for value in values if value is not None]
    return statistics.median(values) if values else None


def medians(measurements):
    """Of each field over the scans, as one measurement. None (infinite, meaningless) only where most are."""
    return {name: median_or_none([m.get(name) for m in measurements]) for name in measurements[0]} if measurements else {}


def median_or_none(values):
    there = [value for value in values if value is not None]
    return median(there) if 2 * len(there) > len(values) else None


def milliseconds(timings, side, clock="cpu_ns"):
    """Median over timed scans of `encode` or `decode`, ms; None where it was not timed."""
    values = [timing[side][clock] / 1e6 for timing in timings or [] if timing.get(side)]
    return median(values)


def joules(timings, side):
    values = [timing[side]["energy_uj"] for timing in timings or [] if timing.get(side)]
    value = median(values)
    return None if value is None else value / 1e6


def stage_ms(timings, stage):
    """Median of one stage, ms."""
    return median([timing["stages"][stage]["cpu_ns"] / 1e6 for timing in timings or [] if stage in timing.get("stages", {})])
