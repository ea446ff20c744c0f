# SPDX-License-Identifier: MIT
"""Where pictures are in the large gallery, and what is at a place: areas of all sizes, scales and numbers."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from types import ModuleType
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

lengths = st.floats(30, 4000)
scales = st.sampled_from([0.75, 1.0, 1.5, 2.0, 3.0])


@pytest.fixture(scope="session")
def layout(addon: ModuleType) -> Any:
    import importlib

    return importlib.import_module(f"{addon.__name__}.gallery.editor.layout")


@pytest.fixture(scope="session")
def cells(addon: ModuleType) -> Any:
    import importlib

    return importlib.import_module(f"{addon.__name__}.gallery.editor.grid")


@settings(max_examples=25, deadline=None)
@given(lengths, lengths, scales, st.integers(0, 60), st.integers(96, 256), st.floats(0, 1))
def test_every_cell_is_found_where_it_is(
    layout: Any, cells: Any, width: float, height: float, scale: float, count: int, picture: int, share: float
) -> None:
    box = layout.Box(10, 20, 10 + width, 20 + height)
    grid = cells.Grid.of(box, count, picture, scale)
    scroll = share * grid.largest_scroll
    shown = grid.visible(scroll)
    for index in range(count):
        cell = grid.cell(index, scroll)
        x, y = (cell.left + cell.right) / 2, (cell.bottom + cell.top) / 2
        inside = box.holds(x, y)
        assert grid.at(x, y, scroll) == (index if inside else None)
        assert index in shown or not inside
        assert cell.left >= box.left
        assert cell.right <= box.right
        picture_box = grid.picture_in(cell)
        assert picture_box.width <= max(picture * scale, 16 * scale) + 1e-6
        assert picture_box.bottom >= grid.lines_in(cell)[-1].bottom - 1e-6
    if count:
        # The last one can be reached.
        last = grid.cell(count - 1, grid.largest_scroll)
        assert last.bottom >= box.bottom - 1e-6 or grid.cell_height > box.height


def test_cells_do_not_overlap_and_gaps_belong_to_none(layout: Any, cells: Any) -> None:
    grid = cells.Grid.of(layout.Box(0, 0, 1000, 600), 10, 160, 1.0)
    assert grid.columns == 5
    cells = [grid.cell(index, 0) for index in range(10)]
    for left, right in pairwise(cells[:5]):
        assert right.left - left.right == pytest.approx(grid.gap)
        assert grid.at((left.right + right.left) / 2, left.top - 5, 0) is None
    assert grid.at(500, 599.9, 0) is None
    assert grid.at(-1, 500, 0) is None


def test_pictures_shrink_where_not_even_one_fits(layout: Any, cells: Any) -> None:
    grid = cells.Grid.of(layout.Box(0, 0, 110, 400), 3, 256, 1.0)
    assert (grid.columns, grid.rows) == (1, 3)
    assert grid.picture <= 110


def test_what_is_chosen_scrolls_into_view(layout: Any, cells: Any) -> None:
    grid = cells.Grid.of(layout.Box(0, 0, 500, 400), 100, 128, 1.0)
    for index in (99, 0, 50):
        scroll = grid.shown(index, 123.0)
        cell = grid.cell(index, scroll)
        assert cell.top <= 400
        assert cell.bottom >= 0
    # What can be seen already stays where it is.
    assert grid.shown(50, grid.shown(50, 0)) == grid.shown(50, 0)


@pytest.mark.parametrize(
    ("index", "key", "target"),
    [
        (-1, "RIGHT_ARROW", 0),
        (0, "LEFT_ARROW", 0),
        (0, "RIGHT_ARROW", 1),
        (0, "DOWN_ARROW", 5),
        (4, "UP_ARROW", 4),
        (8, "DOWN_ARROW", 11),  # the last row is shorter
        (11, "DOWN_ARROW", 11),
        (3, "END", 11),
        (11, "HOME", 0),
        (2, "PAGE_DOWN", 11),
        (11, "PAGE_UP", 1),
    ],
)
def test_keys_lead_from_cell_to_cell(layout: Any, cells: Any, index: int, key: str, target: int) -> None:
    grid = cells.Grid.of(layout.Box(0, 0, 1000, 700), 12, 160, 1.0)
    assert grid.columns == 5
    assert grid.step(index, key) == target
    assert cells.Grid.of(layout.Box(0, 0, 1000, 700), 0, 160, 1.0).step(-1, key) == -1


def test_the_handle_follows_the_scroll_and_the_scroll_the_handle(layout: Any, cells: Any) -> None:
    grid = cells.Grid.of(layout.Box(0, 0, 500, 400), 200, 128, 1.0)
    top, bottom = grid.handle(0), grid.handle(grid.largest_scroll)
    assert top.top == pytest.approx(grid.bar.top, abs=3)
    assert bottom.bottom == pytest.approx(grid.bar.bottom, abs=3)
    assert grid.dragged(0, top.top - bottom.top) == pytest.approx(grid.largest_scroll)
    assert cells.Grid.of(layout.Box(0, 0, 500, 400), 2, 128, 1.0).handle(0) is None


@settings(max_examples=25, deadline=None)
@given(st.floats(200, 4000), st.floats(120, 3000), scales)
def test_buttons_are_inside_and_apart(layout: Any, width: float, height: float, scale: float) -> None:
    bars = layout.arrange(layout.Box(0, 0, width * scale, height * scale), scale)
    buttons = [bars.smaller, bars.larger, bars.close]
    for box in buttons:
        assert 0 <= box.left < box.right <= width * scale
        assert box.top <= height * scale
        name = bars.button_at((box.left + box.right) / 2, (box.bottom + box.top) / 2)
        assert getattr(bars, name) == box
    for left, right in pairwise([bars.search, *buttons]):
        assert left.right <= right.left + 1e-6
    assert bars.content.top <= bars.close.bottom
    assert bars.status.top == bars.content.bottom


def test_regions_on_top_leave_the_rest(layout: Any) -> None:
    box = layout.unobstructed(1000, 600, [("LEFT", 50), ("RIGHT", 300), ("TOP", 1)])
    assert (box.left, box.bottom, box.right, box.top) == (50, 0, 700, 600)
    assert layout.unobstructed(100, 600, [("LEFT", 80), ("RIGHT", 300)]).width == 0


@pytest.mark.parametrize("text", ["", "a", "Horse", "A very long name of a shape.blend", "x" * 300])
@pytest.mark.parametrize("width", [0, 1, 5, 20, 1000])
def test_texts_are_shortened_in_their_middle(layout: Any, text: str, width: int) -> None:
    measure: Callable[[str], float] = len
    short = layout.shortened(text, width, measure)
    assert len(short) <= width or not short
    if len(text) <= width:
        assert short == text
    elif width > 5:
        assert "…" in short
        assert text.startswith(short.partition("…")[0])
        assert text.endswith(short.partition("…")[2])


def test_typing(addon: ModuleType) -> None:
    import importlib

    typed = importlib.import_module(f"{addon.__name__}.gallery.editor.typed_text").TypedText()
    typed = typed.with_input("red\nhorses")
    assert (typed.text, typed.caret) == ("red horses", 10)
    assert typed.with_key("BACK_SPACE").text == "red horse"
    assert typed.with_key("BACK_SPACE", word=True).text == "red "
    assert typed.with_key("HOME").with_input("The ").text == "The red horses"
    assert typed.with_key("LEFT_ARROW").with_key("DEL").text == "red horse"
    assert typed.with_key("HOME").with_key("RIGHT_ARROW", word=True).caret == 3
    assert typed.with_key("HOME").with_key("LEFT_ARROW").caret == 0
    assert typed.with_key("F5") is None


@pytest.mark.parametrize(
    ("wanted", "found"),
    [("HORSE", True), ("hor*", True), ("*.blend", True), ("h?rse", True), ("[h]orse", False), ("cow", False)],
)
def test_the_filter_while_typing_is_that_of_the_search(addon: ModuleType, wanted: str, found: bool) -> None:
    import importlib

    filtering = importlib.import_module(f"{addon.__name__}.gallery.editor.filtering")
    assert filtering.has_text(("Horse", "animals/horse.blend"), wanted) == found


def test_the_ends_of_scales_are_round_and_views_never_upside_down(addon: ModuleType) -> None:
    import importlib

    turning = importlib.import_module(f"{addon.__name__}.gallery.compare.turning")
    assert [turning.rounded_up(value) for value in (0, 0.011, 0.02, 0.36, 7.3, 8)] == pytest.approx(
        [1, 0.015, 0.02, 0.4, 10, 10]
    )
    direction = turning.turned(turning.Direction(), 0, -10_000)
    assert direction.above == pytest.approx(math.pi / 2)
    for up_axis in (1, 2):
        right, up, toward = turning.rows(turning.turned(direction, 40, 90), up_axis)
        for one, other in ((right, up), (up, toward), (toward, right)):
            assert sum(a * b for a, b in zip(one, other, strict=True)) == pytest.approx(0)
        assert right[up_axis] == 0
        assert up[up_axis] >= 0
    # A shape fits however it is turned.
    for above in (0.0, 0.7, -1.5):
        scale = turning.pixels_per_unit(turning.Direction(1.0, above), 3.0, 1.0, 600, 400)
        assert 3.0 * scale <= 300 + 1e-6
        assert (1.0 * math.cos(above) + 3.0 * abs(math.sin(above))) * scale <= 200 + 1e-6
