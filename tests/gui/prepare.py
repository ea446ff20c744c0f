# SPDX-License-Identifier: MIT
"""Run inside a Blender without a window: install the zip, set it up as a user would, write .blend files.

    prepare.py ZIP LIBRARY FOLDER NAME|MESH|MESH...  NAME|...

For every NAME, FOLDER/NAME.blend is written, with an object for each of the .ply files. They are poses of one
creature: how high a vertex is in the first one, from 0 to 1, is in all of them its weight in the vertex group
"High" and how red it is in the colour attribute "Coat".
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import bpy

NAME = "bl_ext.user_default.shape_google"


def dress(item: Any, shares: Any) -> None:
    """Give an object what can be transferred."""
    group = item.vertex_groups.new(name="High")
    for vertex, share in enumerate(shares):
        group.add([vertex], share, "REPLACE")
    # Last: the first weight adds a layer to the mesh, after which attributes lie elsewhere.
    coat = item.data.color_attributes.new("Coat", "FLOAT_COLOR", "POINT")
    coat.data.foreach_set("color", [value for share in shares for value in (share, 0.2, 0.2, 1.0)])


def write_blend(path: Path, meshes: Any) -> None:
    """Save a file with one object for each mesh file, side by side."""
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)
    for number, mesh in enumerate(meshes):
        bpy.ops.wm.ply_import(filepath=mesh)
        item = bpy.context.view_layer.objects.active
        item.name = item.data.name = Path(mesh).stem
        item.location.x = 2.0 * number
        if not number:
            heights = [vertex.co.z for vertex in item.data.vertices]
            low, high = min(heights), max(heights)
            shares = [(height - low) / (high - low) for height in heights]
            item.asset_mark()
        dress(item, shares)
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)


def main(package: str, library: str, folder: str, *files: str) -> None:
    bpy.ops.extensions.package_install_files(filepath=package, repo="user_default", enable_on_install=True)
    preferences = bpy.context.preferences
    preferences.view.show_splash = False
    preferences.view.smooth_view = 0  # a view that is still turning cannot be turned further
    own = preferences.addons[NAME].preferences
    own.library = library
    own.jobs = 1  # slow enough to watch
    entry = own.folders.add()
    entry.name, entry.path = Path(folder).name, folder
    bpy.ops.wm.save_userpref()
    for line in files:
        name, *meshes = line.split("|")
        write_blend(Path(folder) / f"{name}.blend", meshes)


main(*sys.argv[sys.argv.index("--") + 1 :])
