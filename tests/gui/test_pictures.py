# SPDX-License-Identifier: MIT
"""The pictures of the sidebar in the README, made anew where they are asked for.

    python3 scripts/demo.py
    SHAPEGOOGLE_SCREENSHOTS=docs/images python3 scripts/test.py tests/gui/test_pictures.py

They show the demo's library of creatures. Look at them before you keep them.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from benchmarks.creatures import make_creature
from tests.gui.conftest import write_ply
from tests.gui.window import FIRST, ROOT, SIZE

TARGET = os.environ.get("SHAPEGOOGLE_SCREENSHOTS")
BLENDS = ROOT / "demo" / "blend_library"
NAME = "Rearing Horse"
LARGEST_FILE = 250_000

pytestmark = pytest.mark.skipif(not TARGET, reason="SHAPEGOOGLE_SCREENSHOTS names no folder for pictures")


@pytest.fixture(scope="module")
def horse(folder: Path) -> Path:
    """The query of the demo, at the size of the horses in the library."""
    return write_ply(folder / "horse.ply", make_creature("horse", 2011, vertex_count=10_000).pose("rear"))


@pytest.fixture(scope="module")
def library(window: Any, folder: Path, horse: Any) -> Iterator[None]:
    """A library of the demo's .blend files, indexed while it is photographed."""
    if not BLENDS.is_dir():
        pytest.skip("there is no demo/blend_library; run python3 scripts/demo.py first")
    window.clean_scene(horse, NAME)
    before = window.run(
        "folder = preferences.folders[0]\n"
        "result = [preferences.library, preferences.jobs, folder.name, folder.path]"
    )
    window.run(
        f"preferences.library = {str(folder / 'creatures.sglib')!r}; preferences.jobs = 0\n"
        f"preferences.folders[0].name = 'creatures'; preferences.folders[0].path = {str(BLENDS)!r}\n"
        # Where the files lie on this machine is nobody's concern.
        "preferences.active_folder = -1"
    )
    window.open("Library")
    window.press("shape_google.index_library")
    window.rest()
    window.wait(
        lambda state: state["session"]["done"] > 5 or not state["session"]["indexing"], "half of the files"
    )
    save(window.photograph(), "library")
    state = window.wait(lambda state: not state["session"]["indexing"], "all files")
    assert not state["errors"]
    yield
    # For the tests after these.
    window.run(
        "(preferences.library, preferences.jobs, preferences.folders[0].name, preferences.folders[0].path) = "
        f"{before!r}"
    )


def save(image: Image.Image, name: str) -> None:
    """Write a picture, with as many colours as the size of the file allows."""
    path = ROOT / (TARGET or "") / f"{name}.png"
    path.parent.mkdir(parents=True, exist_ok=True)
    image.save(path, optimize=True)
    if path.stat().st_size > LARGEST_FILE:
        image.quantize(256, dither=Image.Dither.NONE).save(path, optimize=True)
    assert path.stat().st_size <= LARGEST_FILE


def test_search_and_words(window: Any, library: Any, horse: Any) -> None:
    window.clean_scene(horse, NAME)
    window.open("Search")
    window.press("shape_google.find_similar")
    window.wait_for_kinds()
    window.press("shape_google.choose_match", columns=(0.75,))
    window.press("shape_google.mark_match")
    window.wait(lambda state: "sg_word" in state["objects"][NAME]["attributes"], "words")
    window.run(
        "[item.hide_set(True) for item in bpy.data.objects if item.type == 'ARMATURE']\n"
        "[item.select_set(False) for item in bpy.data.objects]"
    )
    window.ask("look", 0.25)
    save(window.picture(), "sidebar")


def test_gallery(window: Any, library: Any, horse: Any) -> None:
    window.clean_scene(horse, NAME)
    window.open("Search")
    window.press_beside("shape_google.find_similar", "shape_google.open_gallery")
    window.wait(lambda _: window.ask("gallery"), "the gallery")
    window.run("bpy.context.window_manager.shape_google.matches.clear()")
    window.press("shape_google.find_similar")
    window.wait_for_kinds()
    save(window.picture(), "gallery")
    x, y = window.ask("gallery")["pictures"][1]
    window.click(x, y)
    window.tool("key", "c")
    window.wait(lambda _: window.ask("gallery")["compared"], "both surfaces compared")
    save(window.picture(), "compare")
    for _ in range(2):
        window.move(x, y)
        window.settle()
        window.tool("key", "Escape")
    window.wait(lambda _: not window.ask("gallery"), "the gallery closed")


def test_signature(window: Any, library: Any, horse: Any) -> None:
    window.clean_scene(horse, NAME)
    window.run("bpy.context.scene.shape_google_painting.kind = 'HKS'")
    window.open("Signature")
    window.press("bpy.ops.shape_google.paint")
    window.wait(lambda state: state["objects"][NAME]["attributes"], "the signature painted")
    save(window.picture(), "signature")


def test_keypoints(window: Any, horse: Any) -> None:
    window.clean_scene(horse, NAME)
    window.run(
        "settings = bpy.context.scene.shape_google_painting\n"
        "settings.kind, settings.detector = 'KEYPOINTS', 'salient-points'"
    )
    window.open("Signature")
    window.press("bpy.ops.shape_google.paint")
    window.wait(lambda state: "sg_keypoint" in state["objects"][NAME]["attributes"], "keypoints painted")
    save(window.picture(), "keypoints_in_blender")


def test_duplicates(window: Any, library: Any, horse: Any) -> None:
    window.clean_scene(horse, "Horse A")
    window.ask("add_object", str(horse), "Horse B", [1.5, 0, 0])
    window.ask("add_object", str(horse), "Foal", [0.2, -1.6, 0])
    window.run(
        "from mathutils import Matrix\n"
        "mesh = bpy.data.objects['Foal'].data\n"
        "mesh.transform(Matrix.Scale(0.6, 4)); mesh.update()"
    )
    window.ask("look")
    window.open("Duplicates")
    window.press("shape_google.find_duplicates")
    window.wait(
        lambda state: state["duplicates"]["groups"] and not state["duplicates"]["running"], "the groups"
    )
    window.press(".chosen", columns=FIRST)
    save(window.picture(), "duplicates")


def test_preferences(window: Any, library: Any) -> None:
    # A new window opens under the pointer.
    window.move(SIZE[0] / 2, SIZE[1] / 2)
    window.run(
        "preferences.library = ''\n"
        "bpy.ops.screen.userpref_show('INVOKE_DEFAULT')\n"
        "bpy.ops.preferences.addon_show(module=name)"
    )
    # As high as the screen, so that all of them are seen, and right of where the pointer rests.
    left, width = 500, 690
    size = ("windowmove", "%@", left, 0, "windowsize", "%@", width, SIZE[1])
    window.tool("search", "--name", "Preferences", *size)
    window.settle()
    image = window.picture()
    window.run(
        "with bpy.context.temp_override(window=bpy.context.window_manager.windows[-1]):\n"
        "    bpy.ops.wm.window_close()"
    )
    # What is above the add-on's own preferences says where it is on this machine.
    save(image.crop((left + 165, 225, left + width, 745)), "preferences")
