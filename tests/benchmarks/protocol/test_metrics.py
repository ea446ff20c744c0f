# SPDX-License-Identifier: MIT
"""Measures of retrieval: by hand, against scikit-learn, and properties that must hold."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from numpy.typing import NDArray
from sklearn.metrics import average_precision_score, precision_recall_curve, roc_auc_score, roc_curve

from benchmarks.protocol.metrics import CLASSES, category_scores, precision_recall, ranks, roc, strength_table
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model.augmentation import TRANSFORMATIONS

BoolArray = NDArray[np.bool_]

INF = float("inf")


def few_distances(rows: int, columns: int) -> st.SearchStrategy[FloatArray]:
    """Whole numbers, so that many are equal."""
    return arrays.arrays(float, (rows, columns), elements=st.integers(0, 6).map(float))


def test_table_has_every_class_of_the_protocol() -> None:
    assert set(CLASSES) == {"isometry", *TRANSFORMATIONS}


def test_ranks_count_from_one() -> None:
    distances = [[0.1, 0.2, 0.3], [0.3, 0.2, 0.1], [0.2, 0.3, 0.1]]
    np.testing.assert_array_equal(ranks(distances, [0, 0, 0]), [1, 3, 2])


def test_shapes_at_one_distance_share_their_places() -> None:
    np.testing.assert_array_equal(
        ranks(np.array([[1, 1, 1, 1], [0, 1, 1, 5], [INF, INF, 1, 2]]), [2, 1, 0]), [2.5, 2.5, 3.5]
    )


@given(few_distances(4, 7), st.permutations(range(7)))
def test_ranks_do_not_depend_on_the_order_of_the_database(distances: FloatArray, order: list[int]) -> None:
    relevant = np.array([0, 3, 6, 2])
    expected = ranks(distances, relevant)
    np.testing.assert_array_equal(ranks(distances[:, order], np.argsort(order)[relevant]), expected)


@given(few_distances(4, 7))
def test_only_the_order_of_distances_counts(distances: FloatArray) -> None:
    relevant, mask = np.array([0, 3, 6, 2]), np.eye(4, 7, dtype=bool)
    stretched = np.exp(distances) - 5
    np.testing.assert_array_equal(ranks(stretched, relevant), ranks(distances, relevant))
    np.testing.assert_array_equal(
        roc(stretched, mask).true_positive_rate, roc(distances, mask).true_positive_rate
    )
    assert roc(stretched, mask).equal_error_rate == roc(distances, mask).equal_error_rate
    labels = list("aabb")
    assert category_scores(stretched[:, :4], labels) == category_scores(distances[:, :4], labels)


def test_reciprocal_rank_is_the_average_precision() -> None:
    random = np.random.default_rng(3)
    distances, relevant = random.random((20, 9)), random.integers(0, 9, 20)
    expected = [
        average_precision_score(np.arange(9) == wanted, -row)
        for row, wanted in zip(distances, relevant, strict=True)
    ]
    np.testing.assert_allclose(1 / ranks(distances, relevant), expected)


@pytest.mark.parametrize(
    ("distances", "relevant", "message"),
    [
        ([1.0, 2.0], [0, 0], "must be a matrix"),
        ([[1.0, float("nan")]], [0], "1 of 2 distances are NaN"),
        ([[1.0, 2.0]], [0, 1], "each of the 1 queries"),
        ([[1.0, 2.0]], [0.5], "each of the 1 queries"),
        ([[1.0, 2.0]], [2], "0 … 1"),
        ([[1.0, 2.0]], [-1], "0 … 1"),
    ],
)
def test_refuses_what_has_no_rank(distances: FloatArray, relevant: list[int], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ranks(distances, relevant)


def test_strength_table_by_hand() -> None:
    table = strength_table(
        [1, 2, 4, INF, 1], ["noise", "noise", "noise", "isometry", "isometry"], [1, 2, 5, 2, 2]
    )
    assert list(table) == ["isometry", "noise", "average"]
    assert table["noise"] == pytest.approx([100, 75, 75, 75, 175 / 3])
    assert table["isometry"] == pytest.approx([np.nan, 50, 50, 50, 50], nan_ok=True)
    # Classes weigh alike, though noise asked three times and isometry twice.
    assert table["average"] == pytest.approx([100, 62.5, 62.5, 62.5, (175 / 3 + 50) / 2])


@given(st.lists(st.tuples(st.integers(1, 50), st.sampled_from(CLASSES), st.integers(1, 5)), min_size=1))
def test_strength_table_keeps_within_bounds_and_any_order(queries: Any) -> None:
    table = strength_table(*map(list, zip(*queries, strict=True)))
    shuffled = strength_table(*map(list, zip(*reversed(queries), strict=True)))
    assert list(table) == list(shuffled)
    for kind, row in table.items():
        assert shuffled[kind] == pytest.approx(row, nan_ok=True)
        assert all(np.isnan(value) or 2 <= value <= 100 for value in row)
        assert not np.isnan(row[-1])


@pytest.mark.parametrize(
    ("queries", "message"),
    [
        (([], [], []), "no query"),
        (([1, 2], ["noise"], [1]), "2, 1 and 1"),
        (([0], ["noise"], [1]), "count from 1"),
        (([float("nan")], ["noise"], [1]), "count from 1"),
        (([1], ["noise"], [6]), r"not \[6\]"),
        (([1], ["average"], [1]), "cannot be called"),
    ],
)
def test_strength_table_refuses(queries: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        strength_table(*queries)


def test_roc_by_hand() -> None:
    # Sorted by distance: related, related, unrelated, related, unrelated, unrelated, related, unrelated.
    mask = np.array([True, True, False, True, False, False, True, False])
    curve = roc(np.arange(8.0), mask)
    np.testing.assert_allclose(curve.false_positive_rate, np.array([0, 0, 0, 1, 1, 2, 3, 3, 4]) / 4)
    np.testing.assert_allclose(curve.true_positive_rate, np.array([0, 1, 2, 2, 3, 3, 3, 4, 4]) / 4)
    assert curve.equal_error_rate == pytest.approx(0.25)


@pytest.mark.parametrize(
    ("distances", "expected"),
    [([0, 0, 1, 1], 0), ([1, 1, 0, 0], 1), ([1, 1, 1, 1], 0.5), ([0, INF, INF, INF], 0.4)],
)
def test_equal_error_rate_at_the_ends(distances: FloatArray, expected: float) -> None:
    # The last: from (0, ½) the curve runs straight to (1, 1), and meets 1 − TPR = FPR at ⅓.
    expected = 1 / 3 if expected == 0.4 else expected
    assert roc(distances, np.array([True, True, False, False])).equal_error_rate == pytest.approx(expected)


@given(few_distances(5, 8), arrays.arrays(bool, (5, 8)))
def test_curves_agree_with_sklearn(distances: FloatArray, mask: BoolArray) -> None:
    mask[0, :2] = True, False
    curve = roc(distances, mask)
    expected = roc_curve(mask.ravel(), -distances.ravel(), drop_intermediate=False)
    np.testing.assert_allclose(curve.false_positive_rate, expected[0])
    np.testing.assert_allclose(curve.true_positive_rate, expected[1])
    area = np.trapezoid(curve.true_positive_rate, curve.false_positive_rate)
    assert area == pytest.approx(roc_auc_score(mask.ravel(), -distances.ravel()))
    precision, recall, _ = precision_recall_curve(mask.ravel(), -distances.ravel())
    found = precision_recall(distances, mask)
    np.testing.assert_allclose(found.recall, recall[-2::-1])
    np.testing.assert_allclose(found.precision, precision[-2::-1])


@given(few_distances(3, 6))
def test_equal_error_rate_lies_on_the_curve(distances: FloatArray) -> None:
    curve = roc(distances, np.eye(3, 6, dtype=bool))
    rate = curve.equal_error_rate
    assert 0 <= rate <= 1
    # The curve may rise straight up there: what lies just left and right of it bounds it.
    just_below = np.interp(rate - 1e-9, curve.false_positive_rate, curve.true_positive_rate)
    just_above = np.interp(rate + 1e-9, curve.false_positive_rate, curve.true_positive_rate)
    assert just_below - 1e-6 <= 1 - rate <= just_above + 1e-6


def test_curves_are_thinned_for_plots_and_keep_their_shape() -> None:
    random = np.random.default_rng(0)
    mask = np.arange(20_000) < 50
    curve = roc(random.standard_normal(20_000) - 2 * mask, mask)
    points = np.array(curve.points())
    assert 50 < len(points) <= 200
    np.testing.assert_array_equal(points[[0, -1]], [[0, 0], [1, 1]])
    assert (np.diff(points, axis=0) >= 0).all()
    # On a logarithmic axis: as many points left of 1 % as their share of the picture asks.
    assert (points[:, 0] < 0.01).mean() > 0.3
    seen = np.interp(curve.false_positive_rate, points[:, 0], points[:, 1])
    assert np.abs(seen - curve.true_positive_rate).max() < 0.05
    assert len(precision_recall(random.random(5000), np.arange(5000) < 9).points(100)) <= 100


@pytest.mark.parametrize(
    ("distances", "mask", "message"),
    [
        ([1.0, 2.0], [True], "a bool for each distance"),
        ([1.0, 2.0], [1, 0], "a bool for each distance"),
        ([1.0, 2.0], [True, True], "both related and unrelated"),
        ([1.0, 2.0], [False, False], "both related and unrelated"),
        ([1.0, float("nan")], [True, False], "NaN"),
    ],
)
def test_curves_refuse(distances: FloatArray, mask: BoolArray, message: str) -> None:
    for curve in (roc, precision_recall):
        with pytest.raises(ValueError, match=message):
            curve(distances, np.array(mask))


def on_a_line(*places: float) -> FloatArray:
    points = np.array(places, float)
    return np.asarray(np.abs(points[:, None] - points))


def test_category_scores_by_hand() -> None:
    # a at 0, 1 and 10, b at 2.1 and 4, c at 21 alone.
    scores = category_scores(on_a_line(0, 1, 10, 2.1, 4, 21), ["a", "a", "a", "b", "b", "c"])
    # Right answers, nearest first: to 0 and 1: 10010, to 10: 00110, to 2.1: 01000, to 4: 10000.
    assert scores.nearest_neighbor == pytest.approx(3 / 5)
    assert scores.first_tier == pytest.approx((0.5 + 0.5 + 0 + 0 + 1) / 5)
    assert scores.second_tier == pytest.approx((1 + 1 + 1 + 1 + 1) / 5)
    ideal = 1 + 1 / np.log2(2)
    gains = [
        (1 + 1 / np.log2(4)) / ideal,
        (1 + 1 / np.log2(4)) / ideal,
        (1 / np.log2(3) + 1 / np.log2(4)) / ideal,
        1 / np.log2(2),
        1,
    ]
    assert scores.discounted_cumulative_gain == pytest.approx(np.mean(gains))


def test_a_perfect_order_scores_one_and_a_reversed_one_low() -> None:
    labels = ["a"] * 4 + ["b"] * 3 + ["c"]
    near = np.where(np.array(labels)[:, None] == np.array(labels), 1.0, 2.0)
    perfect = category_scores(near, labels)
    assert (perfect.nearest_neighbor, perfect.first_tier, perfect.second_tier) == (1, 1, 1)
    assert perfect.discounted_cumulative_gain == pytest.approx(1)
    worst = category_scores(-near, labels)
    assert (worst.nearest_neighbor, worst.first_tier) == (0, 0)
    assert worst.discounted_cumulative_gain < 0.6


@settings(deadline=None, max_examples=15)
@given(few_distances(5, 5))
def test_category_scores_of_equal_distances_are_the_mean_of_all_orders(distances: FloatArray) -> None:
    labels = ["a", "a", "b", "b", "b"]
    scores = []
    for tie_break in itertools.permutations(range(5)):
        scores.append(category_scores(distances + np.array(tie_break) / 100, labels))
    for name in ("nearest_neighbor", "first_tier", "second_tier", "discounted_cumulative_gain"):
        expected = np.mean([getattr(score, name) for score in scores])
        assert getattr(category_scores(distances, labels), name) == pytest.approx(expected)


@given(few_distances(6, 6), st.permutations(range(6)))
def test_category_scores_do_not_depend_on_the_order_of_shapes(
    distances: FloatArray, order: list[int]
) -> None:
    labels = list("aabbbc")
    one = category_scores(distances, labels)
    other = category_scores(distances[np.ix_(order, order)], [labels[index] for index in order])
    assert vars(other) == pytest.approx(vars(one))


def test_category_scores_leave_the_query_itself_out() -> None:
    distances = on_a_line(0, 1, 2, 3)
    np.fill_diagonal(distances, [5, -5, np.inf, 0])
    assert category_scores(distances, list("aabb")) == category_scores(on_a_line(0, 1, 2, 3), list("aabb"))


@pytest.mark.parametrize(
    ("distances", "labels", "message"),
    [
        (np.zeros((2, 3)), list("ab"), r"shape \(2, 2\)"),
        (np.zeros((2, 2)), list("abc"), r"shape \(3, 3\)"),
        (np.zeros((2, 2)), list("ab"), "no class has two"),
        (np.full((2, 2), np.nan), list("aa"), "NaN"),
    ],
)
def test_category_scores_refuse(distances: FloatArray, labels: list[str], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        category_scores(distances, labels)
