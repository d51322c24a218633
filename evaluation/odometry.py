"""LiDAR odometry on decoded clouds, with KISS-ICP, against its own result on the original ones.

KISS-ICP keeps the first points that fall into a voxel, so that the order of the points alone moves a pose by a centimeter or
more, and a decoder gives points in another order than the sensor did. Every cloud is therefore shuffled, several times each; how
far apart several shuffles of the original come out is the noise floor, under which no difference is one.
"""

from dataclasses import dataclass
from itertools import combinations

import numpy as np

# Nearer points are the car itself, and the 'no return' at the origin that some files hold.
NEAREST_M = 2.0
FARTHEST_M = 100.0


def shuffled(points, seed):
    """The points in an order that depends on the seed and on nothing else; those too near or not finite left out."""
    points = np.asarray(points, dtype=np.float64)[:, :3]
    distance = np.linalg.norm(points, axis=1)
    kept = points[np.isfinite(distance) & (distance > NEAREST_M)]
    # First into an order that their own numbers give: what order they came in then has no effect.
    kept = kept[np.lexsort(kept.T)]
    return np.random.default_rng(seed).permutation(kept)


def trajectory(clouds, seed, voxel_size_m=1.0):
    """Poses (N, 4, 4) of the sensor over the clouds, each shuffled; the first is where the map begins.

    Without motion compensation: it would need each point's time, which decoded clouds do not hold.
    """
    from kiss_icp.config import KISSConfig
    from kiss_icp.config.config import DataConfig, MappingConfig, RegistrationConfig
    from kiss_icp.kiss_icp import KissICP

    odometry = KissICP(
        KISSConfig(
            data=DataConfig(max_range=FARTHEST_M, min_range=NEAREST_M, deskew=False),
            mapping=MappingConfig(voxel_size=voxel_size_m),
            # One thread: the sums of several end in an order of chance, and with it the last digits of a pose.
            registration=RegistrationConfig(max_num_threads=1),
        )
    )
    poses = []
    for number, cloud in enumerate(clouds):
        odometry.register_frame(shuffled(cloud, [seed, number]), np.zeros(0))
        poses.append(odometry.last_pose.copy())
    return np.array(poses)


@dataclass(frozen=True)
class Difference:
    """How two trajectories differ: root mean square over steps, and over the poses of the whole sequence; its end.

    Translations in meters, rotations in degrees.
    """

    step_m: float
    step_deg: float
    path_m: float
    path_deg: float
    end_m: float
    end_deg: float


FIELDS = tuple(Difference.__dataclass_fields__)


def difference(poses, others):
    """Of two trajectories with the same first pose."""
    steps = _apart(_steps(poses), _steps(others))
    path = _apart(poses, others)
    rms = [float(np.sqrt(np.mean(values**2))) for values in (*steps, *path)]
    return Difference(*rms, float(path[0][-1]), float(path[1][-1]))


def length_m(poses):
    """Length of the way."""
    return float(np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1).sum())


def compare(runs, originals):
    """A configuration's runs (shuffles of decoded clouds) with those of the original: a dictionary of numbers.

    Each field of `Difference`: mean over all pairs of a run and an original. `*_floor`: the same over pairs of originals.
    `step_p`: the probability of a per-step difference so far above the floor if the runs were shuffles of the original, by
    exchanging them with the originals in every way (a permutation test; 1 / number of ways is the least it can be).
    """
    result = mean_difference([difference(run, original) for run in runs for original in originals])
    floor = mean_difference([difference(*pair) for pair in combinations(originals, 2)])
    result |= {f"{name}_floor": value for name, value in floor.items()}
    result["step_p"] = _permutation_p([*runs, *originals], len(runs))
    return result


def step_squares(runs, others=None):
    """For each step, the squared translation between two runs (m^2), mean over all pairs; those of one list where it is alone."""
    pairs = combinations(runs, 2) if others is None else [(run, other) for run in runs for other in others]
    return np.mean([_apart(_steps(one), _steps(other))[0] ** 2 for one, other in pairs], axis=0)


def mean_difference(differences):
    return {name: float(np.mean([getattr(one, name) for one in differences])) for name in FIELDS}


def _permutation_p(poses, runs_len):
    """Where the mean distance between the two groups stands among all ways to make them, less that within the second group."""
    count = len(poses)
    apart = np.zeros((count, count))
    for one, other in combinations(range(count), 2):
        apart[one, other] = apart[other, one] = difference(poses[one], poses[other]).step_m

    def excess(group):
        rest = [index for index in range(count) if index not in group]
        within = apart[np.ix_(rest, rest)].sum() / (len(rest) * (len(rest) - 1))
        return apart[np.ix_(list(group), rest)].mean() - within

    found = excess(tuple(range(runs_len)))
    ways = [excess(group) for group in combinations(range(count), runs_len)]
    return float(np.mean(np.array(ways) >= found - 1e-12))


def _steps(poses):
    return np.linalg.inv(poses[:-1]) @ poses[1:]


def _apart(poses, others):
    """Translation (m) and angle (degrees) between the poses of two lists."""
    between = np.linalg.inv(poses) @ others
    # From the sine: the cosine of so small an angle is 1 to all digits.
    skew = between[:, :3, :3] - np.swapaxes(between[:, :3, :3], 1, 2)
    sine = np.linalg.norm(np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=1), axis=1) / 2
    cosine = (np.trace(between[:, :3, :3], axis1=1, axis2=2) - 1) / 2
    return np.linalg.norm(between[:, :3, 3], axis=1), np.degrees(np.arctan2(sine, cosine))
