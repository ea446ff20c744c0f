# SPDX-License-Identifier: MIT
"""What a list of matches is sorted by, and how likely two shapes are of one kind."""

from __future__ import annotations

import io
import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import trimesh

from shapegoogle_core.errors import ModelError
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.ranking import FIGURES, Ranking, figures_of
from shapegoogle_core.registration import measure_mesh
from tests.core.tiny_model import build_model


@pytest.fixture(scope="module")
def ranking() -> Ranking:
    return Ranking(
        view_weight=0.6,
        bag_weight=0.3,
        figure_weight=0.1,
        figure_mean=np.zeros(FIGURES, np.float32),
        figure_scale=np.ones(FIGURES, np.float32),
        unknown_views=0.9,
        agreement=0.3,
        power=2.0,
        distinctive=0.7,
        distrust=2.0,
        certain_odds=5.0,
        likeness_half=0.5,
        likeness_slope=3.0,
    )


def test_the_kind_distance_is_a_weighted_sum(ranking: Ranking) -> None:
    found = ranking.kind_distances([0.0, 0.5, 0.5], [0.0, 0.4, np.nan], [0.0, 1.0, 1.0])
    np.testing.assert_allclose(found, [0, 0.24 + 0.15 + 0.1, 0.54 + 0.15 + 0.1])


def test_only_an_agreement_beyond_the_typical_one_brings_a_shape_forward(ranking: Ranking) -> None:
    """A creature in another pose comes before a look-alike; two boxes with nearly equal bags do not."""
    kind = np.array([0.6, 0.3, 0.3])
    posed, other, box = ranking.sorting_distances(kind, [0.1, 0.7, 0.04], [0.8, 0.8, 0.05])
    assert posed < 0.05
    assert other == pytest.approx(0.3, abs=0.01)
    assert box == pytest.approx(0.3, abs=0.01)
    assert ranking.sorting_distances(0.6, 0.0, 0.8) == 0


def test_bags_that_say_little_must_agree_more_closely(ranking: Ranking) -> None:
    """The same share of the typical distance counts less the plainer the shapes are."""
    telling, usual, plain, plainer = ranking.sorting_distances(
        [0.6] * 4, [0.2, 0.175, 0.1, 0.05], [0.8, 0.7, 0.4, 0.2]
    )
    assert telling == pytest.approx(usual)
    assert telling < 0.5 * plain < plainer


def test_a_fit_of_the_surfaces_counts_if_the_shapes_are_surely_the_same(ranking: Ranking) -> None:
    nothing, little, much, certain = ranking.verified_distances(
        [0.6] * 4, [0.1, 0.1, 0.1, 0.1], [0.1, 0.5, 0.99, 1.0]
    )
    assert nothing == 0.6
    assert 0.45 < little < 0.6
    assert much < 0.05
    assert 0 < certain < 1e-6


def test_likeness_falls_from_one(ranking: Ranking) -> None:
    likeness = ranking.likeness([0.0, 0.1, 0.5, 1.0])
    assert likeness[0] == 1
    assert likeness[2] == pytest.approx(0.5)
    assert (np.diff(likeness) < 0).all()


def test_simple_measures_depend_on_the_form_only() -> None:
    def figures(mesh: trimesh.Trimesh) -> np.ndarray:
        own = Mesh(mesh.vertices, mesh.faces)
        return np.asarray(figures_of([measure_mesh(own)], [own.area], [own.extents])[0])

    long, larger = trimesh.creation.box((1, 2, 6)), trimesh.creation.box((3, 18, 6))
    np.testing.assert_allclose(figures(long), figures(larger), atol=1e-4)
    assert np.abs(figures(long) - figures(trimesh.creation.icosphere(2))).max() > 0.5
    assert np.isnan(figures_of([None], [1.0], [(0.0, 0.0, 0.0)])).all()
    assert figures_of([], [], []).shape == (0, FIGURES)


def test_what_is_not_known_counts_as_usual(ranking: Ranking) -> None:
    rows = ranking.standardised(np.array([[np.nan] * FIGURES, [100.0] * FIGURES], np.float32))
    assert (rows[0] == 0).all()
    assert (rows[1] == 3).all()


def test_the_file_keeps_the_ranking_and_the_identifier(ranking: Ranking) -> None:
    model = build_model()
    complete = model.with_parts(ranking=ranking)
    again = ShapeModel.from_bytes(complete.to_bytes())
    assert again.identifier == model.identifier
    assert again.ranking is not None
    assert again.ranking.view_weight == 0.6
    assert again.ranking.likeness_slope == 3.0
    np.testing.assert_array_equal(again.ranking.figure_scale, ranking.figure_scale)


def test_a_ranking_of_an_earlier_kind_is_left_out(ranking: Ranking) -> None:
    complete = build_model().with_parts(ranking=ranking)
    with np.load(io.BytesIO(complete.to_bytes())) as archive:
        arrays = dict(archive)
    header = json.loads(str(arrays["header"]))
    del header["ranking"]["distrust"]
    arrays["header"] = np.array(json.dumps(header))
    data = io.BytesIO()
    np.savez(data, **arrays)
    assert ShapeModel.from_bytes(data.getvalue()).ranking is None


@pytest.mark.parametrize(
    "changes", [{"agreement": 0.0}, {"power": -1.0}, {"view_weight": np.nan}, {"figure_mean": np.zeros(3)}]
)
def test_damaged_numbers_are_refused(ranking: Ranking, changes: dict[str, Any]) -> None:
    with pytest.raises(ModelError, match="ranking is damaged"):
        replace(ranking, **changes)
