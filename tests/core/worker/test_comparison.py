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
from shapegoogle_core.indexing import describe_shape
from shapegoogle_core.library.placement import placements_of
from shapegoogle_core.library.storage.records import NewShape
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
        assert by_name[name].relative_size(horse.area) == pytest.approx(factor, rel=1e-3)
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


def test_a_match_is_compared_where_its_placement_shows_it(horse: sg.Mesh, tmp_path: Path) -> None:
    """The mesh at hand and the query are those of the third of three objects that share a mesh."""
    matrices = [np.diag([size, size, size, 1.0]) for size in (1.0, 3.0, 0.5)]
    third = matrices[2]
    third[:3, 3] = 4, 1, 2
    path = tmp_path / "shapes.sglib"
    with sg.Library.open(path, sg.load_model()) as library:
        placements = placements_of(horse, list(zip("abc", matrices, strict=True)))
        shape = describe_shape(NewShape(horse, "a", "a", placements=placements), library.model)
        library.replace_source("zoo.blend", size=None, mtime_ns=None, sha256=None, shapes=[shape])
    there = sg.Mesh(horse.vertices @ third[:3, :3].T + third[:3, 3], horse.faces)
    answer = query(path, [there], 1)
    (match,) = explain(path, answer.signatures, answer.matches).values()
    assert match.object_name == "c"
    found = compare_surfaces(path, answer.signatures, match, there, queries=[there])
    assert found.most < 1e-3 * found.size


def test_another_pose_is_shown_at_the_size_that_is_said(tmp_path: Path) -> None:
    creature = make_creature("horse", 2011, vertex_count=1500)
    walking, running = creature.pose("walk"), creature.pose("gallop")
    other = sg.Mesh(2 * running.vertices, running.faces)
    path = tmp_path / "shapes.sglib"
    with sg.Library.open(path, sg.load_model()) as library:
        library.add(other, name="other")
    answer = query(path, [walking], 1)
    (match,) = explain(path, answer.signatures, answer.matches).values()
    found = compare_surfaces(path, answer.signatures, match, other, queries=[walking])
    assert match.evidence is not None
    assert match.evidence.kind == "re-posed"
    shown = sg.Mesh(found.match.vertices.astype(float), found.match.faces).area
    assert match.relative_size(walking.area) == pytest.approx(np.sqrt(other.area / shown), rel=1e-3)
