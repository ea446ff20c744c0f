# SPDX-License-Identifier: MIT
"""Large files and scenes are read in portions: the shapes are the same, and no step takes long."""

from __future__ import annotations

import importlib
import json
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy
import pytest

from tests.addon.reading.blend_files import add
from tests.addon.reading.every_sort import make_library


def modules(addon: ModuleType, *names: str) -> list[Any]:
    return [importlib.import_module(f"{addon.__name__}.{name}") for name in names]


def instanced(tree: Any, item: Any) -> Any:
    """Node that gives an object as an instance."""
    node = tree.nodes.new("GeometryNodeObjectInfo")
    node.inputs["Object"].default_value = item
    node.inputs["As Instance"].default_value = True
    return node


def scatter(item: Any, side: int, *, stretched: bool = False) -> Any:
    """Object whose nodes instance another one on a grid."""
    tree = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    grid, points = (tree.nodes.new(f"GeometryNode{kind}") for kind in ("MeshGrid", "InstanceOnPoints"))
    grid.inputs["Vertices X"].default_value = grid.inputs["Vertices Y"].default_value = side
    tree.links.new(grid.outputs["Mesh"], points.inputs["Points"])
    tree.links.new(instanced(tree, item).outputs["Geometry"], points.inputs["Instance"])
    if stretched:
        random = tree.nodes.new("FunctionNodeRandomValue")
        random.data_type = "FLOAT_VECTOR"
        random.inputs[0].default_value, random.inputs[1].default_value = (0.5,) * 3, (2,) * 3
        tree.links.new(random.outputs[0], points.inputs["Scale"])
    tree.links.new(points.outputs["Instances"], tree.nodes.new("NodeGroupOutput").inputs[0])
    lawn = bpy.data.objects.new("Lawn", bpy.data.meshes.new("Lawn"))
    bpy.context.collection.objects.link(lawn)
    lawn.modifiers.new("Scatter", "NODES").node_group = tree
    bpy.context.view_layer.update()
    return lawn


