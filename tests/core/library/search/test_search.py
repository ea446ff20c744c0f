# SPDX-License-Identifier: MIT
"""What a query answers."""

from __future__ import annotations

import json
import shutil
import sqlite3

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from shapegoogle_core.library import Library
from shapegoogle_core.library.search import search
from shapegoogle_core.library.search.codes.hamming import asymmetric_distances
from shapegoogle_core.library.storage.bag_precision import round_bags


@pytest.fixture
def few_candidates(monkeypatch):
    """Codes decide already in a library of dozens."""
    monkeypatch.setattr(search, "CANDIDATES", 12)


@pytest.fixture
def small_portions(monkeypatch, model):
    """Seven bags at once, so that a small library takes several portions."""
    monkeypatch.setattr(search, "BAG_ENTRIES_AT_ONCE", 7 * model.bag_size)


@pytest.fixture(scope="module")
def sixty_shapes(tmp_path_factory, model, make_signature):
    path = tmp_path_factory.mktemp("sixty") / "shapes.sglib"
    with Library.open(path, model) as library:
        for seed in range(60):
            library.add_signature(make_signature(seed), f"shape {seed}", source=f"{seed}.obj")
    return path


@pytest.fixture
def filled(path, sixty_shapes):
    shutil.copy(sixty_shapes, path)
    with Library.open(path) as library:
        yield library


def test_an_empty_library_answers_nothing(path, model, make_signature):
    with Library.open(path, model) as library:
        assert library.query_signature(make_signature(1)) == []
        assert library.query_signature(make_signature(1), exact=True) == []


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("metric", ["cosine", "l1"])
def test_every_mesh_finds_itself_first(path, make_model, meshes, exact, metric):
    model = make_model(metric=metric)
    with Library.open(path, model) as library:
        ids = [library.add(mesh, name=f"mesh {index}") for index, mesh in enumerate(meshes)]
        for shape_id, mesh in zip(ids, meshes, strict=True):
            best, *others = library.query(mesh, exact=exact)
            assert (best.shape_id, best.distance, best.similarity) == (shape_id, 0.0, 1.0)
            assert [match.distance for match in others] == sorted(match.distance for match in others)
            assert all(0 <= match.similarity < 1 and match.distance > 0 for match in others)


