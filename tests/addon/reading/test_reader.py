# SPDX-License-Identifier: MIT
"""The Blender that reads and imports files: what it finds, what it refuses, what it leaves alone."""

from __future__ import annotations

import hashlib
import importlib
import math
import os
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy
import numpy as np
import pytest

from shapegoogle_core import MeshError
from tests.addon.conftest import to_point_cloud
from tests.addon.reading.blend_files import add, save


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def test_objects_with_modifiers_at_world_scale(read: Any, tmp_path: Path) -> None:
    item = add("Suzanne", location=(1, 2, 3))
    item.scale = 2, 2, 2
    item.modifiers.new("Subdivision", "SUBSURF").levels = 1
    bpy.context.view_layer.update()
    path = save(tmp_path / "scene.blend")
    before = digest(path)
    (shape,) = read(path).shapes
    assert (shape.object_name, shape.mesh.name) == ("Suzanne", "Suzanne")
    assert len(shape.mesh.vertices) > 1500
    evaluated = item.evaluated_get(bpy.context.evaluated_depsgraph_get())
    expected = np.array([evaluated.matrix_world @ vertex.co for vertex in evaluated.data.vertices])
    np.testing.assert_allclose(shape.mesh.vertices, expected, atol=1e-5)
    assert digest(path) == before


def test_hidden_objects_and_such_without_a_scene(read: Any, tmp_path: Path) -> None:
    add("Hidden").hide_viewport = True
    loose = add("Loose")
    loose.modifiers.new("Subdivision", "SUBSURF").levels = 1
    loose.use_fake_user = True
    for collection in loose.users_collection:
        collection.objects.unlink(loose)
    shapes = {shape.object_name: shape.mesh for shape in read(save(tmp_path / "scene.blend")).shapes}
    assert set(shapes) == {"Hidden", "Loose"}
    assert len(shapes["Loose"].vertices) > 3 * len(shapes["Hidden"].vertices)


def test_armatures_pose(read: Any, tmp_path: Path) -> None:
    bpy.ops.object.armature_add()
    armature = bpy.context.object
    item = add("Posed")
    group = item.vertex_groups.new(name="Bone")
    group.add(range(len(item.data.vertices)), 1.0, "REPLACE")
    item.modifiers.new("Armature", "ARMATURE").object = armature
    armature.pose.bones["Bone"].location = 0, 5, 0
    bpy.context.view_layer.update()
    (shape,) = read(save(tmp_path / "scene.blend")).shapes
    assert shape.mesh.vertices[:, 2].mean() > 4


def linked(first: Any, name: str, scale: Any = (1, 1, 1), place: Any = (0, 0, 0)) -> Any:
    """An object that shares the mesh of another one."""
    copy = first.copy()
    copy.name, copy.scale, copy.location = name, scale, place
    bpy.context.collection.objects.link(copy)
    return copy


def objects_of(shapes: Any) -> list[list[str]]:
    return [[placement.object_name for placement in shape.placements] for shape in shapes]


def test_linked_data_is_described_once(read: Any, tmp_path: Path) -> None:
    first = add("A")
    for name, scale in (("B", (3, 3, 3)), ("C", (1, 1, 2)), ("D", (-1, 1, 1)), ("E", (2, 2, -4))):
        linked(first, name, scale, (5, 0, 0))
    linked(first, "F", (1, 1, 1)).hide_viewport = True
    bpy.data.scenes.new("Other").collection.objects.link(elsewhere := linked(first, "G"))
    bpy.context.collection.objects.unlink(elsewhere)
    moving = linked(first, "H")
    moving.scale = 2, 2, 2
    moving.keyframe_insert("scale", frame=bpy.context.scene.frame_current)
    flat = linked(first, "I", (1, 1, 0))
    bpy.context.view_layer.update()
    matrices = {item.name: np.array(item.matrix_world) for item in (first, moving, flat)}
    shapes = read(save(tmp_path / "scene.blend")).shapes
    # What is stretched in one direction is another shape, but one for all that are stretched alike.
    assert objects_of(shapes) == [["A", "B", "D", "F", "G", "H"], ["C", "E"], ["I"]]
    mirrored = np.diag([-1.0, 1, 1, 1])
    mirrored[0, 3] = 5
    np.testing.assert_allclose(shapes[0].placements[2].matrix, mirrored)
    np.testing.assert_allclose(shapes[0].placements[5].matrix, matrices["H"])
    assert shapes[1].placements[1].extents[0] == pytest.approx(2 * shapes[1].placements[0].extents[0])


