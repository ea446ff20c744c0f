# SPDX-License-Identifier: MIT
"""Find Similar with selected objects, faces, points and examples."""

from __future__ import annotations

import importlib
import shutil
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy
import numpy as np
import pytest

from benchmarks.creatures import make_creature
from shapegoogle_core import Library
from shapegoogle_core.mesh.measures import face_areas
from tests.addon.conftest import to_point_cloud
from tests.addon.shapes import lumpy


def test_find_similar(indexed: Path, preferences: Any, session: Any) -> None:
    item = lumpy("Query", 1)
    item.scale = 3, 3, 3
    item.rotation_euler = 1, 2, 3
    bpy.context.view_layer.update()
    assert bpy.ops.shape_google.find_similar() == {"FINISHED"}
    best = session.matches[0]
    assert (best.name, best.kind) == ("Pear", "Scaled ×0.333")
    assert best.similarity > 0.9
    assert Path(best.source) == indexed / "pear.blend"
    assert best.size == pytest.approx(1 / 3, rel=1e-3)
    assert session.answer.startswith("Query: 3 different shapes, the best of 4, ")
    assert not best.in_scene


def test_the_selected_part_and_several_objects(indexed: Path, preferences: Any, session: Any) -> None:
    item = lumpy("Query", 0)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    with pytest.raises(RuntimeError, match="'Query': no faces are selected"):
        bpy.ops.shape_google.find_similar()
    bpy.ops.mesh.select_all(action="SELECT")
    assert bpy.ops.shape_google.find_similar() == {"FINISHED"}
    assert session.matches[0].name == "Apple"
    assert session.query == "Query, selected part"
    bpy.ops.object.mode_set(mode="OBJECT")
    other = lumpy("Other", 1)
    item.select_set(True)
    other.select_set(True)
    bpy.ops.shape_google.find_similar()
    assert session.query in ("Query and 1 more", "Other and 1 more")


def test_selected_objects_as_examples(indexed: Path, preferences: Any, session: Any) -> None:
    """Both are found: joined they would be a third shape, which the library does not have."""
    for seed, name in ((2, "Second"), (0, "First")):
        lumpy(name, seed)
    bpy.data.objects["Second"].select_set(True)
    session.several, session.collapse = "EXAMPLES", False
    assert bpy.ops.shape_google.find_similar() == {"FINISHED"}
    assert session.query == "First and 1 more"
    assert session.asked == 2
    copies = [match for match in session.matches if match.distance == 0]
    assert {match.name for match in copies} == {"Apple", "Plum", "nut.obj"}
    assert {match.kind for match in copies if match.name == "Apple"} == {"Identical"}
    assert [match.name for match in session.matches][-1] == "Pear"
    session.several = "JOINED"
    bpy.ops.shape_google.find_similar()
    assert session.asked == 1
    assert all(match.distance > 0 for match in session.matches)


def test_more_and_not_like_a_match(indexed: Path, preferences: Any, session: Any) -> None:
    lumpy("Query", 1)
    bpy.ops.shape_google.find_similar()
    second = session.matches[1]
    name, shape_id = second.name, second.shape_id
    bpy.ops.shape_google.choose_match(index=1)
    assert bpy.ops.shape_google.mark_example(unlike=True) == {"FINISHED"}
    assert [(example.name, example.shape_id, example.unlike) for example in session.examples] == [
        (name, shape_id, True)
    ]
    # Nothing is asked before the user says so.
    assert session.matches[1].name == name
    assert bpy.ops.shape_google.find_similar() == {"FINISHED"}
    assert session.query == f"Query, not like {name}"
    assert session.matches[0].name == "Pear"
    assert session.matches[-1].distance == 2
    assert shape_id in [match.shape_id for match in session.matches if match.distance == 2]

    # The other button makes it an example to be found.
    session.active_match = [match.shape_id for match in session.matches].index(shape_id)
    bpy.ops.shape_google.mark_example(unlike=False)
    assert [example.unlike for example in session.examples] == [False]
    bpy.ops.shape_google.find_similar()
    assert session.query == "Query and 1 more"
    assert {match.shape_id for match in session.matches if match.distance == 0} >= {shape_id}
    # Once more takes it back.
    session.active_match = [match.shape_id for match in session.matches].index(shape_id)
    bpy.ops.shape_google.mark_example(unlike=False)
    assert not session.examples
    assert not bpy.ops.shape_google.clear_examples.poll()


def test_examples_of_the_library_alone(indexed: Path, preferences: Any, session: Any) -> None:
    lumpy("Query", 1)
    bpy.ops.shape_google.find_similar()
    best = session.matches[0].shape_id
    bpy.ops.shape_google.mark_example()
    bpy.data.objects.remove(bpy.data.objects["Query"])
    assert bpy.ops.shape_google.find_similar() == {"FINISHED"}
    assert (session.query, session.matches[0].shape_id) == ("Pear", best)
    session.examples[0].unlike = True
    assert not bpy.ops.shape_google.find_similar.poll()
    assert bpy.ops.shape_google.remove_example(index=1) == {"CANCELLED"}
    assert bpy.ops.shape_google.remove_example(index=0) == {"FINISHED"}
    assert not session.examples


