# SPDX-License-Identifier: MIT
"""Evidence of matches whose kind is known, by the default model and through a library as users have it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.experiments.evidence_pairs import EvidencePair
from shapegoogle_core import Library
from shapegoogle_core.library.evidence import KINDS, Evidence
from tests.core.library.explained_pairs import kept


def test_every_kind_is_made(pairs: list[EvidencePair]) -> None:
    # The pairs say of other surfaces only that they are none of the above.
    assert {pair.kind for pair in pairs} == set(KINDS) - {"same kind", "nothing in common"}


@pytest.mark.parametrize(
    ("detail", "kind"),
    [
        ("a copy", "identical"),
        ("other order of vertices and faces", "identical"),
        ("moved", "moved"),
        ("moved and scaled", "scaled"),
        ("reflected and moved", "mirrored"),
        ("other mesh, moved", "re-meshed"),
        ("other mesh in place", "re-meshed"),
        ("other pose", "re-posed"),
        ("other pose and mesh", "re-posed"),
        ("a part", "contains"),
        ("another kind", "nothing in common"),
    ],
)
def test_kinds_are_recognised(answers: tuple[Library, dict[str, Evidence]], detail: str, kind: str) -> None:
    assert answers[1][detail].kind == kind


def test_figures_are_those_of_the_pairs(
    answers: tuple[Library, dict[str, Evidence]], pairs: list[EvidencePair]
) -> None:
    for pair in pairs:
        said = answers[1].get(pair.detail)
        if said is None or said.kind != pair.kind or pair.kind == "similar":
            continue
        assert said.factor == pytest.approx(pair.factor, rel=0.03), pair.detail
        if said.deviation is not None:
            assert 0 <= said.deviation <= 0.01
        if said.share is not None:
            assert said.share == pytest.approx(pair.share, abs=0.05)


def test_a_part_finds_its_whole(tmp_path: Path, pairs: list[EvidencePair]) -> None:
    chosen = next(pair for pair in pairs if pair.kind == "part of")
    with Library.open(tmp_path / "shapes.sglib") as library:
        library.add(chosen.candidate, "whole")
        (match,) = library.query(chosen.query)
    assert match.evidence is not None
    assert match.evidence.kind == "part of"
    assert match.evidence.share == pytest.approx(chosen.share, abs=0.05)


@pytest.mark.parametrize("detail", ["subdivided", "the base of it"])
def test_a_smoothed_version_is_no_part(tmp_path: Path, pairs: list[EvidencePair], detail: str) -> None:
    chosen = next(pair for pair in pairs if pair.detail == detail)
    with Library.open(tmp_path / "shapes.sglib") as library:
        library.add(chosen.candidate, detail)
        (match,) = library.query(chosen.query)
    assert match.evidence is not None
    assert match.evidence.kind == "version"
    assert match.evidence.factor == pytest.approx(1, abs=0.05)
    assert match.evidence.deviation is not None
    assert 0.001 < match.evidence.deviation <= 0.02


def test_only_the_best_are_explained(
    answers: tuple[Library, dict[str, Evidence]], pairs: list[EvidencePair]
) -> None:
    library, _ = answers
    matches = library.query(pairs[0].query, top=6, explain=2)
    assert [match.evidence is not None for match in matches] == [True, True, False, False, False, False]
    assert all(match.evidence is None for match in library.query(pairs[0].query, top=3, explain=0))


def test_evidence_leaves_the_ranking_as_it_is(
    answers: tuple[Library, dict[str, Evidence]], pairs: list[EvidencePair]
) -> None:
    library, _ = answers
    plain = library.query(pairs[0].query, top=20, explain=0)
    explained = library.query(pairs[0].query, top=20, explain=20)
    assert [(match.shape_id, match.distance) for match in explained] == [
        (match.shape_id, match.distance) for match in plain
    ]


def test_with_several_examples_the_nearest_one_is_compared(
    answers: tuple[Library, dict[str, Evidence]], pairs: list[EvidencePair]
) -> None:
    library, _ = answers
    stranger = next(pair.candidate for pair in pairs if pair.detail == "another kind")
    matches = library.query([pairs[0].query, stranger], top=20, explain=20)
    kinds = {match.name: kept(match).kind for match in matches}
    assert kinds["a copy"] == kinds["another kind"] == "identical"


def test_what_was_removed_meanwhile_has_no_evidence(tmp_path: Path, pairs: list[EvidencePair]) -> None:
    with Library.open(tmp_path / "shapes.sglib") as library:
        shape_id = library.add(pairs[0].candidate, "gone soon")
        signature = library.model.describe(pairs[0].query, keep_surface=True)
        matches = library.query(signature, explain=0)
        library.remove_shape(shape_id)
        assert library.explain([signature], matches)[0].evidence is None


def test_a_mesh_and_one_match_can_be_explained(
    answers: tuple[Library, dict[str, Evidence]], pairs: list[EvidencePair]
) -> None:
    library, _ = answers
    match = library.query(pairs[0].query, top=1, explain=0)[0]
    (explained,) = library.explain(pairs[0].query, match)
    assert [explained] == library.explain([pairs[0].query], [match])
    assert kept(explained) == kept(library.query(pairs[0].query, top=1)[0])


def test_samples_alone_give_the_same_kinds(
    answers: tuple[Library, dict[str, Evidence]], pairs: list[EvidencePair]
) -> None:
    """As for duplicates: neither shape has its surface."""
    library, exact = answers
    signature = replace(library.model.describe(pairs[0].query), surface=None)
    matches = library.explain([signature], library.query(signature, top=20, explain=0))
    assert {match.name: kept(match).kind for match in matches} == {
        name: said.kind for name, said in exact.items()
    }
