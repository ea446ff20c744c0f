# SPDX-License-Identifier: GPL-3.0-or-later
"""The meshes of evaluated objects, written one after the other into a file.

It imports nothing but Python's own modules, since `reader` runs in a Blender without this add-on.
"""

from __future__ import annotations

import hashlib
from array import array
from typing import Any, BinaryIO

__all__ = ["MeshWriter", "what_is_empty"]


class MeshWriter:
    """Writes meshes into a file, as `shapegoogle_core.indexing.reading.external_reader` reads them.

    Parameters
    ----------
    output : file object

    Attributes
    ----------
    vertices, faces : list of int
        Their numbers for each mesh.
    starts : list of int
        Where each mesh begins in the file, in bytes.
    """

    def __init__(self, output: BinaryIO) -> None:
        self._output = output
        self.vertices: list[int] = []
        self.faces: list[int] = []
        self.starts: list[int] = []
        self._parts: dict[bytes, int] = {}

    def counts(self) -> list[dict[str, int]]:
        """Return the numbers of vertices and faces of each mesh, for the answer."""
        return [
            {"vertices": vertices, "faces": faces}
            for vertices, faces in zip(self.vertices, self.faces, strict=True)
        ]

    def write(self, positions: array[float], faces: array[int]) -> int:
        """Write a mesh; returns its number."""
        self.starts.append(self._output.tell())
        positions.tofile(self._output)
        faces.tofile(self._output)
        self.vertices.append(len(positions) // 3)
        self.faces.append(len(faces) // 3)
        return len(self.faces) - 1

    def write_part(self, evaluated: Any) -> int | None:
        """Write the mesh of an evaluated object, unless it was written as a part before.

        Returns
        -------
        number : int or None
            None without a mesh.
        """
        try:
            positions, faces = self.read(evaluated)
        except RuntimeError:
            return None
        if not positions:
            return None
        digest = hashlib.blake2b(positions, digest_size=16)
        digest.update(faces)
        number = self._parts.get(digest.digest())
        if number is None:
            number = self._parts[digest.digest()] = self.write(positions, faces)
        return number

    def read(self, evaluated: Any) -> tuple[array[float], array[int]]:
        """Coordinates and triangles of an evaluated object, in its own space.

        A mesh without triangles gets no vertices either: wires and single points are helpers, not shapes.

        Raises
        ------
        RuntimeError
            If it has no mesh.
        """
        faces = array("i")
        if evaluated.type == "POINTCLOUD":
            return _positions(evaluated.data.points), faces
        mesh = evaluated.to_mesh()
        if mesh is None:
            return array("f"), faces
        try:
            mesh.calc_loop_triangles()
            faces = array("i", bytes(12 * len(mesh.loop_triangles)))
            mesh.loop_triangles.foreach_get("vertices", faces)
            return _positions(mesh.vertices) if faces else array("f"), faces
        finally:
            evaluated.to_mesh_clear()


def what_is_empty(item: Any, kind: str) -> str:
    """Say in a report what an object without a surface is.

    Parameters
    ----------
    item : bpy.types.Object
    kind : str
        What its shape would be called.
    """
    if kind == "metaball":  # only one ball of a family has the mesh of all
        return "metaball element"
    if kind != "object":
        return f"empty {kind}"
    # Wires and single points, such as a scan, are not empty.
    return "mesh without faces" if len(item.data.vertices) else "empty mesh"


def _positions(points: Any) -> array[float]:
    positions = array("f", bytes(12 * len(points)))
    points.foreach_get("co", positions)
    return positions
