# SPDX-License-Identifier: MIT
"""Several examples of what is searched for, and negative examples."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from benchmarks.creatures import make_creature
from shapegoogle_core import Library, LibraryError, Match, Mesh, MeshError, ShapeModel, ShapeSignature
from shapegoogle_core.library.search.query import FARTHEST, Query, pool_distances
from shapegoogle_core.library.search.settings import CandidateSettings, SearchSettings, VerificationSettings
from shapegoogle_core.library.storage.signatures import round_bags
from shapegoogle_core.preprocessing import PreprocessingSettings
from shapegoogle_core.registration import Alignment, PreparedSample, SampleSettings, SurfaceSample, align_all

SHAPES = 60


def between(
    make_signature: Callable[..., ShapeSignature],
    model: ShapeModel,
    first: int,
    second: int,
    share: float = 0.5,
) -> ShapeSignature:
    """A signature between those of two seeds."""
    one, other = make_signature(first), make_signature(second)
    bags = ((1 - share) * one.bags + share * other.bags).astype(np.float32)
    return replace(one, bags=bags, code=model.codes(bags[None])[0])


@pytest.fixture
def filled(path: Path, model: ShapeModel, make_signature: Callable[..., ShapeSignature]) -> Iterator[Library]:
    with Library.open(path, model) as library:
        for seed in range(SHAPES):
            library.add_signature(make_signature(seed), f"shape {seed}")
        yield library


def names(matches: Sequence[Match]) -> list[str]:
    return [match.name for match in matches]


@given(arrays(np.float64, (3, 5), elements=st.floats(0, 2)))
def test_the_pooled_distance_lies_between_those_of_the_examples(distances: NDArray[np.float64]) -> None:
    pooled = pool_distances(distances)
    assert (pooled >= distances.min(axis=0) * (1 - 1e-12)).all()
    assert (pooled <= distances.max(axis=0) * (1 + 1e-12)).all()
    assert (pooled[(distances == 0).any(axis=0)] == 0).all()
    np.testing.assert_allclose(pool_distances(distances[::-1]), pooled)
    np.testing.assert_array_equal(pool_distances(distances[:1]), distances[0])


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("metric", ["cosine", "l1"])
def test_one_example_is_an_ordinary_query(
    path: Path,
    make_model: Callable[..., ShapeModel],
    make_signature: Callable[..., ShapeSignature],
    exact: bool,
    metric: str,
) -> None:
    """To the last bit what the model's own distance gives."""
    model = make_model(metric=metric)
    with Library.open(path, model) as library:
        for seed in range(SHAPES):
            library.add_signature(make_signature(seed, model), f"shape {seed}")
        query = make_signature(1_000, model)
        matches = library.query([query], top=SHAPES, exact=exact, explain=0)
        assert matches == library.query(query, top=SHAPES, exact=exact, explain=0)
        bags = np.stack([round_bags(make_signature(seed, model).bags) for seed in range(SHAPES)])
        expected = np.round(model.distances(round_bags(query.bags), bags), 6)
        assert {match.name: match.distance for match in matches} == {
            f"shape {seed}": distance for seed, distance in enumerate(expected.tolist())
        }


def test_what_both_examples_are_near_to_comes_before_what_one_is(
    filled: Library, model: ShapeModel, make_signature: Callable[..., ShapeSignature]
) -> None:
    """A shape half-way between two is the third one at best for each, and the first for both."""
    first, second = (between(make_signature, model, 1_000, 1_001, share) for share in (0.0, 1.0))
    filled.add_signature(between(make_signature, model, 1_000, 1_001), "between")
    for step in range(3):  # nearer to one of them, and far from the other
        for name, seed in (("first", 1_000), ("second", 1_001)):
            decoy = between(make_signature, model, seed, 2_000 + seed + step, 0.35)
            filled.add_signature(decoy, f"near the {name}, {step}")
    together = filled.query([first, second], top=SHAPES, explain=0)
    assert together[0].name == "between"
    assert together == filled.query([second, first], top=SHAPES, explain=0)
    for alone in (first, second):
        assert names(filled.query(alone, explain=0)).index("between") > 0


def test_copies_of_the_examples_come_first(
    filled: Library, make_signature: Callable[..., ShapeSignature]
) -> None:
    examples = [make_signature(seed) for seed in (3, 14, 15)]
    matches = filled.query(examples, top=SHAPES, explain=0)
    assert names(matches[:3]) == ["shape 14", "shape 15", "shape 3"]
    assert [match.similarity for match in matches[:3]] == [1, 1, 1]
    assert all(0 < match.similarity < 1 for match in matches[3:])
    assert [match.distance for match in matches] == sorted(match.distance for match in matches)


