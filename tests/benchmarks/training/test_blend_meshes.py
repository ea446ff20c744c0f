# SPDX-License-Identifier: MIT
"""The parts of the export of .blend meshes that need no Blender."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.training import blend_meshes

RANGES = st.lists(
    st.tuples(st.floats(-100, 100), st.floats(0, 500)).map(lambda pair: (pair[0], sum(pair))),
    min_size=1,
    max_size=15,
)


@settings(deadline=None, max_examples=60)
@given(ranges=RANGES, count=st.integers(0, 40))
def test_frames_are_spread_evenly_over_the_actions(ranges: list[tuple[float, float]], count: int) -> None:
    frames = blend_meshes.spread_frames(ranges, count)
    assert len(frames) == count
    assert frames == sorted(frames)
    assert all(ranges[action][0] <= frame <= ranges[action][1] for action, frame in frames)
    shares = [sum(action == index for action, _ in frames) for index in range(len(ranges))]
    assert max(shares) - min(shares) <= 1


def test_frames_of_one_action_avoid_its_ends() -> None:
    assert blend_meshes.spread_frames([(10, 20)], 2) == [(0, 12.5), (0, 17.5)]
    assert blend_meshes.spread_frames([(0, 10), (0, 200)], 2) == [(0, 5), (1, 100)]
    assert blend_meshes.spread_frames([], 3) == []


def test_blend_files_are_found_in_order_and_named_after_their_folders(tmp_path: Path) -> None:
    for name in (
        "pack/b.blend",
        "pack/a.blend",
        "pack/old/c.blend",
        "other/d.blend",
        "top.blend",
        "pack/e.ply",
    ):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    sources = blend_meshes.find_blend_files([tmp_path], exclude=["other", "b"])
    assert [source.shape for source in sources] == ["pack-a", "pack-old-c", f"{tmp_path.name}-top"]


@pytest.mark.parametrize("face_count", [0, 1, 5])
def test_ply_files_read_back_exactly(tmp_path: Path, face_count: int) -> None:
    random = np.random.default_rng(0)
    vertices = random.standard_normal((12, 3)).astype(np.float32)
    faces = random.integers(0, 12, (face_count, 3)).astype(np.int32)
    blend_meshes.write_ply(tmp_path / "mesh.ply", vertices, faces)
    loaded: Any = trimesh.load(tmp_path / "mesh.ply", process=False)
    np.testing.assert_array_equal(np.asarray(loaded.vertices, np.float32), vertices)
    if face_count:
        np.testing.assert_array_equal(loaded.faces, faces)
