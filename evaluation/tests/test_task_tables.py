"""The documents' tables of the tasks, from made-up results."""

import unittest

from evaluation import documents, metric_fit

FOUND = {"recall_0.3": 1.0, "recall_0.5": 0.5, "recall_0.7": 0.25, "mean_iou": 0.6}
RANKED = {"rho": 0.5, "rho_interval": [0.25, 0.75]}
TASK = {
    "rankings": {metric_fit.PSNR: RANKED, "ePSNR": RANKED},
    "fits": {metric_fit.PSNR: {"left_out_error": 0.125}, "ePSNR": {"left_out_error": 0.0625}},
    "fitted_epsnr": {"rho": 0.75, "left_out_error": 0.03125},
    "mean_error": 0.25,
}


class Tables(unittest.TestCase):
    def test_tasks(self):
        results = {
            "odometry": {"floor": {"step_m": 0.013}, "configurations": {"dense-20mm": {"step_m": 0.02, "step_p": 0.5}}},
            "detection": {"floor": FOUND, "agreement": {"dense-20mm": FOUND}},
            "range_images": {"dense-20mm": {"bytes": 45000}},
        }
        rows = documents.tasks(results).splitlines()
        self.assertTrue(rows[2].endswith("|  | 13.0 |  | 100 | 50 | 25 | 0.60 |"), rows[2])
        self.assertTrue(rows[3].endswith("| 45.0 | 20.0 | 0.50 | 100 | 50 | 25 | 0.60 |"), rows[3])

    def test_metrics(self):
        rows = documents.metrics({"metric_fit": {"tasks": {"detection": TASK, "odometry": TASK}}}).splitlines()
        self.assertEqual(rows[3], "| ePSNR | 0.50 (0.25 to 0.75) | 0.062 | 0.50 (0.25 to 0.75) | 0.062 |")
        self.assertEqual(rows[4], "| ePSNR, fitted to the task | 0.75 | 0.031 | 0.75 | 0.031 |")
        self.assertEqual(rows[5], "| none |  | 0.250 |  | 0.250 |")


if __name__ == "__main__":
    unittest.main()
