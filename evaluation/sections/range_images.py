"""The paper's lossy range images: six widths, quantized or not, by coder and by stage."""

from .. import boards, paper_numbers
from ..configurations import WIDTHS, group, named
from ..figures import figure, joules, look, median, medians, milliseconds, stage_ms
from ..report import Section

HEADINGS = ["frame", "bytes", "ratio, 12 B", "lost %", "PSNR dB", "reverse PSNR", "CD m² × 100", "ePSNR dB", "max error m",
            "encode ms", "decode ms", "encode J", "decode J"]
DECIMALS = [None, 0, 2, 2, 2, 2, 3, 2, 2, 2, 2, 3, 3]
KINDS = (("authors", "the authors’ way"), ("paper", "flicr, preset paper"), ("uniform", "flicr, preset uniform"))
VARIANTS = (
    ("8bit-lz77", "8 bits, LZ77", "authors-{}", "#c0392b", "-"),
    ("8bit-rle", "8 bits, RLE", "authors-{}-8bit-rle", "#e59866", "-"),
    ("float-lz77", "not quantized, LZ77", "authors-{}-float-lz77", "#34495e", "--"),
    ("float-rle", "not quantized, RLE", "authors-{}-float-rle", "#95a5a6", "--"),
)


def section(run):
    made = Section("range_images", "Lossy range images")
    widths = (4500, 1024, 256) if run.quick else WIDTHS
    configurations = [named(f"{kind}-{columns}") for columns in widths for kind, _ in KINDS]
    quality = run.measured(configurations, label="range images")
    times = run.times([c for c in configurations if c.name in quality])
    main_table(made, widths, quality, times)
    variants(made, run, widths)
    if times:
        breakdown(made, widths, times)
    on_boards(made, run, widths)
    return made


def main_table(made, widths, quality, times):
    rows, paper_rows = [], set()
    for columns in widths:
        paper_rows.add(len(rows))
        rows.append(paper_row(columns))
        for kind, label in KINDS:
            name = f"{kind}-{columns}"
            if name in quality:
                m, t = medians(quality[name]), times.get(name)
                rows.append([f"{columns}x64, {label}", m["bytes"], m["ratio_xyz"], percent(m["se"]), m["psnr_db"], m["psnr_reverse_db"],
                             100 * m["cd_m2"], m["epsnr_db"], m["max_error_m"], milliseconds(t, "encode"), milliseconds(t, "decode"),
                             joules(t, "encode"), joules(t, "decode")])
                made.numbers[name] = {**m, "encode_ms": milliseconds(t, "encode"), "decode_ms": milliseconds(t, "decode"),
                                      "encode_j": joules(t, "encode"), "decode_j": joules(t, "decode")}
    made.text("The paper’s Tables IV and V: 8 bits a pixel, 64 rows, six widths. <i>The authors’ way</i> is their program’s arithmetic, plainly "
              "(libm for every point, the last point wins, zlib level 1); <i>preset paper</i> is flicr making the same image; "
              "<i>preset uniform</i> the best of evenly spread pixels: the nearest point wins and comes back in its pixel’s middle.")
    made.table("widths", "Six widths, beside the paper’s own figures (desktop)", HEADINGS, rows, DECIMALS, frozenset(paper_rows))
    made.text("<b>Differences.</b> Points lost agree with the paper to within a percent. Ratios are higher here, by what a better DEFLATE and "
              "placement bring. The paper’s PSNR is above what a corner placement can give at 8 bits; its CD (printed in “cm”) is the sum of "
              "two mean squares, times 100. ePSNR: alpha -0.15, beta 0.5, natural exponent, which reproduces the paper’s column from its PSNR and SE.")


def percent(share):
    return None if share is None else 100 * share


def paper_row(columns):
    p = paper_numbers.WIDTHS[columns]
    return [f"{columns}x64, the paper", None, p["ratio"], 100 * p["se"], p["psnr_db"], None, p["cd_printed"], p["epsnr_db"], None,
            p["encode_ms"][0], p["decode_ms"][0], p["encode_j"][0], p["decode_j"][0]]


