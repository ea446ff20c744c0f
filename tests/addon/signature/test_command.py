# SPDX-License-Identifier: MIT
"""`scripts/paint_signatures.py`: attributes in a copy, the source untouched, exit codes."""

from __future__ import annotations

import hashlib
import importlib
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy
import numpy as np
import pytest

import shapegoogle_core as sg

SCRIPT = Path(__file__).resolve().parents[3] / "scripts" / "paint_signatures.py"


@pytest.fixture
def main(addon: ModuleType) -> Any:
    return importlib.import_module(f"{addon.__name__}.signature.command").main


@pytest.fixture
def source(blender: Any, tmp_path: Path) -> Iterator[Any]:
    """Two scenes; a scaled ball in each, and a curve, a ring without faces and an object in no scene."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3)
    bpy.context.object.name = "Ball"
    bpy.context.object.scale = 1, 2, 3
    bpy.ops.mesh.primitive_circle_add()
    bpy.ops.curve.primitive_bezier_curve_add()
    bpy.context.object.name = "Curve"
    other = bpy.data.scenes.new("Other scene")
    for name, owner in (("Other ball", other), ("Lost", None)):
        item = bpy.data.objects.new(name, bpy.data.objects["Ball"].data.copy())
        item.scale = 3, 3, 3
        if owner is not None:
            owner.collection.objects.link(item)
    bpy.data.objects["Lost"].use_fake_user = True
    bpy.data.scenes["Scene"].render.fps = 17  # to know the open scene again
    path = tmp_path / "in.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    yield path
    bpy.ops.wm.read_homefile(use_empty=True)


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def test_paints_all_objects_at_their_scale(main: Any, source: Any, addon: ModuleType) -> None:
    before, output = digest(source), source.with_name("out.blend")
    assert (
        main(
            [
                str(source),
                "--output",
                str(output),
                "--time",
                "0.5",
                "--object",
                "Ball",
                "--object",
                "Other ball",
            ]
        )
        == 0
    )
    assert digest(source) == before
    bpy.ops.wm.open_mainfile(filepath=str(output))
    assert bpy.context.scene.render.fps == 17
    values_of = importlib.import_module(f"{addon.__name__}.signature.attributes").values_of
    for name, scale in (("Ball", (1, 2, 3)), ("Other ball", (3, 3, 3))):
        data = bpy.data.objects[name].data
        vertices = np.empty((len(data.vertices), 3), np.float32)
        data.vertices.foreach_get("co", vertices.ravel())
        faces = np.empty((len(data.polygons), 3), np.int32)
        data.polygons.foreach_get("vertices", faces.ravel())
        spectrum = sg.compute_spectrum(sg.Mesh(vertices * scale, faces), 100)
        expected = sg.heat_kernel_signature(spectrum, [0.5])[:, 0]
        assert np.allclose(values_of(data, "sg_hks"), expected, rtol=1e-5, atol=0)
    assert not [each.name for each in bpy.data.objects["Lost"].data.attributes if each.name.startswith("sg_")]


def test_what_cannot_be_painted_is_named_and_the_rest_is_saved(
    main: Any, source: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    output = source.with_name("out.blend")
    arguments = ["--attribute", "words", "--attribute", "rgb", "--weights", "2"]
    assert main([str(source), "--output", str(output), *arguments]) == 1
    printed = capsys.readouterr()
    assert "2 of 3 objects painted" in printed.out
    assert "'Circle' has no faces" in printed.err
    bpy.ops.wm.open_mainfile(filepath=str(output))
    names = {each.name for each in bpy.data.objects["Ball"].data.attributes if each.name.startswith("sg_")}
    assert {"sg_word", "sg_hks_1", "sg_hks_3", "sg_color"} < names
    assert sum(name.startswith("sg_weight_") for name in names) == 2


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("Curve", "'Curve' is no mesh"),
        ("Lost", "'Lost' is in no scene"),
        ("Nobody", "'Nobody' is in no scene"),
    ],
)
def test_without_anything_painted_nothing_is_written(
    main: Any, source: Any, capsys: pytest.CaptureFixture[str], name: str, reason: Any
) -> None:
    output = source.with_name("out.blend")
    assert main([str(source), "--output", str(output), "--object", name]) == 1
    assert reason in capsys.readouterr().err
    assert not output.exists()


def test_heat_needs_a_vertex_that_is_there(
    main: Any, source: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    output = source.with_name("out.blend")
    arguments = [str(source), "--output", str(output), "--object", "Ball", "--attribute", "heat", "--vertex"]
    assert main([*arguments, "100000"]) == 1
    assert "'Ball' has no vertex 100000; its last one is 161" in capsys.readouterr().err
    assert main([*arguments, "7"]) == 0


def test_keypoints_of_a_detector(
    main: Any, source: Any, addon: ModuleType, capsys: pytest.CaptureFixture[str]
) -> None:
    output = source.with_name("out.blend")
    arguments = ["--object", "Ball", "--attribute", "keypoints", "--detector", "harris-3d"]
    assert main([str(source), "--output", str(output), *arguments]) == 0
    assert " keypoints of harris-3d; 162 vertices" in capsys.readouterr().err
    bpy.ops.wm.open_mainfile(filepath=str(output))
    item = bpy.data.objects["Ball"]
    attributes = importlib.import_module(f"{addon.__name__}.signature.attributes")
    meshes = importlib.import_module(f"{addon.__name__}.scene.meshes")
    found = sg.vertex_keypoints(meshes.base_mesh(item), "harris-3d")
    assert np.allclose(attributes.values_of(item.data, "sg_keypoint"), found.responses)


def test_modifiers_are_not_computed_and_are_saved_as_they_were(
    main: Any, source: Any, addon: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Subdivided or scattered objects can need more memory than there is."""
    bpy.ops.wm.open_mainfile(filepath=str(source))
    for item in bpy.data.objects:
        if item.type == "MESH":
            for name in ("Seen", "Only rendered"):
                modifier = item.modifiers.new(name, "SUBSURF")
                modifier.levels, modifier.show_viewport = 2, name == "Seen"
    bpy.ops.wm.save_as_mainfile(filepath=str(source), copy=True)
    painting = importlib.import_module(f"{addon.__name__}.signature.command").painting
    apply, computed = painting.apply, {}

    def note(item: Any, *arguments: Any, **options: Any) -> None:
        depsgraph = bpy.context.evaluated_depsgraph_get()
        evaluated = item.evaluated_get(depsgraph)
        computed[item.name] = len(evaluated.data.polygons) / len(item.data.polygons)
        assert np.allclose(evaluated.matrix_world.to_scale(), item.scale)
        apply(item, *arguments, **options)

    monkeypatch.setattr(painting, "apply", note)
    handlers = [bpy.app.handlers.load_post, bpy.app.handlers.save_pre, bpy.app.handlers.save_post]
    handlers += [bpy.app.handlers.save_post_fail]
    before = [list(some) for some in handlers]
    output = source.with_name("out.blend")
    main([str(source), "--output", str(output)])
    assert computed == {"Ball": 1, "Other ball": 1}
    assert [list(some) for some in handlers] == before
    bpy.ops.wm.open_mainfile(filepath=str(output))
    for name in computed:
        shown = {modifier.name: modifier.show_viewport for modifier in bpy.data.objects[name].modifiers}
        assert shown == {"Seen": True, "Only rendered": False}


