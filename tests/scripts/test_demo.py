# SPDX-License-Identifier: MIT
"""The demo: its shapes, its files, and the whole of it."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh

from benchmarks.creatures import CREATURE_KINDS, make_creature
from shapegoogle_core.mesh import Mesh, read_mesh

SCRIPT = Path(__file__).resolve().parents[2] / "scripts" / "demo.py"


def test_the_query_is_a_creature_of_the_library_in_a_pose_the_library_lacks(demo):
    creature = make_creature(demo.QUERY_KIND, demo.INDIVIDUAL)
    assert demo.QUERY_KIND in demo.KINDS
    assert set(demo.KINDS) <= set(CREATURE_KINDS)
    assert demo.QUERY_POSE in creature.pose_names[demo.POSES_EACH :]
    query = demo.query_mesh()
    assert len(query.vertices) != len(creature.rest.vertices), "it is meshed anew"
    assert query.area == pytest.approx(demo.QUERY_SCALE**2 * creature.rest.area, rel=0.05)


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".glb"])
def test_meshes_are_written_once_and_read_back(demo, bumpy_mesh, tmp_path, suffix):
    path = tmp_path / "new" / f"bumpy{suffix}"
    demo.write_mesh(path, bumpy_mesh)
    read = read_mesh(path)
    np.testing.assert_allclose(read.vertices, bumpy_mesh.vertices, atol=1e-6)
    np.testing.assert_array_equal(read.faces, bumpy_mesh.faces)

    written = path.stat().st_mtime_ns
    demo.write_mesh(path, bumpy_mesh)
    assert path.stat().st_mtime_ns == written, "an unchanged file would be indexed again"
    path.write_bytes(path.read_bytes()[:-10])
    demo.write_mesh(path, bumpy_mesh)
    np.testing.assert_array_equal(read_mesh(path).faces, bumpy_mesh.faces)


@pytest.fixture
def bumpy_mesh():
    sphere = trimesh.creation.icosphere(2)
    heights = 1 + 0.2 * np.sin(5 * sphere.vertices[:, :1])
    return Mesh(sphere.vertices * heights, sphere.faces, "bumpy")


def test_without_bpy_one_line_says_why_the_part_in_blender_is_left_out(demo, monkeypatch, capsys):
    def prepare(series):
        raise demo.environment.SetupError(f"there is no Python for Blender {series}")

    monkeypatch.setattr(demo.blenders, "prepare", prepare)
    assert demo.blender_python() is None
    (line,) = capsys.readouterr().out.splitlines()
    assert line.startswith("The part in Blender is left out")
    assert all(f"no Python for Blender {series}" in line for series in demo.BLENDER_SERIES)


def test_another_blender_does_where_the_first_cannot_be_had(demo, monkeypatch, capsys):
    def prepare(series):
        if series == demo.BLENDER_SERIES[0]:
            raise demo.environment.SetupError("no such Python")
        return Path("python-of", series)

    monkeypatch.setattr(demo.blenders, "prepare", prepare)
    assert demo.blender_python() == Path("python-of", demo.BLENDER_SERIES[1])
    assert not capsys.readouterr().out


def test_a_failure_in_blender_is_one_of_the_demo(demo, monkeypatch, tmp_path):
    failing = tmp_path / "failing.py"
    failing.write_text("import sys; sys.exit(3 if len(sys.argv) == 4 else 0)")
    monkeypatch.setattr(demo, "BLENDER_PART", failing)
    with pytest.raises(SystemExit, match="exit code 3"):
        demo.run_in_blender(Path(sys.executable))


@pytest.mark.long
def test_the_demo_finds_the_horse_again(demo):
    result = subprocess.run([sys.executable, str(SCRIPT)], capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    # The name stands after the evidence and before the path.
    names = re.findall(r"^\d+ +[\d.]+ +[\d.]+ .+ (\S+) +\S+$", result.stdout, re.MULTILINE)
    assert len(names) == demo.MATCHES
    assert all(name.startswith("horse-") for name in names[: demo.POSES_EACH]), result.stdout
    if "left out" not in result.stdout:
        names = re.findall(r"^\d+ +[\d.]+  (.+?)  +×", result.stdout, re.MULTILINE)
        assert len(names) == demo.MATCHES
        assert all(name.startswith("Horse ") for name in names[:6]), result.stdout
    assert demo.PICTURE.stat().st_size > 50_000
