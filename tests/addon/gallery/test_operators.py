# SPDX-License-Identifier: MIT
"""What is done with a match: linking, selecting and marking it, also where that fails."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy
import numpy as np
import pytest

from tests.addon.shapes import open_source
from tests.core.mesh.io.mesh_files import POINTS
from tests.core.mesh.io.three_mf_files import item as built
from tests.core.mesh.io.three_mf_files import mesh_object, model, moved, package


def add(name: str, subdivisions: int = 3) -> Any:
    """A lumpy ball."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=subdivisions)
    item = bpy.context.object
    item.name = name
    for vertex in item.data.vertices:
        vertex.co *= 1 + 0.2 * np.sin(3 * vertex.co.x) + 0.1 * vertex.co.z
    return item


def choose(name: str, source: Path | str = "") -> None:
    """Choose a match; without a file, one of the open scene."""
    session = bpy.context.window_manager.shape_google
    match = session.matches.add()
    match.name = match.object_name = name
    match.source = str(source) or open_source()
    session.active_match = len(session.matches) - 1


@pytest.fixture
def source(blender: Any, tmp_path: Path) -> Iterator[Any]:
    """A file with a man, who has an armature and shape keys, and a shape without faces."""
    bpy.ops.object.armature_add()
    armature = bpy.context.object
    man = add("Man")
    man.modifiers.new("Armature", "ARMATURE").object = armature
    man.shape_key_add(name="Basis")
    man.data.materials.append(bpy.data.materials.new("Skin"))
    points = bpy.data.meshes.new("Points")
    points.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1)], [])
    cloud = bpy.data.objects.new("Points", points)
    cloud.shape_key_add(name="Basis")
    cloud.parent = man
    bpy.context.collection.objects.link(cloud)
    path = tmp_path / "source.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    bpy.ops.wm.read_homefile(use_empty=True)
    yield path
    bpy.ops.wm.read_homefile(use_empty=True)


def blocks() -> set[str]:
    return {f"{type(block).__name__} {block.name_full}" for block in bpy.data.user_map()}


class TestLink:
    def test_an_armature_may_have_the_name_of_one_here(self, source: Any) -> None:
        bpy.ops.object.armature_add()
        assert bpy.context.object.name == "Armature"
        choose("Man", source)
        assert bpy.ops.shape_google.link_match() == {"FINISHED"}
        assert bpy.context.active_object.name == "Man"
        assert [item.name for item in bpy.context.selected_objects] == ["Man"]

    @pytest.mark.parametrize("relative", [False, True])
    def test_what_is_linked_already_is_selected(
        self, source: Any, relative: Any, capfd: pytest.CaptureFixture[str]
    ) -> None:
        if relative:
            bpy.ops.wm.save_as_mainfile(filepath=str(source.with_name("here.blend")))
        choose("Man", source)
        bpy.ops.shape_google.link_match()
        if relative:
            bpy.ops.file.make_paths_relative()
            assert bpy.data.libraries[0].filepath.startswith("//")
        own = add("Own")
        bpy.ops.object.mode_set(mode="EDIT")
        assert bpy.ops.shape_google.link_match() == {"FINISHED"}
        assert "Man is linked here already" in capfd.readouterr().out
        assert bpy.context.active_object.name == "Man"
        assert (own.mode, own.select_get()) == ("OBJECT", False)

    def test_what_was_linked_and_taken_out_comes_back(self, source: Any) -> None:
        choose("Man", source)
        bpy.ops.shape_google.link_match()
        man = bpy.context.active_object
        bpy.context.collection.objects.unlink(man)
        assert bpy.ops.shape_google.link_match() == {"FINISHED"}
        assert bpy.context.active_object == man

    def test_in_an_excluded_collection_it_says_so_or_is_shown(self, source: Any) -> None:
        choose("Man", source)
        bpy.ops.shape_google.link_match()
        man = bpy.context.active_object
        collection = bpy.data.collections.new("Away")
        bpy.context.scene.collection.children.link(collection)
        bpy.context.collection.objects.unlink(man)
        collection.objects.link(man)
        bpy.context.view_layer.layer_collection.children["Away"].exclude = True
        if bpy.app.version >= (5, 2):  # Blender puts it into the active collection too
            bpy.ops.shape_google.link_match()
            assert man in set(bpy.context.view_layer.objects)
            assert bpy.context.active_object == man
        else:
            with pytest.raises(RuntimeError, match="view layer excludes: 'Away'"):
                bpy.ops.shape_google.link_match()


