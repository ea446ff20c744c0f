# SPDX-License-Identifier: MIT
"""Tests of the procedural things."""

import numpy as np
import pytest

from benchmarks.objects import OBJECT_KINDS, make_object


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
