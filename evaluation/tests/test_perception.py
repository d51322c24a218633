"""What is counted as found, on made-up detections."""

import tempfile
import unittest
from pathlib import Path

import numpy as np

from evaluation import perception
from evaluation.perception import Variant, View
from evaluation.pointgnn.detector import Detections
from evaluation.scans import Scan

CARS = np.array([[0, 1.5, 10, 4, 1.5, 1.6, 0.3], [6, 1.5, 20, 4.2, 1.4, 1.7, -1.2], [-6, 1.5, 30, 4, 1.5, 1.6, 0]])


class Counting(unittest.TestCase):
    def setUp(self):
        self.view = View(Scan("drive/000000", Path("none")), 1, Path("none"))
        self.moved = CARS + [0.5, 0, 0, 0, 0, 0, 0]
        self.decoded = Variant("decoded")
        self.found = {
            # The third is doubtful in the original: nobody is asked to find it, nor does finding it count as an invention.
            (Variant(), self.view): Detections(CARS, np.array([30.0, 5.0, 0.4])),
            (self.decoded, self.view): Detections(
                np.vstack([CARS[:1], self.moved[1:], CARS[:1] + [30, 0, 0, 0, 0, 0, 0]]), np.array([20.0, 2.0, 9.0, 4.0])
            ),
        }

    def test_strong_cars_of_the_original_are_wanted_and_weaker_ones_may_be_found(self):
        best = perception.overlaps(self.found, self.decoded, [self.view])
        self.assertEqual(len(best), 2)
        self.assertAlmostEqual(best[0], 1)
        self.assertTrue(0.3 < best[1] < 0.9)
        np.testing.assert_allclose(perception.overlaps(self.found, Variant(), [self.view]), 1)

    def test_a_strong_car_where_the_original_has_none_is_an_invention(self):
        self.assertEqual(perception.invented(self.found, self.decoded, [self.view]), 1)
        self.assertEqual(perception.invented(self.found, Variant(), [self.view]), 0)

    def test_labels_are_wanted_where_there_are_some(self):
        with tempfile.TemporaryDirectory() as folder:
            labels = Path(folder) / "labels.txt"
            labels.write_text(
                "Car 0 0 0 1 2 3 4 1.5 1.6 4 0 1.5 10 0.3\nVan 0 0 0 1 2 3 4 1.5 1.6 4 20 1.5 10 0.3\n", encoding="utf-8"
            )
            view = View(self.view.scan, 0, Path("none"), labels)
            found = {(self.decoded, view): self.found[self.decoded, self.view]}
            np.testing.assert_allclose(perception.overlaps(found, self.decoded, [view]), [1])

    def test_clouds_are_read_without_the_point_at_the_origin(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "cloud.bin"
            points = np.array([[1, 2, 3, 0.5], [0, 0, 0, 0], [4, 5, 6, 0]], "<f4")
            path.write_bytes(points.tobytes())
            np.testing.assert_array_equal(perception.read_cloud(path), points[[0, 2]])


if __name__ == "__main__":
    unittest.main()
