# SPDX-License-Identifier: MIT
"""Queries with a filter: only shapes that meet its conditions, and as many of them as asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.experiments.evidence_pairs import EvidencePair, make_pairs
from shapegoogle_core import Filter, Library, LibraryError, ShapeModel, ShapeSignature
from shapegoogle_core.library.search.settings import CandidateSettings, EvidenceSettings, SearchSettings

# Codes decide already in a library of dozens.
FEW = SearchSettings(CandidateSettings(count=3, per_match=1, oversampling=1))


@pytest.fixture(scope="module")
def filled(
    tmp_path_factory: pytest.TempPathFactory, model: ShapeModel, make_signature: Callable[..., ShapeSignature]
) -> Iterator[Library]:
    """Sixty shapes; every fifth in another folder and with a tag, every tenth in a .blend file."""
    path = tmp_path_factory.mktemp("filled") / "shapes.sglib"
    with Library.open(path, model, search=FEW) as library:
        for seed in range(60):
            folder, tags = ("/models/wood", ("wood",)) if seed % 5 == 0 else ("/models/metal", ())
            name = f"Chair {seed}" if seed % 2 else f"Table {seed}"
            file_type = "blend" if seed % 10 == 0 else "obj"
            signature = make_signature(seed)
            library.add_signature(signature, name, source=f"{folder}/{seed}.{file_type}", tags=tags)
        yield library


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize(
    ("where", "expected"),
    [
        (Filter(name="chair"), {seed for seed in range(60) if seed % 2}),
        (Filter(folder="/models/wood"), set(range(0, 60, 5))),
        (Filter(tag="wood"), set(range(0, 60, 5))),
        (Filter(faces=(20, 29)), set(range(20, 30))),
        (Filter(faces=(50, None), name="TABLE"), set(range(50, 60, 2))),
        (Filter(name="chair 1*"), {1, 11, 13, 15, 17, 19}),
        (Filter(name="sofa"), set()),
        (Filter(file_type="blend"), set(range(0, 60, 10))),
        (Filter(file_type="*.BLEND", faces=(30, None)), {30, 40, 50}),
        (Filter(file_type=".obj", tag="wood"), set(range(5, 60, 10))),
        (Filter(file_type="bj"), set()),
    ],
)
def test_only_shapes_that_meet_the_conditions_are_searched(
    filled: Library,
    make_signature: Callable[..., ShapeSignature],
    where: Filter,
    expected: set[int],
    exact: bool,
) -> None:
    query = make_signature(1_000)
    matches = filled.query(query, top=60, exact=exact, where=where, explain=0)
    assert {int(match.name.split()[1]) for match in matches} == expected
    everything = filled.query(query, top=60, exact=True, explain=0)
    assert matches == [match for match in everything if int(match.name.split()[1]) in expected]


def test_candidates_are_chosen_among_the_shapes_that_meet_the_conditions(
    filled: Library, make_signature: Callable[..., ShapeSignature]
) -> None:
    """With three candidates, the nearest three of all shapes are not those that are asked for."""
    query = make_signature(1)
    assert filled.query(query, top=3, explain=0)[0].name == "Chair 1"
    matches = filled.query(query, top=3, where=Filter(tag="wood"), explain=0)
    assert len(matches) == 3
    assert all(int(match.name.split()[1]) % 5 == 0 for match in matches)


def test_matches_below_the_least_similarity_are_left_out(
    filled: Library, make_signature: Callable[..., ShapeSignature]
) -> None:
    query = make_signature(7)
    everything = filled.query(query, top=60, exact=True, explain=0)
    least = everything[4].similarity
    expected = [match for match in everything if match.similarity >= least]
    assert filled.query(query, top=60, where=Filter(min_similarity=least), exact=True, explain=0) == expected
    assert (
        filled.query(query, top=2, where=Filter(min_similarity=least), exact=True, explain=0) == expected[:2]
    )


def test_a_kind_needs_a_model_with_samples(
    filled: Library, make_signature: Callable[..., ShapeSignature]
) -> None:
    with pytest.raises(LibraryError, match=r"keeps no samples of surfaces to find the kind 'moved' with"):
        filled.query(make_signature(1), where=Filter(kind="moved"))


@pytest.fixture(scope="module")
def pairs() -> list[EvidencePair]:
    """Six pairs, those of the kinds that the test asks for among them."""
    wanted = ("a copy", "other mesh, moved", "other mesh in place", "other pose", "a part", "another kind")
    return [pair for pair in make_pairs("deer", 1234) if pair.detail in wanted]


def test_matches_of_a_kind(tmp_path: Path, pairs: list[EvidencePair]) -> None:
    """Explained until enough are found, however far behind, and up to a limit."""
    path, query = tmp_path / "shapes.sglib", pairs[0].query
    with Library.open(path) as library:
        for pair in pairs:
            library.add(pair.candidate, pair.detail)
        signature = library.model.describe(query, keep_surface=True)
        everything = library.query(signature, top=20, explain=20)
        for kind in ("contains", "re-meshed"):
            expected = [match for match in everything if match.evidence and match.evidence.kind == kind]
            assert expected
            assert library.query(signature, where=Filter(kind=kind), explain=0) == expected
            assert library.query(signature, top=1, where=Filter(kind=kind)) == expected[:1]
        last = everything[-1]
        assert last.evidence is not None
        few = SearchSettings(evidence=replace(EvidenceSettings(), max_filtered=3))
    with Library.open(path, search=few) as library:
        assert library.query(signature, top=1, where=Filter(kind="contains")) == []
