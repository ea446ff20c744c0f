# SPDX-License-Identifier: MIT
"""What is shown follows the library: another one, a deleted one, one that was indexed again."""

from __future__ import annotations

import errno
import importlib
import os
import shutil
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy
import pytest

from shapegoogle_core import Library
from tests.addon.shapes import lumpy


@pytest.fixture
def present(addon: ModuleType) -> Any:
    return importlib.import_module(f"{addon.__name__}.library.present")


@pytest.fixture
def state(addon: ModuleType) -> Any:
    return importlib.import_module(f"{addon.__name__}.state").current()


@pytest.fixture
def found(indexed: Path, session: Any) -> Path:
    """An answer with an example among its matches."""
    lumpy("Query", 1)
    session.collapse = False
    bpy.ops.shape_google.find_similar()
    bpy.ops.shape_google.mark_example()
    return indexed


def look(present: Any, addon: ModuleType, session: Any, preferences: Any) -> None:
    """Do what a timer does where there is a window."""
    requests = importlib.import_module("shapegoogle_core.worker.requests")
    shapes = importlib.import_module("shapegoogle_core.worker.library_state").ShownShape
    shown = [shapes(line.shape_id, line.source, line.name) for line in session.matches]
    shown += [shapes(line.shape_id, line.source, line.shape_name) for line in session.examples]
    worker = importlib.import_module(f"{addon.__name__}.jobs").worker()
    path = preferences.library_path()
    present._show(worker.submit(requests.library_state, path, shown).result())


def test_another_library_takes_its_results_along(
    found: Path, preferences: Any, session: Any, state: Any
) -> None:
    session.errors.add()
    first = preferences.library
    preferences.library = str(found.parent / "other.sglib")
    assert (len(session.matches), session.active_match, session.answer) == (0, -1, "")
    assert (session.shape_count, session.summary, len(session.errors)) == (0, "", 0)
    assert state.search.answer is None
    assert not bpy.ops.shape_google.append_match.poll()
    # The examples are for the first one, and come back with it.
    preferences.library = first
    assert bpy.ops.shape_google.clear_examples.poll()


def test_shapes_that_are_gone_are_marked_and_examples_follow_their_shape(
    found: Path, present: Any, addon: ModuleType, preferences: Any, session: Any
) -> None:
    look(present, addon, session, preferences)
    assert {match.since for match in session.matches} == {""}
    assert (session.shape_count, session.model) == (4, "default")
    before = session.examples[0].shape_id
    with Library.open(preferences.library) as library:
        pear = next(shape for shape in library.shapes() if shape.name == "Pear")
        signature = library.signature(pear.shape_id)
        library.remove(pear.source)
        library.add_signature(signature, "Pear", source=pear.source)
        apple = next(shape for shape in library.shapes() if shape.name == "Apple")
        library.remove(apple.source)
    look(present, addon, session, preferences)
    since = {match.name: match.since for match in session.matches}
    assert since["Pear"] == "Indexed again since"
    assert since["Apple"] == "No longer indexed"
    assert since["Plum"] == ""
    assert session.shape_count == 3
    assert session.examples[0].shape_id not in (before, 0)
    assert not session.examples[0].is_gone
    with Library.open(preferences.library) as library:
        library.remove(pear.source)
    look(present, addon, session, preferences)
    assert session.examples[0].is_gone


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("delete", "The library shapes.sglib is no longer there"),
        ("replace", "The library shapes.sglib was replaced by another file"),
        ("write", ""),
        ("unreachable", ""),
    ],
)
def test_what_becomes_of_the_file(
    found: Path,
    present: Any,
    preferences: Any,
    session: Any,
    state: Any,
    monkeypatch: pytest.MonkeyPatch,
    change: str,
    said: str,
) -> None:
    """One that is gone or another one empties the gallery."""
    refreshed: list[Any] = []
    monkeypatch.setattr(present, "refresh", refreshed.append)
    path, answer = preferences.library_path(), session.answer

    def look() -> None:
        for _ in range(2):
            present._look()
            if state.library.look is not None:
                state.library.look.result()

    state.library.shown, state.library.file, state.library.look = str(path), None, None
    look()
    assert session.matches
    refreshed.clear()
    session.show_sources = False
    if change == "delete":
        path.unlink()
    elif change == "replace":
        shutil.copy(path, path.with_name("other.sglib"))
        path.with_name("other.sglib").replace(path)
    elif change == "write":
        os.utime(path, ns=(0, 0))
    else:
        monkeypatch.setattr(os, "stat", raise_no_route)
    look()
    assert session.answer == (said or answer)
    assert bool(session.matches) is not bool(said)
    assert bool(refreshed) is (change != "unreachable")
    # Whoever has no library any more chooses what is indexed next.
    assert session.show_sources is (change == "delete")


def test_the_sources_are_open_where_there_is_no_library_yet(
    present: Any, preferences: Any, session: Any, state: Any
) -> None:
    path = preferences.library_path()
    assert not path.exists()
    state.library.shown, state.library.file, session.show_sources = str(path), None, False
    present._compare(bpy.context, path, present._file(path))
    assert session.show_sources
    # A user who closes them finds them closed.
    session.show_sources = False
    present._compare(bpy.context, path, present._file(path))
    assert not session.show_sources


def raise_no_route(_path: Path) -> None:
    raise OSError(errno.EHOSTUNREACH, "No route to host")


def test_a_cancelled_search_leaves_the_answer_that_is_shown(found: Path, session: Any, state: Any) -> None:
    said = session.answer
    state.search.before, session.answer, session.searching = said, "Searching for Query …", True
    assert bpy.ops.shape_google.cancel_search() == {"FINISHED"}
    assert (session.answer, session.searching) == (said, False)
