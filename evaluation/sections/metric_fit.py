"""What ePSNR is worth."""

import importlib.util
from dataclasses import dataclass
from typing import Callable

import numpy as np

from .. import figures, metric_fit, odometry, paper_tasks, perception, store
from ..perception import Variant
from ..report import Section

THRESHOLDS = (0.3, 0.5, 0.7)
# Fewer configurations rank nothing.
FEWEST = 6
FITTED = "ePSNR, fitted"
RANK_HEADINGS = ["metric", "Spearman's rho", "95 %", "Kendall's tau", "95 % ", "better than PSNR, % of draws", "left out"]


@dataclass(frozen=True)
class Task:
    """Its samples (configurations, samples), the function that makes each configuration's score of them, and what that is."""

    units: np.ndarray
    score: Callable
    what: str

    @property
    def scores(self):
        return self.score(self.units)


def section(run):
    made = Section("metric_fit", "What ePSNR is worth")
    made.text(
        "A quality metric is worth something if it ranks configurations as the tasks do. <i>ePSNR</i> is the paper's, with alpha = -0.15 "
        "and beta = 0.5. Intervals come from drawing configurations and samples (cars, steps) again with replacement. <i>Left "
        "out</i>: root mean square error of a configuration's score, predicted by a logistic curve of the metric that was fitted to "
        f"all others. For <i>{FITTED}</i>, alpha and beta were fitted with the curve, anew each time: a grid of both first, then "
        "least squares from its four best cells. A score of 1 is 'as on the original'."
    )
    chosen = perception.settings(run)
    tasks, qualities = {}, []
    if len(chosen) >= FEWEST:
        tasks = _tasks(run, chosen)
        qualities = [_quality(name, own) for name, own in perception.measured(run, chosen).items()]
    else:
        made.text(f"Fewer than {FEWEST} configurations (--quick): only the paper's own numbers are looked at.")
    made.numbers["tasks"] = {name: _task(made, run, name, task, qualities) for name, task in tasks.items()}
    made.numbers["paper"] = _of_the_paper(made, run)
    made.plot(
        "metric_fit",
        "Above: the paper's figure, redrawn from its numbers (recall at IoU 0.5 as a share of the original's, mean of six models). "
        "Below: the same of our runs (preset uniform). Metrics are gray, in dB, on the right axis.",
        _figure(qualities, tasks),
    )
    return made


def _tasks(run, chosen):
    tasks = {}
    data = perception.detection_data(run)
    if data:
        found = perception.detections(run, chosen, data)
        drive = [view for view in data[1] if not view.labels]
        best = np.array([perception.overlaps(found, Variant(one), drive) for one in chosen])
        # Of each car, the share of thresholds at which it counts as found: their mean is the mean recall.
        units = np.mean([best >= threshold for threshold in THRESHOLDS], axis=0)
        what = f"recall of the original's {best.shape[1]} cars, mean over IoU 0.3, 0.5 and 0.7"
        tasks["detection"] = Task(units, lambda sample: sample.mean(axis=1), what)
    if importlib.util.find_spec("kiss_icp") is not None:
        poses = perception.trajectories(run, chosen)
        originals = poses[perception.ORIGINAL]
        floor = float(np.mean(odometry.step_squares(originals)))
        units = np.array([odometry.step_squares(poses[one.name], originals) for one in chosen])
        what = f"the noise floor as a share of the difference of a step, over {units.shape[1]} steps"
        tasks["odometry"] = Task(units, lambda sample: np.minimum(np.sqrt(floor / sample.mean(axis=1)), 1.0), what)
    return tasks


def _quality(name, measured):
    """None is an infinite PSNR: a cloud without any error."""

    def mean(key):
        return float(np.mean([metric_fit.BEST_PSNR_DB if one[key] is None else one[key] for one in measured]))

    return metric_fit.Quality(name, mean("se"), mean("psnr_db"), mean("psnr_reverse_db"), mean("cd_m2"))


def _task(made, run, name, task, qualities):
    values = metric_fit.metrics(qualities)
    lists = {metric: column.tolist() for metric, column in values.items()}
    key = [lists, task.units.tolist(), task.what, store.source_digest(metric_fit)]
    ranked, fits, fitted = run.store.get("metric-fit", key, lambda: _computed(values, task, qualities))
    rows = [_rank_row(metric, ranking, fits[metric]) for metric, ranking in ranked.items()]
    rows.append([FITTED, fitted["rho"], None, fitted["tau"], None, None, fitted["left_out_error"]])
    rows.append(["no metric: the others' mean", *[None] * 5, metric_fit.mean_error(task.scores)])
    caption = f"{name.capitalize()}: {task.what}; {len(qualities)} configurations"
    made.table(f"metric_fit_{name}", caption, RANK_HEADINGS, rows, [None, 2, None, 2, None, 0, 3])
    made.text(
        f"Fitted to {name}: alpha = {fitted['alpha']:.2f} ({_span(fitted['alpha_range'])} with one configuration left out), beta = "
        f"{fitted['beta']:.2f} ({_span(fitted['beta_range'])}; searched from {_span(metric_fit.BETA_RANGE)}), "
        f"half the score at {fitted['level']:.1f} dB; error {fitted['error']:.3f} on what it was fitted to, "
        f"{fitted['left_out_error']:.3f} on what was left out."
    )
    scores = dict(zip((one.name for one in qualities), task.scores.tolist()))
    none = metric_fit.mean_error(task.scores)
    return {"scores": scores, "rankings": ranked, "fits": fits, "fitted_epsnr": fitted, "mean_error": none}


