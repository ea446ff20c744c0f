# SPDX-License-Identifier: MIT
"""What the panels show while work runs in the background, and when the user acts before it has ended.

Blender without a window calls no timers, and operators wait for the end: the tests press buttons and call the
timers themselves.
"""

from __future__ import annotations

import importlib
import re
import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import FunctionType, MethodType, ModuleType, SimpleNamespace
from typing import Any

import bpy
import pytest

from shapegoogle_core import Library
from tests.addon.shapes import add_folder, lumpy

# Seconds after which a background process is believed to hang.
LIMIT = 120


class Timers:
    """Calls the functions that the add-on has registered, as Blender's window does."""

    def __init__(self) -> None:
        self._functions: list[Callable[[], float | None]] = []

    def register(self, function: Callable[[], float | None], **_options: Any) -> None:
        self._functions.append(function)

    def tick(self) -> None:
        """Call each function once."""
        for function in list(self._functions):
            if function() is None:
                self._functions.remove(function)

    def until(self, condition: Callable[[], Any]) -> None:
        """Call them again and again until a condition holds."""
        end = time.monotonic() + LIMIT
        while not condition():
            assert time.monotonic() < end
            self.tick()
            time.sleep(0.02)


@pytest.fixture
def timers(addon: ModuleType, monkeypatch: pytest.MonkeyPatch) -> Timers:
    timers = Timers()
    monkeypatch.setattr(bpy.app.timers, "register", timers.register)
    return timers


def module(addon: ModuleType, name: str) -> Any:
    return importlib.import_module(f"{addon.__name__}.{name}")


@pytest.fixture
def library(addon: ModuleType) -> Any:
    """State of the library, looked at as it is where there is a window."""
    state = module(addon, "state").current().library
    state.followed = True
    yield state
    state.followed, state.shown, state.file, state.look = False, None, None, None


@pytest.fixture
def meshes(blender: Any, tmp_path: Path) -> Path:
    """A folder of mesh files, which need no other Blender, one of them broken."""
    folder = tmp_path / "meshes"
    folder.mkdir()
    for seed in range(8):
        item = lumpy(f"Shape {seed}", seed, subdivisions=2)
        bpy.ops.wm.obj_export(filepath=str(folder / f"{seed}.obj"))
        bpy.data.objects.remove(item)
    (folder / "9.obj").write_text("no mesh")
    return folder


def press(addon: ModuleType, name: str, **options: Any) -> None:
    """Press the button of an operator, such as "library.index.SHAPEGOOGLE_OT_index_library"."""
    place, _, operator = name.rpartition(".")
    pressed = SimpleNamespace(report=print, **options)
    for kind in reversed(getattr(module(addon, place), operator).__mro__):
        for key, value in vars(kind).items():
            if isinstance(value, FunctionType) and not hasattr(object, key):
                setattr(pressed, key, MethodType(value, pressed))
    assert pressed.invoke(bpy.context, None) == {"FINISHED"}


def index(addon: ModuleType) -> None:
    press(addon, "library.index.SHAPEGOOGLE_OT_index_library", reread=False, retry=False)


def shapes_in(path: Path) -> int:
    with Library.open(path, read_only=True) as library:
        return len(library)


def test_a_cancelled_run_leaves_a_right_count(
    addon: ModuleType, meshes: Path, preferences: Any, session: Any, timers: Timers
) -> None:
    """What was stored before is counted, and the summary says how far it came."""
    module(addon, "jobs").worker()  # as in a window, where somebody looks at the count
    add_folder(preferences, meshes)
    index(addon)
    timers.until(lambda: session.done > 1)
    done = session.done
    assert session.progress.startswith(f"{done} of 9 files, ")
    assert bpy.ops.shape_google.cancel_indexing() == {"FINISHED"}
    assert (session.indexing, session.progress) == (False, "")
    assert session.summary == f"Cancelled after {done} of 9 files"
    timers.until(lambda: session.shape_count == shapes_in(preferences.library_path()))


def test_a_scene_is_counted_in_shapes_and_a_cancelled_one_is_not_stored(
    addon: ModuleType, preferences: Any, session: Any, timers: Timers
) -> None:
    for seed in range(3):
        item = lumpy(f"Shape {seed}", seed, subdivisions=3)
        bpy.context.collection.objects.link(bpy.data.objects.new(f"Copy {seed}", item.data))
    preferences.use_scene = True
    index(addon)
    timers.until(lambda: session.progress.startswith("1 shape"))
    bpy.ops.shape_google.cancel_indexing()
    assert session.summary == "Cancelled; nothing of this scene was stored"
    index(addon)
    said: dict[str, None] = {}

    def ended() -> bool:
        said[session.progress] = None
        return not session.indexing

    timers.until(ended)
    # Neither files are counted, nor objects that share a mesh.
    counts = [text for text in said if "shape" in text]
    assert counts
    assert all(
        re.fullmatch(r"[123] shapes?, estimating the time left|[123] of (about )?3 shapes, .*", text)
        for text in counts
    )
    assert session.summary == "3 shapes of this scene"


