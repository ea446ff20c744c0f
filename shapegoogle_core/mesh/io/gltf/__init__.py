# SPDX-License-Identifier: MIT
"""Reading glTF, text and binary.

`container` takes the file apart, `json_object` checks its JSON, `accessors` read arrays of numbers, `meshes`
make triangles of them, and `scene` puts these in their places.

Not left to trimesh, which in version 5.2 ignores instancing, skins, default morph weights, sparse accessors
and required extensions, and loses the places of the nodes of a file without scenes.
"""

from __future__ import annotations

from shapegoogle_core.mesh.io.file import MeshFile
from shapegoogle_core.mesh.io.gltf.container import buffer_files, open_glb, open_gltf
from shapegoogle_core.mesh.io.gltf.scene import read_scene
from shapegoogle_core.mesh.io.polygons import Polygons

__all__ = ["buffer_files", "read_glb", "read_gltf"]


def read_glb(file: MeshFile) -> Polygons:
    """Read a binary glTF file; see `read_gltf`."""
    return read_scene(open_glb(file))


def read_gltf(file: MeshFile) -> Polygons:
    """Read a glTF file with the buffers that it names.

    Parameters
    ----------
    file : MeshFile

    Returns
    -------
    polygons : Polygons
        The meshes of all nodes of the scene, each in its place and in its default pose. Points alone if the
        scene has no triangles; lines are left out.

    Raises
    ------
    FormatError
        If the file is damaged, needs a file that is not in its folder or an extension that cannot be read,
        or has too many faces.
    """
    return read_scene(open_gltf(file))
