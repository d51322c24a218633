"""flicr's firmware on emulated boards: instructions and memory. QEMU counts instructions, not cycles."""

import re
import shutil
import tempfile
from pathlib import Path

from . import rivals
from .store import file_digest

ROOT = Path(__file__).parent.parent
# Board, what it is, whose firmware.
BOARDS = {"m4f": ("Cortex-M4F", "thumb"), "m7": ("Cortex-M7", "thumb"), "a53": ("Cortex-A53", "a53")}


def firmware(run, board):
    """The built firmware of a board, or None."""
    path = run.out / "firmware" / f"{BOARDS[board][1]}.elf"
    emulator = "qemu-system-aarch64" if board == "a53" else "qemu-system-arm"
    return path.resolve() if path.is_file() and shutil.which(emulator) else None


def costs(run, board, scan, jobs):
    """`{job: {points, kept, bytes, project, code, total, stack_bytes, encoder_bytes, ...}}`, in instructions; None without the firmware.

    A job is `COLUMNS:CODER:MAX_RANGE_M` or `native:CODER:COUNTS` (examples/firmware/job.rs).
    """
    elf = firmware(run, board)
    if elf is None:
        return None
    key = ["board", board, file_digest(elf), scan.digest]
    found = run.map(f"firmware on {board}", lambda job: run.store.get("boards", [*key, job], lambda: one(board, elf, scan, job)), jobs)
    return dict(zip(jobs, found))


def one(board, elf, scan, job):
    with tempfile.TemporaryDirectory() as folder:
        # The board gets its command line as one string of words.
        shutil.copy(scan.path, Path(folder) / "scan.bin")
        said = rivals.output_of([ROOT / "tools" / "emulate.sh", board, elf, "scan.bin", "out", job], cwd=folder)
    line = next(line for line in said.splitlines() if line.startswith("cost "))
    frame = next(line for line in said.splitlines() if line.startswith("frame "))
    return {name: int(value) for name, value in re.findall(r"(\w+)=(\d+)\b", f"{line} {frame}") if name not in ("columns", "step")}
