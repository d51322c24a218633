"""Odometry on a made-up street, whose motion is known."""

import unittest

import numpy as np

from evaluation import odometry

try:
    import kiss_icp  # noqa: F401
except ImportError:
    kiss_icp = None


def street(rng):
    """Points on a ground, two walls and boxes between them."""
    ground = np.column_stack([rng.uniform(-40, 60, 9000), rng.uniform(-12, 12, 9000), np.full(9000, -1.7)])
    walls = [np.column_stack([rng.uniform(-40, 60, 4000), np.full(4000, side), rng.uniform(-1.7, 6, 4000)]) for side in (-12, 12)]
    posts = []
    for x in range(-38, 60, 7):
        angle = rng.uniform(-np.pi, np.pi, 300)
        posts.append(np.column_stack([x + 0.4 * np.cos(angle), (-1) ** x * 8 + 0.4 * np.sin(angle), rng.uniform(-1.7, 4, 300)]))
    return np.vstack([ground, *walls, *posts])


def pose(x_m, yaw_rad):
    result = np.eye(4)
    result[:2, :2] = [[np.cos(yaw_rad), -np.sin(yaw_rad)], [np.sin(yaw_rad), np.cos(yaw_rad)]]
    result[0, 3] = x_m
    return result


def drive(steps, noise_m=0.0):
    """Clouds of a sensor that drives through the street, and its poses from the first."""
    rng = np.random.default_rng(11)
    world = street(rng)
    poses = [pose(0.5 * step, 0.004 * step) for step in range(steps)]
    clouds = []
    for at in poses:
        seen = (world - at[:3, 3]) @ at[:3, :3]
        clouds.append(seen[np.linalg.norm(seen, axis=1) < 50] + 0)
    if noise_m:
        clouds = [cloud + rng.normal(scale=noise_m, size=cloud.shape) for cloud in clouds]
    return clouds, np.array(poses)


class Differences(unittest.TestCase):
    def test_of_a_known_turn_and_shift(self):
        poses = np.array([pose(step, 0) for step in range(5)])
        others = poses.copy()
        others[3:] = pose(0.1, np.radians(0.5)) @ others[3:]
        found = odometry.difference(poses, others)
        self.assertAlmostEqual(found.end_deg, 0.5, places=9)
        self.assertAlmostEqual(found.path_deg, 0.5 * np.sqrt(2 / 5), places=9)
        self.assertAlmostEqual(found.step_deg, 0.5 / 2, places=9)
        self.assertAlmostEqual(odometry.length_m(poses), 4)
        self.assertEqual(odometry.difference(poses, poses), odometry.Difference(*[0.0] * 6))

    def test_order_of_the_input_has_no_effect_once_it_is_shuffled(self):
        points = np.random.default_rng(12).normal(scale=9, size=(400, 4)).astype("f4")
        one = odometry.shuffled(points, [3, 1])
        np.testing.assert_array_equal(one, odometry.shuffled(points[::-1], [3, 1]))
        self.assertFalse(np.array_equal(one, odometry.shuffled(points, [4, 1])))

    def test_points_that_are_none_are_left_out(self):
        points = [[0, 0, 0], [np.nan, 1, 1], [30, 0, 0], [0.5, 0.5, 0]]
        np.testing.assert_array_equal(odometry.shuffled(points, 1), [[30, 0, 0]])


@unittest.skipIf(kiss_icp is None, "kiss-icp is not installed")
class KissIcp(unittest.TestCase):
    def test_finds_the_motion_of_a_made_up_street(self):
        clouds, poses = drive(5)
        found = odometry.trajectory(clouds, 1)
        apart = odometry.difference(found, poses)
        self.assertLess(apart.end_m, 0.1)
        self.assertLess(apart.end_deg, 0.2)
        np.testing.assert_array_equal(found, odometry.trajectory(clouds, 1))

    def test_shuffles_are_within_the_floor_and_coarse_clouds_are_not(self):
        clouds, _ = drive(4, noise_m=0.01)
        coarse = [np.round(cloud / 1.5) * 1.5 + [0.3 * (index % 2), 0, 0] for index, cloud in enumerate(clouds)]
        originals = [odometry.trajectory(clouds, seed) for seed in range(4)]
        same = odometry.compare([odometry.trajectory(clouds, seed) for seed in (10, 11)], originals)
        worse = odometry.compare([odometry.trajectory(coarse, seed) for seed in (10, 11)], originals)
        self.assertGreater(worse["step_m"], 3 * worse["step_m_floor"])
        self.assertLess(same["step_m"], 2 * same["step_m_floor"])
        self.assertAlmostEqual(worse["step_p"], 1 / 15)
        self.assertGreater(same["step_p"], worse["step_p"])


if __name__ == "__main__":
    unittest.main()