def test_objects_that_are_evaluated_alike_are_one_shape(read: Any, tmp_path: Path) -> None:
    """Modifiers, shape keys and drivers decide, not that there are some."""
    first = add("A")
    first.modifiers.new("Subdivision", "SUBSURF").levels = 1
    linked(first, "B", (-2, 2, 2))
    linked(first, "C").modifiers["Subdivision"].levels = 2
    linked(first, "D").modifiers["Subdivision"].show_viewport = False
    linked(first, "E").modifiers.clear()
    driven = linked(first, "F")
    driven.driver_add('modifiers["Subdivision"].levels').driver.expression = "2"
    # Each is mirrored at the place of another object.
    place = bpy.data.objects.new("Place", None)
    place.location.x = 3
    bpy.context.collection.objects.link(place)
    for name, x in (("G", 0), ("H", 1)):
        mirrored = linked(first, name, place=(x, 0, 0))
        mirrored.modifiers.clear()
        mirrored.modifiers.new("Mirror", "MIRROR").mirror_object = place
    for name in "IJ":
        reduced = linked(first, name, place=(5, 0, 0))
        reduced.modifiers.new("Decimate", "DECIMATE").ratio = 0.5
        reduced.modifiers.new("Bevel", "BEVEL").show_viewport = name == "I"
    keyed = add("K", location=(9, 0, 0))
    keyed.shape_key_add(name="Basis")
    key = keyed.shape_key_add(name="Long")
    key.data[0].co.x += 3
    key.value = 0.0  # from Blender 5.0 on a new key has 1, so that all objects of the mesh show it
    linked(keyed, "L", place=(9, 9, 0))
    pinned = linked(keyed, "M")
    pinned.active_shape_key_index, pinned.show_only_shape_key = 1, True
    bpy.context.view_layer.update()
    shapes = read(save(tmp_path / "scene.blend")).shapes
    assert objects_of(shapes) == [
        *(["A", "B"], ["C", "F"], ["D", "E"], ["G"], ["H"], ["I"], ["J"], ["K", "L"], ["M"]),
    ]


def test_modifiers_of_many_objects_are_computed_once(addon: ModuleType) -> None:
    """Blender computes them for each object: 300 subdivided ones took longer than a file may."""
    import importlib

    meshes = importlib.import_module(f"{addon.__name__}.reading.sharing")
    first = add("A")
    first.modifiers.new("Subdivision", "SUBSURF").levels = 1
    first.modifiers.new("Mirror", "MIRROR")
    twin = linked(first, "B", (2, 2, 2))
    other = linked(first, "C")
    other.modifiers["Mirror"].use_axis[1] = True
    depsgraph = bpy.context.evaluated_depsgraph_get()
    shared = meshes.SharedMeshes([first, twin, other])
    evaluated = [item.evaluated_get(depsgraph) for item in (first, twin, other)]
    assert shared.content(evaluated[0]) is None
    content = shared.read(evaluated[0], b"coordinates")
    assert [shared.content(item) for item in evaluated] == [content, content, None]
    # What geometry nodes make may depend on the object.
    twin.modifiers.new("Nodes", "NODES")
    depsgraph.update()
    assert shared.content(twin.evaluated_get(depsgraph)) is None


def test_an_object_that_its_parent_deforms_has_a_shape_of_its_own(read: Any, tmp_path: Path) -> None:
    """As Blender before 2.5 made them: no modifier says that they are deformed."""
    first = add("A")
    for name, parented in (("B", True), ("C", True), ("D", False)):
        copy = first.copy()
        copy.name = name
        bpy.context.collection.objects.link(copy)
        if parented:
            lattice = bpy.data.objects.new(f"Lattice of {name}", bpy.data.lattices.new("Lattice"))
            lattice.scale = 4, 4, 4
            bpy.context.collection.objects.link(lattice)
            if name == "C":
                for point in list(lattice.data.points)[:4]:
                    point.co_deform.x += 3
            copy.parent, copy.parent_type = lattice, "LATTICE"
    bpy.context.view_layer.update()
    shapes = {shape.object_name: shape for shape in read(save(tmp_path / "scene.blend")).shapes}
    # The lattice of B has its own form: it deforms nothing.
    assert objects_of(shapes.values()) == [["A", "B", "D"], ["C"]]
    extents = [np.ptp(shapes[name].mesh.vertices[:, 0]) for name in "AC"]
    assert not math.isclose(*extents, rel_tol=0.05)


