# SPDX-License-Identifier: MIT
"""A query beside a match: where the match lies on the query, and how far apart they are."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import shapegoogle_core as sg
from benchmarks.creatures import make_creature
from shapegoogle_core.worker.comparison import compare_surfaces
from shapegoogle_core.worker.requests import explain, query


@pytest.fixture(scope="module")
def horse() -> sg.Mesh:
    return make_creature("horse", 2011, vertex_count=1500).pose("walk")


@pytest.fixture(scope="module")
def library(horse: sg.Mesh, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The horse turned, moved and at another size; and its mirror image."""
    turn = Rotation.random(random_state=3).as_matrix()
    path = tmp_path_factory.mktemp("library") / "shapes.sglib"
    with sg.Library.open(path, sg.load_model()) as library:
        library.add(sg.Mesh(2.5 * horse.vertices @ turn.T + [3, 1, 2], horse.faces), name="turned")
        library.add(sg.Mesh(horse.vertices * [-1, 1, 1], horse.faces[:, ::-1]), name="mirrored")
    return path


def test_a_copy_lies_on_the_query_wherever_and_however_large_it_is(library: Path, horse: sg.Mesh) -> None:
    answer = query(library, [horse], 2)
    explained = explain(library, answer.signatures, answer.matches)
    by_name = {match.name: match for match in explained.values()}
    turn = Rotation.random(random_state=3).as_matrix()
    there = {
        "turned": sg.Mesh(2.5 * horse.vertices @ turn.T + [3, 1, 2], horse.faces),
        "mirrored": sg.Mesh(horse.vertices * [-1, 1, 1], horse.faces[:, ::-1]),
    }
    for name, factor in (("turned", 2.5), ("mirrored", 1.0)):
        found = compare_surfaces(library, answer.signatures, by_name[name], there[name], queries=[horse])
        assert found.factor == pytest.approx(factor, rel=1e-3)
        assert found.most < 1e-3 * found.size
        assert found.query.origin == found.match.origin == "mesh"
        # Vertex by vertex in the same place, at the size of the query, around its centre.
        assert np.abs(found.match.vertices - found.query.vertices).max() < 2e-3 * found.size
        assert found.size == pytest.approx(np.sqrt(horse.area), rel=1e-6)


def test_without_the_mesh_its_sample_is_compared(library: Path, horse: sg.Mesh) -> None:
    answer = query(library, [horse], 1)
    found = compare_surfaces(library, answer.signatures, answer.matches[0], queries=[horse])
    assert found.match.origin == "sample"
    assert not len(found.match.faces)
    # Points are on the surface; between them there is nothing to be near to.
    assert np.median(found.match.distances) < 0.01 * found.size
    assert found.query.distances.max() < 0.3 * found.size


def test_distances_grow_with_the_difference(library: Path, horse: sg.Mesh) -> None:
    swollen = horse.vertices.copy()
    head = swollen[:, 0] > np.quantile(swollen[:, 0], 0.9)
    swollen[head] += [0.2, 0, 0]
    answer = query(library, [sg.Mesh(swollen, horse.faces)], 2)
    match = next(match for match in answer.matches if match.name == "turned")
    plain = query(library, [horse], 2)
    near = compare_surfaces(library, plain.signatures, replace(match, alignment=None), queries=[horse])
    far = compare_surfaces(library, answer.signatures, match, queries=[sg.Mesh(swollen, horse.faces)])
    assert far.query.distances[head].mean() > 2 * near.query.distances[head].mean()
