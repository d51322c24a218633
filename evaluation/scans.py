"""The scans that are measured: those of FLICR_DATA, else simulated ones."""

import os
from dataclasses import dataclass
from pathlib import Path

from .store import file_digest


@dataclass(frozen=True)
class Scan:
    """One turn of a sensor, in KITTI's format: four little-endian floats a point."""

    name: str
    path: Path

    @property
    def digest(self):
        return file_digest(self.path)

    @property
    def points(self):
        """Points of the file, those at the origin (no return) included."""
        return self.path.stat().st_size // 16


@dataclass(frozen=True)
class Scans:
    """Some scans and where they come from, in words for the report."""

    scans: tuple
    origin: str
    simulated: bool


def data_folder():
    """FLICR_DATA, if it is there."""
    folder = os.environ.get("FLICR_DATA")
    if not folder:
        return None
    folder = Path(folder)
    if not folder.is_dir():
        raise SystemExit(f"FLICR_DATA: no such folder: {folder}")
    return folder


def find(folder):
    """KITTI's raw drive and the paper's whole scans where they are, else every .bin below the folder that is no other format."""
    if (folder / "kitti" / "drive").is_dir():
        drive = sorted((folder / "kitti" / "drive").glob("*.bin"))
        paper = [path for name in ("0", "1") if (path := folder / "kitti" / "paper" / f"{name}.bin").is_file()]
        return drive + paper
    return sorted(path for path in folder.rglob("*.bin") if not path.name.endswith(".xyzir.bin"))


def spread(items, most):
    """At most so many, evenly out of all."""
    if len(items) <= most:
        return list(items)
    return [items[index * len(items) // most] for index in range(most)]


def load(most, out, simulate):
    """Scans of FLICR_DATA; where it is not set, as many simulated ones (`simulate(path, seed)` writes them below `out`)."""
    folder = data_folder()
    if folder is None:
        return simulated(min(most, 3), out, simulate)
    paths = spread(find(folder), most)
    if not paths:
        raise SystemExit(f"FLICR_DATA: {folder}: no .bin files")
    names = [f"{path.parent.name}/{path.stem}" for path in paths]
    scans = tuple(Scan(name, path) for name, path in zip(names, paths))
    return Scans(scans, f"{counted(len(scans))} of FLICR_DATA", False)


def simulated(count, out, simulate):
    scans = []
    for seed in range(1, count + 1):
        path = Path(out) / "simulated" / f"{seed:06}.bin"
        if not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            simulate(path, seed)
        scans.append(Scan(f"simulated/{seed:06}", path))
    return Scans(tuple(scans), f"{counted(count)} of a simulated HDL-64E (FLICR_DATA is not set)", True)


def counted(scans):
    """`1 scan`, `2 scans`."""
    return f"{scans} scan" + ("" if scans == 1 else "s")