def test_nothing_is_listed_in_place_of_what_was_removed(source: Any, addon: ModuleType) -> None:
    placing = importlib.import_module(f"{addon.__name__}.gallery.placing")
    man = importlib.import_module(f"{addon.__name__}.scene.finding").Sought("Man")
    placing.bring_in(bpy.context, str(source), man)  # from then on the file is known, and stays
    before = set(bpy.data.user_map())
    shown = set(bpy.context.view_layer.objects)
    placing.bring_in(bpy.context, str(source), man)
    bpy.context.view_layer.update()
    placing.remove(bpy.context, [block for block in bpy.data.user_map() if block not in before])
    assert set(bpy.context.view_layer.objects) == shown


def test_select_leaves_edit_mode_and_deselects_all_else() -> None:
    bpy.ops.object.light_add()
    light = bpy.context.object
    edited = add("Edited")
    target = bpy.data.objects.new("Target", edited.data.copy())
    bpy.context.collection.objects.link(target)
    light.select_set(True)
    bpy.ops.object.mode_set(mode="EDIT")
    choose("Target")
    assert bpy.ops.shape_google.select_match() == {"FINISHED"}
    assert (edited.mode, bpy.context.mode) == ("OBJECT", "OBJECT")
    assert bpy.context.selected_objects == [target]
    assert bpy.context.active_object == target


class TestMark:
    @pytest.mark.parametrize("trouble", ["library", "match"])
    def test_what_fails_leaves_nothing_behind(self, source: Any, tmp_path: Path, trouble: Any) -> None:
        query, other = add("Query"), add("Other")
        other.select_set(True)
        bpy.context.view_layer.objects.active = query
        chosen = bpy.context.scene.shape_google_painting
        chosen.kind = "HKS"
        before = blocks()
        if trouble == "library":
            (tmp_path / "shapes.sglib").write_text("no library")
            choose("Man", source)
            reason = r"shapes\.sglib"
        else:
            choose("Points", source)
            reason = "'Points' cannot be painted"
        with pytest.raises(RuntimeError, match=reason):
            bpy.ops.shape_google.mark_match()
        assert blocks() == before
        assert "sg_word" not in query.data.attributes
        assert (bpy.context.active_object, set(bpy.context.selected_objects)) == (query, {other})
        assert chosen.kind == "HKS"
        bpy.data.orphans_purge(do_recursive=True)

    def test_all_objects_of_an_imported_file_are_painted(self, tmp_path: Path) -> None:
        path = tmp_path / "two.obj"
        first, second = add("First"), add("Second")
        second.location.x = 4
        first.select_set(True)
        bpy.ops.wm.obj_export(filepath=str(path))
        for item in (first, second):
            bpy.data.objects.remove(item)
        query = add("Query")
        choose("two.obj", path)
        assert bpy.ops.shape_google.mark_match() == {"FINISHED"}
        assert len(bpy.context.selected_objects) == 3
        assert all("sg_word" in item.data.attributes for item in bpy.context.selected_objects)
        assert bpy.context.active_object == query

    def test_the_query_itself(self) -> None:
        query = add("Query")
        choose("Query")
        assert bpy.ops.shape_google.mark_match() == {"FINISHED"}
        assert bpy.context.selected_objects == [query]


def test_append_an_object_of_a_plate(addon: ModuleType, blender: Any, tmp_path: Path) -> None:
    """Of a 3MF only the object that was found, not the whole plate."""
    placing = importlib.import_module(f"{addon.__name__}.gallery.placing")
    finding = importlib.import_module(f"{addon.__name__}.scene.finding")
    resources = mesh_object(1, more='name="Box"') + mesh_object(2, 2 * POINTS, 'name="Crate"')
    path = tmp_path / "plate.3mf"
    path.write_bytes(package(model(resources, built(1) + built(2, moved(50, 0, 0)))))
    (crate,) = placing.bring_in(bpy.context, str(path), finding.Sought("Crate"))
    assert crate.name == "Crate"
    assert list(crate.dimensions) == pytest.approx([4, 2, 6])
    with pytest.raises(placing.PlacingError, match="has no object 'Lid' any more"):
        placing.bring_in(bpy.context, str(path), finding.Sought("Lid"))
    placing.remove(bpy.context, [crate])
