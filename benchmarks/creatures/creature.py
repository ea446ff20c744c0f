# SPDX-License-Identifier: MIT
"""Creatures: individuals of a kind, in poses."""

from __future__ import annotations

import zlib
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.creatures.kinds import bipeds, birds, crawlers, objects, quadrupeds, reptiles, swimmers
from benchmarks.creatures.skeleton import Skeleton
from benchmarks.creatures.skinning import pose_vertices, skin_weights
from benchmarks.creatures.surface import skin_mesh
from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh import Mesh

__all__ = ["CREATURE_KINDS", "Creature", "make_creature"]

FloatArray = NDArray[np.float64]

_KINDS: dict[str, Callable[[np.random.Generator], Skeleton]] = {
    **bipeds.KINDS,
    **quadrupeds.KINDS,
    **birds.KINDS,
    **reptiles.KINDS,
    **swimmers.KINDS,
    **crawlers.KINDS,
    **objects.KINDS,
}

CREATURE_KINDS: tuple[str, ...] = tuple(_KINDS)
"""The kinds that `make_creature` knows."""

# Random poses: factor of the kind's pose, and deviations of each chain and each bone.
_POSE_AMOUNT = (0.75, 1.05)
_CHAIN_FACTOR = (0.8, 1.15)
_JITTER_DEGREES = 5.0
# Attempts until the limbs of an individual are separate.
_ATTEMPTS = 6
# Fewer vertices do not represent all limbs.
_FEWEST_VERTICES = 500


@dataclass(frozen=True, eq=False)
class Creature:
    """One individual: a skeleton, its skin in rest pose, and skin weights.

    All poses have the faces of `rest`, so vertex i is the same point of the body in every pose.
    """

    kind: str
    seed: int
    skeleton: Skeleton
    rest: Mesh
    weights: FloatArray

    @property
    def pose_names(self) -> tuple[str, ...]:
        """Names of poses: "rest" and the poses of the kind."""
        return ("rest", *self.skeleton.poses)

    def pose(self, pose: int | str) -> Mesh:
        """Return the creature in a pose.

        Parameters
        ----------
        pose : int or str
            One of `pose_names`, or a seed: a random one of the kind's poses, more or less of it, with small
            random turns of every joint.

        Returns
        -------
        mesh : Mesh
            Nearly isometric to `rest`, with the same faces.

        Raises
        ------
        ValueError
            If the name is not one of `pose_names`.
        """
        if isinstance(pose, str):
            if pose not in self.pose_names:
                raise ValueError(f"a {self.kind} has no pose {pose!r}; it has {', '.join(self.pose_names)}")
            angles = self.skeleton.angles(self.skeleton.poses.get(pose, {}))
        else:
            angles = self._random_angles(
                np.random.default_rng([zlib.crc32(self.kind.encode()), self.seed, pose])
            )
        vertices = pose_vertices(self.skeleton, self.weights, self.rest.vertices, angles)
        return Mesh(vertices, self.rest.faces, f"{self.rest.name}-{pose}")

    def _random_angles(self, rng: np.random.Generator) -> FloatArray:
        names = list(self.skeleton.poses)
        angles = self.skeleton.angles(self.skeleton.poses[names[rng.integers(len(names))]])
        angles *= rng.uniform(*_POSE_AMOUNT)
        for bones in self.skeleton.chains().values():
            angles[bones] *= rng.uniform(*_CHAIN_FACTOR)
            # The deviation of a whole chain does not depend on its number of bones.
            spread = _JITTER_DEGREES / np.sqrt(len(bones))
            angles[bones] += np.clip(rng.normal(0, spread, (len(bones), 3)), -2 * spread, 2 * spread)
        return angles


def make_creature(kind: str, seed: int, vertex_count: int = 3000) -> Creature:
    """Make an individual of a kind.

    Parameters
    ----------
    kind : str
        One of `CREATURE_KINDS`.
    seed : int
        Determines proportions, thickness and number of parts.
    vertex_count : int
        Number of vertices, met within 1 %.

    Returns
    -------
    creature : Creature
        Its meshes are closed manifolds of one component.

    Raises
    ------
    ValueError
        If the kind is unknown or `vertex_count` is below 500.
    MeshError
        If no attempt results in a closed surface of this size with separate limbs, or it is too large.
    ImportError
        If scikit-image (the optional extra "demo") is not installed.
    """
    if kind not in _KINDS:
        raise ValueError(f"no creature kind {kind!r}; there are {', '.join(CREATURE_KINDS)}")
    if vertex_count < _FEWEST_VERTICES:
        raise ValueError(f"a creature needs at least {_FEWEST_VERTICES} vertices, not {vertex_count}")
    rng = np.random.default_rng([zlib.crc32(kind.encode()), seed])
    for _ in range(_ATTEMPTS):
        skeleton = _KINDS[kind](rng).varied(rng)
        skin = skin_mesh(skeleton, vertex_count)
        if skin is not None and _handles(skin) == skeleton.handles:
            break
    else:
        raise MeshError(
            f"'{kind}-{seed}': no draw gives one closed surface of {vertex_count} vertices, limbs apart; "
            "ask for another number of vertices or take another seed"
        )
    rest = Mesh(skin.vertices, skin.faces, f"{kind}-{seed}")
    return Creature(kind, seed, skeleton, rest, skin_weights(skeleton, rest))


def _handles(mesh: Mesh) -> int:
    """Compute the genus of a closed surface: V − E + F = 2 − 2g, and E = 3F/2."""
    return 1 - (len(mesh.vertices) - len(mesh.faces) // 2) // 2
