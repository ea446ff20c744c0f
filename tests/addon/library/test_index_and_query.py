# SPDX-License-Identifier: MIT
"""Index Library and Find Similar, as pressed by a user, on real files in a real background Blender."""

from __future__ import annotations

import hashlib
import importlib
import os
import shutil
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy
import numpy as np
import pytest

from benchmarks.creatures import make_creature
from shapegoogle_core import Library, ShapeGoogleError
from shapegoogle_core.mesh.measures import face_areas
from tests.addon.conftest import to_point_cloud


@pytest.fixture
def preferences(addon: ModuleType) -> Any:
    return bpy.context.preferences.addons[addon.__name__].preferences


@pytest.fixture
def session() -> Any:
    return bpy.context.window_manager.shape_google


def lumpy(name: str, seed: int, subdivisions: int = 4) -> Any:
    """A lumpy ellipsoid, another one for each seed."""
    random = np.random.default_rng(seed)
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=subdivisions)
    item = bpy.context.object
    item.name = name
    points = np.empty((len(item.data.vertices), 3), np.float32)
    item.data.vertices.foreach_get("co", points.ravel())
    centers = random.standard_normal((4, 3))
    centers /= np.linalg.norm(centers, axis=1, keepdims=True)
    points *= (1 + np.exp(-6 * (1 - points @ centers.T)) @ random.uniform(0, 0.7, 4))[:, None]
    points *= random.uniform(0.6, 1.8, 3)
    item.data.vertices.foreach_set("co", points.astype(np.float32).ravel())
    item.data.update()
    return item


@pytest.fixture
def folder(blender: Any, tmp_path: Path) -> Path:
    """A folder of three .blend files with a shape each, a mesh file, and one that is broken."""
    folder = tmp_path / "assets"
    folder.mkdir()
    for seed, name in enumerate(["apple", "pear", "plum"]):
        item = lumpy(name.title(), seed)
        bpy.ops.wm.save_as_mainfile(filepath=str(folder / f"{name}.blend"), copy=True)
        if name == "plum":
            bpy.ops.wm.obj_export(filepath=str(folder / "nut.obj"))
        bpy.data.objects.remove(item)
    (folder / "broken.blend").write_bytes(b"no Blender file")
    return folder


@pytest.fixture
def indexed(folder: Path, preferences: Any, session: Any) -> Path:
    add_folder(preferences, folder)
    assert bpy.ops.shape_google.index_library() == {"FINISHED"}
    return folder


def add_folder(preferences: Any, folder: Path) -> None:
    assert bpy.ops.shape_google.add_folder(directory=str(folder)) == {"FINISHED"}
    assert [item.path for item in preferences.folders] == [str(folder)]


def digests(folder: Path) -> dict[str, str]:
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in folder.iterdir()}


def test_index_a_folder(folder: Path, preferences: Any, session: Any) -> None:
    before = digests(folder)
    add_folder(preferences, folder)
    assert bpy.ops.shape_google.index_library() == {"FINISHED"}
    assert not session.indexing
    assert session.summary == "4 added, 1 failed"
    assert [(error.name, "broken.blend" in error.reason) for error in session.errors] == [
        ("broken.blend", True)
    ]
    with Library.open(preferences.library) as library:
        assert {(shape.object_name, Path(shape.source).name) for shape in library.shapes()} == {
            ("Apple", "apple.blend"),
            ("Pear", "pear.blend"),
            ("Plum", "plum.blend"),
            ("", "nut.obj"),
        }
        assert all(library.thumbnail(shape.shape_id) for shape in library.shapes())
    assert digests(folder) == before

    # A second time there is nothing to do; a changed file is read again.
    bpy.ops.shape_google.index_library()
    assert session.summary == "4 unchanged, 1 failed"
    (error,) = session.errors
    assert error.reason.endswith("Retry Failed Files tries it again)")
    status = (folder / "pear.blend").stat()
    os.utime(folder / "pear.blend", ns=(status.st_atime_ns, status.st_mtime_ns + 10**9))
    (folder / "broken.blend").unlink()
    bpy.ops.shape_google.index_library()
    assert session.summary == "4 unchanged"


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
    assert session.answer.startswith("Query: the best 4 of 4 shapes")
    assert not best.in_scene


