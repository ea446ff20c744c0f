# SPDX-License-Identifier: MIT
"""The example package and the one on the page about plug-ins, through the command and in Python."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest
import trimesh

ROOT = Path(__file__).resolve().parents[3]
EXAMPLE = ROOT / "docs" / "plugin_example"


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of packages that has the example."""
    folder = tmp_path_factory.mktemp("packages")
    example, from_page = folder / "example", folder / "from_page"
    # pip builds inside the folder that it is given.
    shutil.copytree(EXAMPLE, example, ignore=shutil.ignore_patterns("build", "*.egg-info", "__pycache__"))
    from_page.mkdir()
    page = (ROOT / "docs" / "howto" / "plugins.md").read_text("utf-8")
    for language, name in (("toml", "pyproject.toml"), ("python", "my_shapes.py")):
        block = re.search(rf"^   ```{language}\n(.*?)^   ```$", page, re.DOTALL | re.MULTILINE)
        assert block is not None
        (from_page / name).write_text(textwrap.dedent(block[1]), "utf-8")
    options = ["--quiet", "--no-deps", "--no-build-isolation", "--disable-pip-version-check"]
    command = [sys.executable, "-m", "pip", "install", *options, "--target", str(folder / "site")]
    command += [str(example), str(from_page)]
    subprocess.run(command, check=True)
    return folder / "site"


def run(installed: Path, *arguments: object) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join([str(ROOT), str(installed)])
    return subprocess.run(
        [sys.executable, *map(str, arguments)],
        env=os.environ | {"PYTHONPATH": path, "OMP_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        encoding="utf-8",
        check=False,
    )


def write_tri(path: Path, size: float) -> Path:
    box = trimesh.creation.box((1, 2, 3)).subdivide().subdivide()
    lines = [str(len(box.vertices)), *(" ".join(map(str, size * vertex)) for vertex in box.vertices)]
    lines += [str(len(box.faces)), *(" ".join(map(str, face + 1)) for face in box.faces)]
    path.write_text("\n".join(lines) + "\n", "utf-8")
    return path


def test_the_list_has_one_of_each(installed: Path) -> None:
    listed = run(installed, "-m", "shapegoogle_core", "info", "--plugins", "--json")
    assert listed.returncode == 0, listed.stderr
    plugins = json.loads(listed.stdout)["plugins"]
    assert [(plugin["kind"], plugin["name"]) for plugin in plugins] == [
        ("descriptor", "heights"),
        ("descriptor", "shells"),
        ("keypoint detector", "far-points"),
        ("mesh format", ".tri"),
        ("candidate stage", "same-area"),
        ("re-ranker", "by-size"),
    ]
    assert {plugin["problem"] for plugin in plugins} == {""}
    table = run(installed, "-m", "shapegoogle_core", "info", "--plugins")
    assert "far-points  shapegoogle-example 0.1.0" in table.stdout


def test_files_are_indexed_and_found_with_its_stages(installed: Path, tmp_path: Path) -> None:
    folder = tmp_path / "meshes"
    folder.mkdir()
    write_tri(folder / "large.tri", 4)
    write_tri(folder / "medium.tri", 2)
    same = write_tri(folder / "same.tri", 1)
    trimesh.creation.icosphere(2).export(folder / "ball.ply")
    library = tmp_path / "shapes.sglib"
    made = run(installed, "-m", "shapegoogle_core", "index", folder, "--library", library, "--jobs", 1)
    assert made.returncode == 0, made.stderr
    query = ["-m", "shapegoogle_core", "query", same, "--library", library, "--json", "--evidence", 0]

    def names(*options: str) -> list[str]:
        answer = run(installed, *query, *options)
        assert answer.returncode == 0, answer.stderr
        return [match["name"] for match in json.loads(answer.stdout)["matches"]]

    assert names() == ["same.tri", "large.tri", "medium.tri", "ball.ply"]
    assert names("--rank", "shape", "--candidates", "same-area") == ["same.tri"]
    by_size = names("--reranker", "by-size", "--candidates", "codes", "--candidates", "same-area")
    assert [name for name in by_size if name != "ball.ply"] == ["same.tri", "medium.tri", "large.tri"]

    unknown = run(installed, *query, "--reranker", "none-such")
    assert unknown.returncode == 2
    assert "there is no re-ranker 'none-such': there are by-size" in unknown.stderr


def test_a_model_uses_its_descriptor_and_detector(installed: Path, tmp_path: Path) -> None:
    program = f"""
from dataclasses import replace
from pathlib import Path
import numpy as np
import shapegoogle_core as sg
from shapegoogle_core.model.shape_bags import ChannelWords, shape_bags
from shapegoogle_core.model.working_shape import working_shape

mesh = sg.read_mesh({str(write_tri(tmp_path / "box.tri", 1))!r})
spectrum = sg.compute_spectrum(mesh, k=20)
keypoints = sg.detect_keypoints(mesh, spectrum, "far-points", least=0.3)
assert len(keypoints) == 8, len(keypoints)  # the corners
channel = sg.ChannelSettings("shells", {{"count": 5}}, words=4, bags=("plain",), detector="far-points")
assert channel.size == 5
assert sg.ChannelSettings("heights", {{}}).size == 6
settings = replace(sg.load_model("paper").settings, channels=(channel,), laplacian="robust")
words = ChannelWords(np.eye(5)[:4], 0.5)
bags = shape_bags(settings, (words,), working_shape(settings, mesh))
assert bags.shape == (4,) and abs(bags.sum() - 1) < 1e-6, bags
settings.from_dict(settings.to_dict())
Path({str(tmp_path / "settings.txt")!r}).write_text(repr(settings.to_dict()), "utf-8")
"""
    made = run(installed, "-c", program)
    assert made.returncode == 0, made.stderr
    # Without the package the model says what is missing.
    reading = f"""
import shapegoogle_core as sg
from ast import literal_eval
try:
    sg.ModelSettings.from_dict(literal_eval(open({str(tmp_path / "settings.txt")!r}).read()))
except sg.ModelError as error:
    print(error)
"""
    missing = run(tmp_path, "-c", reading)
    assert "not 'shells'; if a plug-in has it, install its package" in missing.stdout, missing.stderr


def test_a_damaged_file_of_its_format_is_named(installed: Path, tmp_path: Path) -> None:
    path = write_tri(tmp_path / "box.tri", 1)
    lines = path.read_text("utf-8").splitlines()
    for name, content in (("cut.tri", lines[:-3]), ("odd.tri", [*lines[:2], "1 2 x", *lines[3:]])):
        (tmp_path / name).write_text("\n".join(content), "utf-8")
    program = f"""
import shapegoogle_core as sg
for name in ("cut.tri", "odd.tri"):
    try:
        sg.read_mesh({str(tmp_path)!r} + "/" + name)
    except sg.MeshError as error:
        print(error)
"""
    cut, odd = run(installed, "-c", program).stdout.splitlines()
    assert cut == "'cut.tri' is cut short; copy or export it again"
    assert odd.startswith(
        "'odd.tri' cannot be read by the mesh format '.tri' of the package 'shapegoogle-example"
    )


def test_nothing_of_it_is_imported_unless_it_is_used(installed: Path, tmp_path: Path) -> None:
    path = tmp_path / "box.ply"
    trimesh.creation.box().export(path)
    program = f"""
import sys
import shapegoogle_core as sg
mesh = sg.read_mesh({str(path)!r})
sg.load_model().describe(mesh)
sg.find_meshes({str(tmp_path)!r})
assert not [name for name in sys.modules if name.startswith("shapegoogle_example")]
"""
    assert run(installed, "-c", program).returncode == 0
