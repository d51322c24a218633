"""`python -m evaluation`: measures, and writes the report. Options: --help."""

import argparse
import html
import os
import sys
import time
import traceback
from pathlib import Path

from . import page, report, sections
from .run import Run
from .summary import heading

# Scans, and those of them that are timed.
MOST = {"full": (26, 3), "quick": (2, 1)}


def arguments():
    parser = argparse.ArgumentParser(prog="python -m evaluation", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="two scans, fewer settings")
    parser.add_argument("--out", default="target/paper", help="where the report and kept results go (default %(default)s)")
    parser.add_argument("--flicr", default="target/release/flicr", help="the program (default %(default)s)")
    parser.add_argument("--scans", type=int, help="at most so many scans (default 26; with --quick 2)")
    parser.add_argument("--timed-scans", type=int, help="time at most so many of them (default 3; with --quick 1)")
    parser.add_argument("--only", help="sections by name, with commas")
    parser.add_argument("--workers", type=int, default=min(2, os.cpu_count() or 1), help="programs at once, but for timings")
    return parser.parse_args()


def main():
    args = arguments()
    most, most_timed = MOST["quick" if args.quick else "full"]
    run = Run(args.out, args.flicr, args.quick, args.scans or most, args.timed_scans or most_timed, args.workers)
    run.say(run.origin.origin)
    wanted = args.only.split(",") if args.only else None
    made, failed = [], []
    for module in sections.SECTIONS:
        name = module.__name__.rsplit(".", 1)[1]
        if wanted is None or name in wanted:
            start = time.monotonic()
            run.say(f"section {name}")
            made.append(whole_or_reason(module, run, name, failed))
            run.say(f"section {name}: {time.monotonic() - start:.1f} s")
    about = {"quick": run.quick, "simulated": run.origin.simulated, "scans": len(run.scans), "timed_scans": len(run.timed_scans),
             "load": round(os.getloadavg()[0], 1), "cores": os.cpu_count()}
    page.write(args.out, heading(run, made), made, about)
    run.say(f"{run.store.computed} results measured, {run.store.found} kept ones used: {Path(args.out) / 'index.html'}")
    for name in failed:
        run.say(f"section {name} FAILED; run again when it is mended, what was measured is kept")
    return 1 if failed else 0


def whole_or_reason(module, run, name, failed):
    """A section; where making it failed, one that says why, so that the others' work is not lost."""
    try:
        return module.section(run)
    except Exception:  # noqa: BLE001 (whatever it was, it is reported and ends the run with an error)
        failed.append(name)
        said = traceback.format_exc()
        run.say(said)
        broken = report.Section(name, name)
        broken.text(f'<span class="warning">This section could not be made:</span> <code>{html.escape(said.strip().splitlines()[-1])}</code>')
        return broken


if __name__ == "__main__":
    sys.exit(main())