@settings(deadline=None, max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(seed=st.integers(0, 59), top=st.integers(1, 70), exact=st.booleans())
def test_a_shape_of_the_library_is_its_own_best_match(filled, make_signature, seed, top, exact):
    matches = filled.query_signature(make_signature(seed), top, exact)
    assert (matches[0].name, matches[0].distance, matches[0].similarity) == (f"shape {seed}", 0.0, 1.0)
    assert len(matches) == min(top, 60)


def test_exact_answers_equal_a_plain_comparison(filled, model, make_signature, small_portions):
    query = make_signature(1_000)
    bags = np.stack([round_bags(make_signature(seed).bags) for seed in range(60)])
    distances = model.distances(round_bags(query.bags), bags)
    expected = [f"shape {seed}" for seed in np.argsort(distances)]
    matches = filled.query_signature(query, 60, exact=True)
    assert [match.name for match in matches] == expected
    np.testing.assert_allclose([match.distance for match in matches], np.sort(distances), atol=1e-6)
    np.testing.assert_allclose(
        [match.similarity for match in matches], model.similarity(np.sort(distances)), atol=1e-4
    )
    assert filled.query_signature(query, 9, exact=True) == matches[:9]


def test_portions_do_not_show(path, model, make_signature, monkeypatch):
    answers = []
    with Library.open(path, model) as library:
        for seed in range(40):
            library.add_signature(make_signature(seed), f"shape {seed}")
    for portion in (1, 7, 1_000):
        monkeypatch.setattr(search, "BAG_ENTRIES_AT_ONCE", portion * model.bag_size)
        with Library.open(path) as library:
            for exact in (False, True):
                answers.append(library.query_signature(make_signature(99), 11, exact))
    assert all(answer == answers[0] for answer in answers)


def test_codes_and_bags_agree_while_all_shapes_are_candidates(filled, make_signature):
    for seed in range(1_000, 1_020):
        query = make_signature(seed)
        assert filled.query_signature(query, 10) == filled.query_signature(query, 10, exact=True)


def test_only_the_nearest_codes_are_candidates(filled, model, make_signature, few_candidates, monkeypatch):
    """24 by Hamming distance, 12 of these by how far the query's bits are on the wrong side."""
    monkeypatch.setattr(search, "ROUGH_PER_CANDIDATE", 2)
    codes = np.array([make_signature(other).code for other in range(60)])
    differs = False
    for seed in range(1_000, 1_020):
        query = make_signature(seed)
        hamming = [int(np.unpackbits(query.code ^ make_signature(other).code).sum()) for other in range(60)]
        rough = np.sort(np.argsort(hamming, kind="stable")[:24])
        distances = asymmetric_distances(codes[rough], model.code_projections(query.bags[None])[0])
        candidates = {f"shape {other}" for other in rough[np.argsort(distances, kind="stable")[:12]]}
        every = filled.query_signature(query, 60, exact=True)
        expected = [match for match in every if match.name in candidates][:3]
        answer = filled.query_signature(query, 3)
        assert answer == expected
        differs |= answer != every[:3]
    assert differs


def test_asking_for_more_makes_more_candidates(filled, make_signature, few_candidates):
    assert len(filled.query_signature(make_signature(1_000), 40)) == 40
    assert len(filled.query_signature(make_signature(1_000), 500)) == 60


def test_equals_come_in_the_order_of_their_names(path, model, make_signature, small_portions):
    with Library.open(path, model) as library:
        for name in "hkcajbgfdlei":
            library.add_signature(make_signature(1), name)
        library.add_signature(make_signature(1), "c", source="a.obj")
        library.add_signature(make_signature(2), "another shape")
        for exact in (False, True):
            for top in (3, 5, 13):
                matches = library.query_signature(make_signature(1), top, exact)
                assert [match.name for match in matches] == list("abccdefghijkl")[:top]
                assert {match.distance for match in matches} == {0.0}
                assert [match.source for match in matches][2:4] == ["", "a.obj"][: max(0, top - 2)]


def test_own_changes_show_at_once(filled, make_signature):
    query = make_signature(7)
    (best,) = filled.query_signature(query, 1)
    filled.remove_shape(best.shape_id)
    assert filled.query_signature(query, 1)[0].name != "shape 7"
    filled.add_signature(make_signature(7), "back")
    assert filled.query_signature(query, 1)[0].name == "back"
    filled.replace_source("new.obj", size=1, mtime_ns=1, sha256=None)
    filled.remove("8.obj")
    assert len(filled.query_signature(query, 100)) == 59


def test_changes_of_others_show_at_once(path, filled, make_signature):
    query = make_signature(500)
    assert filled.query_signature(query, 1)[0].distance > 0
    with Library.open(path) as other:
        other.add_signature(query, "new")
    assert filled.query_signature(query, 1)[0].name == "new"


@pytest.fixture
def codes_read(filled, monkeypatch):
    """Ids of the shapes whose codes were read, in the order of reading."""
    read: list[int] = []
    pages = filled._store.code_pages

    def watched(table, last_id, code_bytes):
        for shape_ids, codes in pages(table, last_id, code_bytes):
            read.extend(shape_ids.tolist())
            yield shape_ids, codes

    monkeypatch.setattr(filled._store, "code_pages", watched)
    return read


def test_codes_are_read_once(path, filled, make_signature, codes_read):
    for seed in range(4):
        filled.query_signature(make_signature(seed))
    assert codes_read == list(range(1, 61))
    codes_read.clear()
    new_id = filled.add_signature(make_signature(100), "own")
    filled.query_signature(make_signature(1))
    with Library.open(path) as other:
        other_id = other.add_signature(make_signature(101), "another's")
        replaced_id = other.add_signature(make_signature(102), "shape 5", source="5.obj")
        other.remove_shape(new_id)
    names = [match.name for match in filled.query_signature(make_signature(1), 100)]
    assert codes_read == [new_id, other_id, replaced_id]
    assert sorted(names) == sorted([f"shape {seed}" for seed in range(60)] + ["another's"])


def test_removed_shapes_make_room_for_the_next_candidates(path, filled, make_signature, few_candidates):
    """Three at first, which are skipped from then on; then so many that all codes are read again."""
    query = make_signature(1_000)
    filled.query_signature(query, 3)
    for removed in (3, 10, 30):
        with Library.open(path) as other:
            for match in other.query_signature(query, removed):
                other.remove_shape(match.shape_id)
            expected = other.query_signature(query, 3)
        with Library.open(path) as fresh:
            assert filled.query_signature(query, 3) == fresh.query_signature(query, 3) == expected
        assert len(expected) == 3


def test_too_many_removed_shapes_are_forgotten(filled, make_signature, codes_read, monkeypatch):
    monkeypatch.setattr(search, "MAX_GONE", 2)
    query = make_signature(1_000)
    for left in (60, 59, 58, 57, 56):
        matches = filled.query_signature(query, 60)
        assert len(matches) == left
        filled.remove_shape(matches[0].shape_id)
    # With three removed, one more than are kept, the fourth search read the 57 that are left.
    assert len(codes_read) == 60 + 57


def test_a_code_without_bags_is_left_out(path, filled, make_signature):
    """Only in a damaged library; it must not be looked for for ever."""
    connection = sqlite3.connect(path)
    connection.execute("DELETE FROM bags WHERE shape_id = 8")
    connection.commit()
    connection.close()
    for _ in range(2):
        assert len(filled.query_signature(make_signature(7), 100)) == 59


@pytest.mark.parametrize("top", [0, -1])
def test_top_must_be_positive(filled, make_signature, top):
    with pytest.raises(ValueError, match="top must be at least 1"):
        filled.query_signature(make_signature(1), top)


def test_a_match_says_what_the_shape_is_and_turns_into_json(path, model, meshes):
    with Library.open(path, model) as library:
        shape_id = library.add(meshes[0], name="horse", source="animals.blend", object_name="Horse")
        (match,) = library.query(meshes[0])
    assert (match.shape_id, match.object_name, match.vertex_count) == (
        shape_id,
        "Horse",
        len(meshes[0].vertices),
    )
    assert (match.face_count, match.area) == (len(meshes[0].faces), meshes[0].area)
    assert json.loads(json.dumps(match.to_json())) == {
        "name": "horse",
        "source": "animals.blend",
        "similarity": 1.0,
        "distance": 0.0,
        "evidence": None,
    }
