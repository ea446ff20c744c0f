# SPDX-License-Identifier: MIT
"""Shapes side by side, for the examples of the documentation."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
import trimesh

from benchmarks.figures.shape_rows import show_shapes


@pytest.fixture(autouse=True)
def figures_without_a_window() -> Iterator[None]:
    mpl = pytest.importorskip("matplotlib")
    from matplotlib import pyplot

    before = mpl.get_backend()
    pyplot.switch_backend("agg")
    yield
    pyplot.close("all")
    pyplot.switch_backend(before)


def test_shapes_are_drawn_in_rows_with_captions_and_colours() -> None:
    ball, box = trimesh.creation.icosphere(1), trimesh.creation.box()
    red = np.tile([1.0, 0.0, 0.0], (len(ball.vertices), 1))
    figure = show_shapes([ball, box, box], ["ball", "box", "again"], [red, None, None], columns=2)
    assert [axes.get_title() for axes in figure.axes] == ["ball", "box", "again", ""]
    drawn = [axes.get_images()[0].get_array() for axes in figure.axes[:3]]
    middle = [np.asarray(picture)[210, 210] for picture in drawn]
    assert middle[0][0] > middle[0][1] + 50
    assert abs(int(middle[1][0]) - int(middle[1][2])) < 50
    np.testing.assert_array_equal(drawn[1], drawn[2])


@pytest.mark.parametrize("captions", [["one"], []])
def test_each_shape_needs_a_caption(captions: list[str]) -> None:
    with pytest.raises(ValueError, match="2 shapes need as many captions"):
        show_shapes([trimesh.creation.box()] * 2, captions)
