"""What a section asks for: scans, decoded clouds, measurements; all of it kept."""

import json
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from tempfile import TemporaryDirectory

from . import rivals, scans
from .program import Program
from .rivals import Missing
from .store import Store, source_digest

# Runs of which the fastest counts.
TIMED_RUNS = 7


class Run:
    """One run of the evaluation.

    `quick`: a few scans and settings, for a look. `scans`: what is measured, `timed_scans` what is timed. `store`: kept
    results. `missing`: systems that are not here, and why.
    """

    def __init__(self, out, flicr, quick=False, most_scans=26, most_timed=3, workers=2):
        self.out = Path(out)
        self.quick = quick
        self.workers = workers
        self.flicr = Program(flicr)
        self.store = Store(self.out / "cache")
        self.data = scans.data_folder()
        self.origin = scans.load(most_scans, self.store.folder, self.flicr.simulate)
        self.scans = self.origin.scans
        self.timed_scans = tuple(scans.spread(self.scans, most_timed))
        self.rivals_folder = self.out / "rivals"
        self.drivers = rivals.drivers(self.rivals_folder)
        self.missing = {}
        self._start = time.monotonic()

    def say(self, text):
        """A line of progress, with the seconds since the beginning."""
        print(f"[{time.monotonic() - self._start:6.0f} s] {text}", file=sys.stderr, flush=True)

    def is_there(self, configuration):
        """Whether a configuration's system can be run here; why not goes into `missing`."""
        try:
            self._key(configuration)
            return True
        except Missing as why:
            self.missing[configuration.system] = str(why)
            return False

    def _key(self, configuration):
        """What a configuration's results depend on, but for the scan."""
        if configuration.is_ours:
            return ["flicr", configuration.options, self.flicr.digest]
        return [configuration.driver, configuration.options, self.drivers[configuration.driver].digest()]

    def _transcode(self, configuration, scan, cloud, runs=1):
        """Encodes and decodes into the file `cloud`; gives the driver's measurement."""
        if configuration.is_ours:
            return {"bytes": self.flicr.transcode(scan.path, configuration.options, cloud)}
        # Some write a cloud by its name's extension.
        with TemporaryDirectory() as folder:
            back = Path(folder) / "cloud.bin"
            made = self.drivers[configuration.driver].transcode(configuration.options, scan.path, back, runs)
            cloud.write_bytes(back.read_bytes())
            return made

    def decoded(self, configuration, scan):
        """The path of a scan's decoded cloud (.bin: x, y, z, 0 of each point, meters), kept."""
        key = [*self._key(configuration), scan.digest]
        return self.store.file("clouds", key, ".bin", lambda path: self._transcode(configuration, scan, path))

    def measure(self, configuration, scan):
        """Bytes, and quality by `flicr compare`: the paper's measures.

        bytes, bpp, ratio_xyz and ratio_xyzi (12 and 16 bytes a point, over bytes), points, decoded, se, psnr_db, psnr_reverse_db,
        cd_m2, cd_mean_m, epsnr_db, max_error_m, max_error_reverse_m; None where infinite or meaningless.
        """
        def compute():
            with TemporaryDirectory() as folder:
                cloud = Path(folder) / "cloud.bin"
                made = self._transcode(configuration, scan, cloud)
                return {**self.compare(scan.path, cloud), **sizes(made["bytes"], scan.points)}

        return self.store.get("quality", [*self._key(configuration), scan.digest, self.flicr.digest], compute)

    def compare(self, original, decoded):
        """What `flicr compare` says, but for the names."""
        said = json.loads(self.flicr.run("compare", original, decoded, "--json"))
        return {name: value for name, value in said.items() if not isinstance(value, str)}

    def measured(self, configurations, scans_=None, label="quality"):
        """`{name: [a measurement for each scan]}` of those configurations whose systems are here."""
        scans_ = self.scans if scans_ is None else scans_
        here = [configuration for configuration in configurations if self.is_there(configuration)]
        found = self.map(label, lambda pair: self.measure(*pair), [(c, scan) for c in here for scan in scans_])
        return {c.name: found[index * len(scans_):(index + 1) * len(scans_)] for index, c in enumerate(here)}

    def timed(self, configuration, scan):
        """What encoding and decoding take, each `{ns, cpu_ns, energy_uj}` or None, on one core, nothing beside it; of ours with
        `stages`. None where ours is not on this scan's grid."""
        stages = rivals.Built(self.rivals_folder / "release" / "flicr-rivals", ["stages"])

        def compute():
            with TemporaryDirectory() as folder:
                if not configuration.is_ours:
                    return self._transcode(configuration, scan, Path(folder) / "cloud.bin", TIMED_RUNS)
                said = rivals.output_of([stages.path, "stages", configuration.stages, scan.path, TIMED_RUNS])
                return json.loads(said)

        key = [stages.digest(), configuration.stages] if configuration.is_ours else self._key(configuration)
        return self.store.get("times", [*key, scan.digest, TIMED_RUNS, source_digest(rivals)], compute)

    def times(self, configurations, label="times"):
        """`{name: [a timing for each timed scan]}`, one after the other, of what is here."""
        found = {}
        for number, configuration in enumerate(configurations):
            if number % 8 == 0:
                self.say(f"{label}: {number} of {len(configurations)}")
            try:
                found[configuration.name] = [self.timed(configuration, scan) for scan in self.timed_scans]
            except Missing as why:
                self.missing[configuration.system] = str(why)
            except RuntimeError as error:
                self.say(f"{configuration.name} cannot be timed: {error}")
        return found

    def map(self, label, function, items):
        """`function` of each item, in their order, on `workers` threads: for work that other programs do. Says how far it is."""
        items = list(items)
        results, said = [], time.monotonic()
        with ThreadPoolExecutor(self.workers) as pool:
            for number, result in enumerate(pool.map(function, items), 1):
                results.append(result)
                if time.monotonic() - said > 5:
                    said = time.monotonic()
                    self.say(f"{label}: {number} of {len(items)}")
        return results


def sizes(coded_bytes, points):
    """`points` are all of the file."""
    return {
        "bytes": coded_bytes,
        "bpp": 8 * coded_bytes / points,
        "ratio_xyz": 12 * points / coded_bytes,
        "ratio_xyzi": 16 * points / coded_bytes,
    }