def test_a_file_has_the_same_shapes_in_portions_of_one(
    addon: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (contents,) = modules(addon, "reading.contents")
    path = make_library(tmp_path)
    found = []
    for most in (1, contents.MOST_OBJECTS_AT_ONCE):
        monkeypatch.setattr(contents, "MOST_OBJECTS_AT_ONCE", most)
        bpy.ops.wm.open_mainfile(filepath=str(path))
        with (tmp_path / "shapes.bin").open("wb") as output:
            answer = contents.read_contents(path, output)
        found.append(
            sorted(
                (shape["name"], shape["type"], len(shape["parts"]), sorted(map(str, shape["placements"])))
                for shape in answer["shapes"]
            )
        )
        assert not answer["problems"]
    assert found[0] == found[1]
    bpy.ops.wm.read_homefile(use_empty=True)


def test_few_objects_of_asset_collections_are_evaluated_at_once(
    addon: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """500 collections of 10 subdivided objects took more than 20 GB of memory."""
    (contents,) = modules(addon, "reading.contents")
    evaluate, sizes = contents._evaluate, []

    def counted(objects: Any, frame: int) -> Any:
        depsgraph, scene = evaluate(objects, frame)
        sizes.append(sum(1 for one in depsgraph.object_instances if one.is_instance) + len(objects))
        return depsgraph, scene

    monkeypatch.setattr(contents, "_evaluate", counted)
    monkeypatch.setattr(contents, "MOST_OBJECTS_AT_ONCE", 8)
    bpy.ops.wm.read_homefile(use_empty=True)
    for number in range(9):
        collection = bpy.data.collections.new(f"Asset {number}")
        bpy.context.scene.collection.children.link(collection)
        for part in range(3):
            item = add(f"Part {number} {part}")
            item.location.z = part + number / 10
            item.modifiers.new("Subdivision", "SUBSURF").levels = 1
            collection.objects.link(item)
        collection.asset_mark()
    with (tmp_path / "shapes.bin").open("wb") as output:
        reported: list[tuple[int, int]] = []
        answer = contents.read_contents(
            Path("assets.blend"), output, progress=lambda done, total: reported.append((done, total))
        )
    assert len(answer["shapes"]) == 9 + 27
    assert max(sizes) <= 8
    # One for each portion, to the end.
    shares = [done / total for done, total in reported]
    assert len(shares) >= len(sizes)
    assert shares == sorted(shares)
    assert shares[-1] == 1


def test_the_reader_says_how_far_it_is_now_and_then(
    addon: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    (reader,) = modules(addon, "reading.reader")
    reading, writing = os.pipe()
    report = reader._reporter(writing)
    report(1, 9)  # too early to bother anybody
    monkeypatch.setattr(reader, "SECONDS_BEFORE_REPORTS", 0.0)
    report = reader._reporter(writing)
    for done in range(2, 9):
        report(done, 9)
    os.close(writing)
    with os.fdopen(reading, "rb") as lines:
        assert [json.loads(line) for line in lines] == [{"progress": [2, 9]}]


def test_instances_are_collected_without_computing_subdivided_meshes(addon: ModuleType) -> None:
    (instancers,) = modules(addon, "reading.instancers")
    bpy.ops.wm.read_homefile(use_empty=True)
    item = add("Pebble")
    item.modifiers.new("Subdivision", "SUBSURF").levels = 1
    lawn = scatter(item, 3)
    collector = instancers.InstanceCollector({"MESH"}, lambda _shown: 0, lambda _item: True)
    assert collector.collect(bpy.context.evaluated_depsgraph_get())
    assert [one.mesh for one in collector.of[lawn.session_uid]] == [None] * 9
    assert collector.faces == 0


def test_instances_are_collected_in_portions_and_again_where_the_scene_has_changed(
    addon: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    (instancers,) = modules(addon, "reading.instancers")
    monkeypatch.setattr(instancers, "_INSTANCES_BETWEEN_LOOKS", 10)
    bpy.ops.wm.read_homefile(use_empty=True)
    lawn = scatter(add("Pebble"), 7)

    def collect(change: Callable[[int], None]) -> tuple[int, list[Any]]:
        collector = instancers.InstanceCollector({"MESH"}, lambda _shown: 0, lambda _item: True)
        for calls in range(1, 100):
            if collector.collect(bpy.context.evaluated_depsgraph_get(), lambda: False):
                return calls, [tuple(one.matrix.translation) for one in collector.of[lawn.session_uid]]
            change(calls)
        raise AssertionError("it never ends")

    calls, places = collect(lambda _calls: None)
    assert calls == 6
    assert len(set(places)) == 49

    def add_before(calls: int) -> None:
        if calls == 2:
            add("A new one")
            (grid,) = [node for node in lawn.modifiers[0].node_group.nodes if "Vertices X" in node.inputs]
            grid.inputs["Vertices X"].default_value = 6
            bpy.context.view_layer.update()

    calls, places = collect(add_before)
    assert calls > 6
    assert len(places) == len(set(places)) == 42

    def add_always(calls: int) -> None:
        add(f"A new one {calls}")

    calls, places = collect(add_always)
    assert len(places) == len(set(places)) == 42


def test_a_scatter_of_stretched_instances_is_some_shapes_and_a_whole(
    addon: ModuleType, tmp_path: Path
) -> None:
    contents, entries = modules(addon, "reading.contents", "reading.entries")
    bpy.ops.wm.read_homefile(use_empty=True)
    scatter(add("Blade"), 10, stretched=True)
    with (tmp_path / "shapes.bin").open("wb") as output:
        answer = contents.read_contents(Path("grass.blend"), output)
    names = [shape["name"] for shape in answer["shapes"]]
    assert names.count("Blade") == 1 + entries.MOST_STRETCHES
    assert names.count("Lawn") == 1
    assert answer["left_out"] == {"further instance": 100 - entries.MOST_STRETCHES}


def test_the_scene_is_read_in_short_slices(addon: ModuleType, tmp_path: Path) -> None:
    (scene_reading,) = modules(addon, "library.scene_reading")
    bpy.ops.wm.open_mainfile(filepath=str(make_library(tmp_path)))
    found = []
    for seconds in (0.0, 3600.0):
        with tempfile.NamedTemporaryFile() as output:
            reading = scene_reading.SceneReading(bpy.context, output)
            slices = 1
            while not reading.read(seconds):
                slices += 1
            shapes = [shape for shape in reading.shapes() if shape is not None]
        assert slices > len(bpy.data.objects) if seconds == 0 else slices == 1
        found.append([(shape.name, shape.record["type"], len(shape.record["parts"])) for shape in shapes])
        assert reading.expected == 0
    assert found[0] == found[1]
    bpy.ops.wm.read_homefile(use_empty=True)
