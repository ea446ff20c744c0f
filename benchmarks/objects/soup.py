# SPDX-License-Identifier: MIT
"""`make_soup`: procedural things as polygon soup, like rigid models from the web.

Such models were made to be looked at. Sides that nobody sees are missing, or there are parts inside; parts
reach into each other or leave a gap; faces share no vertices, are turned to either side or lie there twice;
one part is tessellated finely and the next one coarsely, without common vertices where they meet.
"""

from __future__ import annotations

import zlib

import numpy as np

from benchmarks.objects.objects import object_parts
from benchmarks.objects.parts import Part, Parts, Random, box, moved
from shapegoogle_core.mesh import Mesh

__all__ = ["make_soup"]

# Largest number of faces of a part that is tessellated more finely.
_MOST_FACES = 1_500
# Faces within this angle of an axis belong to the side that is left out.
_FACING = np.cos(np.radians(35))


def make_soup(kind: str, seed: int) -> Mesh:
    """Make one member of a kind as polygon soup.

    Parameters
    ----------
    kind : str
        One of `OBJECT_KINDS`.
    seed : int
        Determines the thing, as in `make_object`, and what is wrong with it.

    Returns
    -------
    mesh : Mesh
        Upright (z).

    Raises
    ------
    ValueError
        If the kind does not exist.
    """
    random = np.random.default_rng([zlib.crc32(kind.encode()), seed, 1])
    parts = [part for part in object_parts(kind, seed) if len(part[1])]
    size = float(np.ptp(np.concatenate([vertices for vertices, _ in parts]), axis=0).max())
    sizes = [float(np.ptp(vertices, axis=0).max()) for vertices, _ in parts]
    kept = [
        part
        for part, own in zip(parts, sizes, strict=True)
        if own == max(sizes) or len(parts) < 3 or random.random() > 0.06
    ]
    unwelded = random.random()
    made: Parts = []
    for part in kept:
        part = _tessellated(part, random)
        if random.random() < 0.3:
            part = _opened(part, random)
        if random.random() < 0.4:
            part = _turned_over(part, random)
        if random.random() < 0.15:
            part = _doubled(part)
        if random.random() < unwelded:
            part = _unwelded(part)
        if random.random() < 0.3:
            part = moved(part, random.normal(size=3) * 0.01 * size)
        made.append(part)
    if random.random() < 0.3:
        made += _hidden(made, random)
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in made)])
    vertices = np.concatenate([vertices for vertices, _ in made])
    faces = np.concatenate([faces + start for (_, faces), start in zip(made, starts[:-1], strict=True)])
    return Mesh(vertices, faces[random.permutation(len(faces))], f"{kind} {seed} as soup")


def _tessellated(part: Part, random: Random) -> Part:
    """Divide all faces, or some of them, in four; neighbours of these keep their long edges."""
    for _ in range(int(random.choice([0, 0, 1, 2]))):
        vertices, faces = part
        divided = np.full(len(faces), True) if random.random() < 0.5 else random.random(len(faces)) < 0.5
        if not divided.any() or len(faces) > _MOST_FACES:
            break
        corners = vertices[faces[divided]]
        middles = (corners + np.roll(corners, -1, axis=1)) / 2
        first = len(vertices) + 3 * np.arange(len(corners))
        (a, b, c), (ab, bc, ca) = faces[divided].T, (first, first + 1, first + 2)
        quarters = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        smaller = np.concatenate([np.stack(quarter, axis=1) for quarter in quarters])
        part = np.concatenate([vertices, middles.reshape(-1, 3)]), np.concatenate([faces[~divided], smaller])
    return part


def _opened(part: Part, random: Random) -> Part:
    """Leave out one side, such as the bottom."""
    vertices, faces = part
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1)
    away = np.zeros(3)
    away[random.integers(3)] = random.choice([-1.0, 1.0])
    kept = normals @ away < _FACING * lengths
    return (vertices, faces[kept]) if kept.sum() >= len(faces) / 3 else part


def _turned_over(part: Part, random: Random) -> Part:
    """Let all faces, or some of them, face the other way."""
    vertices, faces = part
    over = random.random(len(faces)) < random.choice([0.5, 1.0])
    return vertices, np.where(over[:, None], faces[:, ::-1], faces)


def _doubled(part: Part) -> Part:
    """Add the back of each face."""
    vertices, faces = part
    return vertices, np.concatenate([faces, faces[:, ::-1]])


def _unwelded(part: Part) -> Part:
    """Give each face vertices of its own."""
    vertices, faces = part
    return vertices[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3)


def _hidden(parts: Parts, random: Random) -> Parts:
    """Make boxes inside of the largest parts, where nobody sees them."""
    largest = sorted(parts, key=lambda part: -float(np.ptp(part[0], axis=0).prod()))[:2]
    return [
        moved(
            box(np.ptp(vertices, axis=0) * random.uniform(0.2, 0.5, 3) + 1e-6),
            (vertices.min(axis=0) + vertices.max(axis=0)) / 2,
        )
        for vertices, _ in largest
    ]
