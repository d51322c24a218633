"""Drivers that are not here say so; what is read and written around other programs."""

import os
import struct
import tempfile
import unittest
from pathlib import Path

from evaluation import rivals


class RivalsTest(unittest.TestCase):
    def test_what_is_not_here_is_missing(self):
        with tempfile.TemporaryDirectory() as folder:
            drivers = rivals.drivers(folder)
            for name in ("rust", "draco", "pcl", "h264"):
                with self.assertRaises(rivals.Missing):
                    drivers[name].digest()
        os.environ.pop("FLICR_TMC3", None)
        with self.assertRaises(rivals.Missing):
            rivals.drivers("none")["gpcc"].digest()

    def test_ply_there_and_back(self):
        with tempfile.TemporaryDirectory() as folder:
            scan = Path(folder) / "scan.bin"
            scan.write_bytes(struct.pack("<8f", 1.004, -2.0, 0.5, 0.3, 0.0, 0.0049, 7.0, 0.1))
            points = rivals.round_to_steps(scan, 0.01)
        self.assertEqual(points, [(100, -200, 50), (0, 0, 700)])
        self.assertEqual(rivals.points_of_ply(rivals.ply(points)), points)
