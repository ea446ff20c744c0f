# SPDX-License-Identifier: MIT
"""The readers that are compared, and what they make of a file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from benchmarks.experiments.files.facts import Facts
from shapegoogle_core.mesh import MESH_SUFFIXES

__all__ = [
    "BLENDER",
    "BLENDER_SUFFIXES",
    "PRODUCT",
    "READERS",
    "SUFFIXES",
    "Limits",
    "Parts",
    "Reading",
    "readers_of",
]

PRODUCT, BLENDER = "product", "Blender"
READERS = (PRODUCT, "trimesh", "meshio", BLENDER)
"""All readers, the product first."""

BLENDER_SUFFIXES = frozenset({".blend", ".fbx"})
"""Suffixes of the files that the product reads through Blender."""

_SUFFIXES = {
    PRODUCT: MESH_SUFFIXES,
    "trimesh": frozenset({".3mf", ".glb", ".gltf", ".obj", ".off", ".ply", ".stl", ".xyz"}),
    "meshio": frozenset({".obj", ".off", ".ply", ".stl"}),
    BLENDER: frozenset({".blend", ".fbx", ".glb", ".gltf", ".obj", ".ply", ".stl"}),
}
SUFFIXES = frozenset().union(*_SUFFIXES.values())
"""Suffixes of all files that any of the readers reads, in lower case with the dot."""

Parts = list[tuple[str, Facts]]


@dataclass(frozen=True)
class Limits:
    """What a reader may need for one file.

    Attributes
    ----------
    jobs : int
        Number of processes of each reader.
    seconds : float
    megabytes : int
        Enforced on Linux only, and not for Blender.
    """

    jobs: int
    seconds: float
    megabytes: int


@dataclass(frozen=True)
class Reading:
    """What one reader made of one file.

    Attributes
    ----------
    reader : str
        One of `READERS`.
    path : Path
    status : str
        "read"; "nothing" if it read neither faces nor points; "refused"; for the product "failed" if it
        raised anything but its own error; "time" or "crash" if it had to be ended, or ended itself.
    parts : list of (str, Facts)
        The objects of a .blend file by name; other files have one part, "".
    message : str
        Why it read nothing.
    seconds : float
    """

    reader: str
    path: Path
    status: str
    parts: Parts
    message: str = ""
    seconds: float = 0.0


def readers_of(suffix: str, blender: bool) -> list[str]:
    """Name the readers that read files with a suffix.

    Parameters
    ----------
    suffix : str
        In lower case with the dot.
    blender : bool
        Whether there is a Blender; the product needs it too for some formats.

    Returns
    -------
    readers : list of str
        Some of `READERS`; the product is always among them, unless it lacks the Blender that it needs.
    """
    if suffix in BLENDER_SUFFIXES:
        return [PRODUCT, BLENDER] if blender else []
    others = [reader for reader in READERS[1:] if suffix in _SUFFIXES[reader]]
    return [PRODUCT, *(reader for reader in others if blender or reader != BLENDER)]
