# SPDX-License-Identifier: MIT
"""Packed codes say what the rows of codes say, whoever changed the library."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.library.storage.sqlite.codes import CodeBlocks
from shapegoogle_core.library.storage.sqlite.store import SqliteStore
from shapegoogle_core.library.storage.store import all_codes
from shapegoogle_core.model import ShapeModel, ShapeSignature

BLOCK_IDS = 8
CHANGES = ["add", "replace", "remove", "remove shape"]

SignatureMaker = Callable[..., ShapeSignature]


class SmallBlocks(SqliteStore):
    """A store with small blocks."""

    block_ids = BLOCK_IDS
    rows_at_once = 5


def open_store(path: Path, model: ShapeModel) -> SqliteStore:
    store = SmallBlocks(path, create=True, read_only=False, timeout=30)
    if store.is_empty():
        store.initialise(model)
    return store


def open_library(path: Path, model: ShapeModel) -> Library:
    return Library(open_store(path, model), model)


def blocks_of(path: Path) -> dict[int, list[int]]:
    """Ids in each block."""
    with closing(sqlite3.connect(path)) as connection:
        return {
            block: (block * BLOCK_IDS + 1 + np.frombuffer(offsets, "<u2").astype(int)).tolist()
            for block, offsets in connection.execute("SELECT block, offsets FROM code_blocks")
        }


def check(path: Path, model: ShapeModel) -> None:
    """Read all codes, and those after each id, and compare them with the rows."""
    with closing(sqlite3.connect(path)) as connection:
        rows = connection.execute("SELECT shape_id, code FROM codes ORDER BY shape_id").fetchall()
    with closing(open_store(path, model)) as store:
        shape_ids, codes = all_codes(store, "codes", 9)
        assert list(zip(shape_ids.tolist(), [code.tobytes() for code in codes], strict=True)) == rows
        for last_id in range(0, max((shape_id for shape_id, _ in rows), default=0) + 2, 3):
            check_pages(store, last_id, [shape_id for shape_id, _ in rows if shape_id > last_id])


def check_pages(store: SqliteStore, last_id: int, expected: list[int]) -> None:
    with store.snapshot():
        pages = list(store.code_pages("codes", last_id, 9))
    assert [shape_id for ids, _ in pages for shape_id in ids.tolist()] == expected


def test_a_block_is_packed_when_its_ids_are_given(
    path: Path, model: ShapeModel, make_signature: SignatureMaker
) -> None:
    with open_library(path, model) as library:
        for seed in range(BLOCK_IDS - 1):
            library.add_signature(make_signature(seed), f"{seed}", source="a")
        assert blocks_of(path) == {}
        for seed in range(2 * BLOCK_IDS):
            library.add_signature(make_signature(seed), f"{seed}", source="b")
            check(path, model)
        assert blocks_of(path) == {0: list(range(1, 9)), 1: list(range(9, 17))}


def test_blocks_follow_removals(path: Path, model: ShapeModel, make_signature: SignatureMaker) -> None:
    with open_library(path, model) as library:
        for source in "abc":
            shapes = [NewShape(make_signature(seed), f"{seed}") for seed in range(8)]
            library.replace_source(source, size=1, mtime_ns=1, sha256=None, shapes=shapes)
        library.remove_shape(3)
        assert blocks_of(path)[0] == [1, 2, 4, 5, 6, 7, 8]
        library.add_signature(make_signature(50), "4", source="a")  # replaces the fifth
        library.remove("b")
        assert blocks_of(path) == {0: [1, 2, 4, 6, 7, 8], 1: [], 2: list(range(17, 25))}
        check(path, model)


@pytest.mark.parametrize("filling", [1, 5])
def test_another_program_leaves_gaps_that_are_filled_later(
    path: Path, model: ShapeModel, make_signature: SignatureMaker, filling: int
) -> None:
    """It removes and adds by plain SQL; only the trigger, which is in the file, knows of blocks."""
    with open_library(path, model) as library:
        for seed in range(20):
            library.add_signature(make_signature(seed), f"{seed}", source=f"{seed // 4}")
        with closing(sqlite3.connect(path)) as old:
            old.execute("PRAGMA foreign_keys = ON")
            old.execute("DELETE FROM sources WHERE path = '1'")
            old.commit()
        assert list(blocks_of(path)) == [1]
        check(path, model)
        assert library.query(make_signature(5), top=1, explain=0)[0].name != "5"
        for seed in range(20, 24):
            library.add_signature(make_signature(seed), f"{seed}")
        assert blocks_of(path) == {
            0: [1, 2, 3, 4],
            1: list(range(9, 17)),
            2: list(range(17, 25)),
        }
        check(path, model)


def test_a_library_that_lost_its_blocks_gets_them_all_at_the_end_of_the_next(
    path: Path, model: ShapeModel, make_signature: SignatureMaker
) -> None:
    with open_library(path, model) as library:
        for seed in range(30):
            library.add_signature(make_signature(seed), f"{seed}")
        with closing(sqlite3.connect(path)) as old:
            old.execute("DELETE FROM code_blocks")
            old.commit()
        check(path, model)
        for seed in range(30, 32):
            library.add_signature(make_signature(seed), f"{seed}")
        assert list(blocks_of(path)) == [0, 1, 2, 3]
        check(path, model)


def test_a_change_that_fails_leaves_the_blocks_as_they_were(
    path: Path, model: ShapeModel, make_signature: SignatureMaker, monkeypatch: pytest.MonkeyPatch
) -> None:
    with open_library(path, model) as library:
        for seed in range(12):
            library.add_signature(make_signature(seed), f"{seed}", source="a")
        before = blocks_of(path)

        def fail(_self: CodeBlocks, _blocks: object) -> None:
            raise sqlite3.OperationalError("no")

        monkeypatch.setattr(CodeBlocks, "pack", fail)
        with pytest.raises(LibraryError):
            library.remove("a")
        assert blocks_of(path) == before
        assert len(library) == 12
        check(path, model)


def test_a_block_cut_short_is_damage(path: Path, model: ShapeModel, make_signature: SignatureMaker) -> None:
    with open_library(path, model) as library:
        for seed in range(8):
            library.add_signature(make_signature(seed), f"{seed}")
        with closing(sqlite3.connect(path)) as connection:
            connection.execute("UPDATE code_blocks SET codes = substr(codes, 1, 70)")
            connection.commit()
        with pytest.raises(LibraryError, match=r"shapes\.sglib' is damaged .*code has another length"):
            library.query(make_signature(1), explain=0)


@settings(deadline=None, max_examples=15, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    changes=st.lists(
        st.tuples(st.sampled_from(CHANGES), st.integers(0, 6), st.booleans()),
        max_size=12,
    )
)
def test_any_changes(
    tmp_path_factory: pytest.TempPathFactory,
    model: ShapeModel,
    make_signature: SignatureMaker,
    changes: list[tuple[str, int, bool]],
) -> None:
    """By this connection or another; a search that stays open answers as one that begins."""
    path = tmp_path_factory.mktemp("any") / "shapes.sglib"
    with open_library(path, model) as first, open_library(path, model) as second:
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
                    library.remove_shape(
                        max((shape.shape_id for shape in library.shapes()), default=0) - size
                    )
            check(path, model)
            with open_library(path, model) as fresh:
                expected = fresh.query(make_signature(number), top=5, explain=0)
            assert first.query(make_signature(number), top=5, explain=0) == expected
            assert second.query(make_signature(number), top=5, explain=0) == expected
