"""How decoded clouds look: the paper's pictures, and some that it lacks."""

import tempfile
from pathlib import Path

import numpy
from matplotlib.image import imread

from ..configurations import named
from ..figures import figure
from ..report import Section

CLOUDS = (
    (None, "original"), ("authors-4500", "the authors’ way, 4500x64"), ("authors-1024", "the authors’ way, 1024x64"),
    ("authors-256", "the authors’ way, 256x64"), ("h264-0", "H.264, CRF 0"), ("h264-30", "H.264, CRF 30"),
    ("draco-qp11", "Draco, 11 bits"), ("dense-20mm", "flicr, dense, 20 mm"), ("dense-314mm", "flicr, dense, 314 mm"),
)
# Part of the scene that is drawn, m: ahead, to both sides, height.
AHEAD, SIDE, HEIGHT = (2.0, 38.0), 13.0, (-2.5, 2.0)


def section(run):
    made = Section("pictures", "What comes back")
    scan = run.timed_scans[0]
    drawn = []
    for name, label in CLOUDS:
        if name is None:
            drawn.append((label, read(scan.path), 16 * scan.points))
        elif run.is_there(named(name)):
            m = run.measure(named(name), scan)
            drawn.append((label, read(run.decoded(named(name), scan)), m["bytes"]))
    made.text(f"One scan ({scan.name}), seen from behind and above: the paper’s Figures 5 and 6 in one, with flicr beside. Color is height.")
    clouds(made, drawn)
    images(made, run, scan)
    return made


def read(path):
    """x, y and z of a cloud's points."""
    return numpy.fromfile(path, "<f4").reshape(-1, 4)[:, :3]


def clouds(made, drawn):
    rows = -(-len(drawn) // 3)
    fig, axes = figure(12, 3.1 * rows, rows, 3)
    fig.is_picture = True
    for panel in axes.flat:
        panel.axis("off")
    for panel, (label, points, size) in zip(axes.flat, drawn):
        x, y, z = points.T
        seen = (x > AHEAD[0]) & (x < AHEAD[1]) & (abs(y) < SIDE) & (z > HEIGHT[0] - 1) & (z < HEIGHT[1] + 4)
        across, up, depth = project(points[seen])
        order = numpy.argsort(-depth)
        panel.scatter(across[order], up[order], s=numpy.clip(26 / depth[order] ** 1.15, 0.25, 2.0), c=z[seen][order], cmap="viridis",
                      vmin=HEIGHT[0], vmax=HEIGHT[1], linewidths=0)
        panel.set_xlim(-0.62, 0.62)
        panel.set_ylim(-0.36, 0.12)
        panel.set_title(f"{label}: {size / 1000:,.0f} KB", fontsize=10)
    made.plot("clouds", "The scene ahead of the car. H.264 smears ranges across edges, and its phantom points hang in the air; coarse columns lose "
              "what is far; a coarse step keeps every point and moves it along its ray.", fig)


def project(points, height_m=6.0, behind_m=9.0, down_rad=0.22):
    """Where points are in a picture that is taken from behind and above; and how far off."""
    x, y, z = points[:, 0] + behind_m, points[:, 1], points[:, 2] - height_m
    ahead = x * numpy.cos(down_rad) - z * numpy.sin(down_rad)
    up = x * numpy.sin(down_rad) + z * numpy.cos(down_rad)
    return -y / ahead, up / ahead, ahead


def images(made, run, scan):
    """The range image as the paper makes it, and the sensor's own."""
    fig, axes = figure(12, 3.4, 2, 1)
    fig.is_picture = True
    pictures = (("4500x64, evenly spread rows and columns", ["--preset", "uniform", "--columns", "4500"]), ("the sensor’s own grid: its beams and firings", []))
    for panel, (label, options) in zip(axes, pictures):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "image.png"
            run.flicr.run("view", scan.path, "-o", path, *options)
            panel.imshow(first_panel(imread(path)), aspect="auto", interpolation="nearest")
        panel.set_title(label, fontsize=10, loc="left")
        panel.axis("off")
    made.plot("range_image", "The same scan as <code>flicr view</code> draws it: where rows and columns are evenly spread, rows "
              "stay empty and points collide; on the sensor’s own grid each return has its place.", fig)


def first_panel(picture):
    """Of `flicr view`’s picture, the range image: the first band of a good height that differs from the margin all along."""
    differs = (picture != picture[0, 0]).any(axis=2).mean(axis=1) > 0.9
    edges = numpy.flatnonzero(numpy.diff(numpy.concatenate(([0], differs.astype(int), [0]))))
    bands = [(start, end) for start, end in zip(edges[::2], edges[1::2]) if end - start >= 40]
    return picture[slice(*bands[0])] if bands else picture
