"""ePSNR, rankings and fits, on the paper's own numbers and on made-up tasks whose answer is known."""

import unittest

import numpy as np

from evaluation import metric_fit, paper_tasks


class Epsnr(unittest.TestCase):
    def test_is_the_papers(self):
        found = metric_fit.epsnr(np.array(paper_tasks.PSNR_DB), np.array(paper_tasks.SE))
        # The paper computed from values of more digits than it prints.
        np.testing.assert_allclose(found, paper_tasks.EPSNR_DB, rtol=0.008)

    def test_nothing_lost_is_psnr_and_the_clamp_holds(self):
        self.assertEqual(metric_fit.epsnr(70.0, 0.0), 70)
        self.assertAlmostEqual(metric_fit.epsnr(60.0, 0.5, alpha=1, beta=5), 30)
        self.assertAlmostEqual(metric_fit.epsnr(60.0, 0.5, alpha=-1, beta=0.1), 60)


class Rankings(unittest.TestCase):
    def test_metrics_are_turned_so_that_more_is_better(self):
        better = metric_fit.Quality("a", 0.0, 80.0, 80.0, 1e-4)
        worse = metric_fit.Quality("b", 0.5, 60.0, 50.0, 1e-2)
        for name, (one, other) in metric_fit.metrics([better, worse]).items():
            self.assertGreater(one, other, name)

    def test_the_metric_that_the_task_follows_wins(self):
        rng = np.random.default_rng(13)
        truth = np.linspace(0, 1, 12)
        units = np.clip(truth[:, None] + rng.normal(scale=0.05, size=(12, 30)), 0, 1)
        values = {metric_fit.PSNR: rng.permutation(truth), "right": truth}
        found = metric_fit.rankings(values, units, lambda sample: sample.mean(axis=1), resamplings=100)
        self.assertGreater(found["right"].rho, 0.95)
        self.assertGreater(found["right"].beats_psnr, 0.95)
        self.assertEqual(found[metric_fit.PSNR].beats_psnr, 0.5)
        low, high = found["right"].rho_interval
        self.assertLessEqual(low, found["right"].rho)
        self.assertGreaterEqual(high + 0.05, found["right"].rho)

    def test_a_flat_task_ranks_nothing(self):
        self.assertTrue(np.isnan(metric_fit.rank_agreement(np.arange(4.0), np.ones(4))[0]))


class Fits(unittest.TestCase):
    def setUp(self):
        # All combinations of few and many lost points with fine and coarse ranges.
        psnr, se = np.meshgrid([55.0, 60, 66, 75, 90], [0.0, 0.1, 0.4, 0.6, 0.8, 0.9])
        self.psnr, self.se = psnr.ravel(), se.ravel()

    def test_alpha_and_beta_of_a_task_made_with_them_are_found(self):
        scores = metric_fit.logistic(metric_fit.epsnr(self.psnr, self.se, 0.2, 0.4), 45.0, 6.0)
        found = metric_fit.fit_epsnr(self.psnr[::2], self.se[::2], scores[::2])
        np.testing.assert_allclose((found.alpha, found.beta, found.level, found.width), (0.2, 0.4, 45.0, 6.0), rtol=0.01)
        np.testing.assert_allclose((*found.alpha_range, *found.beta_range), (0.2, 0.2, 0.4, 0.4), rtol=0.02)
        self.assertLess(found.left_out_error, 1e-3)

    def test_a_curve_predicts_what_was_left_out_and_the_wrong_metric_does_not(self):
        scores = metric_fit.logistic(self.psnr, 65.0, 4.0)
        right, wrong = metric_fit.fit_curve(self.psnr, scores), metric_fit.fit_curve(1 - self.se, scores)
        self.assertLess(right.left_out_error, 1e-3)
        self.assertGreater(wrong.left_out_error, 0.2)
        self.assertAlmostEqual(right.level, 65, places=2)
        self.assertGreater(wrong.left_out_error, 0.8 * metric_fit.mean_error(scores))


class Paper(unittest.TestCase):
    def test_every_row_has_a_number_for_each_width_and_the_original(self):
        for rows in paper_tasks.RECALL.values():
            self.assertEqual({len(row) for row in rows.values()}, {len(paper_tasks.WIDTHS) + 1})
        self.assertEqual(set(paper_tasks.LOAM), {"original", *paper_tasks.WIDTHS})


if __name__ == "__main__":
    unittest.main()
