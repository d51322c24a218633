"""That the metrics are right: SciPy finds the same."""

from .. import check
from ..configurations import ALL
from ..report import Section
from ..store import source_digest

QUICK = ("dense-20mm", "uniform-4500", "draco-qp11", "h264-30")


class Disagreement(Exception):
    """Two implementations of the paper's metrics that do not agree: nothing of the report can be believed."""


def section(run):
    made = Section("metrics_check", "The metrics, checked")
    scan = run.scans[0]
    configurations = [c for c in ALL if not c.is_in("variants") and run.is_there(c) and (not run.quick or c.name in QUICK)]
    wrong = [f"{c.name}: {line}" for c, lines in zip(configurations, run.map("SciPy", lambda c: checked(run, c, scan), configurations)) for line in lines]
    if wrong:
        raise Disagreement("flicr compare and SciPy disagree:\n" + "\n".join(wrong))
    made.numbers = {"configurations": len(configurations), "tolerance": check.TOLERANCE}
    made.text(f"Bytes are files’ lengths and quality is <code>flicr compare</code>’s, for every system alike. SciPy’s <code>cKDTree</code> and the paper’s "
              f"equations in Python gave the same ten measures for all {len(configurations)} configurations on {scan.name}, within {check.TOLERANCE:g} of "
              "each other; a run in which they do not agree fails.")
    return made


def checked(run, configuration, scan):
    def compute():
        decoded = run.decoded(configuration, scan)
        return check.disagreements(run.compare(scan.path, decoded), check.measures(check.read_returns(scan.path), check.read_returns(decoded)))

    key = [configuration.driver, configuration.options, run.flicr.digest, run._key(configuration), scan.digest, source_digest(check)]
    return run.store.get("check", key, compute)