@pytest.mark.parametrize("exact", [False, True])
def test_what_is_not_meant_falls_behind_all_that_is_nearer_to_the_example(
    filled: Library, model: ShapeModel, make_signature: Callable[..., ShapeSignature], exact: bool
) -> None:
    example, unwanted = make_signature(1_000), make_signature(7)
    filled.add_signature(make_signature(7), "shape 7 again")
    filled.add_signature(between(make_signature, model, 7, 1_000, 0.2), "much like 7")
    matches = filled.query([example], top=SHAPES + 2, exact=exact, unlike=[unwanted], explain=0)
    assert sorted(names(matches[-2:])) == ["shape 7", "shape 7 again"]
    assert [(match.distance, match.similarity) for match in matches[-2:]] == [(FARTHEST, 0), (FARTHEST, 0)]
    assert [match.similarity for match in matches] == sorted(
        (match.similarity for match in matches), reverse=True
    )
    before = names(filled.query(example, top=SHAPES + 2, exact=exact, explain=0))
    assert names(matches).index("much like 7") > before.index("much like 7")
    assert sorted(names(matches)) == sorted(before)


def test_what_is_far_from_all_that_is_not_meant_stays_where_it_is(
    filled: Library, make_signature: Callable[..., ShapeSignature]
) -> None:
    """And a copy of the example stays the first, however near that is."""
    example = make_signature(5)
    plain = {match.name: match.distance for match in filled.query(example, top=SHAPES, explain=0)}
    matches = filled.query([example], top=SHAPES, unlike=[make_signature(6), make_signature(7)], explain=0)
    assert (matches[0].name, matches[0].distance, matches[0].similarity) == ("shape 5", 0, 1)
    assert all(match.distance >= plain[match.name] for match in matches)


def test_the_similarity_is_the_probability_among_three(
    filled: Library, model: ShapeModel, make_signature: Callable[..., ShapeSignature]
) -> None:
    example, unwanted = make_signature(1_000), make_signature(7)
    matches = filled.query([example], top=SHAPES, unlike=[unwanted], explain=0)

    def odds(query: ShapeSignature) -> dict[str, float]:
        found = filled.query(query, top=SHAPES, explain=0)
        with np.errstate(divide="ignore"):
            return {match.name: 1 / (1 / match.similarity - 1) for match in found if match.similarity < 1}

    meant, other = odds(example), odds(unwanted)
    for match in matches[:-1]:
        expected = meant[match.name] / (1 + meant[match.name] + other[match.name] / 8)
        assert match.similarity == pytest.approx(expected, rel=1e-3)


def test_a_shape_that_is_asked_for_and_not_wanted_is_not_wanted(
    filled: Library, make_signature: Callable[..., ShapeSignature]
) -> None:
    """The copy of the query in the library, marked by someone who has it already."""
    matches = filled.query([make_signature(5)], top=SHAPES, unlike=[make_signature(5)], explain=0)
    assert (matches[-1].name, matches[-1].similarity) == ("shape 5", 0)
    plain = names(filled.query(make_signature(5), top=SHAPES, explain=0))
    assert names(matches[:-1]) == plain[1:]


def test_every_example_brings_its_own_candidates(
    path: Path, filled: Library, make_signature: Callable[..., ShapeSignature]
) -> None:
    """As many as codes find for each: no example is drowned by another one."""
    few = SearchSettings(CandidateSettings(count=5, per_match=1))
    with Library.open(path, search=few) as library:
        matches = library.query([make_signature(3), make_signature(40)], top=5, explain=0)
    assert {"shape 3", "shape 40"} <= set(names(matches))


def test_what_cannot_be_asked(filled: Library, make_signature: Callable[..., ShapeSignature]) -> None:
    with pytest.raises(ValueError, match="at least one mesh or signature"):
        filled.query([], explain=0)
    with pytest.raises(ValueError, match="at least one mesh or signature"):
        filled.query([])
    with pytest.raises(ValueError, match="top must be"):
        filled.query([make_signature(1)], top=0)
    with pytest.raises(ValueError, match="explain must be a whole number of at least 0, not -1"):
        filled.query([make_signature(1)], explain=-1)
    with pytest.raises(MeshError, match=r"'horse\.ply' is a path and not a mesh"):
        filled.query("horse.ply")  # type: ignore[arg-type]
    with pytest.raises(MeshError, match="'unlike' is an object of the type NoneType, not a mesh"):
        filled.query([make_signature(1)], unlike=None)  # type: ignore[arg-type]
    with pytest.raises(MeshError, match="'query 2 of 2' is an object of the type int"):
        filled.query([make_signature(1), 7])  # type: ignore[list-item]
    with pytest.raises(ValueError, match=r"where must be a shapegoogle_core\.Filter, not \{'name': 'x'\}"):
        filled.query([make_signature(1)], where={"name": "x"})  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"top must be a whole number of at least 1, not 1\.5"):
        filled.query([make_signature(1)], top=1.5)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="count must be a whole number of at least 0, not -1"):
        filled.explain([make_signature(1)], [], count=-1)
    with pytest.raises(ValueError, match="matches must be a Match, or several, not 5"):
        filled.explain([make_signature(1)], [5])  # type: ignore[list-item]
    strange = replace(make_signature(1), bags=np.ones(3, np.float32))
    for like, unlike in (([make_signature(1), strange], []), ([make_signature(1)], [strange])):
        with pytest.raises(LibraryError, match="another model"):
            filled.query(like, unlike=unlike, explain=0)


