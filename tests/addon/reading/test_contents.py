# SPDX-License-Identifier: MIT
"""Every sort of object in an artist's files: what each must give."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy
import numpy as np
import pytest

from shapegoogle_core import Library, MeshError
from shapegoogle_core.indexing import FileShapes
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.mesh import Mesh
from tests.addon.reading.every_sort import EXPECTED, LEFT_OUT, Expected, make_library


@pytest.fixture(scope="module")
def made(read: Callable[..., FileShapes], tmp_path_factory: pytest.TempPathFactory) -> FileShapes:
    return read(make_library(tmp_path_factory.mktemp("library")))


def summary(shape: NewShape[Mesh]) -> Expected:
    return Expected(
        str(shape.origin.shape_type),
        shape.name,
        shape.object_name,
        tuple(placement.object_name for placement in shape.placements),
        shape.tags,
        shape.origin.catalog,
    )


def test_every_sort_of_object(made: FileShapes) -> None:
    found = {summary(shape) for shape in made.shapes}
    assert not made.problems
    assert found - set(EXPECTED) == set()
    assert set(EXPECTED) - found == set()
    assert len(made.shapes) == len(EXPECTED)


def test_what_is_left_out_is_counted(addon: ModuleType, made: FileShapes) -> None:
    assert {note.kind: note.count for note in made.notes.left_out} == LEFT_OUT
    # Each has a text of its own, which can be translated.
    texts = importlib.import_module(f"{addon.__name__}.library.sentences").LEFT_OUT
    assert set(LEFT_OUT) <= set(texts)
    assert [Path(path).name for path in made.notes.linked] == ["shelves.blend"]


def test_the_open_scene_has_the_same_shapes(tmp_path: Path, preferences: Any, session: Any) -> None:
    """But for those that it links, which are seen in it, and those that only the frozen file tells."""
    bpy.ops.wm.open_mainfile(filepath=str(make_library(tmp_path)))
    preferences.use_scene = True
    assert bpy.ops.shape_google.index_library() == {"FINISHED"}
    assert not session.errors
    with Library.open(preferences.library) as library:
        found = {
            (str(shape.origin.shape_type), shape.name, shape.placement_count): shape
            for shape in library.shapes()
        }
    expected = {(one.shape_type, one.name, len(one.placements)) for one in EXPECTED}
    # Realized instances are one mesh there: nothing says where they come from.
    realized = {("scatter", "Wood", 1), ("object", "Tree", 14)}
    assert expected - set(found) == realized
    assert set(found) - expected == {("object", "Wood", 1), ("object", "Tree", 5)}
    assert found["collection", "Lamp", 2].tags == ("light",)
    bpy.ops.wm.read_homefile(use_empty=True)


def test_each_pose_of_some_frames_is_a_shape(read: Callable[..., FileShapes], tmp_path: Path) -> None:
    bpy.ops.mesh.primitive_monkey_add()
    item = bpy.context.object
    item.name = "Head"
    item.shape_key_add(name="Basis")
    key = item.shape_key_add(name="Long")
    for point in key.data:
        point.co.x *= 3
    for frame, value in ((1, 0), (10, 1), (20, 0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    bpy.ops.mesh.primitive_cone_add()
    bpy.context.object.name = "Moving"
    for frame in (1, 10):
        bpy.context.object.location.x = frame
        bpy.context.object.keyframe_insert("location", frame=frame)
    path = tmp_path / "poses.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    found = {shape.name: shape for shape in read(path, frames="1,10,20").shapes}
    # At 20 it is as at 1; what only moves has one shape.
    assert {name: shape.origin.frame for name, shape in found.items()} == {
        "Head @ 1": 1,
        "Head @ 10": 10,
        "Moving": None,
    }
    assert {shape.object_name for shape in found.values()} == {"Head", "Moving"}
    lengths = [np.ptp(found[f"Head @ {frame}"].mesh.vertices[:, 0]) for frame in (1, 10)]
    assert lengths[1] == pytest.approx(3 * lengths[0], rel=1e-3)


@pytest.mark.parametrize("suffix", [".usdc", ".usda", ".abc", ".dae", ".svg"])
def test_what_blender_imports_is_one_shape(
    read: Callable[..., FileShapes], addon: ModuleType, tmp_path: Path, suffix: str
) -> None:
    importers = importlib.import_module(f"{addon.__name__}.reading.importers")
    reader = importlib.import_module(f"{addon.__name__}.connections").blend_reader()
    assert (suffix in reader.suffixes) == (importers.importer_of(suffix) is not None)
    if suffix not in reader.suffixes:
        pytest.skip(f"Blender {bpy.app.version_string} imports no {suffix}")
    path = tmp_path / f"two{suffix}"
    if suffix == ".svg":
        path.write_text(
            '<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9"><path d="M0 0H4V4Z"/></svg>'
        )
    else:
        for x in (-2, 2):
            bpy.ops.mesh.primitive_ico_sphere_add(location=(x, 0, 0))
        export = {
            ".abc": lambda: bpy.ops.wm.alembic_export(filepath=str(path), as_background_job=False),
            ".dae": lambda: bpy.ops.wm.collada_export(filepath=str(path)),
        }
        export.get(suffix, lambda: bpy.ops.wm.usd_export(filepath=str(path)))()
    (shape,) = read(path).shapes
    (tmp_path / f"broken{suffix}").write_bytes(b"no such file")
    with pytest.raises(MeshError, match="broken"):
        read(tmp_path / f"broken{suffix}")
    assert (shape.object_name, shape.name) == ("", f"two{suffix}")
    if suffix != ".svg":
        np.testing.assert_allclose(np.ptp(shape.mesh.vertices, axis=0), [6, 2, 2], atol=0.2)
