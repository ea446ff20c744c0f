# SPDX-License-Identifier: MIT
"""Geometric verification brings forward what fits in space, and never loses a match."""

from __future__ import annotations

import shutil
import sqlite3
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.creatures import CREATURE_KINDS, make_creature
from benchmarks.experiments.evidence_pairs import cut
from shapegoogle_core import Library, Match, Mesh, ShapeModel, compute_spectrum
from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.search.settings import CandidateSettings, SearchSettings, VerificationSettings
from shapegoogle_core.library.search.verify import known_alignment
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model.augmentation import transform
from shapegoogle_core.preprocessing import PreprocessingSettings
from shapegoogle_core.registration import (
    Alignment,
    Frame,
    LocalSettings,
    PreparedSample,
    RoughPose,
    SampleSettings,
    SurfaceSample,
    align,
    align_all,
    fit_local_words,
    rough_poses,
    sample_surface,
)

VERIFY = "shapegoogle_core.library.search.verify"


def execute(library: Library, statement: str, *parameters: object) -> None:
    """Change the library file behind the library's back."""
    with closing(sqlite3.connect(library.path)) as connection, connection:
        connection.execute(statement, parameters)


def watch_alignments(module: str, monkeypatch: pytest.MonkeyPatch) -> list[SurfaceSample]:
    """Samples of the queries that a module aligns from now on, once for each candidate."""
    aligned: list[SurfaceSample] = []

    def watched(query: PreparedSample, candidate: PreparedSample) -> Alignment:
        aligned.append(query.sample)
        return align(query, candidate)

    def all_watched(
        query: PreparedSample, candidates: Sequence[SurfaceSample], *, finely: int | None = None
    ) -> list[Alignment | None]:
        aligned.extend(query.sample for _ in candidates)
        return align_all(query, candidates, finely=finely)

    monkeypatch.setattr(f"{module}.align", watched)
    monkeypatch.setattr(f"{module}.align_all", all_watched)
    return aligned


@pytest.fixture(scope="module")
def verifying(make_model: Callable[..., ShapeModel]) -> ShapeModel:
    """An untrained model: its bags know little, so that geometry must decide."""
    model = make_model()
    settings = replace(
        model.settings, sample=SampleSettings(300, 96), preprocessing=PreprocessingSettings(budget=1500)
    )
    return replace(model, settings=settings, agreement_gain=30.0, similarity_half=1e-6)


@pytest.fixture(scope="module")
def shapes_in_it() -> list[Mesh]:
    creatures = [make_creature(kind, 7, vertex_count=1000).rest for kind in CREATURE_KINDS[:24]]
    return [Mesh(mesh.vertices, mesh.faces, f"shape {index}") for index, mesh in enumerate(creatures)]


def filled(path: Path, model: ShapeModel, meshes: Sequence[Mesh]) -> Path:
    """A library that each test gets a copy of."""
    with Library.open(path, model) as library:
        for mesh in meshes:
            library.add(mesh)
    return path


@pytest.fixture(scope="module")
def library_file(
    tmp_path_factory: pytest.TempPathFactory, verifying: ShapeModel, shapes_in_it: list[Mesh]
) -> Path:
    return filled(tmp_path_factory.mktemp("filled") / "shapes.sglib", verifying, shapes_in_it)


@pytest.fixture
def library(path: Path, library_file: Path) -> Iterator[Library]:
    with Library.open(shutil.copy(library_file, path)) as library:
        yield library


def test_a_damaged_shape_comes_first(library: Library, shapes_in_it: list[Mesh]) -> None:
    ranks, plain = [], []
    for index in range(0, 24, 4):
        query = transform(shapes_in_it[index], "partial", 3, seed=index)
        signature = library.model.describe(query)
        names = [match.name for match in library.query(signature, top=24, explain=0)]
        ranks.append(names.index(f"shape {index}"))
        alone = [m.name for m in library.query(replace(signature, sample=None), top=24, explain=0)]
        plain.append(alone.index(f"shape {index}"))
        assert sorted(names) == sorted(alone)
    assert np.mean(np.array(ranks) == 0) >= 0.8
    assert np.mean(1 / (1 + np.array(plain))) < np.mean(1 / (1 + np.array(ranks)))


