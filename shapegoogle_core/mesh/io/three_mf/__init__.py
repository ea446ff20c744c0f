# SPDX-License-Identifier: MIT
"""Reading 3MF, the format of print farms: a plate of objects, in millimetres.

`package` opens the zip, `model` parses the XML of its parts, `slicer` what slicers add, and `plate` puts the
objects in their places.

Not left to trimesh, whose reader needs lxml and networkx, which Blender does not have, and in version 5.2
ignores units, object types and required extensions.
"""

from __future__ import annotations

from shapegoogle_core.mesh.io.three_mf.plate import PlateObject, read_plate, read_three_mf

__all__ = ["PlateObject", "read_plate", "read_three_mf"]
