"""The report is one file that needs no other, and its tables and plots are files too."""

import json
import math
import re
import tempfile
import unittest
from pathlib import Path

from evaluation import figures, page
from evaluation.report import Section


class PageTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.out = Path(folder.name)
        section = Section("one", "One & only")
        section.text("Some <b>text</b>.")
        section.table("sizes", "Sizes", ["system", "bytes"], [["a<b", 12345.6], ["none", None], ["all", math.inf]], [None, 0], frozenset({1}))
        fig, axes = figures.figure()
        axes.plot([1, 2], [3, 4])
        section.plot("curve", "A curve", fig)
        section.numbers = {"a": 1.5, "infinite": math.inf, "deep": {"b": [1, math.nan]}}
        page.write(self.out, "<h1>Head</h1>", [section])
        self.html = (self.out / "index.html").read_text(encoding="utf-8")

    def test_nothing_is_fetched(self):
        self.assertEqual(re.findall(r'(?:src|href)="(?!#|data:|sizes\.csv)[^"]*"', self.html.replace("xlink:href", "xlink")), [])

    def test_cells(self):
        self.assertIn("a&lt;b", self.html)
        self.assertIn('<td class="number">12,346</td>', self.html)
        self.assertIn('<tr class="paper"><td>none</td><td class="number">–</td>', self.html)
        self.assertIn("One &amp; only", self.html)
        self.assertEqual((self.out / "sizes.csv").read_text(encoding="utf-8"), "system,bytes\na<b,12345.6\nnone,\nall,inf\n")

    def test_plots_and_numbers(self):
        self.assertTrue((self.out / "curve.png").read_bytes().startswith(b"\x89PNG"))
        self.assertIn("<svg", self.html)
        numbers = json.loads((self.out / "results.json").read_text(encoding="utf-8"))
        self.assertEqual(numbers, {"one": {"a": 1.5, "infinite": None, "deep": {"b": [1, None]}}})