def test_a_run_that_ends_after_another_library_was_chosen(
    addon: ModuleType, meshes: Path, preferences: Any, session: Any, timers: Timers, tmp_path: Path
) -> None:
    """What is shown is about the library chosen now, and the summary names the other one."""
    first = preferences.library_path()
    add_folder(preferences, meshes)
    index(addon)
    preferences.library = str(tmp_path / "other.sglib")
    timers.until(lambda: not session.indexing)
    timers.tick()
    assert session.shape_count == 0
    assert session.summary == "shapes.sglib: 8 shapes added from 8 files, 1 input failed"
    preferences.library = str(first)
    assert session.summary == ""


def test_answers_that_come_after_another_library_was_chosen(
    addon: ModuleType, meshes: Path, preferences: Any, session: Any, timers: Timers, tmp_path: Path
) -> None:
    """Neither matches, nor versions of a match, nor evidence arrive."""
    first = preferences.library
    add_folder(preferences, meshes)
    bpy.ops.shape_google.index_library()
    (meshes / "0.obj").rename(meshes / "8.obj")
    bpy.ops.shape_google.index_library()
    lumpy("Query", 0, subdivisions=2)
    requests = importlib.import_module("shapegoogle_core.worker.requests")

    def choose_another_and_wait() -> None:
        preferences.library = str(tmp_path / "other.sglib")
        # The worker process does one task after the other, so it has done those before this one.
        last = module(addon, "jobs").worker().submit(requests.library_state, Path(first), [])
        timers.until(last.done)
        timers.tick()
        assert (len(session.matches), len(session.versions), session.opened) == (0, 0, -1)
        assert (session.answer, session.searching) == ("", False)
        preferences.library = first

    press(addon, "search.operators.SHAPEGOOGLE_OT_find_similar")
    choose_another_and_wait()
    press(addon, "search.operators.SHAPEGOOGLE_OT_find_similar")
    timers.until(lambda: session.matches)
    copied = next(place for place, match in enumerate(session.matches) if match.version_count)
    press(addon, "search.versions.SHAPEGOOGLE_OT_show_versions", index=copied)
    choose_another_and_wait()


def test_a_drive_that_does_not_answer_does_not_block_the_window(
    addon: ModuleType,
    preferences: Any,
    session: Any,
    library: Any,
    timers: Timers,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    present = module(addon, "library.present")
    answers = threading.Event()

    def slow(path: Path) -> Any:
        assert answers.wait(LIMIT)
        return found(path)

    found = present._file
    monkeypatch.setattr(present, "_file", slow)
    monkeypatch.setattr(Path, "is_file", lambda path: pytest.fail(f"looks for {path} on the main thread"))
    library.shown = preferences.library_path()
    for _ in range(3):
        assert present._look() is not None
    lumpy("Query", 1)
    # Nobody knows yet that there is no library.
    assert bpy.ops.shape_google.find_similar.poll()
    answers.set()
    timers.register(present._look)
    timers.until(lambda: library.file is not None)
    assert library.file == ()
    assert not bpy.ops.shape_google.find_similar.poll()
    assert not bpy.ops.shape_google.move_sources.poll()


def test_training_says_how_far_it_is_until_it_is_cancelled(
    addon: ModuleType, meshes: Path, session: Any, timers: Timers, tmp_path: Path
) -> None:
    """The operator waits for the end where there is no window, so its run is started here."""
    train, jobs = module(addon, "library.train"), module(addon, "jobs")
    library = module(addon, "state").current().library
    path = tmp_path / "mine.npz"
    run = library.training = jobs.BackgroundRun(["train", str(meshes), "--output", str(path)])
    session.training = "Training …"
    timers.register(lambda: train._look(run, path))
    timers.until(lambda: session.training != "Training …")
    assert session.training.startswith("Reading: ")
    assert bpy.ops.shape_google.cancel_training() == {"FINISHED"}
    assert (session.training, session.trained) == ("", "Training cancelled")
    assert not path.exists()
    assert not bpy.ops.shape_google.cancel_training.poll()