@pytest.fixture(scope="module")
def verifying(make_model: Callable[..., ShapeModel]) -> ShapeModel:
    model = make_model()
    settings = replace(
        model.settings, sample=SampleSettings(300, 96), preprocessing=PreprocessingSettings(budget=1500)
    )
    return replace(model, settings=settings, agreement_gain=8.0, similarity_half=1e-6)


@pytest.fixture(scope="module")
def poses() -> dict[str, list[Mesh]]:
    creatures = [make_creature(kind, 101, vertex_count=800) for kind in ("horse", "human", "crab")]
    return {creature.kind: [creature.pose(pose) for pose in range(3)] for creature in creatures}


class TestMeshes:
    """From meshes, with a model that aligns surfaces."""

    @pytest.fixture
    def library(self, path: Path, verifying: ShapeModel, poses: dict[str, list[Mesh]]) -> Iterator[Library]:
        with Library.open(path, verifying) as library:
            for kind, meshes in poses.items():
                library.add(meshes[2], name=kind)
            library.add(poses["horse"][0], name="the example itself")
            yield library

    def test_several_meshes_and_one_that_is_not_meant(
        self, library: Library, poses: dict[str, list[Mesh]]
    ) -> None:
        assert library.query(poses["horse"][0]) == library.query([poses["horse"][0]])
        matches = library.query(poses["horse"][:2], unlike=[poses["human"][2]])
        assert (matches[0].name, matches[0].distance) == ("the example itself", 0)
        assert matches[-1].name == "human"
        assert [match.distance for match in matches] == sorted(match.distance for match in matches)

    def test_each_match_is_aligned_with_the_example_nearest_to_it(
        self, path: Path, library: Library, poses: dict[str, list[Mesh]], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """Several examples take no more alignments than one, and the copy of one stops none."""
        aligned: list[PreparedSample] = []

        def watched(
            query: PreparedSample, others: Sequence[SurfaceSample], *, finely: int | None = None
        ) -> list[Alignment | None]:
            aligned.extend(query for _ in others)
            return align_all(query, others, finely=finely)

        monkeypatch.setattr("shapegoogle_core.library.search.verify.align_all", watched)
        model = library.model
        examples = [model.describe(poses[kind][0]) for kind in ("horse", "human")]
        always = SearchSettings(verification=VerificationSettings(certain_of_several=2.0))
        with Library.open(path, search=always) as verified:
            verified.query(examples, explain=0)
        assert len(aligned) == 3  # all but the copy
        assert len({id(query) for query in aligned}) <= 2
        query = Query(model, examples)
        vectors = model.comparable(np.stack([example.bags for example in examples]))
        assert query.nearest_samples(vectors).tolist() == [0, 1]

    def test_verification_is_skipped_where_several_are_certain(
        self, path: Path, library: Library, poses: dict[str, list[Mesh]], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(
            "shapegoogle_core.library.search.verify.align_all", None
        )  # would fail if it were called
        examples = [library.model.describe(mesh) for mesh in poses["horse"][:2]]
        bare = [replace(example, sample=None) for example in examples]
        never = SearchSettings(verification=VerificationSettings(certain_of_several=0.0))
        with Library.open(path, search=never) as unverified:
            assert unverified.query(examples, explain=0) == unverified.query(bare, explain=0)

    def test_meshes_and_signatures_can_be_mixed(self, library: Library, poses: dict[str, list[Mesh]]) -> None:
        mesh = poses["horse"][1]
        signature = library.model.describe(mesh, keep_surface=True)
        other = poses["human"][0]
        expected = library.query([mesh, other])
        assert library.query([signature, other]) == expected
        assert library.query((signature, (other.vertices, other.faces))) == expected
        assert library.query((mesh.vertices, mesh.faces)) == library.query(signature) == library.query(mesh)
        assert library.query(mesh, unlike=other) == library.query(signature, unlike=[other])

    def test_examples_without_samples(self, library: Library, poses: dict[str, list[Mesh]]) -> None:
        """As after an interrupted repair by hand: geometry goes by the others."""
        examples = [library.model.describe(mesh) for mesh in poses["horse"][:2]]
        bare = replace(examples[0], sample=None)
        assert library.query([bare, examples[1]], explain=0)[0].name == "the example itself"
        assert library.query([bare, bare], unlike=[bare], explain=0)[-1].name == "the example itself"
