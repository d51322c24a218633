"""Other systems, each run by a driver that takes a scan and gives the cloud that came back, bytes, times and energy.

A driver's measurement is a dictionary: `bytes`; `encode` and `decode`, each with `ns` (the fastest run's wall time), `cpu_ns` and
`energy_uj` (None where the machine has no counter), or None where it cannot be timed.
"""

import json
import os
import re
import shutil
import struct
import subprocess
import tempfile
from pathlib import Path

from .store import digest, file_digest


class Missing(Exception):
    """A system that is not on this machine, and how it would get there."""


def output_of(command, **kwargs):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, stdin=subprocess.DEVNULL,
                          check=False, **kwargs)
    if done.returncode:
        raise RuntimeError(f"{' '.join(map(str, command))}: exit code {done.returncode}\n{done.stderr.strip()[-2000:]}")
    return done.stdout


class Built:
    """A program that tools/paper.sh builds: rivals/src or rivals/cpp."""

    def __init__(self, path, arguments):
        self.path, self.arguments = Path(path), arguments

    def digest(self):
        if not self.path.is_file():
            raise Missing(f"{self.path.name} is not built: tools/paper.sh builds it where its packages can be installed")
        return file_digest(self.path)

    def transcode(self, options, scan, cloud, runs):
        return json.loads(output_of([self.path, *self.arguments, *options, scan, cloud, runs]))


class H264:
    """x264 by ffmpeg on the authors' 8-bit image, every frame an intra frame."""

    TIMED_FRAMES = 40

    def __init__(self, pictures):
        self.pictures = Path(pictures)

    def digest(self):
        ffmpeg = shutil.which("ffmpeg")
        if not ffmpeg:
            raise Missing("ffmpeg is not installed")
        if not self.pictures.is_file():
            raise Missing(f"{self.pictures.name} is not built")
        return digest(file_digest(ffmpeg), file_digest(self.pictures), file_digest(__file__))

    def transcode(self, options, scan, cloud, runs):
        columns, crf = options
        with tempfile.TemporaryDirectory() as folder:
            image, coded, back = (Path(folder) / name for name in ("image.gray", "image.h264", "back.gray"))
            made = json.loads(output_of([self.pictures, "image", columns, scan, image]))
            raw = ["-f", "rawvideo", "-pix_fmt", "gray", "-s", f"{columns}x{made['rows']}"]
            # Full range, so that nothing but x264 changes a level; gray would be scaled to a video's 16 to 235.
            x264 = ["-c:v", "libx264", "-pix_fmt", "yuvj420p", "-crf", crf, "-g", "1", "-threads", "1", "-f", "h264"]
            quiet = ["ffmpeg", "-y", "-hide_banner", "-loglevel", "error"]
            output_of([*quiet, *raw, "-i", image, *x264, coded])
            output_of([*quiet, "-i", coded, "-f", "rawvideo", "-pix_fmt", "gray", back])
            output_of([self.pictures, "unimage", columns, made["max_m"], back, cloud])
            encode = decode = None
            if runs > 1:
                encode = self._frame_cost([*raw, "-stream_loop", self.TIMED_FRAMES], image, [*x264, os.devnull])
                many = Path(folder) / "many.h264"
                output_of([*quiet, *raw, "-stream_loop", str(self.TIMED_FRAMES), "-i", image, *x264, many])
                decode = self._frame_cost(["-threads", "1"], many, ["-f", "null", "-"], coded)
            return {"bytes": coded.stat().st_size, "encode": encode, "decode": decode}

    def _frame_cost(self, before, source, after, one=None):
        """Processor time of a frame: of many frames, less what one takes, so that ffmpeg's start is out of it."""
        def seconds(words):
            command = ["ffmpeg", "-y", "-hide_banner", "-benchmark", *map(str, words)]
            done = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL, check=True)
            found = re.search(r"utime=([\d.]+)s stime=([\d.]+)s", done.stderr)
            return float(found[1]) + float(found[2])

        many = seconds([*before, "-i", source, *after])
        single = [0 if word == self.TIMED_FRAMES else word for word in before]
        few = seconds([*single, "-i", one or source, *after])
        ns = max(0, int(1e9 * (many - few) / self.TIMED_FRAMES))
        return {"ns": ns, "cpu_ns": ns, "energy_uj": None}