def test_filters(addon: ModuleType, indexed: Path, preferences: Any, session: Any) -> None:
    shown_matches = importlib.import_module(f"{addon.__name__}.gallery.filters").shown_matches
    lumpy("Query", 2)
    bpy.ops.shape_google.find_similar()
    # Plum and the .obj made of it are the same mesh.
    assert len(session.matches) == 4
    assert len(shown_matches(session)) == 3
    session.collapse = False
    assert len(shown_matches(session)) == 4
    session.text = "NUT"
    assert [match.name for _, match in shown_matches(session)] == ["nut.obj"]
    session.text = ""
    session.least_similarity = 1.0
    assert {match.name for _, match in shown_matches(session)} == {"Plum", "nut.obj"}
    session.least_similarity = 0
    session.use_size, session.size_tolerance = True, 0.1
    assert {match.name for _, match in shown_matches(session)} == {"Plum", "nut.obj"}
    session.source = "SCENE"
    assert shown_matches(session) == []


def test_the_selected_part_and_several_objects(indexed: Path, preferences: Any, session: Any) -> None:
    item = lumpy("Query", 0)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    with pytest.raises(RuntimeError, match="'Query' has no selected faces"):
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
    session.several = "EXAMPLES"
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


def test_copies_of_two_examples_are_not_taken_for_one_shape(
    addon: ModuleType, indexed: Path, preferences: Any, session: Any
) -> None:
    """All have distance 0, and as poses of one mesh as many vertices; Plum and nut.obj are one shape."""
    shown_matches = importlib.import_module(f"{addon.__name__}.gallery.filters").shown_matches
    lumpy("Second", 2)
    lumpy("First", 0).select_set(True)
    bpy.data.objects["Second"].select_set(True)
    session.several = "EXAMPLES"
    bpy.ops.shape_google.find_similar()
    names = {match.name for _, match in shown_matches(session)}
    assert names in ({"Apple", "Pear", "Plum"}, {"Apple", "Pear", "nut.obj"})


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


def test_the_scene_itself(preferences: Any, session: Any) -> None:
    lumpy("First", 0)
    lumpy("Second", 1)
    preferences.use_scene = True
    assert bpy.ops.shape_google.index_library() == {"FINISHED"}
    assert session.summary == "2 shapes of this scene"
    bpy.context.view_layer.objects.active = bpy.data.objects["First"]
    bpy.ops.object.select_all(action="DESELECT")
    bpy.ops.shape_google.find_similar()
    assert [(match.name, match.in_scene) for match in session.matches] == [("First", True), ("Second", True)]
    assert not bpy.ops.shape_google.append_match.poll()
    bpy.ops.shape_google.choose_match(index=1)
    assert bpy.ops.shape_google.select_match() == {"FINISHED"}
    assert [item.name for item in bpy.context.selected_objects] == ["Second"]


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
    assert session.summary == "3 shapes of this scene"
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
    assert session.summary == "4 shapes of this scene"
    bpy.ops.object.select_all(action="DESELECT")
    bpy.context.view_layer.objects.active = bpy.data.objects["human"]
    assert bpy.ops.shape_google.find_similar() == {"FINISHED"}
    assert [match.name for match in session.matches[:2]] == ["human", "Scan of human"]
    # To paint on there is no surface.
    bpy.context.view_layer.objects.active = item
    item.select_set(True)
    assert not bpy.ops.shape_google.paint.poll()
    assert not bpy.ops.shape_google.mark_match.poll()


