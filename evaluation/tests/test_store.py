"""Results are made once, and anew when what they depend on changes."""

import tempfile
import unittest
from pathlib import Path

from evaluation.store import Store, file_digest


class StoreTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.store = Store(self.folder / "cache")
        self.calls = 0

    def compute(self):
        self.calls += 1
        return {"value": self.calls, "infinite": None}

    def test_a_result_is_computed_once(self):
        first = self.store.get("kind", ["a", 1], self.compute)
        again = Store(self.folder / "cache").get("kind", ["a", 1], self.compute)
        self.assertEqual((first, again, self.calls), ({"value": 1, "infinite": None},) * 2 + (1,))
        self.assertEqual(self.store.get("kind", ["a", 2], self.compute)["value"], 2)
        self.assertEqual(self.store.get("other", ["a", 1], self.compute)["value"], 3)

    def test_a_failure_is_not_kept(self):
        def fails():
            raise RuntimeError("no")

        with self.assertRaises(RuntimeError):
            self.store.get("kind", ["b"], fails)
        self.assertEqual(self.store.get("kind", ["b"], self.compute)["value"], 1)

    def test_a_damaged_result_is_made_anew(self):
        self.store.get("kind", ["c"], self.compute)
        [path] = (self.folder / "cache" / "kind").glob("*.json")
        path.write_text("{", encoding="utf-8")
        self.assertEqual(self.store.get("kind", ["c"], self.compute)["value"], 2)

    def test_a_file_is_there_whole_or_not_at_all(self):
        def half(path):
            path.write_bytes(b"half")
            raise RuntimeError("no")

        with self.assertRaises(RuntimeError):
            self.store.file("clouds", ["d"], ".bin", half)
        self.assertEqual(list((self.folder / "cache" / "clouds").iterdir()), [])
        path = self.store.file("clouds", ["d"], ".bin", lambda path: path.write_bytes(b"whole"))
        self.assertEqual((path.read_bytes(), path.suffix), (b"whole", ".bin"))

    def test_a_changed_file_has_another_digest(self):
        path = self.folder / "file"
        path.write_bytes(b"one")
        before = file_digest(path)
        path.write_bytes(b"three")
        self.assertNotEqual(before, file_digest(path))
