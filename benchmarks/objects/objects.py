# SPDX-License-Identifier: MIT
"""`make_object`: a member of a kind of procedural things."""

from __future__ import annotations

import zlib

import numpy as np

from benchmarks.objects.kinds import buildings, furniture, nature, solids, tools, vehicles, vessels
from benchmarks.objects.parts import Maker, Parts
from shapegoogle_core.mesh import Mesh

__all__ = ["OBJECT_KINDS", "make_object", "object_parts"]

_KINDS: dict[str, Maker] = {
    **solids.KINDS,
    **vessels.KINDS,
    **furniture.KINDS,
    **tools.KINDS,
    **vehicles.KINDS,
    **buildings.KINDS,
    **nature.KINDS,
}

OBJECT_KINDS: tuple[str, ...] = tuple(_KINDS)
"""The kinds that `make_object` knows."""


def make_object(kind: str, seed: int) -> Mesh:
    """Make one member of a kind.

    Parameters
    ----------
    kind : str
        One of `OBJECT_KINDS`.
    seed : int
        Determines proportions, and number and form of the parts.

    Returns
    -------
    mesh : Mesh
        Upright (z); of one part or several loose ones.

    Raises
    ------
    ValueError
        If the kind does not exist.
    """
    parts = object_parts(kind, seed)
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    vertices = np.concatenate([vertices for vertices, _ in parts])
    faces = np.concatenate([faces + start for (_, faces), start in zip(parts, starts[:-1], strict=True)])
    return Mesh(vertices, faces, f"{kind} {seed}")


def object_parts(kind: str, seed: int) -> Parts:
    """Make the parts of a member of a kind; see `make_object`."""
    if kind not in _KINDS:
        raise ValueError(f"no kind of object {kind!r}; there are {', '.join(OBJECT_KINDS)}")
    return _KINDS[kind](np.random.default_rng([zlib.crc32(kind.encode()), seed]))