def test_tags_of_assets(read: Any, tmp_path: Path) -> None:
    item = add("Asset")
    item.asset_mark()
    item.asset_data.tags.new("prop")
    item.asset_data.tags.new("monkey")
    twin = add("Twin")
    twin.data = item.data
    twin.asset_mark()
    twin.asset_data.tags.new("twin")
    path = save(tmp_path / "scene.blend")
    (shape,) = read(path).shapes
    assert (shape.object_name, shape.tags) == ("Asset", ("prop", "monkey", "twin"))


def test_assets_first(read: Any, tmp_path: Path) -> None:
    add("Plain")
    add("Asset").asset_mark()
    path = save(tmp_path / "scene.blend")
    assert [shape.object_name for shape in read(path, objects="assets").shapes] == ["Asset"]
    assert [shape.object_name for shape in read(path).shapes] == ["Asset", "Plain"]
    bpy.data.objects["Asset"].asset_clear()
    path = save(tmp_path / "none.blend")
    assert [shape.object_name for shape in read(path, objects="assets").shapes] == ["Asset", "Plain"]


def test_wires_and_lamps_are_no_shapes(read: Any, tmp_path: Path) -> None:
    bpy.ops.object.light_add()
    mesh = bpy.data.meshes.new("wire")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0)], [(0, 1)], [])
    bpy.context.collection.objects.link(bpy.data.objects.new("Wire", mesh))
    found = read(save(tmp_path / "scene.blend"))
    assert not found.shapes
    assert not found.problems


def test_point_clouds_are_shapes_and_vertices_without_faces_are_not(read: Any, tmp_path: Path) -> None:
    points = np.random.default_rng(1).random((40, 3)).astype(np.float32)
    mesh = bpy.data.meshes.new("points")
    mesh.from_pydata(points.tolist(), [], [])
    objects = [bpy.data.objects.new(name, mesh) for name in ("Vertices", "Scan")]
    objects.append(bpy.data.objects.new("Empty", bpy.data.pointclouds.new("Empty")))
    for item in objects:
        bpy.context.collection.objects.link(item)
    objects[1].scale = 1, 2, -3
    bpy.ops.object.select_all(action="DESELECT")
    objects[1].select_set(True)
    bpy.context.view_layer.objects.active = objects[1]
    converted = to_point_cloud()
    found = read(save(tmp_path / "scene.blend"))
    assert not found.problems
    assert [shape.object_name for shape in found.shapes] == ["Scan"] * converted
    for shape in found.shapes:
        assert shape.mesh.is_point_cloud
        np.testing.assert_allclose(shape.mesh.vertices, points * [1, 2, -3], atol=1e-6)


def test_a_file_is_opened_at_its_frame_and_not_computed(addon: ModuleType, tmp_path: Path) -> None:
    """Blender computes what its window shows as soon as a file is open, however much that is."""
    reader = importlib.import_module(f"{addon.__name__}.reading.reader")
    item = add("Grown")
    item.modifiers.new("Subdivision", "SUBSURF").levels = 2
    faces = len(item.data.polygons)
    bpy.context.scene.frame_set(7)
    path = save(tmp_path / "scene.blend")
    try:
        reader._open(path)
        assert bpy.context.scene.frame_current == 7
        assert not len(bpy.context.scene.objects)
        assert sum(len(scene.objects) for scene in bpy.data.scenes) == 1
        for window in bpy.context.window_manager.windows:
            assert not len(window.view_layer.depsgraph.objects)
        assert reader._leave_scene not in bpy.app.handlers.load_post
        with (tmp_path / "shapes.bin").open("wb") as output:
            contents = importlib.import_module(f"{addon.__name__}.reading.contents")
            answer = contents.read_contents(path, output)
        assert [shape["name"] for shape in answer["shapes"]] == ["Grown"]
        assert answer["meshes"][0]["faces"] > 16 * faces
    finally:
        bpy.ops.wm.read_homefile(use_empty=True)