def named_by(variable):
    """The program that the user points to."""
    program = os.environ.get(variable)
    if not program:
        raise Missing(f"{variable} names no program; no registry has one")
    if not os.access(program, os.X_OK):
        raise Missing(f"{variable}: {program} cannot be run")
    return program


class External:
    """A program in no registry, where the user points to it: `PROGRAM SCAN.bin CLOUD.bin RUNS` prints a driver's JSON."""

    def __init__(self, variable):
        self.variable = variable

    def digest(self):
        program = named_by(self.variable)
        return digest(program, file_digest(program))

    def transcode(self, options, scan, cloud, runs):
        return json.loads(output_of([named_by(self.variable), *options, scan, cloud, runs]))


class GPcc(External):
    """MPEG's test model (tmc3), octree geometry, coordinates in whole steps; times are those that it prints."""

    def transcode(self, options, scan, cloud, runs):
        step_m = float(options[0])
        with tempfile.TemporaryDirectory() as folder:
            given, coded, back = (Path(folder) / name for name in ("given.ply", "coded.bin", "back.ply"))
            given.write_text(ply(round_to_steps(scan, step_m)), encoding="ascii")
            tmc3 = named_by(self.variable)
            encoding = output_of([tmc3, "--mode=0", f"--uncompressedDataPath={given}", f"--compressedStreamPath={coded}",
                                  "--positionQuantizationScale=1", "--mergeDuplicatedPoints=0", "--disableAttributeCoding=1"])
            decoding = output_of([tmc3, "--mode=1", f"--compressedStreamPath={coded}", f"--reconstructedDataPath={back}",
                                  "--outputBinaryPly=0"])
            points = points_of_ply(back.read_text(encoding="ascii"))
            Path(cloud).write_bytes(b"".join(struct.pack("<4f", *(c * step_m for c in point), 0.0) for point in points))
            return {"bytes": coded.stat().st_size, "encode": self._cost(encoding), "decode": self._cost(decoding)}

    @staticmethod
    def _cost(said):
        found = re.search(r"Processing time \(user\):\s*([\d.]+)", said)
        ns = int(1e9 * float(found[1])) if found else None
        return {"ns": ns, "cpu_ns": ns, "energy_uj": None} if found else None


def round_to_steps(scan, step_m):
    """Whole coordinates of a KITTI file's points."""
    return [tuple(round(c / step_m) for c in record[:3]) for record in struct.iter_unpack("<4f", Path(scan).read_bytes())]


def ply(points):
    head = f"ply\nformat ascii 1.0\nelement vertex {len(points)}\n"
    head += "".join(f"property float {axis}\n" for axis in "xyz") + "end_header\n"
    return head + "".join("%d %d %d\n" % point for point in points)


def points_of_ply(text):
    """x, y and z of an ASCII file's vertices, whose first properties they are."""
    head, _, body = text.partition("end_header\n")
    count = int(re.search(r"element vertex (\d+)", head)[1])
    return [tuple(float(word) for word in line.split()[:3]) for line in body.splitlines()[:count]]


def drivers(folder):
    """By the names that configurations have."""
    rust = Path(folder) / "release" / "flicr-rivals"
    return {
        "rust": Built(rust, ["codec"]),
        "draco": Built(Path(folder) / "draco", []),
        "pcl": Built(Path(folder) / "pcl", ["codec"]),
        "h264": H264(rust),
        "gpcc": GPcc("FLICR_TMC3"),
        "rtst": External("FLICR_RTST"),
    }