def test_matches_are_in_order_and_no_farther_than_before(library: Library, shapes_in_it: list[Mesh]) -> None:
    signature = library.model.describe(transform(shapes_in_it[3], "holes", 3, seed=0))
    for exact in (False, True):
        matches = library.query(signature, top=24, exact=exact, explain=0)
        assert [match.distance for match in matches] == sorted(match.distance for match in matches)
        assert [match.similarity for match in matches] == sorted(
            (match.similarity for match in matches), reverse=True
        )
        before = {
            m.shape_id: m.distance for m in library.query(replace(signature, sample=None), top=24, explain=0)
        }
        assert all(match.distance <= before[match.shape_id] for match in matches)
        assert len(matches) == 24


def reopened(
    library: Library, selection: CandidateSettings | None = None, **verification_settings: float
) -> Library:
    """The same library with other settings."""
    settings = SearchSettings(
        candidates=selection or CandidateSettings(),
        verification=VerificationSettings(**verification_settings),  # type: ignore[arg-type]
    )
    return Library.open(library.path, search=settings)


def test_what_stands_far_behind_is_found_by_its_support(library: Library, shapes_in_it: list[Mesh]) -> None:
    """With two aligned first and five next, the right one must come in by the support it has."""
    firsts = 0
    # The untrained model is certain of everything.
    with reopened(library, likely=2.0, first=2, next=5) as other:
        for index in range(0, 24, 4):
            query = transform(shapes_in_it[index], "partial", 3, seed=index)
            firsts += other.query(query, top=1)[0].name == f"shape {index}"
    assert firsts >= 5


def test_samples_come_back_and_go_with_their_shape(library: Library, shapes_in_it: list[Mesh]) -> None:
    shape_id = library.add(shapes_in_it[0], name="again")
    sample = library.signature(shape_id).sample
    assert sample is not None
    assert len(sample.points) == 300
    library.remove_shape(shape_id)
    assert library._store.samples([shape_id]) == {}


def test_a_damaged_sample_is_named(library: Library, shapes_in_it: list[Mesh]) -> None:
    query = transform(shapes_in_it[0], "noise", 2, seed=0)
    execute(library, "UPDATE samples SET content = x'0102'")
    with pytest.raises(LibraryError, match=r"surface of shape .* cannot be read"):
        library.query(query)
    with pytest.raises(LibraryError, match=r"surface of shape 1 cannot be read"):
        library.signature(1)
    other = sample_surface(shapes_in_it[0], compute_spectrum(shapes_in_it[0], k=20), SampleSettings(50, 20))
    execute(library, "UPDATE samples SET content = ?", other.to_bytes())
    with pytest.raises(LibraryError, match=r"another size than its model's"):
        library.query(query)


def test_a_signature_with_a_sample_does_not_fit_a_model_without(
    path: Path, make_model: Callable[..., ShapeModel], verifying: ShapeModel, shapes_in_it: list[Mesh]
) -> None:
    signature = verifying.describe(shapes_in_it[0])
    with Library.open(path, make_model()) as library, pytest.raises(LibraryError, match="another model"):
        library.add_signature(signature, "shape")


def test_shapes_without_a_sample_stand_among_the_others(library: Library, shapes_in_it: list[Mesh]) -> None:
    """As after an interrupted repair by hand: they are compared by their bags."""
    execute(library, "DELETE FROM samples WHERE shape_id % 2 = 0")
    matches = library.query(shapes_in_it[0], top=24)
    assert len(matches) == 24
    assert matches[0].name == "shape 0"


def test_shapes_are_aligned_only_where_it_is_needed(
    library: Library, shapes_in_it: list[Mesh], monkeypatch: pytest.MonkeyPatch
) -> None:
    aligned = watch_alignments(VERIFY, monkeypatch)
    noisy = transform(shapes_in_it[5], "noise", 1, seed=0)
    with reopened(library, first=2) as other:
        certain = other.query(shapes_in_it[5], explain=0)  # itself: distance 0
        assert certain[0].similarity == 1
        assert len(aligned) == 0
        other.query(noisy, explain=0)  # likely, once it is aligned
        assert len(aligned) == 2
    with reopened(library, first=2, likely=2.0) as other:
        other.query(noisy, explain=0)  # fits exactly
        assert len(aligned) == 2 + 2
    with reopened(library, first=2, likely=2.0, surely_exact=2.0) as other:
        other.query(noisy, explain=0)
        assert len(aligned) == 4 + 24


