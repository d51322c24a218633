"""The network: features of the points around each key point, rounds of messages between key points, then a box from each.

Layers are read off the checkpoint's names; only their order is in the code. All in 32-bit floats, as it was trained.
"""

import numpy as np

# Edges at a time: their features (300 floats each) stay in a core's cache from layer to layer. 16384 take half as long again.
EDGES_AT_ONCE = 2048


class Network:
    """Point-GNN with the weights of a checkpoint, as `checkpoint.read_checkpoint` gives them."""

    def __init__(self, tensors):
        self.pool_points = _layers(tensors, "layer1/extract_vertex_features")
        self.pool_output = _layers(tensors, "layer1/combined_features")
        self.rounds = []
        while f"layer{len(self.rounds) + 2}/extract_vertex_features/fully_connected/weights" in tensors:
            scope = f"layer{len(self.rounds) + 2}"
            self.rounds.append(
                {
                    "offset": _layers(tensors, scope),
                    "edge": _layers(tensors, f"{scope}/extract_vertex_features"),
                    "update": _layers(tensors, f"{scope}/combined_features"),
                }
            )
        self.classifier = _layers(tensors, "output/predictor/cls")
        self.classes = self.classifier[-1][1].size
        self.box_heads = [_layers(tensors, f"output/predictor/loc/cls_{index}") for index in range(self.classes)]

    def __call__(self, points, intensities, key_indices, point_edges, key_edges):
        """Class probabilities (K, classes) and encoded boxes (K, classes, 7) of the K key points.

        `point_edges` lead from points to key points, `key_edges` between key points, as `graph.radius_edges` orders them.
        """
        keys = points[key_indices].astype(np.float32)
        features = self._pool(points.astype(np.float32), intensities.astype(np.float32), keys, point_edges)
        for round_ in self.rounds:
            features = features + _exchange(round_, features, keys, key_edges)
        probabilities = _softmax(_run(self.classifier, features, last_linear=True))
        boxes = np.stack([_run(head, features, last_linear=True) for head in self.box_heads], axis=1)
        return probabilities, boxes

    def _pool(self, points, intensities, keys, edges):
        """Each point as seen from its key point, and the largest of each feature among a key point's points."""

        def of_edges(sources, centers):
            return np.column_stack([intensities[sources], points[sources] - keys[centers]])

        pooled = _largest(edges, len(keys), of_edges, self.pool_points)
        return _run(self.pool_output, pooled)


def _exchange(round_, features, keys, edges):
    """What a round adds to the key points' features: each moves itself by an offset of its own making, then takes the largest
    message from its neighbors. The first layer of a message is linear in sender and receiver, hence done once for each."""
    moved = keys + _run(round_["offset"], features, last_linear=True)
    (weights, biases), rest = round_["edge"][0], round_["edge"][1:]
    depth = features.shape[1]
    sent = features @ weights[:depth] + keys @ weights[depth:] + biases
    received = moved @ weights[depth:]

    def of_edges(sources, centers):
        return np.maximum(sent[sources] - received[centers], 0)

    return _run(round_["update"], _largest(edges, len(keys), of_edges, rest), last_linear=True)


def _largest(edges, centers_len, of_edges, layers):
    """The largest of each feature over the edges of each center. Every center has an edge: it is its own neighbor."""
    sources, centers = edges
    starts = np.searchsorted(centers, np.arange(centers_len + 1))
    result = np.empty((centers_len, layers[-1][1].size), dtype=np.float32)
    first = 0
    while first < centers_len:
        last = max(int(np.searchsorted(starts, starts[first] + EDGES_AT_ONCE, side="right")) - 1, first + 1)
        span = slice(starts[first], starts[last])
        features = _run(layers, of_edges(sources[span], centers[span]))
        result[first:last] = np.maximum.reduceat(features, starts[first:last] - starts[first], axis=0)
        first = last
    return result


def _layers(tensors, scope):
    """Weights and biases of the fully connected layers in a scope, in order."""
    layers = []
    while True:
        name = f"{scope}/fully_connected" + (f"_{len(layers)}" if layers else "")
        if f"{name}/weights" not in tensors:
            break
        layers.append((tensors[f"{name}/weights"], tensors[f"{name}/biases"]))
    if not layers:
        raise KeyError(f"no layers in {scope}")
    return layers


def _run(layers, features, last_linear=False):
    """Fully connected layers with rectifiers; the last without one where its output is a number to be read."""
    for index, (weights, biases) in enumerate(layers):
        features = features @ weights
        features += biases
        if not (last_linear and index == len(layers) - 1):
            np.maximum(features, 0, out=features)
    return features


def _softmax(logits):
    exponentials = np.exp(logits - logits.max(axis=1, keepdims=True))
    return exponentials / exponentials.sum(axis=1, keepdims=True)