def test_append_and_mark(indexed: Path, preferences: Any, session: Any) -> None:
    query = lumpy("Query", 1)
    bpy.ops.shape_google.find_similar()
    bpy.context.scene.cursor.location = 10, 0, 0
    bpy.ops.shape_google.append_match()
    pear = bpy.data.objects["Pear"]
    assert pear.library is None
    assert (pear.matrix_world.translation - bpy.context.scene.cursor.location).length < 3
    assert bpy.context.active_object == pear

    bpy.context.view_layer.objects.active = query
    assert bpy.ops.shape_google.mark_match() == {"FINISHED"}
    beside = bpy.data.objects["Pear.001"]
    assert {item.name for item in bpy.context.selected_objects} == {"Query", "Pear.001"}
    # The same mesh has the same words, vertex by vertex.
    words = [
        np.array([entry.value for entry in item.data.attributes["sg_word"].data]) for item in (query, beside)
    ]
    assert (words[0] == words[1]).mean() > 0.99
    assert len(np.unique(words[0])) > 1
    colors = [item.data.color_attributes["sg_color"] for item in (query, beside)]
    np.testing.assert_allclose(colors[0].data[0].color[:], colors[1].data[0].color[:])
    low = min((beside.matrix_world @ vertex.co).x for vertex in beside.data.vertices)
    high = max((query.matrix_world @ vertex.co).x for vertex in query.data.vertices)
    assert low > high


def test_import_a_mesh_file_and_refuse_what_is_gone(indexed: Path, preferences: Any, session: Any) -> None:
    lumpy("Query", 2)
    bpy.ops.shape_google.find_similar()
    index = [match.name for match in session.matches].index("nut.obj")
    bpy.ops.shape_google.choose_match(index=index)
    assert not bpy.ops.shape_google.link_match.poll()
    assert not bpy.ops.shape_google.open_match.poll()
    bpy.ops.shape_google.append_match()
    assert len(bpy.context.active_object.data.vertices) == 642
    (indexed / "nut.obj").unlink()
    with pytest.raises(RuntimeError, match=r"nut\.obj' no longer exists; index the library again"):
        bpy.ops.shape_google.append_match()


def test_link(indexed: Path, preferences: Any, session: Any) -> None:
    lumpy("Query", 0)
    bpy.ops.shape_google.find_similar()
    bpy.ops.shape_google.link_match()
    assert bpy.data.objects["Apple"].library is not None
    bpy.data.libraries.remove(bpy.data.libraries[0])


def test_unusable_library(preferences: Any, session: Any, tmp_path: Path) -> None:
    lumpy("Query", 0)
    assert not bpy.ops.shape_google.find_similar.poll()
    (tmp_path / "shapes.sglib").write_text("no library")
    with pytest.raises(RuntimeError, match="is not a Shape Google library"):
        bpy.ops.shape_google.find_similar()
    with pytest.raises(RuntimeError, match="is not a Shape Google library"):
        bpy.ops.shape_google.choose_library(filepath=str(tmp_path / "shapes.sglib"))


def test_jobs_of_two(addon: ModuleType) -> None:
    """A worker that was stopped starts again, and an error comes back as it is."""
    jobs = importlib.import_module(f"{addon.__name__}.jobs")
    worker = jobs.worker()
    assert worker.submit(abs, -3).result() == 3
    worker.stop()
    assert worker.submit(abs, -4).result() == 4
    with pytest.raises(ShapeGoogleError, match="TypeError"):
        worker.submit(abs, "three").result()


def test_paint_is_no_difference_and_library_groups_are_selected(preferences: Any, session: Any) -> None:
    first = lumpy("First", 0)
    second = first.copy()
    second.data = first.data.copy()
    second.name = "Second"
    bpy.context.collection.objects.link(second)
    preferences.use_scene = True
    bpy.ops.shape_google.index_library()
    first.select_set(True)
    bpy.context.scene.shape_google_painting.kind = "WORDS"
    bpy.ops.shape_google.paint()
    state = bpy.context.window_manager.shape_google_duplicates
    state.scope = "SCENE"
    bpy.ops.shape_google.find_duplicates()
    assert [(group.kind, group.linkable) for group in state.groups] == [("IDENTICAL", True)]
    state.scope = "LIBRARY"
    bpy.ops.shape_google.find_duplicates()
    bpy.ops.object.select_all(action="DESELECT")
    assert bpy.ops.shape_google.select_duplicates(index=0) == {"FINISHED"}
    assert {item.name for item in bpy.context.selected_objects} == {"First", "Second"}
    state.scope = "SCENE"