def test_matches_carry_the_alignment_that_verification_found(
    library: Library, shapes_in_it: list[Mesh]
) -> None:
    """From the query to the match: it maps the query's points to the surface of the match."""
    signature = library.model.describe(transform(shapes_in_it[5], "noise", 1, seed=0))
    assert signature.sample is not None
    best = library.query(signature, explain=0)[0]
    alignment = known_alignment(best, signature.sample)
    assert alignment is not None
    assert alignment.agreement > 0.5
    other = library.signature(1).sample
    assert other is not None
    assert known_alignment(best, other) is None
    plain = replace(best, alignment=None)
    assert (best == plain, plain == best, hash(best) == hash(best)) == (True, True, True)
    assert best != replace(plain, distance=2.0)
    assert known_alignment(plain, signature.sample) is None


def test_evidence_is_the_same_with_and_without_an_alignment_of_the_search(
    library: Library, shapes_in_it: list[Mesh]
) -> None:
    signature = library.model.describe(transform(shapes_in_it[5], "noise", 1, seed=0), keep_surface=True)
    matches = library.query(signature, top=3, explain=0)
    assert any(match.alignment is not None for match in matches)
    anew = library.explain([signature], [replace(match, alignment=None) for match in matches])
    passed_on = library.explain([signature], matches)
    assert [kind_of(match) for match in passed_on] == [kind_of(match) for match in anew]
    assert library.query(signature, top=3) == passed_on


def kind_of(match: Match) -> str:
    assert match.evidence is not None
    return match.evidence.kind


def test_a_model_without_samples_still_answers(
    path: Path, make_model: Callable[..., ShapeModel], shapes_in_it: list[Mesh]
) -> None:
    with Library.open(path, make_model()) as library:
        library.add(shapes_in_it[0])
        library.add(shapes_in_it[1])
        assert library.query(shapes_in_it[1], top=1)[0].name == "shape 1"
        assert library.signature(1).sample is None


@pytest.fixture(scope="module")
def indexing(verifying: ShapeModel, shapes_in_it: list[Mesh]) -> ShapeModel:
    local = LocalSettings(words=256)
    samples = [verifying.describe(mesh).sample for mesh in shapes_in_it]
    words = fit_local_words([sample for sample in samples if sample is not None], local)
    return replace(verifying, settings=replace(verifying.settings, local=local), local_words=words)


@pytest.fixture(scope="module")
def indexed_file(
    tmp_path_factory: pytest.TempPathFactory, indexing: ShapeModel, shapes_in_it: list[Mesh]
) -> Path:
    return filled(tmp_path_factory.mktemp("filled") / "shapes.sglib", indexing, shapes_in_it)


def _with_local_words(library: Library) -> list[int]:
    return [i for ids, _ in library._store.code_pages("local_words", 0, 32) for i in ids.tolist()]


