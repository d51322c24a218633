"""What was measured on what, and how."""

import os
import platform
import shutil
import subprocess

from ..report import Section


def section(run):
    made = Section("method", "How this was measured")
    load = os.getloadavg()[0]
    made.text(f"{platform.system()} {platform.machine()}, {processor()}, {os.cpu_count()} cores, Python {platform.python_version()}; load at the end "
              f"of the run {load:.1f}. Times are of the fastest of several runs, processor time of one thread unless said otherwise; "
              + ("<b>the machine was busy with other work</b>, so that they are too long and only ratios mean something." if load > 2 else "the machine was otherwise idle."))
    made.text(f"Scans: {run.origin.origin}. Those timed: {', '.join(scan.name for scan in run.timed_scans)}. Systems: " + "; ".join(versions()) + ".")
    made.text("Every number is kept under <code>cache/</code> by a hash of all that it depends on (program, options, scan): a run that ended early "
              "goes on, and one after a change measures only what changed. <code>results.json</code> holds all numbers, each table is a CSV, each plot an SVG and a PNG.")
    return made


def processor():
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return "an unnamed processor"


def versions():
    """Of what came from Debian's packages."""
    found = ["cloudini 0.3.2, laz 0.13, zstd 1.5, zlib (crates)"]
    for name, package in (("Draco", "libdraco-dev"), ("PCL", "libpcl-dev"), ("ffmpeg", "ffmpeg")):
        if shutil.which("dpkg-query"):
            done = subprocess.run(["dpkg-query", "-W", "-f=${Version}", package], capture_output=True, text=True, check=False)
            if done.stdout:
                found.append(f"{name} {done.stdout}")
    return found