def test_the_manual_s_script(folder: Path, preferences: Any, session: Any, tmp_path: Path) -> None:
    manual = (Path(__file__).parents[3] / "docs" / "blender.md").read_text(encoding="utf-8")
    script = manual.partition("```python\n")[2].partition("```")[0]
    assert "find_similar" in script
    script = script.replace("/library/studio.sglib", str(tmp_path / "studio.sglib"))
    script = script.replace("/library/assets", str(folder))
    # In tests the add-on is a folder of the repository, and nothing is there twice.
    script = script.replace('endswith("shape_google")', 'endswith(("shape_google", "blender_addon"))')
    script = script.replace("bpy.ops.shape_google.link_duplicates()", "")
    exec(compile(script, "manual", "exec"), {})
    assert len(session.matches) == 4
    assert "sg_word" in bpy.context.active_object.data.attributes


def test_results_outlast_the_opening_of_a_file(
    indexed: Path, preferences: Any, session: Any, tmp_path: Path
) -> None:
    lumpy("Query", 1)
    bpy.ops.shape_google.find_similar()
    names = [match.name for match in session.matches]
    session.least_similarity = 0.25
    bpy.ops.shape_google.mark_example(unlike=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "other.blend"), copy=True)
    for load_ui in (True, False):
        bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "other.blend"), load_ui=load_ui)
        kept = bpy.context.window_manager.shape_google
        assert [match.name for match in kept.matches] == names
        assert [error.name for error in kept.errors] == ["broken.blend"]
        assert (kept.active_match, kept.query) == (0, "Query")
        assert kept.least_similarity == pytest.approx(0.25)
        assert [(example.name, example.unlike) for example in kept.examples] == [("Pear", True)]
    # The file of the best match is open now: it can be selected there.
    bpy.ops.shape_google.open_match()
    kept = bpy.context.window_manager.shape_google
    assert [match.name for match in kept.matches if match.in_scene] == ["Pear"]
    assert bpy.ops.shape_google.select_match() == {"FINISHED"}
    bpy.ops.wm.read_homefile(use_empty=True)


def test_the_scene_and_its_file_are_two_sources(
    addon: ModuleType, folder: Path, preferences: Any, session: Any
) -> None:
    (folder / "broken.blend").unlink()
    bpy.ops.wm.open_mainfile(filepath=str(folder / "pear.blend"), load_ui=False)
    item = lumpy("Unsaved", 5)
    item.asset_mark()
    item.asset_data.tags.new("lump")
    add_folder(preferences, folder)
    preferences.use_scene = True
    bpy.ops.shape_google.index_library()
    session = bpy.context.window_manager.shape_google
    assert session.summary == "4 added; 2 shapes of this scene"
    with Library.open(preferences.library) as library:
        assert {shape.name: shape.tags for shape in library.shapes() if shape.tags} == {"Unsaved": ("lump",)}
    bpy.ops.shape_google.index_library()
    assert session.summary == "4 unchanged; 2 shapes of this scene"
    bpy.ops.shape_google.find_similar()
    assert session.matches[0].name == "Unsaved"
    # Pear is in the file and in the scene: what can be selected is shown.
    shown = importlib.import_module(
        f"{type(preferences).__module__.rpartition('.')[0]}.gallery.filters"
    ).shown_matches
    assert [match.in_scene for _, match in shown(session) if match.name == "Pear"] == [True]
    bpy.ops.wm.read_homefile(use_empty=True)


