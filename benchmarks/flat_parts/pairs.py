# SPDX-License-Identifier: MIT
"""Versions of flat-sided parts, and pairs of parts with known relations."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.flat_parts.families import FAMILIES, FlatPart, make_parts
from benchmarks.flat_parts.tessellations import reordered, split_in_four
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.preprocessing.subdivision import subdivide

__all__ = ["PartPair", "PartVersion", "make_part_pairs", "versions"]


@dataclass(frozen=True, eq=False)
class PartVersion:
    """The same part again.

    Attributes
    ----------
    kind : str
        True relation to the part, one of `shapegoogle_core.library.evidence.KINDS`.
    detail : str
        Construction.
    mesh : Mesh
    factor : float
        Size relative to the part.
    """

    kind: str
    detail: str
    mesh: Mesh
    factor: float = 1.0


@dataclass(frozen=True, eq=False)
class PartPair:
    """Two parts; `kind` is "different" for members of a family that differ, and for other families.

    Attributes
    ----------
    kind, detail : str
    query, candidate : Mesh
    factor : float
    """

    kind: str
    detail: str
    query: Mesh
    candidate: Mesh
    factor: float = 1.0


def versions(part: FlatPart, random: np.random.Generator) -> list[PartVersion]:
    """Make versions of a part: copies, moved, scaled, reflected, and with other triangles.

    Parameters
    ----------
    part : FlatPart
    random : numpy.random.Generator

    Returns
    -------
    versions : list of PartVersion
    """
    mesh = part.mesh
    factor = float(np.exp(random.uniform(0.1, 1.5) * random.choice([-1, 1])))
    split = split_in_four(mesh)
    even = subdivide(mesh, 4 * len(mesh.vertices) + 400)
    reflected = Mesh(mesh.vertices * [-1, 1, 1], mesh.faces[:, ::-1].copy(), mesh.name)
    return [
        PartVersion("identical", "facets in another order", reordered(mesh, random)),
        PartVersion("moved", "moved, facets in another order", _moved(reordered(mesh, random), random)),
        PartVersion("scaled", "moved and scaled", _moved(mesh, random, factor), factor),
        PartVersion("mirrored" if part.chiral else "moved", "reflected", _moved(reflected, random)),
        PartVersion("re-meshed", "split in four", split),
        PartVersion("re-meshed", "even triangles", even),
        PartVersion("re-meshed", "even triangles, moved and scaled", _moved(even, random, factor), factor),
    ]


def make_part_pairs(family: str, seed: int = 0) -> list[PartPair]:
    """Pair each part of a family with its versions, with the other members, and with other families.

    Parameters
    ----------
    family : str
        Key of `FAMILIES`.
    seed : int, optional

    Returns
    -------
    pairs : list of PartPair
    """
    random = np.random.default_rng([seed, *family.encode()])
    parts = list(make_parts([family]))
    pairs = [
        PartPair(version.kind, version.detail, part.mesh, version.mesh, version.factor)
        for part in parts
        for version in versions(part, random)
    ]
    for first, second in combinations(parts, 2):
        detail = f"{family}: {first.name} / {second.name}"
        other = split_in_four(_moved(reordered(second.mesh, random), random))
        pairs.append(PartPair("different", detail, first.mesh, second.mesh))
        pairs.append(PartPair("different", f"{detail}, moved", second.mesh, _moved(first.mesh, random)))
        pairs.append(PartPair("different", f"{detail}, other triangles", first.mesh, other))
    families = list(FAMILIES)
    for number, part in enumerate(parts, start=1):
        stranger = next(make_parts([families[(families.index(family) + number) % len(families)]]))
        pairs.append(PartPair("different", "another family", part.mesh, stranger.mesh))
    return pairs


def _moved(mesh: Mesh, random: np.random.Generator, scale: float = 1.0) -> Mesh:
    turn = Rotation.random(random_state=int(random.integers(2**31))).as_matrix()
    shift: FloatArray = random.normal(size=3) * np.ptp(mesh.vertices, axis=0).max() * scale
    # As a file stores it.
    vertices = (scale * mesh.vertices @ turn.T + shift).astype(np.float32)
    return Mesh(vertices, mesh.faces, mesh.name)
