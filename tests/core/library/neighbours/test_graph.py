# SPDX-License-Identifier: MIT
"""The neighbour graph of a library: incremental, with several writers, and never wrong."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

from shapegoogle_core.library.library import Library
from shapegoogle_core.library.neighbours.pairs import TraitPairs
from shapegoogle_core.library.search.traits.stored import StoredTraits
from shapegoogle_core.model import ShapeModel, load_model
from shapegoogle_core.model.signature import ShapeSignature

COUNT = 30


@pytest.fixture(scope="module")
def model() -> ShapeModel:
    return load_model()


@pytest.fixture(scope="module")
def signatures(model: ShapeModel) -> list[ShapeSignature]:
    """Made-up shapes: some kinds around a few centres."""
    box = replace(model.describe(trimesh.creation.box()), sample=None, measures=None)
    random = np.random.default_rng(0)
    centres = random.gamma(0.5, 1, (3, len(box.bags)))
    made = []
    for number in range(COUNT):
        bags = centres[number % 3] + random.gamma(0.3, 1, len(box.bags))
        bags = (bags / bags.sum() * box.bags.sum()).astype(np.float32)
        made.append(replace(box, bags=bags, code=model.codes(bags[None])[0]))
    return made


@pytest.fixture
def library(tmp_path: Path, model: ShapeModel, signatures: list[ShapeSignature]) -> Iterator[Library]:
    with Library.open(tmp_path / "shapes.sglib", model) as opened:
        for number, signature in enumerate(signatures):
            opened.add_signature(signature, f"shape {number}")
        yield opened


def neighbours(library: Library) -> dict[int, list[int]]:
    shape_ids = [shape.shape_id for shape in library.shapes()]
    rows = library._store.neighbours(shape_ids)
    return {shape_id: rows[shape_id][0].tolist() for shape_id in shape_ids if shape_id in rows}


def nearest(library: Library, shape_id: int, count: int) -> list[int]:
    """Nearest shapes by comparing with all."""
    others = [shape.shape_id for shape in library.shapes() if shape.shape_id != shape_id]
    distances = TraitPairs(StoredTraits(library._store, library.model)).between(shape_id, others)
    return [others[place] for place in np.argsort(distances, kind="stable")[:count]]


def check_nearest(library: Library, found: dict[int, list[int]]) -> None:
    """The four nearest have the least distances; some shapes are equally near."""
    pairs = TraitPairs(StoredTraits(library._store, library.model))
    for shape_id, ids in found.items():
        expected = pairs.between(shape_id, nearest(library, shape_id, 4))
        np.testing.assert_allclose(pairs.between(shape_id, ids[:4]), expected, atol=2e-6)


def test_adding_shapes_one_by_one_finds_the_neighbours_of_all(library: Library) -> None:
    found = neighbours(library)
    assert len(found) == COUNT
    check_nearest(library, found)


def test_two_writers_complete_each_other(
    tmp_path: Path, model: ShapeModel, signatures: list[ShapeSignature]
) -> None:
    path = tmp_path / "shared.sglib"
    with Library.open(path, model) as one, Library.open(path) as two:
        for number, signature in enumerate(signatures):
            (one, two)[number % 2].add_signature(signature, f"shape {number}")
        check_nearest(two, neighbours(one))


def test_removed_neighbours_are_replaced(library: Library) -> None:
    for shape_id in nearest(library, 1, 6):
        library.remove_shape(shape_id)
    assert len(library.query(library.signature(1), top=COUNT, explain=0)) == COUNT - 6
    assert library.update_neighbours() > 0
    check_nearest(library, {1: neighbours(library)[1]})
    assert library.update_neighbours() == 0


def test_a_graph_that_lags_behind_is_completed(library: Library) -> None:
    with library._store.connection:  # type: ignore[attr-defined]
        library._store.connection.execute("DELETE FROM neighbours WHERE shape_id > 5")  # type: ignore[attr-defined]
    matches = library.query(library.signature(2), top=COUNT, explain=0)
    assert len({match.shape_id for match in matches}) == COUNT
    assert library.update_neighbours() == COUNT - 5
    check_nearest(library, neighbours(library))


def test_the_list_is_sorted_by_distance_and_similarities_are_those_of_the_pairs(library: Library) -> None:
    signature = library.signature(3)
    matches = library.query(signature, top=COUNT, explain=0)
    distances = [match.distance for match in matches]
    assert distances == sorted(distances)
    others = [match.shape_id for match in matches]
    unwalked = TraitPairs(StoredTraits(library._store, library.model)).between(3, others)
    # The first few keep their places, and the walk only brings shapes nearer.
    np.testing.assert_allclose(distances[:3], np.sort(unwalked)[:3], atol=2e-6)
    assert (np.array(distances) <= unwalked + 2e-6).all()
    assert (np.array(distances) < unwalked - 1e-5).any()
    assert all(match.likeness is not None for match in matches)
    by_bags = [match.bag_distance or 0 for match in matches]
    typical = [match.typical_distance for match in matches]
    expected = library.model.similarity(np.array(by_bags), np.array(typical, float))
    np.testing.assert_allclose([match.similarity for match in matches], expected)
    kind = [(match.shape_id - 1) % 3 for match in matches[:10]]
    assert kind.count((3 - 1) % 3) == 10
