# SPDX-License-Identifier: MIT
"""The demo in Blender: rigs that move like the core's creatures, a library of them, the search, pictures."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy
import numpy as np
import pytest

pytest.importorskip("skimage", reason="making creatures needs scikit-image")
from benchmarks.creatures import blend_library, make_creature, rigs
from benchmarks.figures import workbench
from tests.addon.conftest import copy_library

DEMO = Path(__file__).resolve().parents[2] / "scripts" / "lib" / "demo_blend.py"
CHOSEN = ("Horse", "Elephant", "Hand")


@pytest.fixture(scope="module")
def demo() -> Iterator[Any]:
    """The demo's part in Blender; scripts are no package, so it is loaded from its file."""
    spec = importlib.util.spec_from_file_location("demo_blend", DEMO)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    yield module
    del sys.modules[spec.name]


@pytest.fixture(scope="module")
def individuals() -> Any:
    return [individual for individual in blend_library.INDIVIDUALS if individual.name in CHOSEN]


@pytest.fixture(scope="module")
def folder(addon: ModuleType, individuals: Any, tmp_path_factory: pytest.TempPathFactory) -> Any:
    folder = tmp_path_factory.mktemp("library")
    written = blend_library.write_library(folder, individuals)
    assert written == [folder / individual.path for individual in individuals]
    return folder


def open_blend(path: Path) -> None:
    bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False, use_scripts=False)


def world_vertices(item: Any) -> Any:
    evaluated = item.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    vertices = np.empty((len(mesh.vertices), 3), np.float32)
    mesh.vertices.foreach_get("co", vertices.ravel())
    evaluated.to_mesh_clear()
    matrix = np.array(evaluated.matrix_world)
    return vertices @ matrix[:3, :3].T + matrix[:3, 3]


@pytest.mark.parametrize("kind", ["human", "octopus", "desk lamp", "bird", "centaur"])
def test_rigs_move_as_the_core_does(kind: str) -> None:
    creature = make_creature(kind, 5, vertex_count=1500)
    collection = bpy.context.scene.collection
    skins = rigs.add_creature(creature, "Probe", creature.pose_names, collection)
    assert len({skin.data for skin in skins}) == 1
    assert len({skin.parent.data for skin in skins}) == 1
    for pose, skin in zip(creature.pose_names, skins, strict=True):
        expected = creature.pose(pose)
        np.testing.assert_allclose(world_vertices(skin), expected.vertices, atol=2e-5, err_msg=pose)
        faces = [tuple(polygon.vertices) for polygon in skin.data.polygons]
        np.testing.assert_array_equal(faces, expected.faces)


def test_bones_of_the_two_sides_are_named_as_blender_mirrors_them() -> None:
    names = rigs.bone_names(make_creature("human", 5, vertex_count=800).skeleton)
    assert len(set(names)) == len(names)
    left = [name for name in names if name.endswith(".L")]
    assert left
    assert all(bpy.utils.flip_name(name) in names for name in left)


def test_an_unknown_pose_is_refused() -> None:
    creature = make_creature("dog", 5, vertex_count=800)
    with pytest.raises(ValueError, match="a dog has no pose 'moonwalk'"):
        rigs.take_pose(creature, None, "moonwalk")


def test_every_file_opens_and_shows_its_figures(folder: Path, individuals: Any) -> None:
    for individual in individuals:
        open_blend(folder / individual.path)
        creature = make_creature(individual.kind, individual.seed)
        assert len([item for item in bpy.data.objects if item.type == "MESH"]) == len(individual.figures)
        right_edge = -np.inf
        for figure in individual.figures:
            skin = bpy.data.objects[f"{individual.name} {figure.pose.title()}"]
            assert skin.modifiers[0].type == "ARMATURE"
            assert skin.modifiers[0].object.type == "ARMATURE"
            assert skin.data.materials[0].name == individual.name
            vertices = world_vertices(skin)
            expected = figure.scale * creature.pose(figure.pose).vertices
            if figure.modifier == "SUBSURF":
                assert len(vertices) > 4 * len(expected)
            elif figure.modifier == "DECIMATE":
                assert len(vertices) < 0.5 * len(expected)
            else:
                moved = vertices - skin.parent.matrix_world.translation
                np.testing.assert_allclose(moved, expected, atol=2e-5 * figure.scale)
            size = np.ptp(expected, axis=0).max()
            assert vertices[:, 2].min() == pytest.approx(0, abs=0.02 * size), "it stands on the floor"
            assert vertices[:, 0].min() > right_edge, "figures stand side by side"
            right_edge = vertices[:, 0].max()


def test_every_mesh_is_an_asset_in_a_catalog_of_the_library(folder: Path, individuals: Any) -> None:
    lines = (folder / blend_library.CATALOG_FILE).read_text().splitlines()
    catalogs = dict(line.split(":")[:2] for line in lines if ":" in line)
    assert "VERSION 1" in lines
    for individual in individuals:
        names = {f"{individual.name} {figure.pose.title()}" for figure in individual.figures}
        with bpy.data.libraries.load(str(folder / individual.path), assets_only=True) as (content, _):
            assert set(content.objects) == names
        open_blend(folder / individual.path)
        for name in names:
            asset = bpy.data.objects[name].asset_data
            assert catalogs[asset.catalog_id] == individual.catalog
            assert individual.kind in asset.tags


