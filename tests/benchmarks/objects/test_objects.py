# SPDX-License-Identifier: MIT
"""Tests of the procedural things."""

import numpy as np
import pytest

from benchmarks.objects import OBJECT_KINDS, make_object, make_soup
from shapegoogle_core.mesh import Mesh


@pytest.mark.parametrize("kind", OBJECT_KINDS)
def test_members_of_a_kind_are_reproducible_and_differ(kind: str) -> None:
    first, again, other = make_object(kind, 0), make_object(kind, 0), make_object(kind, 1)
    assert np.array_equal(first.vertices, again.vertices)
    assert np.array_equal(first.faces, again.faces)
    assert np.isfinite(first.vertices).all()
    assert first.faces.max() < len(first.vertices)
    assert first.area > 0
    assert first.vertices.shape != other.vertices.shape or not np.allclose(first.vertices, other.vertices)


def test_an_unknown_kind_is_named() -> None:
    with pytest.raises(ValueError, match="no kind of object 'unicorn'; there are cuboid"):
        make_object("unicorn", 0)


@pytest.mark.parametrize("kind", ["chair", "rock"])
def test_soup_is_the_same_thing_with_faces_that_do_not_meet(kind: str) -> None:
    thing, soup, again = make_object(kind, 1), make_soup(kind, 1), make_soup(kind, 1)
    np.testing.assert_array_equal(soup.vertices, again.vertices)
    np.testing.assert_array_equal(soup.faces, again.faces)
    assert np.ptp(soup.vertices, axis=0) == pytest.approx(np.ptp(thing.vertices, axis=0), rel=0.1)

    def open_edges(mesh: Mesh) -> float:
        edges = np.sort(mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        return float((np.unique(edges, axis=0, return_counts=True)[1] != 2).mean())

    many = [open_edges(make_soup(kind, seed)) for seed in range(8)]
    assert max(many) > 0.3 > open_edges(thing)
