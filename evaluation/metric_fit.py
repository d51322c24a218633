"""What a quality metric is worth: does it rank configurations as the tasks do, and can ePSNR's parameters be fitted to a task?

A task's score is 1 where its result cannot be told from that on the original cloud, and falls to 0. Metrics are turned so that
more is better. A metric predicts a score through a logistic curve, which has a level and a width to be fitted: quality beyond what
the task needs is worth nothing, which no straight line can say. ePSNR's alpha and beta are fitted together with those two.
Everything is judged by leaving one configuration out, fitting to the rest, and predicting it.
"""

from dataclasses import dataclass

import numpy as np
from scipy import optimize, stats

PAPER_ALPHA, PAPER_BETA = -0.15, 0.5
# The paper's PSNR, with which the others are compared.
PSNR = "PSNR, decoded to original"
# The metrics of clouds that came back without any error, which have no PSNR.
BEST_PSNR_DB = 120.0
ALPHA_RANGE, BETA_RANGE = (-1.0, 1.0), (0.05, 5.0)


@dataclass(frozen=True)
class Quality:
    """A configuration's metrics, mean over scans. `psnr_db` is the paper's: from the decoded cloud to the original.

    `back_psnr_db` is from the original to the decoded: lost points count. `cd_m2` is the sum of both mean squared distances.
    """

    name: str
    sampling_error: float
    psnr_db: float
    back_psnr_db: float
    cd_m2: float


def epsnr(psnr_db, sampling_error, alpha=PAPER_ALPHA, beta=PAPER_BETA):
    """The paper's equation 8: PSNR x (1 - SE x (F(SE) + alpha)), F = e^(-(1 - SE) / beta), F + alpha kept within 0 and 1."""
    lost = np.clip(np.exp(-(1 - np.asarray(sampling_error)) / beta) + alpha, 0, 1)
    return np.asarray(psnr_db) * (1 - sampling_error * lost)


def metrics(qualities):
    """Each metric's values over configurations, more being better."""
    se = np.array([quality.sampling_error for quality in qualities])
    psnr = np.minimum([quality.psnr_db for quality in qualities], BEST_PSNR_DB)
    back = np.minimum([quality.back_psnr_db for quality in qualities], BEST_PSNR_DB)
    cd = np.maximum([quality.cd_m2 for quality in qualities], 1e-12)
    return {
        PSNR: psnr,
        "PSNR, original to decoded": back,
        "PSNR, the worse way": np.minimum(psnr, back),
        "PSNR x (1 - SE)": psnr * (1 - se),
        "CD": -10 * np.log10(cd),
        "1 - SE": 1 - se,
        "ePSNR": epsnr(psnr, se),
    }


def rank_agreement(metric, scores):
    """Spearman's rho and Kendall's tau of a metric with a task's scores; nan where one of them is all the same."""
    if np.ptp(metric) == 0 or np.ptp(scores) == 0:
        return float("nan"), float("nan")
    return float(stats.spearmanr(metric, scores).statistic), float(stats.kendalltau(metric, scores).statistic)


@dataclass(frozen=True)
class Ranking:
    """How one metric ranks, with 95 % intervals from resampling; `beats_psnr`: in which share of the resamplings its rho is
    higher than PSNR's (decoded to original), ties counted half."""

    rho: float
    rho_interval: tuple
    tau: float
    tau_interval: tuple
    beats_psnr: float


def rankings(values, units, score, seed=1, resamplings=1000):
    """The `Ranking` of each metric. `units` (configurations, samples) are what the task's scores are made of (cars, steps):
    both configurations and samples are drawn again with replacement, so that the interval holds for others like them."""
    rng = np.random.default_rng(seed)
    configurations, samples = units.shape
    found = {name: rank_agreement(metric, score(units)) for name, metric in values.items()}
    drawn = {name: [] for name in values}
    for _ in range(resamplings):
        rows = rng.integers(configurations, size=configurations)
        scores = score(units[np.ix_(rows, rng.integers(samples, size=samples))])
        for name, metric in values.items():
            drawn[name].append(rank_agreement(metric[rows], scores))
    drawn = {name: np.array(pairs) for name, pairs in drawn.items()}
    reference = drawn[PSNR][:, 0]
    result = {}
    for name, (rho, tau) in found.items():
        intervals = [tuple(map(float, np.nanquantile(column, (0.025, 0.975)))) for column in drawn[name].T]
        both = np.isfinite(reference) & np.isfinite(drawn[name][:, 0])
        ahead = np.sign(np.round(drawn[name][both, 0] - reference[both], 12))
        result[name] = Ranking(rho, intervals[0], tau, intervals[1], float(np.mean((ahead + 1) / 2)))
    return result


@dataclass(frozen=True)
class Fit:
    """A logistic curve through a task's scores; `alpha` and `beta` where they were fitted too. Errors are root mean squares of the
    score: over all configurations, and of each predicted from the others."""

    level: float
    width: float
    error: float
    left_out_error: float
    alpha: float | None = None
    beta: float | None = None
    # Least and most of each when one configuration is left out: how far the data fix them.
    alpha_range: tuple | None = None
    beta_range: tuple | None = None