def test_only_what_changed_is_written_again(folder: Path, individuals: Any) -> None:
    before = {path: path.read_bytes() for path in folder.rglob("*.blend")}
    assert blend_library.write_library(folder, individuals) == []
    lost = folder / individuals[-1].path
    lost.unlink()
    assert blend_library.write_library(folder, individuals) == [lost]
    for path, content in before.items():
        if path != lost:
            assert path.read_bytes() == content, f"{path.name} was written without need"


def test_a_picture_shows_the_whole_object_in_its_colours() -> None:
    if workbench.missing_library():
        pytest.skip(f"no {workbench.missing_library()}: Workbench cannot render here")
    data = rigs.mesh_data(make_creature("bird", 5, vertex_count=800).rest, "Bird")
    colors = data.color_attributes.new("Color", "FLOAT_COLOR", "POINT")
    colors.data.foreach_set("color_srgb", np.tile([0.9, 0.2, 0.1, 1], len(data.vertices)))
    data.color_attributes.active_color = colors
    bird = bpy.data.objects.new("Bird", data)
    bpy.context.scene.collection.objects.link(bird)
    bird.scale = (40, 40, 40)
    bystander = bpy.data.objects.new("Bystander", data)
    bpy.context.scene.collection.objects.link(bystander)
    objects = set(bpy.data.objects)

    workbench.set_up_studio(bpy.context.scene)
    picture = np.asarray(workbench.photograph(bird, (200, 120)), float) / 255
    assert picture.shape == (120, 200, 3)
    border = np.concatenate([picture[0], picture[-1], picture[:, 0], picture[:, -1]])
    assert border.min() > 0.9, "object and shadow end inside the picture, the floor is light"
    red = (picture[..., 0] - picture[..., 1:].max(axis=-1) > 0.3).mean()
    assert 0.08 < red < 0.7, "the object fills a good part of it"
    assert set(bpy.data.objects) == objects, "camera and floor are gone"
    assert not bystander.hide_render


def test_a_note_of_what_is_there_that_was_cut_short_only_costs_time(individuals: Any, tmp_path: Path) -> None:
    (tmp_path / blend_library.STAMP_FILE).write_text('{"animals/ho')
    hand = individuals[-1]
    assert blend_library.write_library(tmp_path, [hand]) == [tmp_path / hand.path]
    assert blend_library.write_library(tmp_path, [hand]) == []


@pytest.fixture
def indexed(
    addon: ModuleType, demo: Any, folder: Path, tmp_path: Path, made_once: dict[str, Path]
) -> Iterator[Any]:
    """The part of the demo that shows something, with the library indexed and chosen."""
    library = tmp_path / "shapes.sglib"
    if "demo" in made_once:  # then nothing in it is left to be indexed
        copy_library(made_once["demo"], library)
    blend_library.start_empty()
    demo.index_library(addon, folder, library)
    if "demo" not in made_once:
        made_once["demo"] = folder.with_name("demo.sglib")
        copy_library(library, made_once["demo"])
    yield demo
    chosen = bpy.context.preferences.addons[addon.__name__].preferences
    for name in ("library", "folders", "use_asset_libraries"):
        chosen.property_unset(name)


def test_indexing_leaves_every_file_as_it_is_to_the_byte(
    folder: Path, addon: ModuleType, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    before = {path: (path.read_bytes(), path.stat().st_mtime_ns) for path in folder.rglob("*.*")}
    request.getfixturevalue("indexed")
    assert before == {path: (path.read_bytes(), path.stat().st_mtime_ns) for path in folder.rglob("*.*")}


def test_the_query_finds_the_same_horse_in_all_its_poses(indexed: Any, individuals: Any) -> None:
    matches = indexed.find_similar(indexed.add_query())
    horse = next(individual for individual in individuals if individual.name == "Horse")
    poses = {f"Horse {figure.pose.title()}" for figure in horse.figures}
    assert {match.name for match in matches[: len(poses)]} == poses
    assert all(Path(match.source).name == "horse.blend" for match in matches[: len(poses)])
    assert matches[len(poses)].similarity < 0.5 < matches[len(poses) - 1].similarity


def test_the_picture_is_drawn_once(indexed: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    if workbench.missing_library():
        pytest.skip("Workbench cannot render here")
    picture = tmp_path / "picture.png"
    query = indexed.add_query()
    matches = indexed.find_similar(query)[:2]
    indexed.update_picture(query, matches, picture)
    first = picture.stat()
    assert first.st_size > 30_000
    indexed.update_picture(query, matches, picture)
    assert picture.stat().st_mtime_ns == first.st_mtime_ns
