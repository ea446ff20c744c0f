# SPDX-License-Identifier: MIT
"""Unlike shapes that belong to a model say how distinctive an agreement is."""

from __future__ import annotations

import io
import json

import numpy as np
import pytest

from shapegoogle_core.errors import ModelError
from shapegoogle_core.model import ShapeModel, load_model
from shapegoogle_core.model.background import NEIGHBOUR, Background
from shapegoogle_core.model.training.background_learning import KnownPairs, learn_background
from tests.core.tiny_model import build_model

METRICS = ("cosine", "l1")


@pytest.fixture(scope="module")
def model() -> ShapeModel:
    return build_model()


def bags_of(seeds: range, model: ShapeModel) -> np.ndarray:
    alpha = np.full(model.bag_size, 0.3)
    return np.stack(
        [np.random.default_rng(seed).dirichlet(alpha).astype(np.float32) ** 0.5 for seed in seeds]
    )


def with_background(model: ShapeModel, bags: np.ndarray, distinctive: float = 0.5) -> ShapeModel:
    vectors = model.comparable(bags).astype(np.float16)
    return model.with_parts(background=Background(vectors, distinctive, 1.0, 2.0))


@pytest.mark.parametrize("metric", METRICS)
def test_the_background_distance_is_that_of_the_fifth_nearest(metric: str) -> None:
    model = build_model(metric=metric)
    bags = bags_of(range(20), model)
    complete = with_background(model, bags)
    asked = bags_of(range(100, 103), model)
    found = complete.background_distances(asked)
    assert found is not None
    expected = [np.sort(model.distances(one, bags))[NEIGHBOUR - 1] for one in asked]
    np.testing.assert_allclose(found, expected, rtol=0.02)
    typical = complete.typical_distances(asked[0], asked[1:])
    assert typical is not None
    np.testing.assert_allclose(typical, np.sqrt(expected[0] * np.array(expected[1:])), rtol=0.02)


def test_only_distances_of_plain_shapes_are_raised(model: ShapeModel) -> None:
    complete = with_background(model, bags_of(range(20), model), distinctive=0.5)
    distances = np.array([0.0, 0.1, 0.1, 0.1])
    typical = np.array([0.05, 0.05, 0.5, 0.9])
    np.testing.assert_allclose(complete.weighed_distances(distances, typical), [0, 1.0, 0.1, 0.1])
    np.testing.assert_allclose(
        complete.weighed_distances(distances, typical, verified=True), [0, 10.0, 0.1, 0.1]
    )
    similarities = complete.similarity(distances, typical)
    assert similarities[0] == 1
    assert similarities[1] < similarities[2] == similarities[3] == model.similarity(0.1)
    # Without knowing how plain they are, all count in full.
    np.testing.assert_array_equal(complete.similarity(distances), model.similarity(distances))


def test_a_model_without_a_background_is_as_before(model: ShapeModel) -> None:
    bags = bags_of(range(3), model)
    assert model.background_distances(bags) is None
    assert model.typical_distances(bags[0], bags) is None
    np.testing.assert_array_equal(model.similarity([0.1], [0.01]), model.similarity([0.1]))


def test_the_file_keeps_the_background_and_the_identifier(model: ShapeModel) -> None:
    complete = with_background(model, bags_of(range(20), model))
    again = ShapeModel.from_bytes(complete.to_bytes())
    assert again.identifier == complete.identifier == model.identifier
    assert again.background is not None
    assert complete.background is not None
    np.testing.assert_array_equal(again.background.vectors, complete.background.vectors)

    assert (again.background.distinctive, again.background.exponent, again.background.verified_exponent) == (
        0.5,
        1.0,
        2.0,
    )


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"vectors": np.zeros((NEIGHBOUR - 1, 16))}, "rows of finite numbers"),
        ({"vectors": np.full((20, 16), np.nan)}, "rows of finite numbers"),
        ({"vectors": np.zeros((20, 7))}, "rows of 16 numbers"),
        ({"distinctive": 0.0}, "must be above 0"),
        ({"exponent": -1.0}, "must be above 0"),
        ({"verified_exponent": np.inf}, "must be above 0"),
    ],
)
def test_a_damaged_background_is_refused(changes: dict[str, object], message: str, model: ShapeModel) -> None:
    complete = with_background(model, bags_of(range(20), model))
    with np.load(io.BytesIO(complete.to_bytes())) as archive:
        arrays = {name: archive[name] for name in archive.files}
    header = json.loads(str(arrays["header"]))
    if "vectors" in changes:
        arrays["background_vectors"] = np.asarray(changes["vectors"], np.float16)
    header["background"] |= {name: value for name, value in changes.items() if name != "vectors"}
    arrays["header"] = np.array(json.dumps(header))
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, **arrays)
    with pytest.raises(ModelError, match=message):
        ShapeModel.from_bytes(buffer.getvalue())


def test_exponents_are_learnt_where_plain_shapes_deceive(model: ShapeModel) -> None:
    """Different plain shapes are as near to each other as two versions of distinctive ones."""
    random = np.random.default_rng(0)
    center = random.standard_normal(16)

    def unit(rows: np.ndarray) -> np.ndarray:
        return np.asarray(rows / np.linalg.norm(rows, axis=1, keepdims=True), np.float32)

    plain = unit(center + 0.1 * random.standard_normal((40, 16)))
    distinct = unit(random.standard_normal((40, 16)))
    versions = unit(distinct + 0.06 * random.standard_normal((40, 16)))
    same_plain = unit(plain + 0.003 * random.standard_normal((40, 16)))
    first = np.concatenate([plain, distinct, plain[:-1], distinct[:-1]])
    second = np.concatenate([same_plain, versions, plain[1:], distinct[1:]])
    distances = 1.0 - (first * second).sum(axis=1, dtype=np.float64)
    same = np.arange(len(first)) < 80
    pairs = KnownPairs(first, second, distances, distances, same)
    background = learn_background(model, np.concatenate([plain[::4], distinct[::4]]), distinct, pairs)
    assert background.exponent > 0.5
    assert background.verified_exponent > 0.5
    metric = model.settings.metric
    assert (background.distances(metric, distinct) > 4 * background.distances(metric, plain)).all()


def test_the_default_model_has_a_background() -> None:
    background = load_model().background
    assert background is not None
    assert 100 < len(background.vectors) < 1000
    assert background.exponent > 0
