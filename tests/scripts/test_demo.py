# SPDX-License-Identifier: MIT
"""The demo: its shapes, its files, and the whole of it."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import demo
import numpy as np
import pytest
import trimesh
from lib import bootstrap, demo_creatures

from benchmarks.creatures import CREATURE_KINDS, make_creature
from shapegoogle_core.mesh import Mesh, read_mesh

SCRIPT = Path(demo.__file__)


def test_the_query_is_a_creature_of_the_library_in_a_pose_the_library_lacks() -> None:
    creature = make_creature(demo.QUERY_KIND, demo_creatures.INDIVIDUAL)
    assert demo.QUERY_KIND in demo_creatures.KINDS
    assert set(demo_creatures.KINDS) <= set(CREATURE_KINDS)
    assert demo.QUERY_POSE in creature.pose_names[demo_creatures.POSES_EACH :]
    query = demo.query_mesh()
    assert len(query.vertices) != len(creature.rest.vertices), "it is meshed anew"
    assert query.area == pytest.approx(demo.QUERY_SCALE**2 * creature.rest.area, rel=0.05)


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".glb"])
def test_meshes_are_written_once_and_read_back(bumpy_mesh: Mesh, tmp_path: Path, suffix: str) -> None:
    path = tmp_path / "new" / f"bumpy{suffix}"
    demo_creatures.write_mesh(path, bumpy_mesh)
    read = read_mesh(path)
    np.testing.assert_allclose(read.vertices, bumpy_mesh.vertices, atol=1e-6)
    np.testing.assert_array_equal(read.faces, bumpy_mesh.faces)

    written = path.stat().st_mtime_ns
    demo_creatures.write_mesh(path, bumpy_mesh)
    assert path.stat().st_mtime_ns == written, "an unchanged file would be indexed again"
    path.write_bytes(path.read_bytes()[:-10])
    demo_creatures.write_mesh(path, bumpy_mesh)
    np.testing.assert_array_equal(read_mesh(path).faces, bumpy_mesh.faces)


@pytest.fixture
def bumpy_mesh() -> Mesh:
    sphere = trimesh.creation.icosphere(2)
    heights = 1 + 0.2 * np.sin(5 * sphere.vertices[:, :1])
    return Mesh(sphere.vertices * heights, sphere.faces, "bumpy")


def test_without_bpy_one_line_says_why_the_part_in_blender_is_left_out(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(title: str, command: list[str]) -> None:
        raise bootstrap.SetupError(f"there is no Python for {command[command.index('--session') + 1]}")

    monkeypatch.setattr(bootstrap, "run", refuse)
    assert demo.blender_python() is None
    (line,) = capsys.readouterr().out.splitlines()
    assert line.startswith("The part in Blender is left out")
    assert all(f"no Python for addon-{series}" in line for series in demo.BLENDER_SERIES)


def test_another_blender_does_where_the_first_cannot_be_had(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse_first(title: str, command: list[str]) -> None:
        if f"addon-{demo.BLENDER_SERIES[0]}" in command:
            raise bootstrap.SetupError("no such Python")

    monkeypatch.setattr(bootstrap, "run", refuse_first)
    second = demo.BLENDER_SERIES[1].replace(".", "-")
    assert demo.blender_python() == bootstrap.python_of(bootstrap.ROOT / ".nox" / f"addon-{second}")
    assert not capsys.readouterr().out


def test_a_failure_in_blender_is_one_of_the_demo(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    # A module that ends with this code, whatever its arguments are.
    monkeypatch.setattr(demo, "BLENDER_PART", "failing")
    (tmp_path / "failing.py").write_text("import sys; sys.exit(3 if len(sys.argv) == 4 else 0)")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit, match="exit code 3"):
        demo.run_in_blender(Path(sys.executable))


@pytest.mark.long
def test_the_demo_finds_the_horse_again() -> None:
    result = subprocess.run([sys.executable, str(SCRIPT)], capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    # The name stands after the evidence and before the path.
    names = re.findall(r"^\d+ +[\d.]+ +[\d.]+ .+ (\S+) +\S+$", result.stdout, re.MULTILINE)
    assert len(names) == demo.MATCHES
    assert all(name.startswith("horse-") for name in names[: demo_creatures.POSES_EACH]), result.stdout
    if "left out" not in result.stdout:
        names = re.findall(r"^\d+ +[\d.]+  (.+?)  +×", result.stdout, re.MULTILINE)
        assert len(names) == demo.MATCHES
        assert all(name.startswith("Horse ") for name in names[:6]), result.stdout
    assert demo.PICTURE.stat().st_size > 50_000