def _span(pair):
    return "{:.2f} to {:.2f}".format(*pair)


def _rank_row(metric, ranking, fit):
    intervals = [_span(ranking[key]) for key in ("rho_interval", "tau_interval")]
    better = None if metric == metric_fit.PSNR else 100 * ranking["beats_psnr"]
    return [metric, ranking["rho"], intervals[0], ranking["tau"], intervals[1], better, fit["left_out_error"]]


def _computed(values, task, qualities):
    ranked = {name: vars(one) for name, one in metric_fit.rankings(values, task.units, task.score).items()}
    fits = {name: vars(metric_fit.fit_curve(metric, task.scores)) for name, metric in values.items()}
    psnr, se = values[metric_fit.PSNR], np.array([one.sampling_error for one in qualities])
    fit = metric_fit.fit_epsnr(psnr, se, task.scores)
    rho, tau = metric_fit.rank_agreement(metric_fit.epsnr(psnr, se, fit.alpha, fit.beta), task.scores)
    return ranked, fits, {**vars(fit), "rho": rho, "tau": tau}


def _of_the_paper(made, run):
    """The paper's recalls against the metrics that it gives for the same frames."""
    psnr, se = np.array(paper_tasks.PSNR_DB), np.array(paper_tasks.SE)
    values = {metric_fit.PSNR: psnr, "PSNR x (1 - SE)": psnr * (1 - se), "1 - SE": 1 - se, "ePSNR": metric_fit.epsnr(psnr, se)}

    def computed(scores):
        fits = {name: vars(metric_fit.fit_curve(metric, scores)) for name, metric in values.items()}
        return {**fits, FITTED: vars(metric_fit.fit_epsnr(psnr, se, scores))}

    rows, numbers = [], {}
    for threshold in THRESHOLDS:
        scores = np.array(paper_tasks.mean_share(threshold))
        key = [scores.tolist(), psnr.tolist(), se.tolist(), store.source_digest(metric_fit)]
        numbers[f"{threshold:g}"] = fits = run.store.get("metric-fit-paper", key, lambda: computed(scores))
        for name, fit in fits.items():
            rho = metric_fit.rank_agreement(values[name], scores)[0] if name in values else None
            rows.append([f"{threshold:g}", name, rho, fit["error"], fit["left_out_error"], fit["alpha"], fit["beta"]])
        rows.append([f"{threshold:g}", "no metric: the others' mean", None, None, metric_fit.mean_error(scores), None, None])
    made.table(
        "metric_fit_paper",
        "The paper's own six frames: its recalls (share of the original's, mean of six models) against its metrics",
        ["IoU", "metric", "Spearman's rho", "error", "left out", "alpha", "beta"],
        rows,
        [None, None, 2, 3, 3, 2, 2],
    )
    made.text(
        "On the paper's own frames every metric falls from each width to the next, PSNR among them, and so does recall: all rank alike. "
        "Six frames that differ in nothing but width cannot show that one metric ranks better; they show shape, and once a "
        "curve is allowed between metric and recall, PSNR predicts about as well as ePSNR does. Only frames that differ "
        "in range steps as well as in lost points tell metrics apart."
    )
    return numbers


def _figure(qualities, tasks):
    figure, (above, below) = figures.figure(9, 8, rows=2)
    columns = zip(paper_tasks.WIDTHS, paper_tasks.SE, paper_tasks.PSNR_DB)
    # What the paper does not give is not drawn.
    paper = [metric_fit.Quality(str(width), se, psnr_db, psnr_db, 1.0) for width, se, psnr_db in columns]
    _curves(above, paper, {"recall, IoU 0.5": paper_tasks.mean_share(0.5)})
    above.set_title("the paper")
    rows = [index for index, one in enumerate(qualities) if one.name.startswith("uniform-")]
    if rows:
        _curves(below, [qualities[index] for index in rows], {name: task.scores[rows] for name, task in tasks.items()})
        below.set_title("ours")
    else:
        below.set_visible(False)
    return figure


def _curves(axes, qualities, scores):
    ticks = [one.name.removeprefix("uniform-") for one in qualities]
    for name, values in scores.items():
        axes.plot(ticks, values, "o-", label=name)
    axes.set(ylim=(0, 1.05), xlabel="columns", ylabel="share of the original's")
    metrics = metric_fit.metrics(qualities)
    right = axes.twinx()
    for name, style in ((metric_fit.PSNR, "--"), ("ePSNR", "-."), ("PSNR x (1 - SE)", ":")):
        right.plot(ticks, metrics[name], style, color="gray", label=name)
    right.set(ylim=(0, 80), ylabel="dB")
    right.grid(False)
    axes.legend(loc="lower left")
    right.legend(loc="upper right")
