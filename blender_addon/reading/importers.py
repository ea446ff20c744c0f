# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of other programs that Blender imports.

It imports nothing but bpy, since `reader` runs in a Blender without this add-on.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy

__all__ = ["import_file", "importable_suffixes", "importer_of", "is_importable"]

# Operators by suffix, with their options; the first that this Blender has is used. Blender 4.5 has its own
# importer of .fbx, earlier ones an add-on; Blender 5.0 has none of Collada any more.
_USD = (("wm.usd_import", {"set_frame_range": False}),)
_OPERATORS: dict[str, tuple[tuple[str, dict[str, Any]], ...]] = {
    ".fbx": (("wm.fbx_import", {"use_anim": False}), ("import_scene.fbx", {"use_anim": False})),
    ".usd": _USD,
    ".usda": _USD,
    ".usdc": _USD,
    ".usdz": _USD,
    ".abc": (("wm.alembic_import", {"as_background_job": False, "set_frame_range": False}),),
    ".dae": (("wm.collada_import", {}),),
    ".svg": (("import_curve.svg", {}),),
}


def importable_suffixes() -> tuple[str, ...]:
    """Return the suffixes of files that this Blender imports and the core does not read.

    Returns
    -------
    suffixes : tuple of str
        In lower case with the dot.
    """
    return tuple(suffix for suffix in _OPERATORS if importer_of(suffix) is not None)


def is_importable(suffix: str) -> bool:
    """Whether some version of Blender imports files with a suffix; see `importer_of`."""
    return suffix in _OPERATORS


def importer_of(suffix: str) -> tuple[Any, dict[str, Any]] | None:
    """Return the operator that imports files with a suffix.

    Parameters
    ----------
    suffix : str
        In lower case with the dot.

    Returns
    -------
    importer : (callable, dict) or None
        The operator and its options; None if this Blender has none.
    """
    for name, options in _OPERATORS.get(suffix, ()):
        module, _, operator = name.partition(".")
        if operator in dir(getattr(bpy.ops, module)):
            return getattr(getattr(bpy.ops, module), operator), options
    return None


def import_file(path: Path) -> None:
    """Import a file into an empty scene.

    Parameters
    ----------
    path : Path

    Raises
    ------
    RuntimeError
        If Blender cannot read it.
    """
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    importer = importer_of(path.suffix.lower())
    if importer is None:
        raise RuntimeError(f"Blender {bpy.app.version_string} imports no {path.suffix} files")
    operator, options = importer
    if operator(filepath=str(path), **options) != {"FINISHED"}:
        raise RuntimeError("its importer gives up")