class TestPartsIndex:
    """Local words find candidates that bags do not find."""

    @pytest.fixture
    def library_file(self, indexed_file: Path) -> Path:
        return indexed_file

    @pytest.mark.parametrize("exact", [False, True])
    def test_a_shape_far_by_its_bags_is_found(
        self, library: Library, shapes_in_it: list[Mesh], exact: bool
    ) -> None:
        query = library.model.describe(transform(shapes_in_it[8], "partial", 4, seed=0))
        strange = replace(query, bags=library.signature(3).bags[::-1].copy(), code=~library.signature(9).code)
        few = CandidateSettings(count=3, per_match=1, oversampling=1, sharing=0)
        with reopened(library, few, candidates=3) as other:
            matches = other.query(strange, top=3, exact=exact, explain=0)
            assert "shape 8" not in [match.name for match in matches]
        with reopened(library, replace(few, sharing=2), candidates=3) as other:
            assert other.query(strange, top=1, exact=exact, explain=0)[0].name == "shape 8"

    def test_a_wrong_rough_pose_does_not_hide_a_shape(
        self, library: Library, shapes_in_it: list[Mesh], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        query = library.model.describe(transform(shapes_in_it[8], "partial", 4, seed=0))
        strange = replace(query, bags=library.signature(3).bags[::-1].copy(), code=~library.signature(9).code)
        far_away = Frame(1.0, np.eye(3), np.full(3, 10.0))
        wrong = RoughPose(covered=1.0, frame=far_away)
        monkeypatch.setattr(f"{VERIFY}.rough_poses", lambda _query, among, _scales: [wrong] * len(among))
        few = CandidateSettings(count=3, per_match=1, oversampling=1)
        with reopened(library, few, first=2) as other:
            assert other.query(strange, top=1, explain=0)[0].name == "shape 8"

    def test_support_decides_among_those_with_the_words(
        self, library: Library, shapes_in_it: list[Mesh], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """All have some of the words; only eight of 36 places are given away, by what agrees in space."""
        query = library.model.describe(cut(shapes_in_it[8], np.array([0.3, 1, 0.2]), 0.5))
        strange = replace(query, bags=library.signature(3).bags[::-1].copy(), code=~library.signature(9).code)
        aligned: list[FloatArray] = []

        def watched(
            query: PreparedSample, among: Sequence[SurfaceSample], scales: Sequence[Collection[int]]
        ) -> list[RoughPose]:
            aligned.extend(sample.points for sample in among)
            return rough_poses(query, among, scales)

        monkeypatch.setattr(f"{VERIFY}.rough_poses", watched)
        with reopened(library, CandidateSettings(supported=8), first=1, likely=2.0) as other:
            assert other.query(strange, top=1, explain=0)[0].name == "shape 8"
        assert len(aligned) <= 8
        sample = library.signature(9).sample
        assert sample is not None
        assert any(np.array_equal(points, sample.points) for points in aligned)

    def test_shapes_that_another_process_removed_are_skipped(
        self, library: Library, shapes_in_it: list[Mesh]
    ) -> None:
        query = library.model.describe(cut(shapes_in_it[8], np.array([0.3, 1, 0.2]), 0.5))
        with reopened(library, first=1, likely=2.0) as other:
            other.query(query, explain=0)
            library.remove_shape(9)
            assert "shape 8" not in [match.name for match in other.query(query, top=24, explain=0)]
            index = other._search._shared_words.index
            assert index is not None
            assert index.current().gone == 1

    def test_local_words_come_back_and_go_with_their_shape(
        self, library: Library, shapes_in_it: list[Mesh]
    ) -> None:
        code = library.model.describe(shapes_in_it[4]).local_code
        np.testing.assert_array_equal(library.signature(5).local_code, code)
        assert len(_with_local_words(library)) == 24
        library.remove_shape(5)
        assert len(library._store.codes("local_words", [5], 32)[0]) == 0
        assert len(_with_local_words(library)) == 23

    def test_a_model_without_them_still_answers(
        self, path: Path, verifying: ShapeModel, shapes_in_it: list[Mesh]
    ) -> None:
        with Library.open(path, verifying) as library:
            library.add(shapes_in_it[0])
            library.add(shapes_in_it[1])
            query = transform(shapes_in_it[1], "partial", 2, seed=0)
            assert library.query(query, top=1)[0].name == "shape 1"
            assert library.signature(1).local_code is None

    def test_what_fits_exactly_comes_before_what_bags_prefer(
        self, library: Library, shapes_in_it: list[Mesh]
    ) -> None:
        """Half of a shape, with bags that say nothing."""
        query = library.model.describe(cut(shapes_in_it[8], np.array([0.3, 1, 0.2]), 0.5))
        strange = replace(query, bags=library.signature(3).bags[::-1].copy())
        with reopened(library, exact_gain=0.0) as other:
            before = [match.name for match in other.query(strange, top=24, explain=0)]
        after = [match.name for match in library.query(strange, top=24, explain=0)]
        assert sorted(after) == sorted(before)
        assert after.index("shape 8") <= before.index("shape 8")
        assert after[0] == "shape 8"

    def test_a_signature_with_another_local_code(
        self, path: Path, library: Library, verifying: ShapeModel, shapes_in_it: list[Mesh]
    ) -> None:
        signature = library.model.describe(shapes_in_it[0])
        with pytest.raises(LibraryError, match="its local code does not fit"):
            library.add_signature(replace(signature, local_code=np.zeros(3, np.uint8)), "shape")
