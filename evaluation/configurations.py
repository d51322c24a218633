"""Every system and setting that is measured, by name."""

from dataclasses import dataclass

WIDTHS = (4500, 4096, 2048, 1024, 512, 256)
TIERS = ("dense", "small", "fast")
STEPS = ("native", "0.01", "0.02", "0.05", "0.102", "0.202", "0.314")
# A step in the sensor's range counts.
COUNT_M = 0.002


@dataclass(frozen=True)
class Configuration:
    """One system in one setting.

    `system` groups settings in plots; `driver` is who runs it ("flicr", or one of rivals.py) and `options` what it is told:
    of flicr, the arguments of `flicr encode`. `stages` is what the stages of ours are timed as (rivals/src/stages.rs).
    """

    name: str
    label: str
    system: str
    driver: str
    options: tuple
    groups: frozenset = frozenset()
    stages: str | None = None

    def is_in(self, group):
        return group in self.groups

    @property
    def is_ours(self):
        return self.driver == "flicr"


def step_word(step):
    """`lossless`, `20mm`."""
    return "lossless" if step == "native" else f"{round(float(step) * 1000)}mm"


def _widths():
    for preset in ("paper", "uniform"):
        for columns in WIDTHS:
            groups = {"widths"}
            if preset == "uniform" or columns in (4500, 1024, 256):
                groups.add("tasks")
            if preset == "uniform" and columns in (4500, 1024, 256):
                groups |= {"links", "quick"}
            yield Configuration(
                f"{preset}-{columns}", f"flicr {preset} {columns}x64, 8 bits, DEFLATE", f"flicr, preset {preset}", "flicr",
                ("--preset", preset, "--columns", str(columns)), frozenset(groups), f"{preset}:{columns}:deflate",
            )


def _tiers():
    for tier in TIERS:
        for step in STEPS:
            groups = {"steps"}
            if tier == "dense":
                groups.add("tasks")
            if step in ("native", "0.02", "0.102", "0.314"):
                groups |= {"links", "quick"}
            counts = 1 if step == "native" else round(float(step) / COUNT_M)
            words = "lossless, 2 mm" if step == "native" else f"step {round(float(step) * 1000)} mm"
            yield Configuration(
                f"{tier}-{step_word(step)}", f"flicr {tier}, {words}", f"flicr, {tier}", "flicr",
                ("--tier", tier, "--step", step), frozenset(groups), f"native:{tier}:{counts}",
            )


def _narrow():
    """Coarse enough for a link of a megabit a second."""
    return Configuration("dense-500mm", "flicr dense, step 500 mm", "flicr, dense", "flicr", ("--tier", "dense", "--step", "0.5"),
                         frozenset({"links", "quick"}), "native:dense:250")


def _rival(name, label, system, driver, options, *groups):
    return Configuration(name, label, system, driver, tuple(options.split()), frozenset({"rivals", *groups}))


RIVALS = (
    _rival("rle", "RLE on raw bytes", "bytes as they are", "rust", "rle", "quick"),
    _rival("gzip-1", "LZ77 (gzip -1) on raw bytes", "bytes as they are", "rust", "gzip:1", "quick"),
    _rival("zstd-3", "zstd -3 on raw bytes", "bytes as they are", "rust", "zstd:3"),
    _rival("draco-qp10", "Draco, 10 bits", "Draco", "draco", "10 10", "curve", "links"),
    _rival("draco-qp11", "Draco, 11 bits", "Draco", "draco", "11 10", "curve", "links", "quick", "tasks"),
    _rival("draco-qp12", "Draco, 12 bits", "Draco", "draco", "12 10", "curve"),
    _rival("draco-qp14", "Draco, 14 bits", "Draco", "draco", "14 10", "curve", "quick", "tasks"),
    _rival("draco-qp16", "Draco, 16 bits", "Draco", "draco", "16 10", "curve"),
    _rival("pcl-low", "PCL octree, low", "PCL octree", "pcl", "low", "curve"),
    _rival("pcl-medium", "PCL octree, medium", "PCL octree", "pcl", "medium", "curve", "quick"),
    _rival("pcl-high", "PCL octree, high", "PCL octree", "pcl", "high", "curve"),
    _rival("cloudini-2mm", "cloudini, 2 mm, zstd", "cloudini", "rust", "cloudini:0.002:zstd", "curve", "links", "quick"),
    _rival("cloudini-20mm", "cloudini, 20 mm, zstd", "cloudini", "rust", "cloudini:0.02:zstd", "curve", "links"),
    _rival("cloudini-100mm", "cloudini, 100 mm, zstd", "cloudini", "rust", "cloudini:0.1:zstd", "curve"),
    _rival("cloudini-2mm-lz4", "cloudini, 2 mm, LZ4", "cloudini, LZ4", "rust", "cloudini:0.002:lz4"),
    _rival("laszip-1mm", "LASzip, 1 mm", "LASzip", "rust", "laszip:0.001", "curve", "quick"),
    _rival("laszip-10mm", "LASzip, 10 mm", "LASzip", "rust", "laszip:0.01", "curve", "links"),
    _rival("laszip-50mm", "LASzip, 50 mm", "LASzip", "rust", "laszip:0.05", "curve"),
    *(_rival(f"h264-{crf}", f"H.264 intra on the 8-bit 4500x64 image, CRF {crf}", "H.264", "h264", f"4500 {crf}",
             "h264", *(("quick",) if crf in (0, 30) else ())) for crf in (0, 10, 20, 30)),
    *(_rival(f"authors-{columns}", f"FLiCR as its authors do it, {columns}x64", "FLiCR, the authors' way", "rust",
             f"authors:{columns}:8bit:lz77", "curve", "authors", *(("quick", "links") if columns in (4500, 256) else ()))
      for columns in WIDTHS),
    *(_rival(f"authors-{columns}-{depth}-{coder}", f"the authors' way, {columns}x64, {depth}, {coder.upper()}",
             "FLiCR, variants", "rust", f"authors:{columns}:{depth}:{coder}", "variants")
      for columns in WIDTHS for depth, coder in (("8bit", "rle"), ("float", "lz77"), ("float", "rle"))),
    _rival("gpcc-1mm", "MPEG G-PCC octree, 1 mm", "G-PCC", "gpcc", "0.001", "external", "curve"),
    _rival("gpcc-10mm", "MPEG G-PCC octree, 10 mm", "G-PCC", "gpcc", "0.01", "external", "curve"),
    _rival("gpcc-50mm", "MPEG G-PCC octree, 50 mm", "G-PCC", "gpcc", "0.05", "external", "curve"),
    _rival("rtst", "RT-ST", "RT-ST", "rtst", "", "external", "curve"),
)

ALL = (*_widths(), *_tiers(), _narrow(), *RIVALS)
_BY_NAME = {configuration.name: configuration for configuration in ALL}


def named(name):
    return _BY_NAME[name]


def group(name):
    """All configurations of a group: widths, steps, tasks, links, rivals, curve, authors, variants, h264, external, quick."""
    return [configuration for configuration in ALL if configuration.is_in(name)]
