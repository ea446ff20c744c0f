# SPDX-License-Identifier: MIT
"""Large libraries: the database compares codes itself, with and without pgvector."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing

import numpy as np
import pytest

from shapegoogle_core.cli.parser import main
from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.search.codes.code_index import CodeIndex
from shapegoogle_core.library.storage.opening import connect
from shapegoogle_core.library.storage.postgresql.administration import (
    index_memory,
    index_statements,
    run_statements,
)
from shapegoogle_core.library.storage.postgresql.codes import CodeTables
from shapegoogle_core.library.storage.postgresql.store import PostgresqlStore
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.library.storage.store import all_codes
from shapegoogle_core.model import ShapeModel, ShapeSignature
from tests.core.postgresql_server import PostgresqlServer

SignatureMaker = Callable[..., ShapeSignature]
COUNT = 400


def fill(url: str, model: ShapeModel, make_signature: SignatureMaker) -> Library:
    """Every fifth shape is there twice, so that distances are equal."""
    library = Library.open(url, model)
    shapes = [
        NewShape(make_signature(seed - seed % 5 // 4), f"shape {seed}", f"{seed}") for seed in range(COUNT)
    ]
    library._graph = None  # neighbours are not of interest here
    library.replace_source("all", size=1, mtime_ns=1, sha256="ab", shapes=shapes)
    return library


@pytest.fixture
def compared_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(CodeTables, "compared_in_memory", 0)


def test_the_database_finds_what_the_memory_finds(
    postgresql_url: str, model: ShapeModel, make_signature: SignatureMaker, compared_there: None
) -> None:
    with fill(postgresql_url, model, make_signature) as library:
        ids, codes = all_codes(library._store, "codes", 9)
        index = CodeIndex()
        index.add(ids, codes)
        some = library._store.filtered_ids(Filter(faces=(100, 300)))
        for seed in range(5):
            code = make_signature(1_000 + seed).code
            for among in (None, some):
                found = library._store.nearest_codes(code, 30, among)
                assert found is not None
                np.testing.assert_array_equal(found, index.nearest(code, 30, among))
        there = library.query(make_signature(7), top=20, explain=0)
    with Library.open(postgresql_url) as library:
        library._store.compared_in_memory = COUNT  # type: ignore[attr-defined]
        here = library.query(make_signature(7), top=20, explain=0)
    assert [(match.shape_id, match.distance) for match in there] == [
        (match.shape_id, match.distance) for match in here
    ]


@pytest.fixture
def with_vectors(
    postgresql_with_vectors: PostgresqlServer, model: ShapeModel, make_signature: SignatureMaker
) -> str:
    url = postgresql_with_vectors.new_url()
    fill(url, model, make_signature).close()
    return url


@pytest.mark.long
def test_an_index_of_pgvector_is_made_used_and_made_anew(
    with_vectors: str,
    make_signature: SignatureMaker,
    compared_there: None,
    capsys: pytest.CaptureFixture[str],
) -> None:
    for _ in range(2):
        assert main(["database", "--library", with_vectors, "--index"]) == 0
        assert "index of 400 codes in 20 lists made" in capsys.readouterr().out
    with Library.open(with_vectors) as library:
        store = library._store
        assert isinstance(store, CodeTables)
        assert store.index_lists() == 20
        with store.snapshot():
            store.rows("SELECT set_config('enable_seqscan', 'off', TRUE)")
            plan = store.rows(
                "EXPLAIN SELECT shape_id FROM codes ORDER BY code OPERATOR(public.<~>) %s::bit(72) LIMIT 5",
                "0" * 72,
            )
        assert "codes_nearest" in str(plan)
        ids, codes = all_codes(store, "codes", 9)
        index = CodeIndex()
        index.add(ids, codes)
        for seed in range(0, 100, 5):
            code = make_signature(seed).code
            found = store.nearest_codes(code, 5)
            assert found is not None
            assert found[0] == index.nearest(code, 1)[0]
        match, *_ = library.query(make_signature(7), top=3, explain=0)
        assert match.distance == pytest.approx(0, abs=1e-3)
        assert library.remove("all")
        left = store.nearest_codes(code, 5)
        assert left is not None
        assert left.tolist() == []


def test_a_server_without_pgvector_says_so(
    postgresql: PostgresqlServer, postgresql_url: str, model: ShapeModel
) -> None:
    with Library.open(postgresql_url, model) as library:
        has_vectors = library._store.value(  # type: ignore[attr-defined]
            "SELECT count(*) FROM pg_available_extensions WHERE name = 'vector'"
        )
    if has_vectors:
        pytest.skip("this PostgreSQL has pgvector")
    with pytest.raises(LibraryError, match=r"has no pgvector; install pgvector 0\.7 or later"):
        index_statements(connect(postgresql_url, read_only=True, timeout=1))


@pytest.mark.parametrize(("lists", "asked"), [(316, 21), (548, 61), (1000, 198), (1414, 394), (2000, 785)])
def test_the_index_gets_the_memory_that_pgvector_asks_for(lists: int, asked: int) -> None:
    """Megabytes as pgvector 0.8.5 states them for codes of 256 bits."""
    assert 1.03 * asked < index_memory(lists) / 2**20 < 1.2 * asked + 20


@pytest.mark.long
def test_memory_is_raised_for_the_index_alone(with_vectors: str) -> None:
    with closing(connect(with_vectors, read_only=False, timeout=1)) as store:
        assert isinstance(store, PostgresqlStore)
        usual = store.value("SHOW maintenance_work_mem")
        store.execute("SET maintenance_work_mem TO '1MB'")
        statements = index_statements(store)
        assert any(text.startswith("SET maintenance_work_mem TO '") for text in statements)
        run_statements(store, statements)
        assert store.index_lists() == 20
        assert store.value("SHOW maintenance_work_mem") == usual


def test_what_the_server_refuses_is_not_called_damaged(postgresql_url: str, model: ShapeModel) -> None:
    Library.open(postgresql_url, model).close()
    with closing(connect(postgresql_url, read_only=True, timeout=1)) as store:
        assert isinstance(store, PostgresqlStore)
        with pytest.raises(LibraryError, match=r"PostgreSQL says: requested length too large \(everything"):
            store.rows("SELECT repeat('x', 2000000000)")
        with pytest.raises(LibraryError, match=r"is damaged .*contradict each other"):
            store.rows("SELECT * FROM no_such_table")
