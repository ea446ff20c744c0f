# SPDX-License-Identifier: MIT
"""Everyday things: individuals of a kind, built and tessellated as differently as models from many hands."""

from __future__ import annotations

import zlib
from collections.abc import Callable

import numpy as np

from benchmarks.things.kinds import (
    aircraft,
    buildings,
    devices,
    furniture,
    instruments,
    machines,
    plants,
    seats,
    tools,
    vehicles,
    vessels,
    watercraft,
    wearables,
)
from benchmarks.things.part import Part, join
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.mesh import FloatArray, IntArray

__all__ = ["THING_KINDS", "make_thing"]

_KINDS: dict[str, Callable[[np.random.Generator], list[Part]]] = {
    **seats.KINDS,
    **furniture.KINDS,
    **vessels.KINDS,
    **vehicles.KINDS,
    **aircraft.KINDS,
    **watercraft.KINDS,
    **tools.KINDS,
    **machines.KINDS,
    **devices.KINDS,
    **instruments.KINDS,
    **buildings.KINDS,
    **plants.KINDS,
    **wearables.KINDS,
}

THING_KINDS: tuple[str, ...] = tuple(_KINDS)
"""The kinds that `make_thing` knows."""

# Largest logarithms of the factors of the whole object along its axes and of each part about its middle, and
# how much narrower or wider the top is than the bottom.
_STRETCH = 0.28
_PART_STRETCH = 0.13
_TAPER = 0.15
# Share of parts that are missing.
_MISSING = 0.06
# Shares of objects whose triangles do not share vertices, and that have some faces inside out or doubled.
_SOUP = 0.4
_FLIPPED = 0.3
_DOUBLED = 0.15


def make_thing(kind: str, seed: int) -> Mesh:
    """Make an individual of a kind.

    Parameters
    ----------
    kind : str
        One of `THING_KINDS`.
    seed : int
        Determines construction, proportions, details and tessellation.

    Returns
    -------
    mesh : Mesh
        Up is z and the front faces -y, in any unit. Like models of many hands it is a union of loose parts
        that interpenetrate; its triangles may share no vertices, be doubled or be inside out.

    Raises
    ------
    ValueError
        If the kind is unknown.
    """
    if kind not in _KINDS:
        raise ValueError(f"no kind of thing {kind!r}; there are {', '.join(THING_KINDS)}")
    rng = np.random.default_rng([zlib.crc32(kind.encode()), seed])
    whole = _tessellated(_varied(_KINDS[kind](rng), rng), rng)
    return Mesh(whole.vertices, whole.faces, f"{kind}-{seed}")


def _varied(parts: list[Part], rng: np.random.Generator) -> Part:
    """Join parts of other proportions, some of them missing."""
    kept = [part for number, part in enumerate(parts) if number == 0 or rng.random() > _MISSING]
    stretched = []
    for part in kept:
        middle = (part.vertices.min(axis=0) + part.vertices.max(axis=0)) / 2
        factors = np.exp(rng.uniform(-_PART_STRETCH, _PART_STRETCH, 3))
        stretched.append(part.at(*-middle).scaled(*factors).at(*middle))
    whole = join(stretched).scaled(*np.exp(rng.uniform(-_STRETCH, _STRETCH, 3)))
    low, height = whole.vertices[:, 2].min(), max(float(np.ptp(whole.vertices[:, 2])), 1e-9)
    share = (whole.vertices[:, 2] - low) / height - 0.5
    taper = 1 + 2 * rng.uniform(-_TAPER, _TAPER) * share
    return Part(whole.vertices * np.column_stack([taper, taper, np.ones(len(taper))]), whole.faces)


def _tessellated(part: Part, rng: np.random.Generator) -> Part:
    vertices, faces = part.vertices, part.faces
    extent = float(np.ptp(vertices, axis=0).max())
    fineness = rng.choice([0, 0, 6, 12, 25])
    if fineness:
        vertices, faces = _split_long_edges(vertices, faces, extent / fineness)
    if rng.random() < _DOUBLED:
        faces = np.concatenate([faces, faces[: len(faces) // 3]])
    if rng.random() < _FLIPPED:
        flipped = rng.random(len(faces)) < rng.uniform(0.1, 0.6)
        faces = np.where(flipped[:, None], faces[:, ::-1], faces)
    if rng.random() < _SOUP:
        return Part(vertices[faces].reshape(-1, 3), np.arange(faces.size, dtype=np.int32).reshape(-1, 3))
    return Part(vertices, faces)


def _split_long_edges(
    vertices: FloatArray, faces: IntArray, longest: float, rounds: int = 6
) -> tuple[FloatArray, IntArray]:
    """Halve the longest edge of each triangle while it is too long, which may leave T-junctions."""
    corners = vertices[faces]
    done = []
    for _ in range(rounds):
        lengths = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)
        long = lengths.max(axis=1) > longest
        done.append(corners[~long])
        edge = lengths[long].argmax(axis=1)
        rows = np.arange(len(edge))
        a, b, c = (corners[long][rows, (edge + step) % 3] for step in range(3))
        middle = (a + b) / 2
        corners = np.concatenate([np.stack([a, middle, c], 1), np.stack([middle, b, c], 1)])
        if not len(corners) or sum(map(len, done)) + len(corners) > 30_000:
            break
    split = np.concatenate([*done, corners])
    points, index = np.unique(split.reshape(-1, 3).round(9), axis=0, return_inverse=True)
    return points, index.reshape(-1, 3).astype(np.int32)
