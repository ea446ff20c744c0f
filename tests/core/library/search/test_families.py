# SPDX-License-Identifier: MIT
"""Families of matches: different shapes, the best of each in front."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import shapegoogle_core as sg
from benchmarks.creatures import make_creature
from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.search.settings import CandidateSettings, FamilySettings, SearchSettings
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeModel, ShapeSignature

VERSIONS, OTHERS = 70, 6
FEW_CANDIDATES = SearchSettings(
    candidates=CandidateSettings(count=5, per_match=1), families=FamilySettings(at_once=7)
)


@pytest.fixture(scope="module")
def crowded_file(
    tmp_path_factory: pytest.TempPathFactory, model: ShapeModel, make_signature: Callable[..., ShapeSignature]
) -> Path:
    """A library with 70 versions of one shape among six others."""
    path = tmp_path_factory.mktemp("crowded") / "shapes.sglib"
    random = np.random.default_rng(0)
    original = make_signature(0)
    with Library.open(path, model) as library:
        for seed in range(1, OTHERS + 1):
            library.add_signature(make_signature(seed), f"other {seed}", source="others.blend")
        for number in range(VERSIONS):
            noise = random.standard_normal(original.bags.shape).astype(np.float32)
            bags = np.asarray(original.bags * (1 + np.float32(0.005) * noise), np.float32)
            version = replace(original, bags=bags, code=model.codes(bags[None])[0])
            library.add_signature(version, f"version {number}", source=f"versions/{number}.obj")
    return path


@pytest.fixture
def crowded(crowded_file: Path) -> Iterator[Library]:
    with Library.open(crowded_file, read_only=True, search=FEW_CANDIDATES) as library:
        yield library


@pytest.mark.parametrize("exact", [False, True])
def test_many_versions_take_one_place(
    crowded: Library, make_signature: Callable[..., ShapeSignature], exact: bool
) -> None:
    query = make_signature(0)
    plain = crowded.query(query, top=10, exact=exact)
    assert {match.name.split()[0] for match in plain} == {"version"}
    assert [match.versions for match in plain] == [0] * 10

    found = crowded.query(query, top=10, exact=exact, families=True)
    assert len(found) == OTHERS + 1
    # Going on, a search with few candidates may meet a better one.
    (best,) = crowded.query(query, top=1, exact=True)
    assert found[0].shape_id == best.shape_id
    assert found[0].versions == VERSIONS - 1 == len(set(found[0].version_ids) - {found[0].shape_id})
    assert {match.name.split()[0] for match in found[1:]} == {"other"}
    assert [match.versions for match in found[1:]] == [0] * OTHERS
    assert [match.rank_key for match in found] == sorted(match.rank_key for match in found)
    # They stay what they are in a search without families.
    everything = {match.shape_id: match for match in crowded.query(query, top=100, exact=True)}
    assert all(match.distance == everything[match.shape_id].distance for match in found)

    versions = crowded.versions(query, found[0])
    assert [match.shape_id for match in versions[:10]] == [
        match.shape_id for match in crowded.query(query, top=10, exact=True)
    ]
    assert {match.name.split()[0] for match in versions} == {"version"}
    assert len(versions) == VERSIONS


def test_filters_act_in_the_search(crowded: Library, make_signature: Callable[..., ShapeSignature]) -> None:
    query = make_signature(0)

    def found(where: Filter, top: int = 3) -> list[str]:
        return [match.name for match in crowded.query(query, top=top, where=where, families=True)]

    assert len(found(Filter(not_sources=("others.blend",)))) == 1
    assert [name.split()[0] for name in found(Filter(sources=("others.blend",)))] == ["other"] * 3
    assert found(Filter(sources=("versions/5.obj",))) == ["version 5"]
    assert (
        found(Filter(name="version 7*"), 9)
        == [
            name
            for name in (match.name for match in crowded.query(query, top=80))
            if name.startswith("version 7")
        ][:1]
    )
    least = crowded.query(query, top=3, families=True)[2].similarity
    assert len(found(Filter(min_similarity=least), 10)) == 3
    assert found(Filter(name="nothing")) == []


def test_a_limit_of_the_matches_gone_through(
    crowded_file: Path, make_signature: Callable[..., ShapeSignature]
) -> None:
    limited = replace(FEW_CANDIDATES, families=FamilySettings(most_met=20))
    with Library.open(crowded_file, read_only=True, search=limited) as library:
        (only,) = library.query(make_signature(0), top=5, families=True)
    assert 5 <= only.versions < 25


@pytest.fixture(scope="module")
def creatures(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Library, Mesh]]:
    """Poses, a mirror image and another size of one creature, another creature, a cube and a ball."""
    creature = make_creature("ape", 0, 1_000)
    mesh = creature.pose(2)
    trimesh = pytest.importorskip("trimesh")
    mirrored = Mesh(mesh.vertices * [-1, 1, 1], mesh.faces[:, ::-1])
    with sg.Library.open(tmp_path_factory.mktemp("creatures") / "shapes.sglib") as library:
        library.add(mesh, name="ape")
        library.add(creature.pose(1), name="ape, another pose")
        library.add(mirrored, name="ape, mirrored")
        library.add(Mesh(2 * mesh.vertices, mesh.faces), name="ape, larger")
        library.add(make_creature("bird", 0, 1_000).rest, name="bird")
        library.add(trimesh.creation.box(), name="cube")
        library.add(trimesh.creation.icosphere(3), name="ball")
        yield library, mesh


def test_poses_and_sizes_are_one_family_but_plain_solids_are_not(creatures: tuple[Library, Mesh]) -> None:
    library, mesh = creatures
    found = library.query(mesh, families=True)
    assert {match.name: match.versions for match in found} == {"ape": 3, "bird": 0, "cube": 0, "ball": 0}
    assert found[0].evidence is not None
    assert found[0].evidence.kind == "identical"
    # Another member stands for the family if only it has the kind.
    (only,) = library.query(mesh, families=True, where=Filter(kind="mirrored"))
    assert (only.name, only.versions) == ("ape, mirrored", 3)
    kinds = {match.name: match.evidence for match in library.versions(mesh, only)}
    assert {name: evidence.kind for name, evidence in kinds.items() if evidence is not None} == {
        "ape": "identical",
        "ape, larger": "scaled",
        "ape, mirrored": "mirrored",
        "ape, another pose": "re-posed",
    }
