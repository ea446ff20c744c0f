# SPDX-License-Identifier: MIT
"""Queries with signatures: order, candidates, and changes of the library between them."""

from __future__ import annotations

import json
import shutil
import sqlite3
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from shapegoogle_core.library.library import Library
from shapegoogle_core.library.search.codes.hamming import asymmetric_distances
from shapegoogle_core.library.search.settings import CandidateSettings, RerankSettings, SearchSettings
from shapegoogle_core.library.storage.signatures import round_bags
from shapegoogle_core.library.storage.store import CodeKind, CodePage
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeModel, ShapeSignature

# Codes decide already in a library of dozens.
FEW_CANDIDATES = SearchSettings(candidates=CandidateSettings(count=12))


@pytest.fixture
def small_portions(model: ShapeModel) -> SearchSettings:
    """Seven bags at once, so that a small library takes several portions."""
    return SearchSettings(rerank=RerankSettings(entries_at_once=7 * model.bag_size))


@pytest.fixture(scope="module")
def sixty_shapes(
    tmp_path_factory: pytest.TempPathFactory, model: ShapeModel, make_signature: Callable[..., ShapeSignature]
) -> Path:
    path = tmp_path_factory.mktemp("sixty") / "shapes.sglib"
    with Library.open(path, model) as library:
        for seed in range(60):
            library.add_signature(make_signature(seed), f"shape {seed}", source=f"{seed}.obj")
    return path


@pytest.fixture
def filled(path: Path, sixty_shapes: Path) -> Iterator[Library]:
    shutil.copy(sixty_shapes, path)
    with Library.open(path) as library:
        yield library


@pytest.fixture
def few(path: Path, sixty_shapes: Path) -> Iterator[Library]:
    """The same shapes, searched with few candidates."""
    shutil.copy(sixty_shapes, path)
    with Library.open(path, search=FEW_CANDIDATES) as library:
        yield library


def test_an_empty_library_answers_nothing(
    path: Path, model: ShapeModel, make_signature: Callable[..., ShapeSignature]
) -> None:
    with Library.open(path, model) as library:
        assert library.query(make_signature(1), explain=0) == []
        assert library.query(make_signature(1), exact=True, explain=0) == []


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("metric", ["cosine", "l1"])
def test_every_mesh_finds_itself_first(
    path: Path, make_model: Callable[..., ShapeModel], meshes: list[Mesh], exact: bool, metric: str
) -> None:
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
def test_a_shape_of_the_library_is_its_own_best_match(
    filled: Library, make_signature: Callable[..., ShapeSignature], seed: int, top: int, exact: bool
) -> None:
    matches = filled.query(make_signature(seed), top=top, exact=exact, explain=0)
    assert (matches[0].name, matches[0].distance, matches[0].similarity) == (f"shape {seed}", 0.0, 1.0)
    assert len(matches) == min(top, 60)


def test_exact_answers_equal_a_plain_comparison(
    path: Path,
    sixty_shapes: Path,
    model: ShapeModel,
    make_signature: Callable[..., ShapeSignature],
    small_portions: SearchSettings,
) -> None:
    shutil.copy(sixty_shapes, path)
    query = make_signature(1_000)
    bags = np.stack([round_bags(make_signature(seed).bags) for seed in range(60)])
    distances = model.distances(round_bags(query.bags), bags)
    expected = [f"shape {seed}" for seed in np.argsort(distances)]
    with Library.open(path, search=small_portions) as library:
        matches = library.query(query, top=60, exact=True, explain=0)
        assert library.query(query, top=9, exact=True, explain=0) == matches[:9]
    assert [match.name for match in matches] == expected
    np.testing.assert_allclose([match.distance for match in matches], np.sort(distances), atol=1e-6)
    np.testing.assert_allclose(
        [match.similarity for match in matches], model.similarity(np.sort(distances)), atol=1e-4
    )