def test_examples_belong_to_their_library(
    indexed: Path, preferences: Any, session: Any, tmp_path: Path
) -> None:
    """In another one their numbers are those of other shapes; and what is gone is said by its name."""
    lumpy("Query", 1)
    bpy.ops.shape_google.find_similar()
    bpy.ops.shape_google.mark_example(unlike=True)
    first = preferences.library
    shutil.copy(first, tmp_path / "other.sglib")
    preferences.library = str(tmp_path / "other.sglib")
    bpy.ops.shape_google.find_similar()
    assert session.query == "Query"
    assert not bpy.ops.shape_google.clear_examples.poll()
    preferences.library = first
    with Library.open(first) as library:
        library.remove_shape(session.examples[0].shape_id)
    with pytest.raises(RuntimeError, match=r"example 'Pear' cannot be used: .*remove it from the list"):
        bpy.ops.shape_google.find_similar()
    assert bpy.ops.shape_google.clear_examples() == {"FINISHED"}
    assert bpy.ops.shape_google.find_similar() == {"FINISHED"}


def scan(kind: str, count: int = 6000) -> Any:
    """A mesh of vertices alone, spread over a creature at random."""
    mesh = make_creature(kind, 100, 2000).pose(0)
    random = np.random.default_rng(3)
    corners = mesh.vertices[mesh.faces]
    areas = face_areas(mesh)
    chosen = corners[random.choice(len(corners), count, p=areas / areas.sum())]
    data = bpy.data.meshes.new("Scan")
    data.from_pydata(np.einsum("nk,nki->ni", random.dirichlet(np.ones(3), count), chosen).tolist(), [], [])
    item = bpy.data.objects.new(f"Scan of {kind}", data)
    bpy.context.collection.objects.link(item)
    bpy.ops.object.select_all(action="DESELECT")
    item.select_set(True)
    bpy.context.view_layer.objects.active = item
    return item


def test_points_find_their_mesh_and_mesh_its_points(
    addon: ModuleType, preferences: Any, session: Any
) -> None:
    """Vertices without faces can be a query; only objects of the type point cloud are indexed."""
    kinds = ("horse", "octopus", "human")
    new_object = importlib.import_module(f"{addon.__name__}.scene.meshes").new_object
    for kind in kinds:
        new_object(bpy.context, make_creature(kind, 100, 2000).pose(0), kind)
    preferences.use_scene = True
    for kind in kinds:
        scan(kind)
    bpy.ops.shape_google.index_library()
    assert session.summary == "3 shapes of this scene; 3 objects skipped: 3 meshes without faces"
    for kind in kinds:
        item = bpy.data.objects[f"Scan of {kind}"]
        bpy.ops.object.select_all(action="DESELECT")
        bpy.context.view_layer.objects.active = item
        item.select_set(True)
        assert bpy.ops.shape_google.find_similar() == {"FINISHED"}
        assert (session.matches[0].name, len(session.matches)) == (kind, 3)
    item.scale = 1, 1, -1
    bpy.context.view_layer.update()
    if not to_point_cloud():
        pytest.skip("this Blender cannot convert meshes to point clouds; the parts without them passed")
    item = bpy.context.object
    assert item.type == "POINTCLOUD"
    assert bpy.ops.shape_google.find_similar() == {"FINISHED"}
    assert session.matches[0].name == "human"
    bpy.ops.shape_google.index_library()
    assert session.summary == "4 shapes of this scene; 2 objects skipped: 2 meshes without faces"
    bpy.ops.object.select_all(action="DESELECT")
    bpy.context.view_layer.objects.active = bpy.data.objects["human"]
    assert bpy.ops.shape_google.find_similar() == {"FINISHED"}
    assert [match.name for match in session.matches[:2]] == ["human", "Scan of human"]
    # To paint on there is no surface.
    bpy.context.view_layer.objects.active = item
    item.select_set(True)
    assert not bpy.ops.shape_google.paint.poll()
    assert not bpy.ops.shape_google.mark_match.poll()


def test_unusable_library(preferences: Any, session: Any, tmp_path: Path) -> None:
    lumpy("Query", 0)
    assert not bpy.ops.shape_google.find_similar.poll()
    (tmp_path / "shapes.sglib").write_text("no library")
    with pytest.raises(RuntimeError, match="is not a Shape Google library"):
        bpy.ops.shape_google.find_similar()
    with pytest.raises(RuntimeError, match="is not a Shape Google library"):
        bpy.ops.shape_google.choose_library(filepath=str(tmp_path / "shapes.sglib"))
