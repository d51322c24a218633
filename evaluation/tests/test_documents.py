"""The documents' tables are evaluation/results.json's numbers."""

import json
import unittest

from evaluation import documents


class DocumentsTest(unittest.TestCase):
    def test_documents_hold_what_was_measured(self):
        self.assertEqual(documents.differing(False), [], "python3 -m evaluation.documents write")

    def test_every_table_is_somewhere(self):
        text = "".join((documents.ROOT / name).read_text(encoding="utf-8") for name in documents.DOCUMENTS)
        results = json.loads(documents.RESULTS.read_text(encoding="utf-8"))
        # Those of the tasks need a run with all that the tasks need.
        waiting = {"tasks": "odometry", "metrics": "metric_fit"}
        measured = {name for name in documents.TABLES if waiting.get(name, "about") in results}
        self.assertEqual({found[1] for found in documents.BLOCK.findall(text)}, measured)

    def test_a_changed_number_is_seen(self):
        results = json.loads(documents.RESULTS.read_text(encoding="utf-8"))
        text = (documents.ROOT / "docs/PERFORMANCE.md").read_text(encoding="utf-8")
        for section in ("range_images", "rate_distortion", "existing_methods"):
            results[section]["uniform-4500"]["bytes"] += 1
        self.assertNotEqual(documents.rendered(text, results), text)

    def test_the_results_are_of_a_full_run(self):
        about = json.loads(documents.RESULTS.read_text(encoding="utf-8"))["about"]
        self.assertFalse(about["quick"] or about["simulated"])
        self.assertGreaterEqual(about["scans"], 5)
