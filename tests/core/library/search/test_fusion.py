# SPDX-License-Identifier: MIT
"""One list: the same shape in any pose first, then shapes of the same kind."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import shapegoogle_core as sg
from benchmarks.creatures import make_creature
from benchmarks.objects import make_object
from tests.core.tiny_model import build_model

CHAIRS = ("chair 1", "chair 2", "chair 3")
THINGS = ("sword 1", "bottle 1", "car 1", "staircase 1", "cuboid 1")


@pytest.fixture(scope="module")
def shapes() -> dict[str, sg.ShapeSignature]:
    model = sg.load_model()
    meshes = {}
    for name in (*CHAIRS, *THINGS):
        kind, seed = name.rsplit(" ", 1)
        meshes[name] = make_object(kind, int(seed))
    horse = make_creature("horse", 300)
    meshes |= {f"horse in pose {pose}": horse.pose(pose) for pose in (0, 1)}
    meshes["other horse in pose 0"] = make_creature("horse", 301).pose(0)
    return {name: model.describe(mesh) for name, mesh in meshes.items()}


@pytest.fixture(scope="module")
def library(
    shapes: dict[str, sg.ShapeSignature], tmp_path_factory: pytest.TempPathFactory
) -> Iterator[sg.Library]:
    with sg.Library.open(tmp_path_factory.mktemp("fusion") / "shapes.sglib") as library:
        for name, signature in shapes.items():
            library.add_signature(signature, name)
        yield library


def names(matches: list[sg.Match]) -> list[str]:
    return [match.name for match in matches]


@pytest.mark.parametrize("rank", ["both", "kind"])
@pytest.mark.parametrize("exact", [False, True])
def test_a_chair_finds_chairs(
    rank: Any, exact: bool, library: sg.Library, shapes: dict[str, sg.ShapeSignature]
) -> None:
    matches = library.query(shapes["chair 1"], top=20, explain=0, rank=rank, exact=exact)
    assert matches[0].name == "chair 1"
    assert matches[0].distance == 0
    assert matches[0].likeness == 1
    assert set(names(matches)[:3]) == set(CHAIRS)
    assert len(matches) == len(shapes)
    assert [match.distance for match in matches] == sorted(match.distance for match in matches)


def test_another_pose_comes_before_another_individual_in_the_same_pose(
    library: sg.Library, shapes: dict[str, sg.ShapeSignature]
) -> None:
    matches = library.query(shapes["horse in pose 0"], top=3, explain=0)
    assert names(matches) == ["horse in pose 0", "horse in pose 1", "other horse in pose 0"]


def test_likeness_is_of_the_pair_whatever_the_order(
    library: sg.Library, shapes: dict[str, sg.ShapeSignature], tmp_path: Path
) -> None:
    by_rank = [
        {m.name: m.likeness for m in library.query(shapes["chair 1"], top=20, explain=0, rank=rank)}
        for rank in ("shape", "kind", "both")
    ]
    for name, likeness in by_rank[0].items():
        assert by_rank[1][name] == pytest.approx(likeness, abs=1e-5)
        assert by_rank[2][name] == pytest.approx(likeness, abs=1e-5)
    with sg.Library.open(tmp_path / "one.sglib") as other:
        other.add_signature(shapes["chair 2"], "chair 2")
        (alone,) = other.query(shapes["chair 1"], explain=0)
    assert alone.likeness == pytest.approx(by_rank[0]["chair 2"], abs=1e-5)
    assert alone.to_json()["likeness"] == pytest.approx(alone.likeness, abs=1e-6)


def test_negative_examples_and_filters_work_in_the_order_by_kind(
    library: sg.Library, shapes: dict[str, sg.ShapeSignature]
) -> None:
    without = library.query(shapes["chair 1"], top=20, explain=0, unlike=shapes["chair 2"])
    assert names(without)[-1] == "chair 2"
    where = sg.Filter(name="chair*")
    assert set(names(library.query(shapes["sword 1"], top=20, explain=0, where=where))) == set(CHAIRS)
    pooled = library.query([shapes["chair 1"], shapes["chair 2"]], top=3, explain=0)
    assert set(names(pooled)) == set(CHAIRS)


def test_a_least_similarity_is_that_of_the_shown_figures(
    library: sg.Library, shapes: dict[str, sg.ShapeSignature]
) -> None:
    shown = library.query(shapes["horse in pose 0"], top=20, explain=20)
    for least in (0.2, 0.5, 0.9):
        expected = [match.name for match in shown if match.similarity >= least]
        found = library.query(
            shapes["horse in pose 0"], top=20, explain=20, where=sg.Filter(min_similarity=least)
        )
        assert names(found) == expected
        assert all(match.similarity >= least for match in found)


def test_the_kind_is_told_where_it_is_clear(
    library: sg.Library, shapes: dict[str, sg.ShapeSignature]
) -> None:
    for match in library.query(shapes["chair 1"], top=20, explain=20):
        assert match.evidence is not None
        assert match.likeness is not None
        if match.evidence.kind == "same kind":
            assert match.likeness >= 0.5 > match.similarity
        if match.evidence.kind == "nothing in common":
            assert max(match.likeness, match.similarity) <= 0.2
        assert match.evidence.kind != "similar" or max(match.likeness, match.similarity) > 0.2
    kinds = {m.name: m.evidence and m.evidence.kind for m in library.query(shapes["chair 1"], explain=10)}
    assert "nothing in common" in kinds.values()


def test_shapes_without_views_are_ordered_by_what_is_known(
    shapes: dict[str, sg.ShapeSignature], tmp_path: Path
) -> None:
    with sg.Library.open(tmp_path / "old.sglib") as library:
        for name in (*CHAIRS, *THINGS):
            library.add_signature(replace(shapes[name], views=None, view_code=None), name)
        matches = library.query(shapes["chair 1"], top=20, explain=0)
    assert names(matches)[0] == "chair 1"
    assert np.isfinite([match.distance for match in matches]).all()
    assert len(matches) == len(CHAIRS) + len(THINGS)


def test_a_model_that_has_not_learnt_about_kinds_orders_by_shape(tmp_path: Path) -> None:
    model = build_model()
    with sg.Library.open(tmp_path / "tiny.sglib", model) as library:
        mesh = make_object("chair", 1)
        library.add(mesh, "chair")
        for rank in ("both", "kind", "shape"):
            (match,) = library.query(mesh, rank=rank)
            assert match.likeness is None
            assert match.distance == 0


def test_an_unknown_order_is_named(library: sg.Library, shapes: dict[str, sg.ShapeSignature]) -> None:
    size: Any = "size"
    with pytest.raises(ValueError, match="there is no order 'size'; choose one of shape, kind, both"):
        library.query(shapes["chair 1"], rank=size)
