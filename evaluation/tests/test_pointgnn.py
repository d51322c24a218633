"""Point-GNN's parts against simpler ways to the same result."""

import struct
import tempfile
import unittest
from pathlib import Path

import numpy as np

from evaluation.pointgnn import agreement, boxes, checkpoint, graph, kitti, merge
from evaluation.pointgnn.network import Network


def varint(number):
    out = bytearray()
    while number > 0x7F:
        out.append(number & 0x7F | 0x80)
        number >>= 7
    return bytes([*out, number])


def field(number, content):
    if isinstance(content, int):
        return varint(number << 3) + varint(content)
    return varint(number << 3 | 2) + varint(len(content)) + content


def block(pairs):
    """A LevelDB block whose keys share what they can, and its trailer."""
    out, before = b"", b""
    for key, value in pairs:
        shared = next((i for i, (a, b) in enumerate(zip(key, before)) if a != b), min(len(key), len(before)))
        out += varint(shared) + varint(len(key) - shared) + varint(len(value)) + key[shared:] + value
        before = key
    out += struct.pack("<II", 0, 1)
    return out, out + b"\0" + struct.pack("<I", checkpoint.mask_crc(checkpoint.crc32c(out + b"\0")))


def write_checkpoint(folder, tensors):
    """A checkpoint of float tensors, put together from the formats' descriptions."""
    data, pairs = b"", [(b"", field(1, 1))]
    for name, tensor in sorted(tensors.items()):
        raw = tensor.astype("<f4").tobytes()
        shape = b"".join(field(2, field(1, size)) for size in tensor.shape)
        crc = varint(6 << 3 | 5) + struct.pack("<I", checkpoint.mask_crc(checkpoint.crc32c(raw)))
        pairs.append((name.encode(), field(1, 1) + field(2, shape) + field(4, len(data)) + field(5, len(raw)) + crc))
        data += raw
    table = b""
    half = len(pairs) // 2
    handles = []
    for part in (pairs[:half], pairs[half:]):
        body, stored = block(part)
        handles.append((part[-1][0], varint(len(table)) + varint(len(body))))
        table += stored
    meta_at, (meta, stored) = len(table), block([])
    table += stored
    index_at, (index, stored) = len(table), block(handles)
    table += stored
    footer = varint(meta_at) + varint(len(meta)) + varint(index_at) + varint(len(index))
    table += footer.ljust(40, b"\0") + struct.pack("<Q", checkpoint.TABLE_MAGIC)
    (folder / "model.index").write_bytes(table)
    (folder / "model.data-00000-of-00001").write_bytes(data)
    return folder / "model"


