# SPDX-License-Identifier: MIT
"""Models as rows: full bags, codes alone, and the library's own answers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.protocol.cache import BenchmarkCache
from benchmarks.protocol.collection import Collection, database_shape
from benchmarks.protocol.matching import Matched
from benchmarks.protocol.workshop import Workshop
from benchmarks.variants.model_variants import _in_order, hamming, model_group
from shapegoogle_core.library.library import Library
from shapegoogle_core.model import ShapeModel
from tests.benchmarks.conftest import relevant_columns


@pytest.fixture(scope="module")
def matched(
    collection: Collection, tiny_model: ShapeModel, tmp_path_factory: pytest.TempPathFactory
) -> dict[str, Matched]:
    cache = BenchmarkCache(tmp_path_factory.mktemp("cache"))
    workshop = Workshop(cache, jobs=0, progress=lambda items, _title, _total: items)
    group = model_group(tiny_model)
    found = list(group.match(workshop, collection.queries, collection.database))
    assert workshop.problems == ()
    return {str(entry.variant.parameters["stage"]): entry for entry in found}


def test_rows_are_what_the_model_says(
    matched: dict[str, Matched], collection: Collection, tiny_model: ShapeModel
) -> None:
    known = [tiny_model.describe(shape.mesh()) for shape in collection.database]
    asked = [tiny_model.describe(query.mesh()) for query in collection.queries]
    bags = np.array([signature.bags for signature in known])
    expected = [tiny_model.distances(signature.bags, bags) for signature in asked]
    np.testing.assert_allclose(matched["full bags"].distances, expected, atol=1e-6)
    differing = [[np.unpackbits(a.code ^ b.code).sum() for b in known] for a in asked]
    np.testing.assert_array_equal(matched["codes"].distances, differing)
    assert matched["codes"].bytes_per_shape == 8
    assert matched["full bags"].bytes_per_shape == 2 * tiny_model.bag_size


def test_the_search_is_the_librarys(
    matched: dict[str, Matched], collection: Collection, tiny_model: ShapeModel, tmp_path: Path
) -> None:
    found = matched["search"].distances
    assert np.isfinite(found).all()
    with Library.open(tmp_path / "shapes.sglib", tiny_model) as library:
        for shape in collection.database:
            library.add(shape.mesh(), name=shape.name, source=str(shape.path))
        for row, query in zip(found, collection.queries, strict=True):
            matches = library.query(query.mesh(), top=10)
            order = [collection.database[column].name for column in np.argsort(row)]
            assert order == [match.name for match in matches]
            assert np.abs(np.sort(row) - [match.distance for match in matches]).max() < 1e-4
    assert matched["search"].bytes_per_shape > 0


def test_scaled_shapes_are_found_first(matched: dict[str, Matched], collection: Collection) -> None:
    for entry in matched.values():
        own = entry.distances[np.arange(6), relevant_columns(collection)]
        assert (own <= entry.distances.min(axis=1)).all()


def test_a_shape_that_fails_stands_last(
    workshop: Workshop, collection: Collection, tiny_model: ShapeModel, tmp_path: Path
) -> None:
    (tmp_path / "broken.off").write_text("OFF\n")
    broken = database_shape(tmp_path / "broken.off", "negative")
    database = (*collection.database, broken)
    for entry in model_group(tiny_model).match(workshop, collection.queries[:1], database):
        assert np.isinf(entry.distances[:, -1]).all()
        assert np.isfinite(entry.distances[:, :-1]).all()
    assert [problem.shape for problem in workshop.problems] == ["broken"]


def test_choosing_one_row_computes_that(
    workshop: Workshop, collection: Collection, tiny_model: ShapeModel
) -> None:
    group = model_group(tiny_model, "mine").only({"mine · 64-bit codes"})
    (entry,) = group.match(workshop, collection.queries, collection.database)
    assert entry.variant.family == "codes"
    assert not (workshop.cache.folder / "libraries").exists()


def test_hamming_counts_differing_bits() -> None:
    first = np.array([[0, 255]], np.float32)
    second = np.array([[0, 255], [1, 255], [255, 0]], np.float32)
    np.testing.assert_array_equal(hamming(first, second), [[0, 1, 16]])


def test_answers_keep_their_order() -> None:
    distances = np.array([0.1, 0.1, 0.3, 0.2, 0.4])
    ordered = _in_order(distances)
    assert (np.diff(ordered) > 0).all()
    np.testing.assert_allclose(ordered, [0.1, 0.1, 0.3, 0.3, 0.4], atol=1e-7)