def test_portions_do_not_show(
    path: Path, model: ShapeModel, make_signature: Callable[..., ShapeSignature]
) -> None:
    answers = []
    with Library.open(path, model) as library:
        for seed in range(40):
            library.add_signature(make_signature(seed), f"shape {seed}")
    for portion in (1, 7, 1_000):
        settings = SearchSettings(rerank=RerankSettings(entries_at_once=portion * model.bag_size))
        with Library.open(path, search=settings) as library:
            for exact in (False, True):
                answers.append(library.query(make_signature(99), top=11, exact=exact, explain=0))
    assert all(answer == answers[0] for answer in answers)


def test_codes_and_bags_agree_while_all_shapes_are_candidates(
    filled: Library, make_signature: Callable[..., ShapeSignature]
) -> None:
    for seed in range(1_000, 1_020):
        query = make_signature(seed)
        assert filled.query(query, top=10, explain=0) == filled.query(query, top=10, exact=True, explain=0)


def test_only_the_nearest_codes_are_candidates(
    path: Path, sixty_shapes: Path, model: ShapeModel, make_signature: Callable[..., ShapeSignature]
) -> None:
    """24 by Hamming distance, 12 of these by how far the query's bits are on the wrong side."""
    shutil.copy(sixty_shapes, path)
    filled = Library.open(path, search=SearchSettings(CandidateSettings(count=12, oversampling=2)))
    codes = np.array([make_signature(other).code for other in range(60)])
    differs = False
    for seed in range(1_000, 1_020):
        query = make_signature(seed)
        hamming = [int(np.unpackbits(query.code ^ make_signature(other).code).sum()) for other in range(60)]
        rough = np.sort(np.argsort(hamming, kind="stable")[:24])
        distances = asymmetric_distances(codes[rough], model.code_projections(query.bags[None])[0])
        candidates = {f"shape {other}" for other in rough[np.argsort(distances, kind="stable")[:12]]}
        every = filled.query(query, top=60, exact=True, explain=0)
        expected = [match for match in every if match.name in candidates][:3]
        answer = filled.query(query, top=3, explain=0)
        assert answer == expected
        differs |= answer != every[:3]
    assert differs
    filled.close()


def test_asking_for_more_makes_more_candidates(
    few: Library, make_signature: Callable[..., ShapeSignature]
) -> None:
    assert len(few.query(make_signature(1_000), top=40, explain=0)) == 40
    assert len(few.query(make_signature(1_000), top=500, explain=0)) == 60


def test_equals_come_in_the_order_of_their_names(
    path: Path,
    model: ShapeModel,
    make_signature: Callable[..., ShapeSignature],
    small_portions: SearchSettings,
) -> None:
    with Library.open(path, model, search=small_portions) as library:
        for name in "hkcajbgfdlei":
            library.add_signature(make_signature(1), name)
        library.add_signature(make_signature(1), "c", source="a.obj")
        library.add_signature(make_signature(2), "another shape")
        for exact in (False, True):
            for top in (3, 5, 13):
                matches = library.query(make_signature(1), top=top, exact=exact, explain=0)
                assert [match.name for match in matches] == list("abccdefghijkl")[:top]
                assert {match.distance for match in matches} == {0.0}
                assert [match.source for match in matches][2:4] == ["", "a.obj"][: max(0, top - 2)]


def test_own_changes_show_at_once(filled: Library, make_signature: Callable[..., ShapeSignature]) -> None:
    query = make_signature(7)
    (best,) = filled.query(query, top=1, explain=0)
    filled.remove_shape(best.shape_id)
    assert filled.query(query, top=1, explain=0)[0].name != "shape 7"
    filled.add_signature(make_signature(7), "back")
    assert filled.query(query, top=1, explain=0)[0].name == "back"
    filled.replace_source("new.obj", size=1, mtime_ns=1, sha256=None)
    filled.remove("8.obj")
    assert len(filled.query(query, top=100, explain=0)) == 59


def test_changes_of_others_show_at_once(
    path: Path, filled: Library, make_signature: Callable[..., ShapeSignature]
) -> None:
    query = make_signature(500)
    assert filled.query(query, top=1, explain=0)[0].distance > 0
    with Library.open(path) as other:
        other.add_signature(query, "new")
    assert filled.query(query, top=1, explain=0)[0].name == "new"


