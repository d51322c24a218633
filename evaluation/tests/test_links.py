"""Latency over a link, by hand."""

import unittest

from evaluation.sections import links


class LinksTest(unittest.TestCase):
    def test_a_megabit_link(self):
        index = [name for name, _, _ in links.LINKS].index("1 Mbit radio")
        _, rate, round_trip = links.LINKS[index]
        self.assertEqual(rate, 1.0)
        # 10,000 bytes are 80,000 bits: 80 ms.
        self.assertAlmostEqual(links.latencies(5.0, 10_000, 2.0)[index], 5 + 80 + round_trip / 2 + 2)
        self.assertTrue(links.fits(12_500)[index])
        self.assertFalse(links.fits(12_501)[index])

    def test_what_a_link_cannot_carry_is_in_brackets(self):
        self.assertEqual(links.shown(12.34, True), "12.3")
        self.assertEqual(links.shown(1234.5, False), "(1,234)")
