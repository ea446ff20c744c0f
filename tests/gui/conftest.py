# SPDX-License-Identifier: MIT
"""A Blender with a window for all tests of this folder, and the library that they search."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import trimesh

from benchmarks.creatures import make_creature
from tests.gui.window import LIMIT, ROOT, SIZE, Window, screen

HERE = Path(__file__).parent
TOOLS = ("Xvfb", "xdotool", "import")
NAME = "Rearing Horse"
CREATURES = {
    "horse": ("rest", "walk", "gallop"),
    "dog": ("rest", "sit"),
    "human": ("stand", "walk"),
    "octopus": ("sprawl",),
    "bird": ("glide",),
}
SHAPES = sum(map(len, CREATURES.values()))
VERTICES = 2000
QUERY = ("horse", "rear", 2600)


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder for everything."""
    return tmp_path_factory.mktemp("window")


@pytest.fixture(scope="session")
def query(folder: Path) -> Path:
    """A horse in a pose that is in no file."""
    kind, pose, vertices = QUERY
    return write_ply(folder / "query.ply", make_creature(kind, 2011, vertex_count=vertices).pose(pose))


@pytest.fixture(scope="session")
def shapes(folder: Path) -> Path:
    """The folder to index; `prepare.py` writes what is good in it, here is a file that is none."""
    place = folder / "shapes"
    place.mkdir()
    (place / "unicorn.blend").write_bytes(b"There are no unicorns.")
    return place


def write_ply(path: Path, mesh: Any) -> Path:
    trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).export(path)
    return path


def blend_files(folder: Path) -> Iterator[str]:
    """Write the meshes of the library, and say which belong into one file."""
    for kind, poses in CREATURES.items():
        creature = make_creature(kind, 2011, vertex_count=VERTICES)
        paths = [folder / f"{kind} {pose}.ply".title().replace(".Ply", ".ply") for pose in poses]
        for path, pose in zip(paths, poses, strict=True):
            write_ply(path, creature.pose(pose))
        yield "|".join([kind, *map(str, paths)])


@pytest.fixture(scope="session")
def user_folder(folder: Path, shapes: Any) -> Path:
    """A user folder of Blender with the built extension, which knows the folder to index."""
    extension = os.environ.get("SHAPEGOOGLE_EXTENSION")
    missing = [tool for tool in TOOLS if not shutil.which(tool)]
    if not extension or not os.environ.get("BLENDER"):
        pytest.skip("SHAPEGOOGLE_EXTENSION or BLENDER is not set; run scripts/test.py tests/gui")
    if missing:
        pytest.skip(f"not installed: {', '.join(missing)}; Debian: apt install xvfb xdotool imagemagick")
    user = folder / "user"
    modules = user / "scripts" / "modules"
    modules.mkdir(parents=True)
    # As people must give numpy to a Blender that has none.
    for package in Path(os.environ["SHAPEGOOGLE_BLENDER_MODULES"]).glob("numpy*"):
        (modules / package.name).symlink_to(package)
    arguments = [extension, folder / "shapes.sglib", shapes, *blend_files(folder)]
    command = [os.environ["BLENDER"], "--background", "--python-exit-code", "1"]
    result = subprocess.run(
        [*command, "--python", HERE / "prepare.py", "--", *arguments],
        cwd=ROOT,
        env={**os.environ, "BLENDER_USER_RESOURCES": str(user)},
        capture_output=True,
        text=True,
        errors="replace",
        timeout=5 * LIMIT,
        check=False,
    )
    assert result.returncode == 0, result.stdout + result.stderr
    return user


@pytest.fixture(scope="session")
def window(folder: Path, user_folder: Any) -> Iterator[Window]:
    """Blender's window, with the add-on's tab of the sidebar open."""
    requests = folder / "requests"
    requests.mkdir()
    with screen(folder / "xvfb.log") as display, (folder / "blender.log").open("wb") as log:
        variables = {"DISPLAY": display, "BLENDER_USER_RESOURCES": str(user_folder)}
        size = ("--window-geometry", "0", "0", *map(str, SIZE))
        process = subprocess.Popen(
            [os.environ["BLENDER"], *size, "--python", HERE / "driver.py", "--", requests],
            cwd=ROOT,
            env={**os.environ, **variables, "LIBGL_ALWAYS_SOFTWARE": "1"},
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            window = Window(process, display, requests)
            window.ask("show_sidebar")
            window.wait(lambda state: window.ask("show_tab"), "the tab of the add-on in the sidebar")
            window.picture()
            yield window
            window.ask("quit_blender")
            process.wait(LIMIT)
        finally:
            if process.poll() is None:
                os.killpg(process.pid, 9)
                process.wait()


@pytest.fixture(scope="session")
def indexed(window: Window, query: Path) -> dict[str, Any]:
    """The library, indexed by a click; what was seen meanwhile."""
    window.clean_scene(query, NAME)
    window.open("Library")
    _, y = window.press("shape_google.index_library")
    left, _, right, _ = window.ask("regions")["ui"]
    button = left, round(y) - 8, right, round(y) + 8
    window.wait(lambda state: state["session"]["indexing"], "indexing begun")
    # Meanwhile the window is as usable as ever: turn the view.
    direction = window.ask("view_direction")
    left, top, right, bottom = window.ask("regions")["window"]

    def is_turned() -> Any:
        return window.ask("view_direction") != direction

    for _ in range(4):  # a slow Blender may miss one
        window.drag(left + 0.3 * (right - left), (top + bottom) / 2, 60, 0, button=2)
        window.settle()
        if is_turned():
            break
    window.wait(lambda _: is_turned(), "the view turned")
    turned = window.ask("state")["session"]["indexing"]
    window.rest()
    window.settle()
    window.ask("count_draws")
    seen: dict[int, str] = {}
    bar = None

    def ended(state: Any) -> Any:
        nonlocal bar
        session = state["session"]
        if session["indexing"] and session["done"]:
            seen[session["done"]] = session["progress"]
            bar = bar or window.photograph(button)
        return not session["indexing"]

    state = window.wait(ended, "the end of indexing")
    draws = window.ask("count_draws")
    return {"state": state, "draws": draws, "seen": seen, "turned": turned, "bar": bar} | {
        "button": window.picture(button)
    }


@pytest.fixture
def found(window: Window, indexed: Any, query: Path) -> dict[str, Any]:
    """The answer to a click on Find Similar, in a scene with nothing but the query."""
    window.clean_scene(query, NAME)
    window.open("Search")
    window.run(
        "session = bpy.context.window_manager.shape_google\nsession.collapse = False\nsession.matches.clear()"
    )
    window.press("shape_google.find_similar")
    return window.wait_for_kinds()
