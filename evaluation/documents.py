"""Tables of README.md and docs/PERFORMANCE.md that `make paper` measured: made from evaluation/results.json, and nothing else.

    python -m evaluation.documents keep target/paper/results.json   take over a full run's numbers, and write the tables anew
    python -m evaluation.documents write                            write the tables anew
    python -m evaluation.documents check                            fail where a document does not hold them

A table stands between `<!-- evaluation: NAME -->` and `<!-- evaluation: end -->`.
"""

import json
import re
import sys
from pathlib import Path

from .configurations import STEPS, TIERS, WIDTHS, named, step_word

ROOT = Path(__file__).parent.parent
RESULTS = Path(__file__).parent / "results.json"
DOCUMENTS = ("README.md", "docs/PERFORMANCE.md")
BLOCK = re.compile(r"(<!-- evaluation: (?!end)([a-z-]+) -->\n)(.*?)(<!-- evaluation: end -->)", re.DOTALL)
KEPT = ("existing_methods", "construction", "range_images", "rate_distortion", "links", "metrics_check", "about", "odometry", "detection", "metric_fit")


def table(headings, rows):
    lines = ["| " + " | ".join(headings) + " |", "|" + "---|" * len(headings)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


def number(value, decimals, none="–"):
    return none if value is None else f"{value:,.{decimals}f}"


def of(results, name):
    """A configuration's numbers, of all sections that have it."""
    found = {}
    for section in ("range_images", "rate_distortion", "existing_methods"):
        found |= {key: value for key, value in results.get(section, {}).get(name, {}).items() if value is not None or key not in found}
    if not found:
        raise KeyError(f"results.json has no {name}")
    return found


def widths(results):
    rows = []
    for columns in WIDTHS:
        m = of(results, f"uniform-{columns}")
        rows.append([str(columns), number(m["bytes"], 0), number(m["ratio_xyz"], 1), number(m["ratio_xyzi"], 1), number(m["bpp"], 2),
                     number(100 * m["se"], 2), number(m["psnr_db"], 2), number(m["psnr_reverse_db"], 2), number(m["cd_m2"], 4),
                     number(m["epsnr_db"], 2), number(m["max_error_m"], 2)])
    return table(["columns", "bytes", "ratio, 12 B a point", "ratio, 16 B", "bits a point", "lost %", "PSNR dB", "reverse PSNR", "CD m²",
                  "ePSNR dB", "max error m"], rows)


def tiers(results):
    """Ratios at 16 bytes a point, by tier and step, and what the step costs."""
    steps = [step_word(step) for step in STEPS]
    rows = [[tier, *(number(of(results, f"{tier}-{step}")["ratio_xyzi"], 1) for step in steps)] for tier in TIERS]
    rows.append(["PSNR dB", *(number(of(results, f"dense-{step}")["psnr_db"], 1) for step in steps)])
    rows.append(["max error mm", *(number(1000 * of(results, f"dense-{step}")["max_error_m"], 0) for step in steps)])
    return table(["tier"] + ["2 mm, lossless" if step == "lossless" else step.replace("mm", " mm") for step in steps], rows)


RIVALS = ("gzip-1", "zstd-3", "draco-qp11", "draco-qp14", "pcl-medium", "cloudini-2mm", "cloudini-20mm", "laszip-1mm", "laszip-10mm", "h264-0",
          "authors-4500", "uniform-4500", "dense-lossless", "dense-20mm", "fast-20mm", "dense-102mm")


def rivals(results):
    rows = []
    for name in RIVALS:
        m = of(results, name)
        lossless = m["cd_m2"] == 0
        rows.append([named(name).label, number(m["bpp"], 2), number(m["ratio_xyzi"], 1), number(100 * m["se"] if m["se"] is not None else None, 1),
                     "lossless" if lossless else number(m["psnr_db"], 1), "0" if lossless else number(1000 * m["max_error_m"], 1),
                     number(m.get("encode_ms"), 1), number(m.get("decode_ms"), 1)])
    return table(["system", "bits a point", "ratio, 16 B", "lost %", "PSNR dB", "max error mm", "encode ms", "decode ms"], rows)


# README's frames, what they are as boards' jobs, and what they are called.
COSTS = (("uniform-4500", "4500:deflate:120", "4500x64"), ("uniform-256", "256:deflate:120", "256x64"))


def costs(results):
    boards = results["range_images"]["boards"]["m7"]
    rows = []
    for name, job, label in COSTS:
        m, cost = of(results, name), boards[job]
        pixels = 64 * int(job.split(":")[0])
        rows.append([label, number(m["bytes"], 0), number(m["ratio_xyzi"], 1), number(100 * m["se"], 1) + " %", number(m["psnr_db"], 1) + " dB",
                     number(cost["encoder_bytes"] / 1024, 0) + " KB", f"{cost['project'] / cost['points']:.0f} + {cost['code'] / pixels:.0f}"])
    return table(["frame", "bytes", "ratio (16 B a point)", "points lost", "PSNR", "RAM", "Cortex-M7: instructions a point + a pixel"], rows)


def ratios(results):
    """The context coders in a sentence."""
    def all_tiers(step):
        dense, small, fast = (number(of(results, f"{tier}-{step}")["ratio_xyzi"], 0) for tier in TIERS)
        return f"{dense}, {small} and {fast}"

    bound_mm = number(1000 * of(results, "dense-20mm")["max_error_m"], 0)
    return (f"At 16 bytes a point, no point lost, dense, small and fast make a scan {all_tiers('lossless')} times smaller at the sensor's own 2 mm,\n"
            f"and {all_tiers('20mm')} times at `--step 0.02`, where the worst point is {bound_mm} mm off.\n")


def tasks(results):
    """What odometry and detection make of decoded clouds; the first row is how far apart the original's own results lie."""
    poses, cars = results["odometry"], results["detection"]
    rows = [["original, shuffled or its grid moved", "", number(1000 * poses["floor"]["step_m"], 1), "", *found(cars["floor"])]]
    for name, one in poses["configurations"].items():
        rows.append([named(name).label, number(of(results, name)["bytes"] / 1000, 1), number(1000 * one["step_m"], 1),
                     number(one["step_p"], 2), *found(cars["agreement"][name])])
    return table(["cloud", "kB a scan", "step mm", "p", "IoU 0.3 %", "IoU 0.5 %", "IoU 0.7 %", "mean IoU"], rows)


def found(shares):
    return [*(number(100 * shares[f"recall_{iou}"], 0) for iou in ("0.3", "0.5", "0.7")), number(shares["mean_iou"], 2)]


def metrics(results):
    """How metrics rank configurations as the tasks do, and how well a curve of each predicts the tasks' scores."""
    by_task = results["metric_fit"]["tasks"]
    rows = []
    for name in by_task["detection"]["rankings"]:
        cells = [name]
        for task in ("detection", "odometry"):
            ranking, fit = by_task[task]["rankings"][name], by_task[task]["fits"][name]
            low, high = ranking["rho_interval"]
            cells += [f"{ranking['rho']:.2f} ({low:.2f} to {high:.2f})", number(fit["left_out_error"], 3)]
        rows.append(cells)
    fitted = [by_task[task]["fitted_epsnr"] for task in ("detection", "odometry")]
    rows.append(["ePSNR, fitted to the task", *(cell for one in fitted for cell in (number(one["rho"], 2), number(one["left_out_error"], 3)))])
    means = [by_task[task]["mean_error"] for task in ("detection", "odometry")]
    rows.append(["none", *(cell for mean in means for cell in ("", number(mean, 3)))])
    return table(["metric", "detection: Spearman's rho (95 %)", "left out", "odometry: Spearman's rho (95 %)", "left out"], rows)


TABLES = {
    "costs": costs,
    "ratios": ratios,
    "widths": widths,
    "tiers": tiers,
    "rivals": rivals,
    "tasks": tasks,
    "metrics": metrics,
}


def rendered(text, results):
    """A document with its tables made anew."""
    return BLOCK.sub(lambda found: found[1] + TABLES[found[2]](results) + found[4], text)


def rounded(value):
    """Five significant digits: what is worth keeping."""
    if isinstance(value, dict):
        return {key: rounded(item) for key, item in value.items()}
    if isinstance(value, list):
        return [rounded(item) for item in value]
    return float(f"{value:.5g}") if isinstance(value, float) else value


def keep(path):
    results = json.loads(Path(path).read_text(encoding="utf-8"))
    about = results.get("about", {})
    if about.get("quick") or about.get("simulated"):
        raise SystemExit(f"{path}: of a quick run, or of simulated scans: expected make paper's, with FLICR_DATA")
    # A run of some sections (--only) leaves the others' numbers as they are.
    before = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.exists() else {}
    kept = before | {name: rounded(results[name]) for name in KEPT if name in results}
    RESULTS.write_text(json.dumps(kept, indent=1, sort_keys=True, ensure_ascii=False) + "\n", encoding="utf-8")


def differing(write):
    """Documents that do not hold the tables; written anew if asked for."""
    results = json.loads(RESULTS.read_text(encoding="utf-8"))
    found = []
    for name in DOCUMENTS:
        path = ROOT / name
        text = path.read_text(encoding="utf-8")
        if (new := rendered(text, results)) != text:
            found.append(name)
            if write:
                path.write_text(new, encoding="utf-8")
    return found


def main(words):
    if words[:1] == ["keep"]:
        keep(words[1])
    if words[:1] in (["keep"], ["write"]):
        print("written:", ", ".join(differing(True)) or "nothing, all hold them")
        return 0
    if words == ["check"]:
        wrong = differing(False)
        for name in wrong:
            print(f"{name}: a table is not what evaluation/results.json says: python3 -m evaluation.documents write", file=sys.stderr)
        return 1 if wrong else 0
    raise SystemExit(__doc__)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