def test_a_cancelled_scene_stores_nothing(addon: ModuleType, preferences: Any, session: Any) -> None:
    for seed in range(3):
        lumpy(f"Shape {seed}", seed)
    module = importlib.import_module(f"{addon.__name__}.library.scene_source")
    indexing = module.SceneIndexing(bpy.context, preferences.library_path(), "default")
    indexing.events()
    indexing.cancel()
    indexing.join()
    assert indexing.events() == []
    with Library.open(preferences.library) as library:
        assert len(library) == 0
    # Objects that are deleted meanwhile are left out; a model that is not there is said.
    indexing = module.SceneIndexing(bpy.context, preferences.library_path(), "default")
    bpy.data.objects.remove(bpy.data.objects["Shape 1"])
    events = []
    while indexing.exit_code is None:
        indexing.join()
        events += indexing.events()
    assert [event["path"] for event in events[:-1]] == ["Shape 0", "Shape 2"]
    assert events[-1] == {"scene": 2, "failed": [], "shapes": 2}
    Path(preferences.library).unlink()
    indexing = module.SceneIndexing(bpy.context, preferences.library_path(), "/no/model.npz")
    assert indexing.events() == []
    assert indexing.exit_code == 2
    assert "cannot read the model" in indexing.last_words()


def test_hidden_objects_and_wires_are_left_out_of_the_scene(preferences: Any, session: Any) -> None:
    lumpy("Hidden", 0).hide_viewport = True
    lumpy("Shown", 1)
    wire = bpy.data.meshes.new("wire")
    wire.from_pydata([(0, 0, 0), (1, 0, 0)], [(0, 1)], [])
    bpy.context.collection.objects.link(bpy.data.objects.new("Wire", wire))
    preferences.use_scene = True
    bpy.ops.shape_google.index_library()
    assert session.summary == "1 shape of this scene"
    assert not session.errors


def test_forget_missing_files(indexed: Path, preferences: Any, session: Any) -> None:
    (indexed / "plum.blend").unlink()
    (indexed / "broken.blend").unlink()
    bpy.ops.shape_google.index_library()
    assert session.summary == "3 unchanged"
    with Library.open(preferences.library) as library:
        assert len(library) == 4
    bpy.ops.shape_google.index_library(prune=True)
    assert session.summary == "3 unchanged, 2 removed"
    with Library.open(preferences.library) as library:
        assert len(library) == 3


def test_what_is_chosen_is_saved(preferences: Any, tmp_path: Path) -> None:
    for change in (
        lambda: bpy.ops.shape_google.choose_library(filepath=str(tmp_path / "new")),
        lambda: bpy.ops.shape_google.add_folder(directory=str(tmp_path)),
        lambda: setattr(preferences.folders[0], "use", False),
        lambda: bpy.ops.shape_google.remove_folder(),
    ):
        bpy.context.preferences.is_dirty = False
        change()
        assert bpy.context.preferences.is_dirty
    assert preferences.library == str(tmp_path / "new.sglib")
    # A path beside the open file would mean another one in the next file.
    preferences.library = "//lib.sglib"
    assert Path(preferences.library).is_absolute()


@pytest.mark.long
def test_train_a_model_on_this_library(folder: Path, preferences: Any, session: Any, tmp_path: Path) -> None:
    (folder / "broken.blend").unlink()
    for seed in range(3, 10):
        item = lumpy(f"Shape {seed}", seed, subdivisions=3)
        bpy.ops.wm.save_as_mainfile(filepath=str(folder / f"shape{seed}.blend"), copy=True)
        bpy.data.objects.remove(item)
    add_folder(preferences, folder)
    model = tmp_path / "mine.npz"
    assert bpy.ops.shape_google.train_model(filepath=str(model)) == {"FINISHED"}
    assert session.summary == "Trained mine.npz; it is used for new libraries"
    assert (preferences.model, preferences.model_file) == ("FILE", str(model))
    bpy.ops.shape_google.index_library()
    with Library.open(preferences.library) as library:
        assert library.model.name == "mine"
