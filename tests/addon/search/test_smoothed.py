# SPDX-License-Identifier: MIT
"""A model with a subdivision modifier finds its base."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import trimesh

import shapegoogle_core as sg

CONES = 8


def test_subdivided_suzanne_is_a_version_of_suzanne(blender: Any, tmp_path: Path) -> None:
    bpy.ops.mesh.primitive_monkey_add()
    suzanne = bpy.context.object
    base = as_mesh(suzanne)
    suzanne.modifiers.new("Subdivision", "SUBSURF").levels = 2
    smooth = as_mesh(suzanne)
    assert len(smooth.faces) > 3 * len(base.faces)
    with sg.Library.open(tmp_path / "shapes.sglib") as library:
        # Cones came before her: by its bags a rounded head with open sockets is near to them.
        for number in range(CONES):
            cone = trimesh.creation.cone(radius=0.3 + 0.15 * number, height=2.5 - 0.2 * number, sections=24)
            library.add((cone.vertices, cone.faces), name=f"cone {number}")
        library.add(base, name="Suzanne")
        matches = library.query(smooth, top=3, explain=3)
    assert "Suzanne" in [match.name for match in matches]
    found = next(match for match in matches if match.name == "Suzanne")
    assert found.evidence is not None
    assert found.evidence.kind == "version"
    assert found.similarity > 0.9


def as_mesh(item: Any) -> sg.Mesh:
    """Read an object as its modifiers show it."""
    evaluated = item.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    mesh.calc_loop_triangles()
    vertices = [tuple(vertex.co) for vertex in mesh.vertices]
    faces = [tuple(triangle.vertices) for triangle in mesh.loop_triangles]
    evaluated.to_mesh_clear()
    return sg.Mesh(vertices, faces)
