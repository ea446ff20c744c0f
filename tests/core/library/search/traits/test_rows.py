# SPDX-License-Identifier: MIT
"""What was read of shapes stays in memory, as far as there is room, and is never that of another shape."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray

from shapegoogle_core.library.library import Library
from shapegoogle_core.library.search.traits.rows import ShapeRows
from shapegoogle_core.library.search.traits.stored import StoredBags

GONE = 13


def test_rows_are_those_of_the_shapes_whatever_is_in_memory() -> None:
    asked: list[int] = []

    def read(shape_ids: Sequence[int]) -> tuple[list[int], tuple[NDArray[np.float64], NDArray[np.bool_]]]:
        asked.extend(shape_ids)
        there = sorted(shape_id for shape_id in shape_ids if shape_id != GONE)
        values = np.array(there, float)
        return there, (np.stack([values, -values], axis=1).reshape(-1, 2), values % 2 == 0)

    rows = ShapeRows(read, most=20)
    random = np.random.default_rng(0)
    for _ in range(50):
        wanted = random.permutation(40)[: random.integers(0, 30)].tolist()
        found, (pairs, is_even) = rows.of(wanted)
        expected = [shape_id for shape_id in wanted if shape_id != GONE]
        assert found.tolist() == expected
        assert pairs.tolist() == [[value, -value] for value in expected]
        assert is_even.tolist() == [value % 2 == 0 for value in expected]
    assert rows.of([1, 2])[0].tolist() == [1, 2]
    before = len(asked)
    rows.of([2, 1])
    assert len(asked) == before


def test_vectors_do_not_depend_on_what_was_read_with_them(tmp_path: Path) -> None:
    """Products of few rows have other last bits; an answer must not depend on earlier searches."""
    random = np.random.default_rng(0)
    with Library.open(tmp_path / "shapes.sglib") as library, library.neighbours_later():
        box = library.model.describe(trimesh.creation.box())
        made = [replace(box, bags=random.random(len(box.bags), np.float32)) for _ in range(20)]
        numbers = [library.add_signature(shape, "made up") for shape in made]
        together, at_once, background = StoredBags(library._store, library.model).read(numbers)
        alone = StoredBags(library._store, library.model)
        for row, number in enumerate(numbers):
            found, vectors, own = alone.read([number])
            assert found.tolist() == [together[row]]
            np.testing.assert_array_equal(vectors[0], at_once[row])
            assert own is not None
            assert background is not None
            assert own[0] == background[row]