def test_scripts_in_files_do_not_run(read: Any, tmp_path: Path) -> None:
    victim = tmp_path / "ran"
    text = bpy.data.texts.new("start.py")
    text.use_module = True  # runs when the file is opened, where that is allowed
    text.write(f"open({str(victim)!r}, 'w')")
    item = add("Driven")
    driver = item.driver_add("location", 0).driver
    driver.expression = f"len(open({str(victim)!r}, 'w').name)"
    path = save(tmp_path / "scene.blend")
    bpy.data.texts.remove(text)
    victim.unlink(missing_ok=True)  # the driver may have run here, where it was made
    assert len(read(path).shapes) == 1
    assert not victim.exists()


@pytest.mark.parametrize("content", [b"", b"no Blender file", b"BLENDER-v405" + bytes(100)])
def test_what_is_no_blend_file(read: Any, tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "broken.blend"
    path.write_bytes(content)
    with pytest.raises(MeshError, match=r"'broken\.blend'"):
        read(path)
    # The same Blender reads the next file.
    add("Suzanne")
    assert len(read(save(tmp_path / "good.blend")).shapes) == 1


def test_a_missing_library_and_a_compressed_file(read: Any, tmp_path: Path) -> None:
    add("Elsewhere")
    elsewhere = save(tmp_path / "elsewhere.blend")
    bpy.data.objects.remove(bpy.data.objects["Elsewhere"])
    with bpy.data.libraries.load(str(elsewhere), link=True) as (_, wanted):
        wanted.objects = ["Elsewhere"]
    bpy.context.collection.objects.link(wanted.objects[0])
    add("Own")
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True, compress=True)
    elsewhere.unlink()
    # What is linked belongs to the other file.
    assert [shape.object_name for shape in read(path).shapes] == ["Own"]
    bpy.data.libraries.remove(bpy.data.libraries[0])


def test_an_fbx_is_one_shape(read: Any, tmp_path: Path) -> None:
    if "fbx" not in dir(bpy.ops.export_scene):
        pytest.skip("this Blender writes no .fbx")
    # Inside a real Blender tests are lent packages; the Blender that reads files has its own alone.
    lent = Path(os.environ.get("BLENDER_USER_RESOURCES", tmp_path), "scripts", "modules").resolve()
    if Path(np.__file__).resolve().is_relative_to(lent):
        pytest.skip("this Blender has no numpy of its own, which its importer of .fbx needs")
    add("A", location=(-2, 0, 0))
    add("B", location=(2, 0, 0))
    path = tmp_path / "two.fbx"
    bpy.ops.export_scene.fbx(filepath=str(path))
    (shape,) = read(path).shapes
    assert shape.object_name == ""
    assert len(shape.mesh.faces) == 2 * 968
    assert math.isclose(np.ptp(shape.mesh.vertices[:, 0]), 6.7, rel_tol=0.05)


def test_objects_of_many_faces_are_evaluated_one_after_the_other(
    addon: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import importlib

    contents = importlib.import_module(f"{addon.__name__}.reading.contents")
    evaluate, sizes = contents._evaluate, []

    def counted(objects: Any, frame: int) -> Any:
        sizes.append(len(objects))
        return evaluate(objects, frame)

    monkeypatch.setattr(contents, "_evaluate", counted)
    for number in range(5):
        add(f"Part {number}")
    answers = []
    for limit in (contents.MOST_FACES_AT_ONCE, 1000):  # each has 968
        monkeypatch.setattr(contents, "MOST_FACES_AT_ONCE", limit)
        with (tmp_path / "shapes.bin").open("wb") as output:
            answers.append(contents.read_contents(Path("parts.blend"), output))
    assert sizes == [1, 2, 2, 1, 1, 1, 1, 1]
    assert answers[0] == answers[1]
    assert len(answers[0]["shapes"]) == 5
