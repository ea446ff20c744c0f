# SPDX-License-Identifier: MIT
"""Flat-sided parts: closed solids of known volume, and versions that are what they say."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from benchmarks.flat_parts import FAMILIES, make_part_pairs, make_parts, versions
from shapegoogle_core.mesh import Mesh


def volume(mesh: Mesh) -> float:
    solid = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    assert solid.is_watertight
    return float(solid.volume)


@pytest.mark.parametrize("family", FAMILIES)
def test_parts_are_closed_and_differ(family: str) -> None:
    found = [(part.mesh.area, volume(part.mesh)) for part in make_parts([family])]
    assert min(size for _, size in found) > 0
    # A hole that is only elsewhere changes neither.
    assert len({(round(area, 6), round(size, 6)) for area, size in found}) >= len(found) - 1


def test_volumes_are_those_of_the_drawings() -> None:
    parts = {(part.family, part.name): part.mesh for part in make_parts(["sheet", "tray"])}
    assert volume(parts["sheet", "300 x 330"]) == pytest.approx(300 * 330 * 2)
    tray = 100 * 60 * 30 - 96 * 56 * 28
    assert volume(parts["tray", "100 mm long"]) == pytest.approx(tray)


def test_versions_keep_the_surface() -> None:
    (part, *_) = make_parts(["bracket"])
    for version in versions(part, np.random.default_rng(0)):
        area, size = version.mesh.area, volume(version.mesh)
        assert area == pytest.approx(part.mesh.area * version.factor**2, rel=1e-5)
        assert size == pytest.approx(volume(part.mesh) * version.factor**3, rel=1e-4)


@pytest.mark.long
def test_there_are_enough_pairs() -> None:
    pairs = [pair for family in FAMILIES for pair in make_part_pairs(family)]
    assert len(pairs) >= 400
    assert sum(pair.kind == "different" for pair in pairs) >= 200
