# SPDX-License-Identifier: MIT
"""One reader per file format: geometry only, strict about damage, bounded in memory.

Every reader is a function `read_<format>(path, max_faces) -> (vertices, faces)` that raises `FormatError`.

OBJ, PLY, STL and OFF are read here rather than with trimesh because trimesh 5.2 was seen to refuse sound
files (binary PLY with triangles beside quads, which Blender writes; any text that is not UTF-8) and to
return other geometry than the file holds without a word (relative OBJ indices in files of several objects,
index 0, tabs and leading blanks in OBJ; PLY, OFF and STL text that was cut short). glTF is read with
trimesh.
"""

from shapegoogle_core.mesh.formats.common import FormatError
from shapegoogle_core.mesh.formats.gltf import read_glb, read_gltf
from shapegoogle_core.mesh.formats.obj import read_obj
from shapegoogle_core.mesh.formats.off import read_off
from shapegoogle_core.mesh.formats.ply import read_ply
from shapegoogle_core.mesh.formats.stl import read_stl

__all__ = ["FormatError", "read_glb", "read_gltf", "read_obj", "read_off", "read_ply", "read_stl"]
