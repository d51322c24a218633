"""The paper's figures as they were read off its tables."""

import unittest

from evaluation import check, paper_numbers
from evaluation.configurations import ALL, WIDTHS, group, named


class PaperTest(unittest.TestCase):
    def test_its_epsnr_follows_from_its_psnr_and_se(self):
        for columns, p in paper_numbers.WIDTHS.items():
            epsnr_db = p["psnr_db"] * (1 - p["se"] * check.lost_share(p["se"]))
            # Both are means over 100 scans, of which a product is not quite the product.
            self.assertAlmostEqual(epsnr_db, p["epsnr_db"], delta=0.4, msg=columns)

    def test_all_its_widths_are_measured(self):
        self.assertEqual(tuple(paper_numbers.WIDTHS), WIDTHS)
        for kind in ("paper", "uniform", "authors"):
            for columns in WIDTHS:
                self.assertEqual(named(f"{kind}-{columns}").name, f"{kind}-{columns}")

    def test_names_are_unique(self):
        self.assertEqual(len({c.name for c in ALL}), len(ALL))
        self.assertTrue(all(c.stages for c in ALL if c.is_ours))
        self.assertTrue(group("tasks") and group("quick") and not group("no such group"))
