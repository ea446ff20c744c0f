# SPDX-License-Identifier: MIT
"""Everything that may lie where a library should: each gets a sentence that names it and says what to do."""

from __future__ import annotations

import os
import sqlite3
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from shapegoogle_core import LibraryError
from shapegoogle_core.errors import ModelError
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.model import ShapeModel, ShapeSignature

SignatureMaker = Callable[..., ShapeSignature]


@pytest.fixture
def filled(path: Path, model: ShapeModel, make_signature: SignatureMaker) -> Path:
    with Library.open(path, model) as library:
        shapes = [NewShape(make_signature(seed), f"shape {seed}", f"{seed}") for seed in range(50)]
        library.replace_source("a.blend", size=1, mtime_ns=1, sha256="ab", shapes=shapes)
    return path


@pytest.fixture
def unprivileged_folder() -> Iterator[Path]:
    """A folder of an ordinary user, as whom the test runs; root could write anywhere."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        was_root = hasattr(os, "geteuid") and os.geteuid() == 0
        if was_root and not hasattr(os, "setresuid"):
            pytest.skip("root may write anywhere, and cannot become another user for a while here")
        if was_root:
            nobody = 65534
            os.chown(folder, nobody, nobody)
            os.setresgid(nobody, nobody, 0)
            os.setresuid(nobody, nobody, 0)
        try:
            yield folder
        finally:
            folder.chmod(0o700)
            if was_root:
                os.setresuid(0, 0, 0)
                os.setresgid(0, 0, 0)


posix = pytest.mark.skipif(os.name == "nt", reason="permissions of folders work differently on Windows")


def change(path: Path, *statements: str) -> None:
    connection = sqlite3.connect(path)
    with connection:
        for statement in statements:
            connection.execute(statement)
    connection.close()


def test_a_folder(tmp_path: Path, model: ShapeModel) -> None:
    with pytest.raises(LibraryError, match=f"'{tmp_path}' is a folder; .*name a file"):
        Library.open(tmp_path, model)


@pytest.mark.parametrize("read_only", [False, True])
def test_no_such_folder(tmp_path: Path, model: ShapeModel, read_only: bool) -> None:
    path = tmp_path / "typo" / "shapes.sglib"
    match = "there is no library" if read_only else "there is no folder '.*typo'; create it first"
    with pytest.raises(LibraryError, match=match):
        Library.open(path, model, read_only=read_only)
    assert not path.parent.exists()


def test_nothing_to_read(path: Path, model: ShapeModel) -> None:
    with pytest.raises(LibraryError, match=r"there is no library '.*shapes\.sglib'; check the name"):
        Library.open(path, model, read_only=True)
    assert not path.exists()


def test_below_a_file_and_impossible_names(path: Path, model: ShapeModel) -> None:
    path.touch()
    with pytest.raises(LibraryError, match="there is no folder"):
        Library.open(path / "inside.sglib", model)
    with pytest.raises(LibraryError, match="cannot be reached"):
        Library.open(path.parent / ("x" * 5_000), model)
    with pytest.raises(LibraryError, match="has a null character in its name"):
        Library.open(f"{path}\0", model)
    assert [entry.name for entry in path.parent.iterdir()] == [path.name]


@pytest.mark.parametrize("read_only", [False, True])
@pytest.mark.parametrize("content", [b"solid cube\nfacet normal 0 0 1\n" * 100, b"mesh", b"SQLite format 3"])
def test_no_database(path: Path, model: ShapeModel, content: bytes, read_only: bool) -> None:
    path.write_bytes(content)
    with pytest.raises(LibraryError, match=r"shapes\.sglib' is not a Shape Google library"):
        Library.open(path, model, read_only=read_only)
    assert path.read_bytes() == content


@pytest.mark.parametrize("read_only", [False, True])
def test_database_of_another_program(path: Path, model: ShapeModel, read_only: bool) -> None:
    change(path, "CREATE TABLE moz_places (url)", "INSERT INTO moz_places VALUES ('somewhere')")
    before = path.read_bytes()
    with pytest.raises(LibraryError, match="an SQLite database of another program"):
        Library.open(path, model, read_only=read_only)
    assert path.read_bytes() == before


def test_an_empty_file_becomes_a_library_but_is_none_to_read(path: Path, model: ShapeModel) -> None:
    path.touch()
    with pytest.raises(LibraryError, match="is empty; index a folder into it first"):
        Library.open(path, model, read_only=True)
    with Library.open(path, model) as library:
        assert len(library) == 0


@pytest.mark.parametrize(("version", "made_by"), [(1, "an older"), (6, "an older"), (9, "a newer")])
def test_another_format(filled: Path, model: ShapeModel, version: int, made_by: str) -> None:
    change(filled, f"UPDATE meta SET value = '{version}' WHERE key = 'schema'")
    before = filled.read_bytes()
    for read_only in (False, True):
        with pytest.raises(
            LibraryError,
            match=rf"{made_by} version of .* \(format {version}; .* 7 and 8\); .*index your folders",
        ):
            Library.open(filled, model, read_only=read_only)
    assert filled.read_bytes() == before


@pytest.mark.parametrize("value", ["", "one", "-1"])
def test_unreadable_schema(filled: Path, model: ShapeModel, value: object) -> None:
    change(filled, f"UPDATE meta SET value = '{value}' WHERE key = 'schema'")
    with pytest.raises(LibraryError, match=r"is damaged .*which format"):
        Library.open(filled, model)


def test_another_model(filled: Path, model: ShapeModel, other_model: ShapeModel) -> None:
    match = (
        f"made with model {model.identifier}, not with {other_model.identifier}"
        ".*leave the model out.*new library"
    )
    with pytest.raises(LibraryError, match=match):
        Library.open(filled, other_model)
    with Library.open(filled, ShapeModel.from_bytes(model.to_bytes())) as library:
        assert len(library) == 50


def test_a_damaged_model(filled: Path) -> None:
    change(filled, "UPDATE model SET content = substr(content, 1, 200)")
    with pytest.raises(LibraryError, match=r"the model in '.*shapes\.sglib'"):
        Library.open(filled)


def test_a_model_that_is_not_the_one_it_says(filled: Path) -> None:
    change(filled, "UPDATE model SET identifier = '0123456789abcdef'")
    with pytest.raises(LibraryError, match="0123456789abcdef"):
        Library.open(filled)


@pytest.mark.parametrize("count", [0, 2])
def test_not_one_model(filled: Path, model: ShapeModel, count: int) -> None:
    change(filled, "DELETE FROM model", *["INSERT INTO model VALUES ('a', x'')"] * count)
    with pytest.raises(LibraryError, match=rf"is damaged .*{count} models"):
        Library.open(filled)


@pytest.mark.parametrize("part", [0.02, 0.3, 0.9, 0.999])
def test_cut_short(filled: Path, part: float) -> None:
    """Whatever is left of it, the error is a sentence, at the latest when the shapes are read."""
    content = filled.read_bytes()
    filled.write_bytes(content[: int(part * len(content))])
    with pytest.raises(LibraryError, match=r"shapes\.sglib' is (damaged or was cut short|not a Shape)"):
        Library.open(filled)


def test_overwritten_in_the_middle(filled: Path, make_signature: SignatureMaker) -> None:
    """Random bytes over every page but the first: any method may fail, but only with a LibraryError."""
    content = bytearray(filled.read_bytes())
    for page in range(4096, len(content), 4096):
        content[page : page + 64] = bytes(range(64))
    filled.write_bytes(content)
    with pytest.raises(LibraryError, match="is damaged"):
        Library.open(filled)


@pytest.mark.parametrize(
    "statement",
    ["UPDATE codes SET code = substr(code, 2)", "UPDATE bags SET halves = x'00'"],
)
def test_rows_of_the_wrong_length(filled: Path, make_signature: SignatureMaker, statement: str) -> None:
    change(filled, statement)
    with Library.open(filled) as library:
        with pytest.raises(LibraryError, match=r"is damaged .*another length than its model's"):
            library.query(make_signature(1), explain=0)
        with pytest.raises(LibraryError, match="is damaged"):
            library.signature(1)


def test_names_that_are_no_text_and_tables_that_are_gone(filled: Path) -> None:
    change(filled, "UPDATE shapes SET name = CAST(x'ff41' AS TEXT)")
    with (
        Library.open(filled) as library,
        pytest.raises(LibraryError, match=r"is damaged .*not valid text"),
    ):
        list(library.shapes())
    change(filled, "DROP TABLE codes")
    with (
        Library.open(filled) as library,
        pytest.raises(LibraryError, match=r"is damaged .*contradict each other"),
    ):
        len(library)


def test_a_shape_without_its_signature(filled: Path) -> None:
    change(filled, "DELETE FROM bags WHERE shape_id = 3")
    with (
        Library.open(filled) as library,
        pytest.raises(LibraryError, match=r"shape 3 .* index 'a\.blend' again"),
    ):
        library.signature(3)


def test_no_model_given_and_none_shipped_leaves_no_file(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_model(_: object) -> ShapeModel:
        return ShapeModel.from_bytes(b"", "the shipped model")

    monkeypatch.setattr("shapegoogle_core.library.storage.opening.as_model", no_model)
    with pytest.raises(ModelError, match="the shipped model"):
        Library.open(path)
    assert not path.exists()


def test_read_only_refuses_every_change(filled: Path, make_signature: SignatureMaker) -> None:
    before = filled.read_bytes()
    with Library.open(filled, read_only=True) as library:
        assert library.read_only
        for change_it in (
            lambda: library.add_signature(make_signature(1), "new"),
            lambda: library.replace_source("a.blend", size=1, mtime_ns=1, sha256=None),
            lambda: library.update_source("a.blend", size=1, mtime_ns=1),
            lambda: library.remove("a.blend"),
            lambda: library.remove_shape(1),
        ):
            with pytest.raises(LibraryError, match="was opened with read_only=True; open it without"):
                change_it()
        assert len(library) == 50
    assert filled.read_bytes() == before


@posix
@pytest.mark.parametrize("read_only", [False, True])
def test_write_protected_files_are_searched(
    unprivileged_folder: Path, model: ShapeModel, make_signature: SignatureMaker, read_only: bool
) -> None:
    path = unprivileged_folder / "shapes.sglib"
    with Library.open(path, model) as library:
        library.add_signature(make_signature(1), "one")
    path.chmod(0o444)
    unprivileged_folder.chmod(0o555)
    with Library.open(path, read_only=read_only) as library:
        assert library.read_only
        assert library.query(make_signature(1), explain=0)[0].name == "one"
        with pytest.raises(LibraryError, match="is read-only"):
            library.add_signature(make_signature(2), "two")


@posix
def test_a_file_that_can_be_written_in_a_folder_that_cannot(
    unprivileged_folder: Path, model: ShapeModel, make_signature: SignatureMaker
) -> None:
    path = unprivileged_folder / "shapes.sglib"
    with Library.open(path, model) as library:
        library.add_signature(make_signature(1), "one")
    unprivileged_folder.chmod(0o555)
    with Library.open(path) as library:
        assert library.query(make_signature(1), explain=0)[0].name == "one"
        with pytest.raises(LibraryError, match="or its folder is read-only"):
            library.add_signature(make_signature(2), "two")
        assert len(library) == 1


@posix
def test_nothing_can_be_made_in_a_read_only_folder(unprivileged_folder: Path, model: ShapeModel) -> None:
    unprivileged_folder.chmod(0o555)
    with pytest.raises(LibraryError, match=r"shapes\.sglib' cannot be created: its folder is read-only"):
        Library.open(unprivileged_folder / "shapes.sglib", model)


@posix
def test_files_and_folders_that_may_not_be_read(unprivileged_folder: Path, model: ShapeModel) -> None:
    path = unprivileged_folder / "shapes.sglib"
    with Library.open(path, model):
        pass
    path.chmod(0)
    with pytest.raises(LibraryError, match="you may not read the file"):
        Library.open(path)
    unprivileged_folder.chmod(0)
    with pytest.raises(LibraryError, match=r"shapes\.sglib' cannot be reached: .*ermission"):
        Library.open(path)


def test_closed(filled: Path, make_signature: SignatureMaker) -> None:
    library = Library.open(filled)
    library.close()
    library.close()
    for use in (
        lambda: len(library),
        lambda: list(library.shapes()),
        lambda: library.query(make_signature(1), explain=0),
        lambda: library.query(make_signature(1), exact=True, explain=0),
        lambda: library.add_signature(make_signature(1), "new"),
        library.info,
        library.sources,
    ):
        with pytest.raises(LibraryError, match="was closed; open it again"):
            use()


def test_a_model_may_be_given_by_its_name(path: Path) -> None:
    with pytest.raises(ModelError, match="cannot read the model 'none'"):
        Library.open(path, "none")
    assert not path.exists()
    with Library.open(path, "default") as library:
        assert library.model.name == "default"
    with Library.open(path, model="default") as library:
        assert len(library) == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"path": None}, "a path must be a str or a pathlib.Path, not None"),
        ({"timeout": "a"}, "timeout must be a number ≥ 0, not 'a'"),
        ({"search": 5}, "search must be a SearchSettings, not 5"),
    ],
)
def test_arguments_of_wrong_types_are_named(path: Path, arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Library.open(**{"path": path, **arguments})
    assert not path.exists()


def test_the_home_folder(tmp_path: Path, model: ShapeModel, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("USERPROFILE", str(tmp_path))
    with Library.open("~/shapes.sglib", model) as library:
        assert library.path == tmp_path / "shapes.sglib"
