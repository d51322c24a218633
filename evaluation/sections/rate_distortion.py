"""Bits a point against error, of all systems and our modes."""

from matplotlib.ticker import LogLocator, NullLocator

from .. import boards, elsewhere
from ..configurations import group
from ..figures import figure, look, medians, milliseconds
from ..report import Section
from ..scans import counted

HEADINGS = ["setting", "bytes", "bits / point", "ratio, 12 B", "ratio, 16 B", "lost %", "PSNR dB", "reverse PSNR", "CD m² × 100", "mean cm", "max error m",
            "encode ms", "decode ms"]
DECIMALS = [None, 0, 2, 1, 1, 2, 2, 2, 4, 2, 3, 1, 1]
PANELS = (
    ("psnr_db", "PSNR, dB (decoded to original)", "linear"),
    ("psnr_reverse_db", "reverse PSNR, dB (original to decoded)", "linear"),
    ("cd_m2", "Chamfer distance, m²", "log"),
    ("max_error_m", "largest error of a decoded point, m", "log"),
)


def section(run):
    made = Section("rate_distortion", "Rate and distortion")
    ours = [c for c in group("steps") + group("widths") if not run.quick or c.is_in("quick")]
    others = [c for c in group("curve") + group("h264") if not run.quick or c.is_in("quick")]
    quality = run.measured(ours + others, label="rate and distortion")
    found = [(c, medians(quality[c.name])) for c in ours + others if c.name in quality]
    times = run.times([c for c in ours if c.is_in("steps") and c.name in quality], "times of our modes")
    made.text("Every system at several settings: to the right costs bytes, up is better (in the lower two, down). Medians over "
              f"{counted(len(run.scans))}. The context coders’ curves are the sensor’s own grid in steps of 2 mm (lossless) to 314 mm.")
    drawn(made, found)
    rows = [row(c.label, m, times.get(c.name)) for c, m in found if c.is_in("steps")]
    made.table("our_modes", "The context coders’ tiers and steps, on the sensor’s own grid", HEADINGS, rows, DECIMALS)
    for configuration, m in found:
        t = times.get(configuration.name)
        made.numbers[configuration.name] = {**m, "encode_ms": milliseconds(t, "encode"), "decode_ms": milliseconds(t, "decode")}
    made.text("At equal PSNR, what matters is the distance between curves along bits a point. No other system here drops below 2 bits a point "
              "without losing points, or has a bound on the largest error that its frames carry with them.")
    footprints(made, run, quality)
    return made


def row(label, m, t):
    return [label, m["bytes"], m["bpp"], m["ratio_xyz"], m["ratio_xyzi"], 100 * m["se"], m["psnr_db"], m["psnr_reverse_db"], 100 * m["cd_m2"],
            100 * m["cd_mean_m"], m["max_error_m"], milliseconds(t, "encode"), milliseconds(t, "decode")]


def drawn(made, found):
    fig, axes = figure(11, 9, 2, 2)
    systems = list(dict.fromkeys(c.system for c, _ in found))
    for panel, (field, title, scale) in zip(axes.flat, PANELS):
        for system in systems:
            points = sorted((m["bpp"], m[field]) for c, m in found if c.system == system and m[field])
            if not points:
                continue
            color, marker = look(system)
            strong = system.startswith("flicr, ") and "preset" not in system
            panel.plot(*zip(*points), marker=marker, color=color, label=system, markersize=5, linewidth=2.4 if strong else 1.2,
                       zorder=3 if strong else 2)
        if field == "psnr_db":
            for label in ("G-PCC", "RT-ST"):
                points = sorted((f[2], f[3]) for f in elsewhere.FIGURES.values() if f[1] == label and f[3])
                if label not in systems:
                    panel.plot(*zip(*points), marker=look(label)[1], color=look(label)[0], linestyle=":", linewidth=1.2, markersize=5,
                               label=f"{label} ({elsewhere.MARK})")
        panel.set_xscale("log")
        panel.set_yscale(scale)
        panel.set_xticks([0.5, 1, 2, 4, 8, 16], ["0.5", "1", "2", "4", "8", "16"])
        panel.minorticks_off()
        panel.set_xlabel("bits a point")
        panel.set_title(title)
    handles, labels = axes[0, 0].get_legend_handles_labels()
    fig.legend(handles, labels, loc="outside lower center", ncols=4)
    made.plot("rate_distortion_plot", "Bits a point against four errors.", fig)


def footprints(made, run, quality):
    """Bytes against memory against instructions."""
    scan = run.timed_scans[0]
    widths = [f"{columns}:deflate:120" for columns in ((4500, 1024, 256) if run.quick else (4500, 4096, 2048, 1024, 512, 256))]
    native = [f"native:{tier}:10" for tier in ("small", "dense")]
    costs = boards.costs(run, "m7", scan, [*widths, "256:deflate-small:120", *native])
    if not costs:
        return
    fig, axes = figure(9, 5)
    for job, cost in costs.items():
        columns, coder, _ = job.split(":")
        name = f"own grid, {coder}, 20 mm" if columns == "native" else f"{columns}x64 {'small' if coder.endswith('small') else ''}"
        color = look("flicr, " + coder)[0] if columns == "native" else look("flicr, preset uniform")[0]
        axes.scatter(cost["encoder_bytes"] / 1024, cost["bytes"] / 1000, s=(cost["project"] + cost["code"]) / 1e5, color=color, alpha=0.75)
        axes.annotate(f"{name}\n{(cost['project'] + cost['code']) / 1e6:.0f} M", (cost["encoder_bytes"] / 1024, cost["bytes"] / 1000),
                      textcoords="offset points", fontsize=8, **place_of_label(columns, coder))
        made.numbers.setdefault("footprints", {})[job] = {
            "bytes": cost["bytes"], "ram_bytes": cost["encoder_bytes"], "instructions": cost["project"] + cost["code"]}
    axes.set_xlabel("RAM of the encoder, KiB (range image and coder)")
    axes.set_ylabel("kilobytes a frame")
    axes.set_xscale("log")
    axes.set_yscale("log")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_locator(NullLocator())
    axes.margins(0.15)
    made.plot("footprints", f"Bytes against RAM against instructions (area; millions a frame) on an emulated Cortex-M7, {scan.name}. "
              "Streams need 3.2 KB of RAM in place of an image (docs/PERFORMANCE.md).", fig)


def place_of_label(columns, coder):
    """Beside its circle, where others' are not."""
    if columns in ("4500", "4096"):
        return {"xytext": (14, 6 if columns == "4500" else -16), "ha": "left"}
    if columns != "native":
        return {"xytext": (0, 14), "ha": "center"}
    return {"xytext": (-24, 12 if coder == "small" else -22), "ha": "right"}