def variants(made, run, widths):
    """The paper's figure of four: ratio, latency, PSNR and CD, with and without quantization, by both coders."""
    configurations = [named(pattern.format(columns)) for _, _, pattern, _, _ in VARIANTS for columns in widths]
    quality = run.measured(configurations, run.timed_scans, label="quantized and not")
    if not quality:
        return
    times = run.times([c for c in configurations if c.name in quality], "quantized and not")
    fig, axes = figure(10, 6.4, 2, 2)
    panels = (
        (axes[0, 0], "compression ratio (12 B a point)", lambda m, t: m["ratio_xyz"], "linear"),
        (axes[0, 1], "encode and decode, ms", lambda m, t: (milliseconds(t, "encode") or 0) + (milliseconds(t, "decode") or 0), "linear"),
        (axes[1, 0], "PSNR, dB", lambda m, t: m["psnr_db"], "linear"),
        (axes[1, 1], "CD, m²", lambda m, t: m["cd_m2"], "log"),
    )
    for panel, title, value, scale in panels:
        for kind, label, pattern, color, style in VARIANTS:
            values = []
            for columns in widths:
                name = pattern.format(columns)
                measured = medians(quality[name])
                values.append(value(measured, times.get(name)))
                made.numbers.setdefault("variants", {})[f"{kind}-{columns}"] = {
                    "ratio_xyz": measured["ratio_xyz"], "psnr_db": measured["psnr_db"], "cd_m2": measured["cd_m2"]}
            panel.plot(range(len(widths)), values, style, color=color, label=label, marker="o", markersize=4)
        panel.set_xticks(range(len(widths)), [f"{columns}" for columns in widths])
        panel.set_title(title)
        panel.set_yscale(scale)
    axes[0, 0].legend()
    made.plot("quantized_and_not", "The paper’s Figure 8, re-done in the authors’ way: quantization and subsampling both help the dictionary "
              "coder, and only together do they make it good; RLE gains from neither as much. Without quantization the PSNR is the "
              "projection’s alone (corner of the pixel).", fig)


def breakdown(made, widths, times):
    """The paper's figure of latencies by stage."""
    stages = (("scale", "largest range", "#dfe4ea"), ("project", "points to image", "#0b6e75"), ("code", "DEFLATE and checksum", "#e07b39"),
              ("uncode", "inflate", "#f2b134"), ("points", "image to points", "#7cc6a2"))
    fig, axes = figure(9, 3.4)
    labels = [f"{columns}x64" for columns in widths][::-1]
    left = [0.0] * len(labels)
    for stage, label, color in stages:
        values = [stage_ms(times.get(f"uniform-{columns}"), stage) or 0.0 for columns in widths][::-1]
        axes.barh(labels, values, left=left, color=color, label=label)
        left = [a + b for a, b in zip(left, values)]
        for columns, value in zip(widths[::-1], values):
            made.numbers.setdefault("stages_ms", {}).setdefault(f"uniform-{columns}", {})[stage] = value
    axes.set_xlabel("ms on this machine, one thread (encoding: the first three; decoding: the last two)")
    axes.grid(axis="y", visible=False)
    axes.legend(ncols=5, loc="upper center", bbox_to_anchor=(0.5, 1.15), fontsize=8.5)
    made.plot("breakdown", "The paper’s Figure 9, re-done: where a frame’s time goes. The paper: 23 ms at 4500x64 on the desktop, most of it "
              "conversion between points and image.", fig)


def on_boards(made, run, widths):
    """Instructions of the firmware."""
    # One scan is enough: instructions repeat, and differ little from scan to scan.
    scan = run.timed_scans[0]
    names = ("m7",) if run.quick else tuple(boards.BOARDS)
    native = [f"native:{tier}:{counts}" for tier in ("small", "dense") for counts in ((10,) if run.quick else (1, 10, 51, 157))]
    jobs = [f"{columns}:deflate:120" for columns in widths] + ["256:deflate-small:120"] + native
    rows = []
    for board in names:
        costs = boards.costs(run, board, scan, jobs)
        for job, cost in (costs or {}).items():
            pixels = max(1, round(100 * cost["code"] / max(1, cost["hundredths_a_pixel"])))
            rows.append([boards.BOARDS[board][0], words(job), cost["bytes"], cost["project"] / cost["points"], cost["code"] / pixels,
                         (cost["project"] + cost["code"]) / 1e6, cost["encoder_bytes"], cost["stack_bytes"]])
            made.numbers.setdefault("boards", {}).setdefault(board, {})[job] = cost
    if not rows:
        made.text("No firmware, or no emulator, on this machine: instructions on boards are left out.")
        return
    made.table("boards", f"Instructions on emulated boards ({scan.name})",
               ["board", "frame", "bytes", "projection, a point", "coding, a pixel", "a frame, millions", "RAM bytes", "stack bytes"],
               rows, [None, None, 0, 1, 1, 1, 0, 0])
    made.text("Instructions as QEMU counts them (<code>-icount</code>); they repeat to the instruction and are not cycles: a Cortex-M7 "
              "retires up to two in one, and waits for memory. The paper has a Jetson AGX Xavier (15 W) instead: 26.8 ms to encode at "
              "4500x64, 9.5 ms at 256x64.")


def words(job):
    columns, coder, last = job.split(":")
    if columns == "native":
        return f"own grid, {coder}, step {2 * int(last)} mm"
    return f"{columns}x64, 8 bits, {coder}"
