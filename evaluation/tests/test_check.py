"""SciPy's side of the metrics' check: distances that a ruler finds, and that a difference is seen."""

import math
import tempfile
import unittest
from pathlib import Path

import numpy

from evaluation import check


class CheckTest(unittest.TestCase):
    ORIGINAL = numpy.array([[3.0, 0, 0], [0, 4, 0], [0, 4.5, 0]])
    DECODED = numpy.array([[3.0, 0, 0.25], [0, 4, 0]])

    def test_distances(self):
        found = check.measures(self.ORIGINAL, self.DECODED)
        self.assertAlmostEqual(found["cd_m2"], 0.0625 / 2 + (0.0625 + 0.25) / 3)
        self.assertAlmostEqual(found["psnr_db"], 10 * math.log10(6400 / (0.0625 / 2)))
        self.assertEqual((found["max_error_m"], found["max_error_reverse_m"]), (0.25, 0.5))
        self.assertAlmostEqual(found["se"], 1 / 3)

    def test_more_points_than_there_were(self):
        found = check.measures(self.DECODED, self.ORIGINAL)
        self.assertIsNone(found["se"])
        self.assertIsNone(found["epsnr_db"])

    def test_equal_clouds(self):
        found = check.measures(self.ORIGINAL, self.ORIGINAL)
        self.assertIsNone(found["psnr_db"])
        self.assertEqual((found["se"], found["cd_m2"]), (0, 0))

    def test_a_difference_is_seen(self):
        found = check.measures(self.ORIGINAL, self.DECODED)
        self.assertEqual(check.disagreements(found, found), [])
        self.assertEqual(len(check.disagreements({**found, "psnr_db": found["psnr_db"] + 1e-4}, found)), 1)
        self.assertEqual(len(check.disagreements({**found, "se": None}, found)), 1)

    def test_points_at_the_origin_are_no_returns(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "scan.bin"
            numpy.array([[0, 0, 0, 1], [1, 2, 3, 0]], "<f4").tofile(path)
            self.assertEqual(check.read_returns(path).tolist(), [[1, 2, 3]])
