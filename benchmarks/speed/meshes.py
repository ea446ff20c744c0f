# SPDX-License-Identifier: MIT
"""Meshes to measure with, and their files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from shapegoogle_core import Mesh

__all__ = ["KIND", "SEED", "creature", "write_mesh"]

# A creature that nothing was learnt from. Larger meshes are subdivisions of one with `LARGEST_CREATURE`
# vertices.
KIND, SEED, LARGEST_CREATURE = "horse", 100, 20_000


def creature(vertices: int, tolerance: float = 0.0) -> Mesh:
    """Make an irregular closed surface with this number of vertices.

    Parameters
    ----------
    vertices : int
    tolerance : float
        Largest relative deviation from the number of vertices; a mesh within it is not simplified.

    Returns
    -------
    mesh : Mesh
    """
    import numpy as np
    import trimesh

    from benchmarks.creatures import make_creature
    from shapegoogle_core import Mesh
    from shapegoogle_core.preprocessing.resampling import simplify

    mesh = make_creature(KIND, SEED, min(vertices, LARGEST_CREATURE)).rest
    while len(mesh.vertices) < (1 - tolerance) * vertices:
        # Smooth, because simplifying flat patches would leave slivers.
        finer = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).subdivide_loop(1)
        mesh = Mesh(np.asarray(finer.vertices), np.asarray(finer.faces, dtype=np.int32), name=mesh.name)
    return mesh if len(mesh.vertices) <= (1 + tolerance) * vertices else simplify(mesh, vertices)


def write_mesh(mesh: Mesh, path: Path) -> None:
    """Write a mesh as binary PLY or as OBJ, in single precision.

    Parameters
    ----------
    mesh : Mesh
    path : Path
        The suffix decides on the format.
    """
    import numpy as np

    if path.suffix == ".obj":
        with path.open("wb") as file:
            np.savetxt(file, mesh.vertices, "v %.7g %.7g %.7g")
            np.savetxt(file, mesh.faces + 1, "f %d %d %d")
        return
    faces = np.empty(len(mesh.faces), [("count", "u1"), ("vertices", "<i4", 3)])
    faces["count"], faces["vertices"] = 3, mesh.faces
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(mesh.vertices)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    path.write_bytes(header.encode() + mesh.vertices.astype("<f4").tobytes() + faces.tobytes())
