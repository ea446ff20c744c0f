# SPDX-License-Identifier: MIT
"""Packed codes say what the rows of codes say, whoever changed the library."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library import Library, NewShape
from shapegoogle_core.library.storage.sqlite import code_blocks

BLOCK_IDS = 8
CHANGES = ["add", "replace", "remove", "remove shape"]


@pytest.fixture(autouse=True)
def small_blocks(monkeypatch):
    monkeypatch.setattr(code_blocks, "BLOCK_IDS", BLOCK_IDS)
    monkeypatch.setattr(code_blocks, "TRIGGER", code_blocks.TRIGGER.replace("4096", str(BLOCK_IDS)))
    monkeypatch.setattr(code_blocks, "ROWS_AT_ONCE", 5)


def blocks_of(path: Path) -> dict[int, list[int]]:
    """Which ids each block holds."""
    with closing(sqlite3.connect(path)) as connection:
        return {
            block: (block * BLOCK_IDS + 1 + np.frombuffer(offsets, "<u2").astype(int)).tolist()
            for block, offsets in connection.execute("SELECT block, offsets FROM code_blocks")
        }


def check(library: Library) -> None:
    """Read all codes, and those after each id, and compare them with the rows."""
    with closing(sqlite3.connect(library.path)) as connection:
        rows = connection.execute("SELECT shape_id, code FROM codes ORDER BY shape_id").fetchall()
    shape_ids, codes = library._store.codes(9)
    assert list(zip(shape_ids.tolist(), [code.tobytes() for code in codes], strict=True)) == rows
    for last_id in range(0, library._store.last_id() + 2, 3):
        with library._store.snapshot():
            pages = list(library._store.code_pages("codes", last_id, 9))
        found = [shape_id for ids, _ in pages for shape_id in ids.tolist()]
        assert found == [shape_id for shape_id, _ in rows if shape_id > last_id]


def test_a_block_is_packed_when_its_ids_are_given(path, model, make_signature):
    with Library.open(path, model) as library:
        for seed in range(BLOCK_IDS - 1):
            library.add_signature(make_signature(seed), f"{seed}", source="a")
        with closing(sqlite3.connect(path)) as connection:
            assert not connection.execute("SELECT 1 FROM sqlite_master WHERE name = 'code_blocks'").fetchall()
        for seed in range(2 * BLOCK_IDS):
            library.add_signature(make_signature(seed), f"{seed}", source="b")
            check(library)
        assert blocks_of(path) == {0: list(range(1, 9)), 1: list(range(9, 17))}


def test_blocks_follow_removals(path, model, make_signature):
    with Library.open(path, model) as library:
        for source in "abc":
            shapes = [NewShape(make_signature(seed), f"{seed}") for seed in range(8)]
            library.replace_source(source, size=1, mtime_ns=1, sha256=None, shapes=shapes)
        library.remove_shape(3)
        assert blocks_of(path)[0] == [1, 2, 4, 5, 6, 7, 8]
        library.add_signature(make_signature(50), "4", source="a")  # replaces the fifth
        library.remove("b")
        assert blocks_of(path) == {0: [1, 2, 4, 6, 7, 8], 1: [], 2: list(range(17, 25))}
        check(library)


@pytest.mark.parametrize("filling", [1, 5])
def test_an_older_version_leaves_gaps_that_are_filled_later(path, model, make_signature, filling):
    """It removes and adds by plain SQL; only the trigger, which is in the file, knows of blocks."""
    with Library.open(path, model) as library:
        for seed in range(20):
            library.add_signature(make_signature(seed), f"{seed}", source=f"{seed // 4}")
        with closing(sqlite3.connect(path)) as old:
            old.execute("PRAGMA foreign_keys = ON")
            old.execute("DELETE FROM sources WHERE path = '1'")
            old.commit()
        assert list(blocks_of(path)) == [1]
        check(library)
        assert library.query_signature(make_signature(5), 1)[0].name != "5"
        for seed in range(20, 24):
            library.add_signature(make_signature(seed), f"{seed}")
        assert blocks_of(path) == {
            0: [1, 2, 3, 4],
            1: list(range(9, 17)),
            2: list(range(17, 25)),
        }
        check(library)


def test_a_library_of_an_older_version_gets_all_blocks_at_the_end_of_the_next(path, model, make_signature):
    with Library.open(path, model) as library:
        for seed in range(30):
            library.add_signature(make_signature(seed), f"{seed}")
        with closing(sqlite3.connect(path)) as old:
            old.execute("DROP TRIGGER code_blocks_removed")
            old.execute("DROP TABLE code_blocks")
        check(library)
        for seed in range(30, 32):
            library.add_signature(make_signature(seed), f"{seed}")
        assert list(blocks_of(path)) == [0, 1, 2, 3]
        check(library)


def test_a_change_that_fails_leaves_the_blocks_as_they_were(path, model, make_signature, monkeypatch):
    with Library.open(path, model) as library:
        for seed in range(12):
            library.add_signature(make_signature(seed), f"{seed}", source="a")
        before = blocks_of(path)

        def fail(_blocks):
            raise sqlite3.OperationalError("no")

        monkeypatch.setattr(library._store._code_blocks["codes"], "pack", fail)
        with pytest.raises(LibraryError):
            library.remove("a")
        assert blocks_of(path) == before
        assert len(library) == 12
        check(library)


def test_a_block_cut_short_is_damage(path, model, make_signature):
    with Library.open(path, model) as library:
        for seed in range(8):
            library.add_signature(make_signature(seed), f"{seed}")
        with closing(sqlite3.connect(path)) as connection:
            connection.execute("UPDATE code_blocks SET codes = substr(codes, 1, 70)")
            connection.commit()
        with pytest.raises(LibraryError, match=r"shapes\.sglib' is damaged .*code has another length"):
            library.query_signature(make_signature(1))


@settings(deadline=None, max_examples=15, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    changes=st.lists(
        st.tuples(st.sampled_from(CHANGES), st.integers(0, 6), st.booleans()),
        max_size=12,
    )
)
def test_any_changes(tmp_path_factory, model, make_signature, changes):
    """By this connection or another; a search that stays open answers as one that begins."""
    path = tmp_path_factory.mktemp("any") / "shapes.sglib"
    with Library.open(path, model) as first, Library.open(path) as second:
        for number, (change, size, by_other) in enumerate(changes):
            library = second if by_other else first
            match change:
                case "add":
                    library.add_signature(make_signature(number), "shape", source=f"{size}")
                case "replace":
                    shapes = [NewShape(make_signature(10 * number + i), f"{i}") for i in range(size)]
                    library.replace_source(f"{size % 4}", size=1, mtime_ns=1, sha256=None, shapes=shapes)
                case "remove":
                    library.remove(f"{size}")
                case _:
                    library.remove_shape(library._store.last_id() - size)
            check(first)
            with Library.open(path) as fresh:
                expected = fresh.query_signature(make_signature(number), 5)
            assert first.query_signature(make_signature(number), 5) == expected
            assert second.query_signature(make_signature(number), 5) == expected