def watch_codes(library: Library, monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Ids of the shapes whose codes are read from now on, in the order of reading."""
    read: list[int] = []
    pages = library._store.code_pages

    def watched(kind: CodeKind, last_id: int, code_bytes: int) -> Iterator[CodePage]:
        for shape_ids, codes in pages(kind, last_id, code_bytes):
            read.extend(shape_ids.tolist())
            yield shape_ids, codes

    monkeypatch.setattr(library._store, "code_pages", watched)
    return read


def test_codes_are_read_once(
    path: Path,
    filled: Library,
    make_signature: Callable[..., ShapeSignature],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    codes_read = watch_codes(filled, monkeypatch)
    for seed in range(4):
        filled.query(make_signature(seed), explain=0)
    assert codes_read == list(range(1, 61))
    codes_read.clear()
    new_id = filled.add_signature(make_signature(100), "own")
    filled.query(make_signature(1), explain=0)
    with Library.open(path) as other:
        other_id = other.add_signature(make_signature(101), "another's")
        replaced_id = other.add_signature(make_signature(102), "shape 5", source="5.obj")
        other.remove_shape(new_id)
    names = [match.name for match in filled.query(make_signature(1), top=100, explain=0)]
    assert codes_read == [new_id, other_id, replaced_id]
    assert sorted(names) == sorted([f"shape {seed}" for seed in range(60)] + ["another's"])


def test_removed_shapes_make_room_for_the_next_candidates(
    path: Path, few: Library, make_signature: Callable[..., ShapeSignature]
) -> None:
    """Three at first, which are skipped from then on; then so many that all codes are read again."""
    query = make_signature(1_000)
    few.query(query, top=3, explain=0)
    for removed in (3, 10, 30):
        with Library.open(path, search=FEW_CANDIDATES) as other:
            for match in other.query(query, top=removed, explain=0):
                other.remove_shape(match.shape_id)
            expected = other.query(query, top=3, explain=0)
        with Library.open(path, search=FEW_CANDIDATES) as fresh:
            assert few.query(query, top=3, explain=0) == fresh.query(query, top=3, explain=0) == expected
        assert len(expected) == 3


def test_too_many_removed_shapes_are_forgotten(
    path: Path,
    sixty_shapes: Path,
    make_signature: Callable[..., ShapeSignature],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    shutil.copy(sixty_shapes, path)
    query = make_signature(1_000)
    with Library.open(path, search=SearchSettings(CandidateSettings(max_removed=2))) as library:
        codes_read = watch_codes(library, monkeypatch)
        for left in (60, 59, 58, 57, 56):
            matches = library.query(query, top=60, explain=0)
            assert len(matches) == left
            library.remove_shape(matches[0].shape_id)
    # With three removed, one more than are kept, the fourth search read the 57 that are left.
    assert len(codes_read) == 60 + 57


def test_a_code_without_bags_is_left_out(
    path: Path, filled: Library, make_signature: Callable[..., ShapeSignature]
) -> None:
    """Only in a damaged library; it must not be searched for ever."""
    connection = sqlite3.connect(path)
    connection.execute("DELETE FROM bags WHERE shape_id = 8")
    connection.commit()
    connection.close()
    for _ in range(2):
        assert len(filled.query(make_signature(7), top=100, explain=0)) == 59


@pytest.mark.parametrize("top", [0, -1])
def test_top_must_be_positive(
    filled: Library, make_signature: Callable[..., ShapeSignature], top: int
) -> None:
    with pytest.raises(ValueError, match="top must be a whole number of at least 1"):
        filled.query(make_signature(1), top=top, explain=0)


def test_a_match_says_what_the_shape_is_and_turns_into_json(
    path: Path, model: ShapeModel, meshes: list[Mesh]
) -> None:
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
        "object_name": "Horse",
        "similarity": 1.0,
        "likeness": None,
        "distance": 0.0,
        "placements": 1,
        "shape_type": "object",
        "evidence": None,
    }