def logistic(metric, level, width):
    return 1 / (1 + np.exp(-np.clip((np.asarray(metric) - level) / width, -60, 60)))


def fit_curve(metric, scores):
    """A curve of a metric as it is."""

    def solve(kept):
        return _solve_curve(metric[kept], scores[kept])

    def predict(parameters):
        return logistic(metric, *parameters)

    parameters = solve(slice(None))
    left_out, _ = _left_out(solve, predict, scores)
    return Fit(*parameters, _rms(predict(parameters) - scores), left_out)


def fit_epsnr(psnr_db, sampling_error, scores):
    """A curve of ePSNR with the alpha and beta that predict best.

    The error is not convex in alpha and beta (F + alpha is clamped): a grid is searched first, then refined from its best cells.
    """

    def solve(kept):
        return _solve_epsnr(psnr_db[kept], sampling_error[kept], scores[kept])

    def predict(parameters):
        alpha, beta, level, width = parameters
        return logistic(epsnr(psnr_db, sampling_error, alpha, beta), level, width)

    alpha, beta, level, width = parameters = solve(slice(None))
    left_out, solutions = _left_out(solve, predict, scores)
    alphas, betas = ((min(column), max(column)) for column in list(zip(*solutions))[:2])
    return Fit(level, width, _rms(predict(parameters) - scores), left_out, alpha, beta, alphas, betas)


def mean_error(scores):
    """The left-out error of no metric at all: each configuration predicted as the mean of the others."""
    others = (scores.sum() - scores) / (len(scores) - 1)
    return _rms(others - scores)


def _solve_curve(metric, scores):
    """Level and width of least squares: from the best cell of a grid, since a curve can be caught where it is flat."""
    low, high = float(metric.min()), float(metric.max())
    span = max(high - low, 1e-9)
    levels = np.linspace(low - span, high, 41)
    widths = span * np.geomspace(0.005, 3, 24)
    curves = logistic(metric, levels[:, None, None], widths[:, None])
    cell = np.argmin(np.square(curves - scores).sum(axis=-1))
    start = levels[cell // len(widths)], np.log(widths[cell % len(widths)])
    bounds = ((low - 3 * span, np.log(span / 1000)), (high + span, np.log(span * 10)))
    found = optimize.least_squares(lambda p: logistic(metric, p[0], np.exp(p[1])) - scores, start, bounds=bounds, max_nfev=100)
    return float(found.x[0]), float(np.exp(found.x[1]))


def _solve_epsnr(psnr_db, sampling_error, scores):
    def cost(alpha, beta):
        metric = epsnr(psnr_db, sampling_error, alpha, beta)
        level, width = _linear_curve(metric, scores)
        return _rms(logistic(metric, level, width) - scores), level, width

    alphas, betas = np.linspace(-0.6, 0.9, 16), np.geomspace(*BETA_RANGE, 14)
    grid = [(*cost(alpha, beta), alpha, beta) for alpha in alphas for beta in betas]
    grid.sort(key=lambda cell: cell[0])
    best = None
    for _, level, width, alpha, beta in grid[:4]:
        found = optimize.least_squares(
            lambda p: logistic(epsnr(psnr_db, sampling_error, p[0], np.exp(p[1])), p[2], np.exp(p[3])) - scores,
            (alpha, np.log(beta), level, np.log(width)),
            bounds=tuple(zip(ALPHA_RANGE, np.log(BETA_RANGE) + [-1e-9, 1e-9], (-400, 400), (-7, 7))),
            max_nfev=100,
        )
        if best is None or found.cost < best.cost:
            best = found
    alpha, beta, level, width = best.x
    return float(alpha), float(np.exp(beta)), float(level), float(np.exp(width))


def _linear_curve(metric, scores):
    """A rough curve at once: a straight line through the scores' logits, each weighed by how steep the curve is there."""
    clipped = np.clip(scores, 0.02, 0.98)
    weight = clipped * (1 - clipped)
    mean = np.average(metric, weights=weight)
    logits = np.log(clipped / (1 - clipped))
    spread = np.average((metric - mean) ** 2, weights=weight)
    slope = np.average((metric - mean) * (logits - np.average(logits, weights=weight)), weights=weight) / max(spread, 1e-12)
    slope = max(slope, 1e-3)
    return float(mean - np.average(logits, weights=weight) / slope), float(np.clip(1 / slope, 1e-2, 1e3))


def _left_out(solve, predict, scores):
    """Root mean square error of each score predicted from the others, and the parameters that they gave."""
    solutions = [solve(np.arange(len(scores)) != index) for index in range(len(scores))]
    errors = [predict(parameters)[index] - scores[index] for index, parameters in enumerate(solutions)]
    return _rms(np.array(errors)), solutions


def _rms(values):
    return float(np.sqrt(np.mean(np.square(values))))
