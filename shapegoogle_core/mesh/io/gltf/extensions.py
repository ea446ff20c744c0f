# SPDX-License-Identifier: MIT
"""Extensions of glTF: those that are read, and those that leave the geometry alone."""

from __future__ import annotations

import re
from collections.abc import Iterable

from shapegoogle_core.mesh.io.file import FormatError

__all__ = ["DRACO", "INSTANCING", "MESHOPT", "check_extensions"]

DRACO = "KHR_draco_mesh_compression"
INSTANCING = "EXT_mesh_gpu_instancing"
MESHOPT = ("EXT_meshopt_compression", "KHR_meshopt_compression")

_READ = frozenset({DRACO, INSTANCING, *MESHOPT, "KHR_mesh_quantization"})

# Materials, textures, lights, sound, meaning and behaviour, of whatever vendor: without them, the surface is
# the same.
_WITHOUT_GEOMETRY = re.compile(
    r"VRM|AGI_|OMI_|[A-Z0-9]+_(animation_pointer|audio|feature_metadata|instance_features|interactivity|lights_"
    r"|lod|materials_|mesh_features|node_(hoverability|selectability|visibility)|packing_|physics_|primitive_outline"
    r"|property_|single_root|structural_metadata|techniques?_|texture_|xmp)"
)
"""Beginnings of their names."""


def check_extensions(required: Iterable[str]) -> None:
    """Raise `FormatError` if a file requires an extension that is unknown and may change its geometry."""
    unknown = [name for name in required if name not in _READ and not _WITHOUT_GEOMETRY.match(name)]
    if unknown:
        names = ", ".join(name[:60] for name in sorted(set(unknown))[:5])
        raise FormatError(
            f"requires the glTF extension {names}, which cannot be read; export it without this extension"
        )
