# SPDX-License-Identifier: MIT
"""Names that say what a shape is, where its object has only the name that a program gave it."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

__all__ = ["file_based_name", "is_generic", "useful_name"]

# Words in the names that programs and exporters give to new objects, meshes and nodes.
_GENERIC = {
    *("mesh", "meshes", "object", "obj", "node", "geometry", "geo", "geom", "group", "grp", "part", "model"),
    *("shape", "scene", "root", "default", "untitled", "unnamed", "no", "name", "new", "tmp", "temp", "lod"),
    *("poly", "polygon", "polysurface", "primitive", "element", "item", "component", "body", "solid", "p"),
    *("entity", "layer", "instance", "cube", "box", "cylinder", "cyl", "sphere", "icosphere", "ico", "uv"),
    *("cone", "torus", "plane", "circle", "disc", "pyramid", "grid", "curve", "bezier", "bézier", "nurbs"),
    *("surf", "path", "patch", "surface", "text", "font", "mball", "lathe", "meta", "metaball", "capsule"),
    *("ellipsoid", "empty", "collection", "point", "cloud", "pointcloud", "line", "spline", "loft"),
    *("extrude", "sweep"),
}
# Runs of letters, split at capitals: "pCubeShape1" has three words.
_WORDS = re.compile(r"[^\W\d_A-Z]+|[A-Z][^\W\d_A-Z]*")


def is_generic(name: str) -> bool:
    """Whether a name is one that programs give to new objects.

    Parameters
    ----------
    name : str

    Returns
    -------
    generic : bool

    Examples
    --------
    >>> from shapegoogle_core.indexing.reading.naming import is_generic
    >>> [is_generic(name) for name in ("Cube.003", "Mesh_0", "Object_12", "pCylinderShape1", "")]
    [True, True, True, True, True]
    >>> [is_generic(name) for name in ("Cubicle", "Chair.003", "Ice Cube", "Suzanne")]
    [False, False, False, False]
    """
    return all(word.lower() in _GENERIC for word in _WORDS.findall(name))


def useful_name(object_name: str, others: Iterable[str]) -> str:
    """Choose the first name that says something.

    Parameters
    ----------
    object_name : str
    others : iterable of str
        Further names of the same thing, such as that of its mesh.

    Returns
    -------
    name : str
        Empty if all are generic.

    Examples
    --------
    >>> from shapegoogle_core.indexing.reading.naming import useful_name
    >>> useful_name("Cube.003", ["Mesh", "Oak chair"]), useful_name("Cube.003", ["Mesh"])
    ('Oak chair', '')
    """
    return next((name for name in (object_name, *others) if not is_generic(name)), "")


def file_based_name(path: Path, object_name: str, *, alone: bool) -> str:
    """Name a shape after its file, for want of a better name.

    Parameters
    ----------
    path : Path
    object_name : str
    alone : bool
        Whether the file has no other shape.

    Returns
    -------
    name : str

    Examples
    --------
    >>> from pathlib import Path
    >>> from shapegoogle_core.indexing.reading.naming import file_based_name
    >>> file_based_name(Path("oak.blend"), "Cube.003", alone=False)
    'oak (Cube.003)'
    """
    return path.stem if alone else f"{path.stem} ({object_name})"
