# SPDX-License-Identifier: MIT
"""The figures of a pair of shapes do not depend on what else is in the library."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

import shapegoogle_core as sg
from benchmarks.experiments.evidence_pairs import EvidencePair


@pytest.fixture(scope="module")
def asked(pairs: list[EvidencePair]) -> sg.ShapeSignature:
    return sg.load_model().describe(pairs[0].query, keep_surface=True)


@pytest.fixture(scope="module")
def explained(answers: tuple[sg.Library, dict[str, object]], asked: sg.ShapeSignature) -> list[sg.Match]:
    library, _ = answers
    return library.query(asked, top=20, explain=20)


def figures(match: sg.Match) -> tuple[float, object]:
    return match.similarity, match.evidence


def test_a_pair_has_the_same_figures_with_and_without_other_shapes(
    explained: list[sg.Match], asked: sg.ShapeSignature, pairs: list[EvidencePair], tmp_path: Path
) -> None:
    """The large library holds the query itself, so that its search is conclusive; the small ones do not."""
    together = {match.name: match for match in explained}
    for detail in ("other pose", "a part", "another individual of its kind"):
        candidate = next(pair.candidate for pair in pairs if pair.detail == detail)
        with sg.Library.open(tmp_path / f"{detail}.sglib") as alone:
            alone.add(candidate, detail)
            (match,) = alone.query(asked)
        compared = sg.compare(pairs[0].query, candidate)
        assert figures(match) == figures(together[detail]) == figures(compared), detail


def test_without_evidence_the_similarity_is_that_of_the_bags(
    answers: tuple[sg.Library, dict[str, object]], asked: sg.ShapeSignature
) -> None:
    library, _ = answers
    for match in library.query(asked, top=20, explain=0):
        bags = library.signature(match.shape_id).bags
        distances = library.model.distances(asked.bags, bags[None])
        typical = library.model.typical_distances(asked.bags, bags[None])
        expected = library.model.similarity(distances, typical)[0]
        assert match.similarity == pytest.approx(expected, abs=5e-4)


def test_verification_does_not_change_the_order_of_a_conclusive_search(
    answers: tuple[sg.Library, dict[str, object]], asked: sg.ShapeSignature, explained: list[sg.Match]
) -> None:
    library, _ = answers
    plain = library.query(asked, top=20, explain=0)
    assert [match.name for match in explained] == [match.name for match in plain]
    assert [match.distance for match in explained] == [match.distance for match in plain]


def test_of_equally_near_copies_the_identical_one_comes_first(tmp_path: Path) -> None:
    box = trimesh.creation.box((1, 2, 3))
    with sg.Library.open(tmp_path / "boxes.sglib") as library:
        for name, shift in (("a", 5.0), ("b", 0.0), ("c", 7.0)):
            library.add((box.vertices + shift, box.faces), name)
        matches = library.query((box.vertices, box.faces))
        (first,) = library.query((box.vertices, box.faces), top=1)
        (family,) = library.query((box.vertices, box.faces), families=True)
        versions = library.versions((box.vertices, box.faces), family)
    assert [match.distance for match in matches] == [0, 0, 0]
    assert [match.name for match in matches] == ["b", "a", "c"]
    assert (first.name, first.evidence.kind if first.evidence else "") == ("b", "identical")
    assert (family.name, family.versions) == ("b", 2)
    assert [match.name for match in versions] == ["b", "a", "c"]


def test_plain_shapes_do_not_pass_for_each_other(tmp_path: Path) -> None:
    """Bags of a cube, a ball, a slab and a rock are almost equal; only a copy of the cube is the cube."""
    box, ball = trimesh.creation.box(), trimesh.creation.icosphere(3)
    slab = trimesh.creation.box((1, 1.3, 0.8))
    stretched = (ball.vertices * [1, 1.2, 0.8], ball.faces)
    with sg.Library.open(tmp_path / "plain.sglib") as library:
        for name, mesh in {"box": box, "ball": ball, "slab": slab, "egg": stretched}.items():
            library.add(mesh, name)
        found = {match.name: match for match in library.query(box)}
        assert found["box"].similarity == 1
        assert found["box"].evidence is not None
        assert found["box"].evidence.kind == "identical"
        for name in ("ball", "slab", "egg"):
            evidence = found[name].evidence
            assert evidence is not None
            assert found[name].similarity < 0.9, name
            assert evidence.kind != "re-posed", name
            assert sg.compare(box, {"ball": ball, "slab": slab, "egg": stretched}[name]).similarity < 0.9


def joined(parts: list[trimesh.Trimesh]) -> sg.Mesh:
    count = len(parts[0].vertices)
    faces = np.concatenate([part.faces + number * count for number, part in enumerate(parts)])
    return sg.Mesh(np.concatenate([part.vertices for part in parts]), faces)


def test_shapes_of_many_parts_are_not_called_another_pose() -> None:
    """With more parts than eigenfunctions all of these are constant, which says nothing about the parts."""
    cubes = [trimesh.creation.box().apply_translation([2 * i, 0, 0]) for i in range(30)]
    balls = [trimesh.creation.icosphere(1).apply_translation([0, 3 * i, 0]) for i in range(30)]
    evidence = sg.compare(joined(cubes), joined(balls)).evidence
    assert evidence is not None
    assert evidence.kind in ("similar", "same kind", "nothing in common")