def test_the_source_is_never_saved_over(
    main: Any, source: Any, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    before = digest(source)
    link = tmp_path / "link.blend"
    link.symlink_to(source)
    for output in (source, link, tmp_path / "missing" / "out.blend", tmp_path):
        assert main([str(source), "--output", str(output)]) == 2
    assert "is the file that is read" in capsys.readouterr().err
    assert digest(source) == before


@pytest.mark.parametrize("content", [b"", b"BLENDER-v402 cut short", b"no .blend at all"])
def test_file_that_is_no_blend(
    main: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str], content: Any
) -> None:
    broken = tmp_path / "broken.blend"
    broken.write_bytes(content)
    assert main([str(broken), "--output", str(tmp_path / "out.blend")]) == 2
    assert "cannot be opened" in capsys.readouterr().err


@pytest.mark.parametrize(
    "arguments",
    [
        ["in.blend"],
        ["in.blend", "--output", "x", "--time", "-1"],
        ["in.blend", "--output", "x", "--scale", "2"],
        ["in.blend", "--output", "x", "--attribute", "beauty"],
        ["in.blend", "--output", "x", "--times", "0"],
        ["in.blend", "--output", "x", "--attribute", "keypoints", "--detector", "corners"],
    ],
)
def test_wrong_usage(main: Any, arguments: Any) -> None:
    with pytest.raises(SystemExit) as stop:
        main(arguments)
    assert stop.value.code == 2


@pytest.mark.skipif(bool(bpy.app.binary_path), reason="inside Blender the installed extension is asked for")
@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        (["--help"], 0, "--attribute"),
        (["IN", "--output", "OUT"], 1, "2 of 3 objects painted"),
        (["--", "IN", "--output", "OUT", "--object", "Ball"], 0, "1 of 1 objects painted"),
        (["IN", "--output", "IN"], 2, "is the file that is read"),
        (["IN"], 2, "--output"),
    ],
)
def test_script(source: Any, tmp_path: Path, arguments: Any, code: Any, said: Any) -> None:
    files = {"IN": str(source), "OUT": str(tmp_path / "out.blend")}
    command = [sys.executable, str(SCRIPT), *(files.get(word, word) for word in arguments)]
    # From elsewhere: the script must find the add-on without help.
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == code, done.stderr
    assert said in done.stdout + done.stderr


def test_disabled_objects_are_left_out_and_named(
    main: Any, source: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    """Blender does not evaluate them: their scale would be taken for 1."""
    bpy.ops.wm.open_mainfile(filepath=str(source))
    hidden = bpy.data.objects.new("Cutter", bpy.data.objects["Ball"].data.copy())
    hidden.scale = 5, 5, 5
    bpy.context.scene.collection.objects.link(hidden)
    hidden.hide_viewport = True
    bpy.ops.wm.save_as_mainfile(filepath=str(source), copy=True)
    output = source.with_name("out.blend")
    arguments = [str(source), "--output", str(output)]
    capsys.readouterr()
    main([*arguments, "--object", "Ball"])
    assert "Cutter" not in capsys.readouterr().err
    main(arguments)
    assert "left out, as they are disabled in viewports: Cutter" in capsys.readouterr().err
    assert main([*arguments, "--object", "Ball", "--object", "Cutter"]) == 1
    assert "'Cutter' is disabled in viewports" in capsys.readouterr().err
    bpy.ops.wm.open_mainfile(filepath=str(output))
    assert "sg_hks" in bpy.data.objects["Ball"].data.attributes
    assert "sg_hks" not in bpy.data.objects["Cutter"].data.attributes
