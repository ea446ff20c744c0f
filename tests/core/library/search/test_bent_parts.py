# SPDX-License-Identifier: MIT
"""Parts in another pose are found by their local heat, through the whole search."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.creatures import make_creature
from benchmarks.experiments.evidence_pairs import cut
from shapegoogle_core import Library, Mesh, ShapeSignature, compare, load_model
from shapegoogle_core.library.match import Match
from shapegoogle_core.library.search.settings import SearchSettings, VerificationSettings
from shapegoogle_core.library.search.verified_distances import bent_distance
from shapegoogle_core.library.search.verify import Verifier
from shapegoogle_core.model.augmentation import transform

KINDS = ("dog", "horse", "spider", "octopus", "bird", "human")
SEEDS = (303, 304, 305)


def creature(kind: str, seed: int, pose: int) -> Mesh:
    return make_creature(kind, seed, 3000).pose(pose)


def bent_part(kind: str) -> Mesh:
    return cut(creature(kind, SEEDS[0], 1), np.array([0.3, 0.2, 1.0]), 0.6)


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Library]:
    with Library.open(tmp_path_factory.mktemp("bent") / "creatures.sglib") as library:
        for kind in KINDS:
            for seed in SEEDS if kind in ("dog", "spider") else SEEDS[:1]:
                library.add(creature(kind, seed, 0), name=f"{kind} {seed}")
        yield library


@pytest.fixture(scope="module")
def parts() -> dict[str, ShapeSignature]:
    return {kind: load_model().describe(bent_part(kind)) for kind in ("dog", "spider")}


def without_heat(signature: ShapeSignature) -> ShapeSignature:
    assert signature.sample is not None
    return replace(signature, sample=replace(signature.sample, packed_heat=b""))


@pytest.mark.parametrize("kind", ["dog", "spider"])
def test_a_bent_part_finds_its_whole_among_relatives(
    kind: str, library: Library, parts: dict[str, ShapeSignature]
) -> None:
    found = library.query(parts[kind], top=8, rank="shape", explain=0)
    assert found[0].name == f"{kind} {SEEDS[0]}"
    before = {match.name: match.distance for match in library.query(without_heat(parts[kind]), rank="shape")}
    assert found[0].distance < before[found[0].name]


def test_the_similarity_of_a_pair_is_that_of_the_search(library: Library) -> None:
    part = bent_part("spider")
    (first, *_) = library.query(part, top=8, rank="shape", explain=8)
    alone = compare(part, creature("spider", SEEDS[0], 0))
    assert first.name == f"spider {SEEDS[0]}"
    assert first.similarity == pytest.approx(alone.similarity, abs=1e-3)


def test_libraries_from_before_are_searched_as_before(
    tmp_path: Path, parts: dict[str, ShapeSignature]
) -> None:
    model = load_model()
    with Library.open(tmp_path / "old.sglib") as old:
        for kind in ("dog", "spider"):
            old.add_signature(without_heat(model.describe(creature(kind, SEEDS[0], 0))), kind)
        one, other = (
            [(match.name, match.distance) for match in old.query(query, rank="shape")]
            for query in (parts["dog"], without_heat(parts["dog"]))
        )
        assert one == other


@pytest.mark.parametrize("kind", ["dog", "horse", "human"])
def test_swollen_limbs_with_small_holes_are_searched_without_it(kind: str, library: Library) -> None:
    """They have other heat than their original, and are no part of it."""
    swollen = transform(creature(kind, SEEDS[0], 0), "local_scale", 4, 11)
    query = load_model().describe(transform(swollen, "holes", 1, 5))
    assert query.sample is not None
    assert not query.sample.is_cut
    found, expected = (
        [(match.name, match.distance) for match in library.query(one, rank="shape", explain=0)]
        for one in (query, without_heat(query))
    )
    assert found[0][0] == f"{kind} {SEEDS[0]}"
    assert found == expected


@pytest.mark.parametrize("similarity", [0.75, 0.95])
def test_a_cut_query_needs_more_certain_bags(similarity: float) -> None:
    settings = VerificationSettings()
    verifier = Verifier(lambda _: iter(()), load_model(), settings)
    best = Match("whole", "", "", 0.1, similarity, 1, 1, 1, 1.0)
    assert verifier.is_needed(best, several=False, cut=True) == (similarity < settings.certain_of_cut)
    assert not verifier.is_needed(best, several=False, cut=False)
    assert not verifier.is_needed(best, several=True, cut=True)


@pytest.mark.parametrize("kind", ["dog", "spider"])
def test_a_relative_that_is_likely_does_not_end_the_search(
    kind: str, parts: dict[str, ShapeSignature], library: Library
) -> None:
    """Here every alignment is likely: heat is asked all the same, since nothing fits exactly."""
    easily = SearchSettings(verification=VerificationSettings(likely=0.0))
    with Library.open(library.path, read_only=True, search=easily) as opened:
        found = opened.query(parts[kind], top=8, rank="shape", explain=0)
    assert found[0].name == f"{kind} {SEEDS[0]}"
    assert found[0].bent_distance is not None


def changed(distance: float, bags: float, exact: float, difference: float) -> float:
    return bent_distance(load_model(), VerificationSettings(), distance, bags, exact, difference)


def test_local_heat_that_agrees_lowers_a_distance() -> None:
    model, settings = load_model(), VerificationSettings()
    assert changed(0.9, 0.9, 0.0, settings.bent_half) == pytest.approx(model.verified_half, abs=1e-6)
    odds = (settings.bent_half / 0.4) ** settings.bent_exponent
    similarity = float(model.similarity(changed(0.9, 0.9, 0.0, 0.4), verified=True))
    assert similarity == pytest.approx(odds / (1 + odds), abs=1e-4)
    # An alignment of the same pair lowers it further, and is not enough by itself.
    assert changed(0.3, 0.9, 0.0, 0.4) < changed(0.9, 0.9, 0.0, 0.4)
    assert changed(0.3, 0.9, 0.0, 0.5) > changed(0.9, 0.9, 0.0, 0.4)
    # Only a copy is at distance 0.
    assert 0 < changed(0.9, 0.9, 0.0, 1e-6) < 1e-5


@given(
    distance=st.floats(1e-4, 1.5),
    raised=st.floats(1, 10),
    exact=st.floats(0, 1),
    difference=st.floats(0.05, 5) | st.just(np.inf),
)
def test_it_takes_back_an_alignment_only_in_part(
    distance: float, raised: float, exact: float, difference: float
) -> None:
    bags = distance * raised
    found = changed(distance, bags, exact, difference)
    assert found <= bags + 1e-6
    if np.isinf(difference):
        assert found == distance
    elif exact >= VerificationSettings().bent_exact:
        assert found <= distance
    # More alike is never farther.
    assert changed(distance, bags, exact, difference / 2) <= found + 1e-6
