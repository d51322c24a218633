"""The paper's first table: what codecs there are, and what they cost."""

from .. import elsewhere, paper_numbers
from ..configurations import group, named
from ..figures import joules, medians, milliseconds
from ..report import Section
from ..scans import counted

HEADINGS = ["system", "bits / point", "ratio, 12 B", "ratio, 16 B", "lost %", "PSNR dB", "reverse PSNR", "CD m² × 100", "mean cm", "max error m",
            "encode ms", "decode ms", "encode J", "decode J"]
DECIMALS = [None, 2, 2, 2, 2, 2, 2, 4, 2, 3, 1, 1, 3, 3]
# The paper's row beside which of ours.
BESIDE = {"rle": "RLE", "gzip-1": "LZ77", "draco-qp11": "Draco", "pcl-medium": "PCL"}
OURS = ("dense-lossless", "dense-20mm", "fast-20mm", "dense-102mm", "uniform-4500")


def systems(run):
    if run.quick:
        return [c for c in group("rivals") if c.is_in("quick")]
    return [c for c in group("rivals") if not c.is_in("variants") and (not c.is_in("authors") or c.name == "authors-4500")]


def section(run):
    made = Section("existing_methods", "Existing methods")
    configurations = systems(run) + [named(name) for name in OURS]
    quality = run.measured(configurations, label="existing methods")
    times = run.times([c for c in configurations if c.name in quality])
    rows, paper_rows = [], set()
    for configuration in configurations:
        if configuration.name not in quality:
            continue
        m, t = medians(quality[configuration.name]), times.get(configuration.name)
        rows.append(row(configuration.label, m, t))
        made.numbers[configuration.name] = numbers(m, t)
        if configuration.name in BESIDE:
            paper_rows.add(len(rows))
            rows.append(paper_row(BESIDE[configuration.name]))
    for name, system in (("G-PCC", "G-PCC"), ("RT-ST", "RT-ST")):
        paper_rows.add(len(rows))
        rows.append(paper_row(name))
        if not any(c.system == system and c.name in quality for c in configurations):
            rows += [elsewhere_row(figure) for figure in elsewhere.FIGURES.values() if figure[1].startswith(system)]
    made.text(
        "The paper’s Table I, with three systems that it lacks (cloudini, LASzip, zstd) and H.264 on its range image (its Table III: ratios 12.9, 13.3, 16.4, 35.0; "
        "PSNR 63.2, 48.2, 37.6, 38.1 dB; what it calls QP is x264’s CRF). Medians over "
        f"{counted(len(run.scans))}; times over {len(run.timed_scans)}: processor time of the fastest of 7 runs, one thread, in "
        "process (H.264: ffmpeg’s, its start taken out), cloud in memory to bytes in memory and back. Rows in italics are the paper’s, on a "
        "Core i7-10700.")
    made.table("existing_methods", "Existing methods, sorted by kind; flicr last", HEADINGS, rows, DECIMALS, frozenset(paper_rows))
    made.text(
        "<b>Where our figures differ from the paper’s.</b> Its ratios count 16 bytes a point for RLE and LZ77 and 12 for range images; "
        "both are here. Its “CD (cm)” is the equation’s m² times 100, no length: that is the column’s unit; the mean distance in "
        "centimeters is beside it. Draco drops no point: the paper’s 6.7 % is not reproduced by any of its settings. Its PSNR looks "
        "from decoded points to the nearest original one, so that lost points cost nothing: the reverse direction shows them. "
        "PCL codes each scan on its own (no frame before it); its 1.13 truncates a point’s place within its 10 mm voxel to 5 mm, which costs "
        "6 dB against rounding: the paper’s 89.8 dB is what rounding would give. RLE, LZ77 and zstd carry the intensity (16 bytes); all others only "
        "x, y and z.")
    if run.missing:
        made.text("Not on this machine: " + "; ".join(f"{system}: {why}" for system, why in run.missing.items()) + ".")
    made.text("Energy is what the processor’s own counter (RAPL) says of a frame; machines without one leave the columns empty.")
    return made


def row(label, m, t):
    cd = None if m["cd_m2"] is None else 100 * m["cd_m2"]
    lossless = m["cd_m2"] == 0
    psnr = "lossless" if lossless else m["psnr_db"]
    return [label, m["bpp"], m["ratio_xyz"], m["ratio_xyzi"], percent(m["se"]), psnr, "lossless" if lossless else m["psnr_reverse_db"], cd,
            100 * m["cd_mean_m"], m["max_error_m"], milliseconds(t, "encode"), milliseconds(t, "decode"), joules(t, "encode"), joules(t, "decode")]


def percent(share):
    return None if share is None else 100 * share


def numbers(m, t):
    return {**m, "encode_ms": milliseconds(t, "encode"), "decode_ms": milliseconds(t, "decode"),
            "encode_j": joules(t, "encode"), "decode_j": joules(t, "decode")}


def paper_row(name):
    p = paper_numbers.EXISTING[name]
    sixteen = name in ("RLE", "LZ77")
    ratio, psnr = p["ratio"], p["psnr_db"] or "lossless"
    return [f"the paper: {name}", (128 if sixteen else 96) / ratio, None if sixteen else ratio, ratio if sixteen else None, None, psnr, None,
            p["cd_printed"], None, None, p["encode_ms"][0], p["decode_ms"][0], p["encode_j"][0], p["decode_j"][0]]


def elsewhere_row(figure):
    label, _, bpp, psnr, lost, encode, decode = figure
    return [f"{label} ({elsewhere.MARK})", bpp, 96 / bpp, 128 / bpp, 100 * lost, psnr if psnr else "exact at 1 mm", None, None, None, None,
            encode, decode, None, None]
