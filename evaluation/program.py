"""The `flicr` program."""

import json
import subprocess
import tempfile
from pathlib import Path

from .store import file_digest


class Program:
    """Runs `flicr`, and fails with what it said."""

    def __init__(self, path):
        self.path = Path(path)

    @property
    def digest(self):
        return file_digest(self.path)

    def run(self, *arguments):
        command = [str(self.path), *map(str, arguments)]
        done = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL, check=False)
        if done.returncode:
            raise RuntimeError(f"{' '.join(command)}: exit code {done.returncode}\n{done.stderr.strip()}")
        return done.stdout

    def simulate(self, path, seed):
        self.run("simulate", "-o", path, "--seed", seed)

    def transcode(self, scan, options, cloud):
        """Encodes a scan and decodes it again to `cloud` (.bin); gives the frame's length."""
        with tempfile.TemporaryDirectory() as folder:
            frame = Path(folder) / "scan.flicr"
            self.run("encode", scan, "-o", frame, *options)
            # The program knows a cloud's format by its name.
            decoded = Path(folder) / "cloud.bin"
            self.run("decode", frame, "-o", decoded)
            cloud.write_bytes(decoded.read_bytes())
            return frame.stat().st_size

    def evaluate(self, scan, options):
        """What `flicr eval` says of one scan and configuration."""
        return json.loads(self.run("eval", scan, "--json", *options))
