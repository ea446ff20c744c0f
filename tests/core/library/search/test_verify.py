# SPDX-License-Identifier: MIT
"""Geometric verification brings forward what fits in space, and never loses a match."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.creatures import CREATURE_KINDS, make_creature
from benchmarks.experiments.evidence_pairs import cut
from shapegoogle_core import Library, Mesh, compute_spectrum
from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.search import search
from shapegoogle_core.library.search import verify as verification
from shapegoogle_core.model.augmentation import transform
from shapegoogle_core.preprocessing import PreprocessingSettings
from shapegoogle_core.registration import LocalSettings, SampleSettings, fit_local_words, sample_surface
from shapegoogle_core.registration.exact_fit import RoughPose
from shapegoogle_core.registration.frames import Frame


@pytest.fixture(scope="module")
def verifying(make_model):
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


@pytest.fixture
def library(path, verifying, shapes_in_it):
    with Library.open(path, verifying) as library:
        for mesh in shapes_in_it:
            library.add(mesh)
        yield library


def test_a_damaged_shape_comes_first(library, shapes_in_it):
    ranks, plain = [], []
    for index in range(0, 24, 4):
        query = transform(shapes_in_it[index], "partial", 3, seed=index)
        signature = library.model.describe(query)
        names = [match.name for match in library.query_signature(signature, top=24)]
        ranks.append(names.index(f"shape {index}"))
        alone = [m.name for m in library.query_signature(replace(signature, sample=None), top=24)]
        plain.append(alone.index(f"shape {index}"))
        assert sorted(names) == sorted(alone)
    assert np.mean(np.array(ranks) == 0) >= 0.8
    assert np.mean(1 / (1 + np.array(plain))) < np.mean(1 / (1 + np.array(ranks)))


def test_matches_are_in_order_and_no_farther_than_before(library, shapes_in_it):
    signature = library.model.describe(transform(shapes_in_it[3], "holes", 3, seed=0))
    for exact in (False, True):
        matches = library.query_signature(signature, top=24, exact=exact)
        assert [match.distance for match in matches] == sorted(match.distance for match in matches)
        assert [match.similarity for match in matches] == sorted(
            (match.similarity for match in matches), reverse=True
        )
        before = {
            m.shape_id: m.distance for m in library.query_signature(replace(signature, sample=None), top=24)
        }
        assert all(match.distance <= before[match.shape_id] for match in matches)
        assert len(matches) == 24


def test_what_stands_far_behind_is_found_by_its_support(library, shapes_in_it, monkeypatch):
    """With two looked at first and five next, the right one must come in by the support it has."""
    monkeypatch.setattr(verification, "_LIKELY", 2.0)  # the untrained model is sure of everything
    monkeypatch.setattr(verification, "_FIRST", 2)
    monkeypatch.setattr(verification, "_NEXT", 5)
    firsts = 0
    for index in range(0, 24, 4):
        query = transform(shapes_in_it[index], "partial", 3, seed=index)
        firsts += library.query(query, top=1)[0].name == f"shape {index}"
    assert firsts >= 5


def test_samples_come_back_and_go_with_their_shape(library, shapes_in_it):
    shape_id = library.add(shapes_in_it[0], name="again")
    sample = library.signature(shape_id).sample
    assert sample is not None
    assert len(sample.points) == 300
    library.remove_shape(shape_id)
    assert library._store.samples([shape_id]) == {}


def test_a_damaged_sample_is_named(library, shapes_in_it):
    query = transform(shapes_in_it[0], "noise", 2, seed=0)
    library._store.connection.execute("UPDATE samples SET content = x'0102'")
    with pytest.raises(LibraryError, match=r"surface of shape .* cannot be read"):
        library.query(query)
    with pytest.raises(LibraryError, match=r"surface of shape 1 cannot be read"):
        library.signature(1)
    other = sample_surface(shapes_in_it[0], compute_spectrum(shapes_in_it[0], k=20), SampleSettings(50, 20))
    library._store.connection.execute("UPDATE samples SET content = ?", (other.to_bytes(),))
    with pytest.raises(LibraryError, match=r"another size than its model's"):
        library.query(query)


def test_a_signature_with_a_sample_does_not_fit_a_model_without(path, make_model, verifying, shapes_in_it):
    signature = verifying.describe(shapes_in_it[0])
    with Library.open(path, make_model()) as library, pytest.raises(LibraryError, match="another model"):
        library.add_signature(signature, "shape")


def test_shapes_without_a_sample_stand_among_the_others(library, shapes_in_it):
    """As after an interrupted repair by hand: they are compared by their bags."""
    library._store.connection.execute("DELETE FROM samples WHERE shape_id % 2 = 0")
    matches = library.query(shapes_in_it[0], top=24)
    assert len(matches) == 24
    assert matches[0].name == "shape 0"


def test_geometry_is_asked_only_where_it_is_needed(library, shapes_in_it, monkeypatch):
    monkeypatch.setattr(verification, "_FIRST", 2)
    looked_at = []
    original = verification.align
    monkeypatch.setattr(
        verification, "align", lambda query, other: looked_at.append(1) or original(query, other)
    )
    certain = library.query(shapes_in_it[5])  # itself: distance 0
    assert certain[0].similarity == 1
    assert len(looked_at) == 0
    library.query(transform(shapes_in_it[5], "noise", 1, seed=0))  # likely, once it has been looked at
    assert len(looked_at) == 2
    monkeypatch.setattr(verification, "_LIKELY", 2.0)
    library.query(transform(shapes_in_it[5], "noise", 1, seed=0))  # lies on it exactly
    assert len(looked_at) == 2 + 2
    monkeypatch.setattr(verification, "_SURELY_EXACT", 2.0)
    library.query(transform(shapes_in_it[5], "noise", 1, seed=0))
    assert len(looked_at) == 4 + 24


def test_a_model_without_samples_still_answers(path, make_model, shapes_in_it):
    with Library.open(path, make_model()) as library:
        library.add(shapes_in_it[0])
        library.add(shapes_in_it[1])
        assert library.query(shapes_in_it[1], top=1)[0].name == "shape 1"
        assert library.signature(1).sample is None


@pytest.fixture(scope="module")
def indexing(verifying, shapes_in_it):
    local = LocalSettings(words=256)
    words = fit_local_words([verifying.describe(mesh).sample for mesh in shapes_in_it], local)
    return replace(verifying, settings=replace(verifying.settings, local=local), local_words=words)


def _with_local_words(library: Library) -> list[int]:
    return [i for ids, _ in library._store.code_pages("local_words", 0, 32) for i in ids.tolist()]


class TestPartsIndex:
    """What bags do not find, local words bring before geometry."""

    @pytest.fixture
    def library(self, path, indexing, shapes_in_it):
        with Library.open(path, indexing) as library:
            for mesh in shapes_in_it:
                library.add(mesh)
            yield library

    @pytest.mark.parametrize("exact", [False, True])
    def test_a_shape_far_by_its_bags_is_found(self, library, shapes_in_it, monkeypatch, exact):
        query = library.model.describe(transform(shapes_in_it[8], "partial", 4, seed=0))
        strange = replace(query, bags=library.signature(3).bags[::-1].copy(), code=~library.signature(9).code)
        monkeypatch.setattr(search, "CANDIDATES", 3)
        monkeypatch.setattr(search, "CANDIDATES_PER_MATCH", 1)
        monkeypatch.setattr(search, "ROUGH_PER_CANDIDATE", 1)
        monkeypatch.setattr(search, "SCREENED", 3)
        with monkeypatch.context() as patch:
            patch.setattr(library._search, "_local_words", None)
            assert "shape 8" not in [m.name for m in library.query_signature(strange, top=3, exact=exact)]
        monkeypatch.setattr(search, "LOCAL_CANDIDATES", 2)
        assert library.query_signature(strange, top=1, exact=exact)[0].name == "shape 8"

    def test_a_wrong_rough_pose_does_not_hide_a_shape(self, library, shapes_in_it, monkeypatch):
        query = library.model.describe(transform(shapes_in_it[8], "partial", 4, seed=0))
        strange = replace(query, bags=library.signature(3).bags[::-1].copy(), code=~library.signature(9).code)
        far_away = Frame(1.0, np.eye(3), np.full(3, 10.0))
        monkeypatch.setattr(verification, "rough_pose", lambda *_: RoughPose(covered=1.0, frame=far_away))
        monkeypatch.setattr(verification, "_FIRST", 2)
        monkeypatch.setattr(search, "CANDIDATES", 3)
        monkeypatch.setattr(search, "CANDIDATES_PER_MATCH", 1)
        monkeypatch.setattr(search, "ROUGH_PER_CANDIDATE", 1)
        assert library.query_signature(strange, top=1)[0].name == "shape 8"

    def test_support_decides_among_those_with_the_words(self, library, shapes_in_it, monkeypatch):
        """All have some of the words; only one place is given away, by what agrees in space."""
        query = library.model.describe(cut(shapes_in_it[8], np.array([0.3, 1, 0.2]), 0.5))
        strange = replace(query, bags=library.signature(3).bags[::-1].copy(), code=~library.signature(9).code)
        laid = []
        original = verification.rough_pose
        monkeypatch.setattr(
            verification, "rough_pose", lambda *pair: laid.append(pair[1].points) or original(*pair)
        )
        monkeypatch.setattr(verification, "_FIRST", 1)
        monkeypatch.setattr(verification, "_LIKELY", 2.0)
        monkeypatch.setattr(search, "SUPPORTED", 1)
        assert library.query_signature(strange, top=1)[0].name == "shape 8"
        (points,) = laid
        np.testing.assert_array_equal(points, library.signature(9).sample.points)

    def test_shapes_that_another_process_removed_are_skipped(self, path, library, shapes_in_it, monkeypatch):
        query = library.model.describe(cut(shapes_in_it[8], np.array([0.3, 1, 0.2]), 0.5))
        monkeypatch.setattr(verification, "_FIRST", 1)
        monkeypatch.setattr(verification, "_LIKELY", 2.0)
        library.query_signature(query)
        with Library.open(path) as other:
            other.remove_shape(9)
        assert "shape 8" not in [match.name for match in library.query_signature(query, top=24)]
        assert library._search._local_words.current().gone == 1

    def test_local_words_come_back_and_go_with_their_shape(self, library, shapes_in_it):
        code = library.model.describe(shapes_in_it[4]).local_code
        np.testing.assert_array_equal(library.signature(5).local_code, code)
        assert len(_with_local_words(library)) == 24
        library.remove_shape(5)
        assert len(library._store.codes("local_words", [5], 32)[0]) == 0
        assert len(_with_local_words(library)) == 23

    def test_a_model_without_them_still_answers(self, path, verifying, shapes_in_it):
        with Library.open(path, verifying) as library:
            library.add(shapes_in_it[0])
            library.add(shapes_in_it[1])
            query = transform(shapes_in_it[1], "partial", 2, seed=0)
            assert library.query(query, top=1)[0].name == "shape 1"
            assert library.signature(1).local_code is None

    def test_what_fits_exactly_comes_before_what_bags_prefer(self, library, shapes_in_it, monkeypatch):
        """Half of a shape, with bags that say nothing."""
        query = library.model.describe(cut(shapes_in_it[8], np.array([0.3, 1, 0.2]), 0.5))
        strange = replace(query, bags=library.signature(3).bags[::-1].copy())
        with monkeypatch.context() as patch:
            patch.setattr(verification, "_EXACT_GAIN", 0.0)
            before = [match.name for match in library.query_signature(strange, top=24)]
        after = [match.name for match in library.query_signature(strange, top=24)]
        assert sorted(after) == sorted(before)
        assert after.index("shape 8") <= before.index("shape 8")
        assert after[0] == "shape 8"

    def test_a_signature_with_another_local_code(self, path, library, verifying, shapes_in_it):
        signature = library.model.describe(shapes_in_it[0])
        with pytest.raises(LibraryError, match="its local code does not fit"):
            library.add_signature(replace(signature, local_code=np.zeros(3, np.uint8)), "shape")