class Checkpoint(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        rng = np.random.default_rng(1)
        self.tensors = {f"layer{n}/fully_connected{end}": rng.normal(size=(n, 3 + n)).astype("f4") for n in (1, 2, 9) for end in ("", "_1")}
        self.prefix = write_checkpoint(Path(self.temporary.name), self.tensors)

    def test_crc_of_the_standard_check_string(self):
        self.assertEqual(checkpoint.crc32c(b"123456789"), 0xE3069283)

    def test_tensors_come_back(self):
        found = checkpoint.read_checkpoint(self.prefix)
        self.assertEqual(sorted(found), sorted(self.tensors))
        for name, tensor in self.tensors.items():
            np.testing.assert_array_equal(found[name], tensor)

    def test_every_flipped_byte_and_every_cut_of_the_index_is_an_error_or_changes_nothing(self):
        path = Path(f"{self.prefix}.index")
        whole = path.read_bytes()
        footer = len(whole) - checkpoint.FOOTER_LEN
        damaged = [whole[:at] + bytes([whole[at] ^ 0x40]) + whole[at + 1 :] for at in range(len(whole))]
        for at, bad in enumerate([*damaged, *(whole[:length] for length in range(len(whole)))]):
            path.write_bytes(bad)
            try:
                found = checkpoint.read_checkpoint(self.prefix)
            except checkpoint.CheckpointError:
                continue
            # The block of meta data and the padding of the footer are never read.
            self.assertEqual(sorted(found), sorted(self.tensors), at)
            self.assertGreaterEqual(at, footer - 80, at)

    def test_damaged_data_is_an_error(self):
        path = Path(f"{self.prefix}.data-00000-of-00001")
        path.write_bytes(path.read_bytes()[:-1] + b"\1")
        with self.assertRaises(checkpoint.CheckpointError):
            checkpoint.read_checkpoint(self.prefix)


def random_boxes(rng, count):
    center = rng.uniform([-2, 0, 8], [2, 1, 12], size=(count, 3))
    size = rng.uniform([1, 1, 1], [5, 2, 2.5], size=(count, 3))
    return np.column_stack([center, size, rng.uniform(-np.pi, np.pi, count)])


def contains(box, points):
    """By turning the points into the box's frame."""
    offset = points - box[:3]
    cos, sin = np.cos(box[6]), np.sin(box[6])
    along = offset[:, 0] * cos - offset[:, 2] * sin
    across = offset[:, 0] * sin + offset[:, 2] * cos
    return (np.abs(along) < box[3] / 2) & (np.abs(across) < box[5] / 2) & (offset[:, 1] < 0) & (offset[:, 1] > -box[4])


class Boxes(unittest.TestCase):
    def test_overlap_is_what_random_points_say(self):
        rng = np.random.default_rng(2)
        points = rng.uniform([-6, -3, 3], [6, 2, 17], size=(200_000, 3))
        flat = points.copy()
        pairs = zip(random_boxes(rng, 25), random_boxes(rng, 25))
        for box, other in pairs:
            for ground_only in (False, True):
                if ground_only:
                    flat[:, 1] = box[1] - 0.1
                    other = np.concatenate([other[:1], box[1:2], other[2:]])
                sample = flat if ground_only else points
                own, theirs = contains(box, sample), contains(other, sample)
                expected = (own & theirs).sum() / max((own | theirs).sum(), 1)
                found = boxes.iou(box, other[None], ground_only)[0]
                self.assertAlmostEqual(found, expected, delta=0.025)

    def test_overlap_with_itself_turned_half_around_or_apart(self):
        rng = np.random.default_rng(3)
        for box in random_boxes(rng, 20):
            turned, away = box.copy(), box.copy()
            turned[6] += np.pi
            away[0] += 20
            np.testing.assert_allclose(boxes.iou(box, [box, turned, away]), [1, 1, 0], atol=1e-9)
            lower = box.copy()
            lower[1] += box[4] / 2
            np.testing.assert_allclose(boxes.iou(box, lower[None]), 1 / 3, atol=1e-9)
            np.testing.assert_allclose(boxes.iou(box, lower[None], ground_only=True), 1, atol=1e-9)

    def test_encoding_and_back(self):
        rng = np.random.default_rng(4)
        wanted, vertices = random_boxes(rng, 50), rng.normal(size=(50, 3))
        across = rng.random(50) < 0.5
        np.testing.assert_allclose(boxes.decode(boxes.encode(wanted, vertices, across), vertices, across), wanted)

    def test_a_median_car_at_the_vertex_is_all_zeros(self):
        car = np.array([[1.0, 2.0, 3.0, *boxes.CAR_SIZE_M, np.pi / 2]])
        np.testing.assert_allclose(boxes.encode(car, [[1.0, 2.0, 3.0]], np.array([True])), np.zeros((1, 7)))


class Graph(unittest.TestCase):
    def test_radius_edges_are_those_of_all_pairs(self):
        rng = np.random.default_rng(5)
        sources = rng.normal(size=(300, 3))
        centers = sources[rng.choice(300, 60, replace=False)]
        found = graph.radius_edges(sources, centers, 0.7)
        near = np.linalg.norm(centers[:, None] - sources[None], axis=2) <= 0.7
        np.testing.assert_array_equal(np.stack(found), np.stack(np.nonzero(near)[::-1]))

    def test_key_points_are_the_points_nearest_to_their_voxels_means(self):
        rng = np.random.default_rng(6)
        points = rng.uniform(-3, 3, size=(500, 3))
        voxels = {}
        for point in points:
            voxels.setdefault(tuple(np.floor((point - 0.1) / 0.8)), []).append(point)
        found = points[graph.key_points(points, 0.8, (0.1, 0.1, 0.1))]
        # In the order of the voxels. Of a voxel with two points, both are as near to its mean.
        means = [np.mean(voxels[voxel], axis=0) for voxel in sorted(voxels)]
        nearest = [np.linalg.norm(points - mean, axis=1).min() for mean in means]
        np.testing.assert_allclose(np.linalg.norm(found - means, axis=1), nearest, atol=2e-6)

    def test_neither_order_nor_small_errors_choose_other_key_points(self):
        rng = np.random.default_rng(10)
        # Two points in most voxels, well inside them.
        voxels = rng.integers(-9, 9, size=(400, 3)).repeat(2, axis=0)
        points = 0.8 * (voxels + rng.uniform(0.1, 0.9, size=voxels.shape))
        found = graph.key_points(points, 0.8)
        order = rng.permutation(len(points))
        moved = (points + rng.normal(scale=1e-5, size=points.shape))[order]
        self.assertEqual(set(order[graph.key_points(moved, 0.8)].tolist()), set(found.tolist()))


def layer(rng, scope, sizes, tensors):
    for index, (fan_in, fan_out) in enumerate(zip(sizes, sizes[1:])):
        name = f"{scope}/fully_connected" + (f"_{index}" if index else "")
        tensors[f"{name}/weights"] = rng.normal(size=(fan_in, fan_out)).astype("f4")
        tensors[f"{name}/biases"] = rng.normal(size=fan_out).astype("f4")


class Forward(unittest.TestCase):
    """The network, which works on all edges at once and takes shortcuts, against one written out edge by edge."""

    def setUp(self):
        rng = np.random.default_rng(7)
        tensors = {}
        layer(rng, "layer1/extract_vertex_features", [4, 5, 6], tensors)
        layer(rng, "layer1/combined_features", [6, 6], tensors)
        layer(rng, "layer2", [6, 4, 3], tensors)
        layer(rng, "layer2/extract_vertex_features", [9, 6, 6], tensors)
        layer(rng, "layer2/combined_features", [6, 6, 6], tensors)
        layer(rng, "output/predictor/cls", [6, 5, 4], tensors)
        for index in range(4):
            layer(rng, f"output/predictor/loc/cls_{index}", [6, 5, 7], tensors)
        self.tensors = tensors
        self.points = rng.uniform(-1, 1, size=(80, 3)).astype("f4")
        self.intensities = rng.random(80).astype("f4")
        self.keys = np.arange(0, 80, 8)

    def run_layers(self, scope, vector, last_linear=False):
        index = 0
        while (name := f"{scope}/fully_connected" + (f"_{index}" if index else "")) + "/weights" in self.tensors:
            if index:
                vector = np.maximum(vector, 0)
            vector = vector @ self.tensors[f"{name}/weights"] + self.tensors[f"{name}/biases"]
            index += 1
        return vector if last_linear else np.maximum(vector, 0)

    def test_edge_by_edge(self):
        keys = self.points[self.keys]
        pooled = []
        for key in keys:
            near = [i for i, point in enumerate(self.points) if np.linalg.norm(point - key) <= 0.6]
            seen = [self.run_layers("layer1/extract_vertex_features", np.r_[self.intensities[i], self.points[i] - key]) for i in near]
            pooled.append(self.run_layers("layer1/combined_features", np.max(seen, axis=0)))
        updated = []
        for own, key in zip(pooled, keys):
            moved = key + self.run_layers("layer2", own, last_linear=True)
            near = [i for i, other in enumerate(keys) if np.linalg.norm(other - key) <= 1.2]
            messages = [self.run_layers("layer2/extract_vertex_features", np.r_[pooled[i], keys[i] - moved]) for i in near]
            updated.append(own + self.run_layers("layer2/combined_features", np.max(messages, axis=0), last_linear=True))
        logits = np.array([self.run_layers("output/predictor/cls", vector, last_linear=True) for vector in updated])
        expected = np.exp(logits) / np.exp(logits).sum(axis=1, keepdims=True)
        expected_boxes = [[self.run_layers(f"output/predictor/loc/cls_{c}", v, last_linear=True) for c in range(4)] for v in updated]

        found, found_boxes = Network(self.tensors)(
            self.points, self.intensities, self.keys, graph.radius_edges(self.points, keys, 0.6), graph.radius_edges(keys, keys, 1.2)
        )
        np.testing.assert_allclose(found, expected, rtol=1e-3, atol=1e-5)
        np.testing.assert_allclose(found_boxes, expected_boxes, rtol=1e-3, atol=1e-3)

    def test_few_edges_at_a_time_give_the_same(self):
        from evaluation.pointgnn import network

        keys = self.points[self.keys]
        edges = graph.radius_edges(self.points, keys, 0.6), graph.radius_edges(keys, keys, 1.2)
        whole = Network(self.tensors)(self.points, self.intensities, self.keys, *edges)
        before, network.EDGES_AT_ONCE = network.EDGES_AT_ONCE, 7
        self.addCleanup(setattr, network, "EDGES_AT_ONCE", before)
        for one, other in zip(whole, Network(self.tensors)(self.points, self.intensities, self.keys, *edges)):
            np.testing.assert_allclose(one, other, rtol=1e-4, atol=1e-5)


class Merge(unittest.TestCase):
    def test_votes_for_two_cars_become_two_boxes(self):
        rng = np.random.default_rng(8)
        cars = np.array([[0, 1.5, 10, 4, 1.5, 1.6, 0.3], [6, 1.5, 20, 4.2, 1.4, 1.7, -1.2]])
        votes = np.repeat(cars, 9, axis=0) + rng.normal(scale=0.02, size=(18, 7))
        found, scores = merge.merge(votes, rng.uniform(0.5, 1, 18), 0.01)
        self.assertEqual(len(found), 2)
        order = np.argsort(found[:, 2])
        np.testing.assert_allclose(found[order], cars, atol=0.03)
        self.assertTrue((scores > 4).all())

    def test_coverage_is_the_share_of_the_box_that_the_points_extent_fills(self):
        box = np.array([1.0, 2.0, 9.0, 4.0, 1.5, 2.0, 0.7])
        corners = boxes.corners(box)[0]
        middle = corners.mean(axis=0)
        self.assertAlmostEqual(merge.coverage(box, middle + 0.8 * (corners - middle)), 0.8**3, places=6)
        self.assertEqual(merge.coverage(box, corners + 30), 0)


class Agreement(unittest.TestCase):
    def test_a_found_box_serves_one_wanted_box(self):
        car = np.array([0, 1.5, 10, 4, 1.5, 1.6, 0.3])
        beside = car + [0.4, 0, 0, 0, 0, 0, 0]
        best = agreement.best_iou([beside, car], [car])
        self.assertEqual(best[0], 0)
        self.assertAlmostEqual(best[1], 1)
        self.assertEqual(agreement.recall(best), {0.3: 0.5, 0.5: 0.5, 0.7: 0.5})
        self.assertEqual(agreement.invented(np.array([car, car + [30, 0, 0, 0, 0, 0, 0]]), np.array([car])), 1)
        self.assertEqual(agreement.invented(np.array([car]), np.zeros((0, 7))), 1)

    def test_four_quarter_turns_are_none(self):
        points = np.random.default_rng(9).normal(size=(20, 3)).astype("f4")
        turned = points
        for _ in range(4):
            turned = agreement.turned(turned, 1)
        np.testing.assert_array_equal(turned, points)
        np.testing.assert_array_equal(agreement.turned(points, 2)[:, :2], -points[:, :2])


CALIBRATION = """P2: 700 0 600 45 0 700 180 -0.3 0 0 1 0.005
R0_rect: 1 0 0 0 1 0 0 0 1
Tr_velo_to_cam: 0 -1 0 0 0 0 -1 -0.06 1 0 0 -0.3

"""


class Kitti(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)

    def write(self, text):
        path = Path(self.temporary.name) / "file.txt"
        path.write_text(text)
        return path

    def test_pixels_are_those_of_the_projection_matrix(self):
        calibration = kitti.read_calibration(self.write(CALIBRATION))
        points = np.array([[10.0, 0, 0], [20, 5, -1], [-10, 0, 0], [3, 40, 0]])
        camera = kitti.to_camera(points, calibration)
        projection = np.array([[700, 0, 600, 45], [0, 700, 180, -0.3], [0, 0, 1, 0.005]])
        for point, pixel in zip(points[:2], kitti.to_image(camera[:2], calibration)):
            homogeneous = projection @ [-point[1], -point[2] - 0.06, point[0] - 0.3, 1]
            np.testing.assert_allclose(pixel, homogeneous[:2] / homogeneous[2])
        np.testing.assert_array_equal(kitti.in_view(camera, calibration), [True, True, False, False])

    def test_labels(self):
        labels = kitti.read_labels(
            self.write("Car 0.1 2 1.85 387.6 181.5 423.8 203.1 1.67 1.87 3.69 -16.5 2.39 58.5 1.57\nDontCare -1 -1 -10 5 1 9 1 -1 -1 -1 -1000 -1000 -1000 -10\n")
        )
        self.assertEqual([label.kind for label in labels], ["Car"])
        np.testing.assert_allclose(labels[0].box, [-16.5, 2.39, 58.5, 3.69, 1.67, 1.87, 1.57])
        self.assertAlmostEqual(labels[0].height_px, 21.6)


if __name__ == "__main__":
    unittest.main()
