# SPDX-License-Identifier: MIT
"""Skeletons: bones, round cones around them, and poses.

Axes: x points to the creature's left, −y is forward, z is up. Lengths are free units; a creature is about 1
to 2 long.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["Bone", "Pose", "PoseRule", "RoundCone", "Skeleton", "SkeletonBuilder", "Vector", "Wave"]

FloatArray = NDArray[np.float64]
Vector = Sequence[float] | FloatArray
Points = ArrayLike | Sequence[Any]
Angles = tuple[float, float, float]

_MIRROR = np.array([-1.0, 1.0, 1.0])
# Deviations of individuals from the chains of their kind.
_LENGTH_FACTOR = (0.86, 1.16)
_GIRTH_FACTOR = (0.94, 1.2)


@dataclass(frozen=True)
class Wave:
    """Sinusoidal angles along a chain, for snakes, tails and tentacles.

    Parameters
    ----------
    bend, swing : float
        Amplitude in degrees, summed over half a wave.
    cycles : float
        Number of waves along the chain.
    phase : float
        Phase of the first bone, in turns.
    """

    bend: float = 0.0
    swing: float = 0.0
    cycles: float = 1.0
    phase: float = 0.0

    def angles(self, count: int) -> FloatArray:
        """Return the angles of the `count` bones of a chain, (count, 3) in degrees."""
        turns = self.phase + self.cycles * (np.arange(count) + 0.5) / count
        per_bone = np.sin(2 * np.pi * turns) * np.pi * max(self.cycles, 0.5) / count
        angles: FloatArray = np.outer(per_bone, [self.bend, self.swing, 0.0])
        return angles


PoseRule = Angles | Sequence[Angles] | Wave
"""Angles (bend, swing, twist) in degrees: one triple is spread evenly over the chain's bones, a list gives
each bone's own (bones after its end stay as they are), a `Wave` runs along the chain."""

Pose = Mapping[str, PoseRule]
"""Chain name to rule. The name of a mirrored chain without its side moves both sides."""


@dataclass(frozen=True)
class Bone:
    """A bone and its joint.

    `axes` holds the rotation axes of bend, swing and twist as rows, in rest coordinates.
    """

    chain: str
    parent: int
    head: FloatArray
    axes: FloatArray


@dataclass(frozen=True)
class RoundCone:
    """A tapered capsule, rigid on one bone, stretched by a factor along each world axis.

    The union of cones in a group is sharp; groups blend smoothly.
    """

    bone: int
    group: int
    start: FloatArray
    end: FloatArray
    start_radius: float
    end_radius: float
    stretch: FloatArray

    @property
    def thickness(self) -> float:
        """Least radius in any direction."""
        return float(min(self.start_radius, self.end_radius) * self.stretch.min())


@dataclass(frozen=True)
class Skeleton:
    """Bones (parents first), the solid around them, poses, and the number of handles (rings) of the solid."""

    bones: tuple[Bone, ...]
    cones: tuple[RoundCone, ...]
    blends: tuple[float, ...]
    poses: Mapping[str, Pose] = field(default_factory=dict)
    handles: int = 0

    def chains(self) -> dict[str, list[int]]:
        """Return the bone indices of every chain, in order."""
        indices: dict[str, list[int]] = {}
        for index, bone in enumerate(self.bones):
            indices.setdefault(bone.chain, []).append(index)
        return indices

    def varied(self, rng: np.random.Generator) -> Skeleton:
        """Return another individual with random lengths and thicknesses of chains, equal on both sides."""
        names = sorted({_both_sides(bone.chain) for bone in self.bones})
        lengths = dict(zip(names, rng.uniform(*_LENGTH_FACTOR, len(names)), strict=True))
        girths = dict(zip(names, rng.uniform(*_GIRTH_FACTOR, len(names)), strict=True))
        bones: list[Bone] = []
        for bone in self.bones:
            head = bone.head
            if bone.parent >= 0:
                old, new = self.bones[bone.parent], bones[bone.parent]
                head = new.head + lengths[_both_sides(old.chain)] * (bone.head - old.head)
            bones.append(replace(bone, head=head))
        cones = []
        for cone in self.cones:
            old, new = self.bones[cone.bone], bones[cone.bone]
            longer = lengths[_both_sides(old.chain)]
            thicker = longer * girths[_both_sides(old.chain)]
            cones.append(
                replace(
                    cone,
                    start=new.head + longer * (cone.start - old.head),
                    end=new.head + longer * (cone.end - old.head),
                    start_radius=thicker * cone.start_radius,
                    end_radius=thicker * cone.end_radius,
                )
            )
        return replace(self, bones=tuple(bones), cones=tuple(cones))

    def angles(self, pose: Pose) -> FloatArray:
        """Compute the angles of every bone for a pose.

        Parameters
        ----------
        pose : mapping of chain name to rule

        Returns
        -------
        angles : (bones, 3) array
            Bend, swing and twist in degrees.

        Raises
        ------
        KeyError
            If the pose names a chain that the skeleton does not have.
        """
        chains = self.chains()
        result = np.zeros((len(self.bones), 3))
        for name, rule in pose.items():
            matching = [chain for chain in (name, f"{name}.L", f"{name}.R") if chain in chains]
            if not matching:
                raise KeyError(f"no chain {name!r}; there are {sorted(chains)}")
            for chain in matching:
                bones = chains[chain]
                if isinstance(rule, Wave):
                    result[bones] += rule.angles(len(bones))
                    continue
                given = np.asarray(rule, float)
                if given.ndim == 1:
                    result[bones] += given / len(bones)
                else:
                    result[bones[: len(given)]] += given[: len(bones)]
        return result


def _both_sides(chain: str) -> str:
    """Return a chain's name without its side."""
    return chain.removesuffix(".L").removesuffix(".R")


def _direction(vector: FloatArray) -> FloatArray:
    length = float(np.linalg.norm(vector))
    if length == 0:
        raise ValueError("a bone must have a length")
    return vector / length


def _bone_axes(direction: FloatArray, toward: FloatArray, mirrored: bool) -> FloatArray:
    """Compute axes so that a positive bend rotates `direction` to `toward`; mirrored sides mirror it."""
    twist = _direction(direction)
    bend = _direction(np.cross(twist, toward))
    swing = np.cross(twist, bend)
    return np.stack([bend, -swing, -twist] if mirrored else [bend, swing, twist])


class SkeletonBuilder:
    """Collects chains of bones and the solid around them.

    Names of mirrored chains end in ".L" and ".R"; a part with a ".L" parent and `both_sides` also gets the
    corresponding ".R" parent. Bones are named by chain and number, "arm.L.0".
    """

    def __init__(self) -> None:
        self._bones: list[Bone] = []
        self._cones: list[RoundCone] = []
        self._blends: list[float] = []
        self._index: dict[str, int] = {}
        self._handles = 0

    def build(self, poses: Mapping[str, Pose]) -> Skeleton:
        """Return the finished skeleton; every pose must fit it."""
        skeleton = Skeleton(
            tuple(self._bones), tuple(self._cones), tuple(self._blends), dict(poses), self._handles
        )
        for pose in poses.values():
            skeleton.angles(pose)
        return skeleton

    def chain(
        self,
        name: str,
        points: Points,
        radii: Vector,
        *,
        parent: str | None = None,
        toward: Vector = (0, 0, -1),
        stretch: Vector = (1, 1, 1),
        blend: float = 0.5,
        both_sides: bool = False,
        bare: bool = False,
    ) -> None:
        """Add a chain of bones with a tapered capsule around each.

        Parameters
        ----------
        name : str
        points : (b + 1, 3) array_like
            Joints, from the one at the parent to the tip.
        radii : sequence of b + 1 floats
        parent : str, optional
            Bone that carries the chain; left out for the root.
        toward : vector
            A positive bend turns the chain's bones in this direction.
        stretch : vector
            Cross sections are stretched by these factors along x, y and z.
        blend : float
            Width of the smooth transition to other parts, in mean radii.
        both_sides : bool
            Add the mirror image (x → −x) as well.
        bare : bool
            Leave out the capsules: the bones get their solid from `stick`, `blob` and `ring`.
        """
        for side, mirror in self._sides(both_sides):
            joints = np.asarray(points, float) * mirror
            carrier = -1 if parent is None else self._find(parent, side)
            group = -1 if bare else self._new_group(blend * float(np.mean(radii)) * min(stretch))
            for number in range(len(joints) - 1):
                axes = _bone_axes(
                    joints[number + 1] - joints[number], np.asarray(toward, float) * mirror, side == ".R"
                )
                index = len(self._bones)
                self._bones.append(Bone(name + side, carrier, joints[number], axes))
                self._index[f"{name}{side}.{number}"] = index
                if not bare:
                    ends = joints[number : number + 2]
                    self._add_cone(index, group, ends, radii[number : number + 2], stretch)
                carrier = index

    def stick(
        self,
        bone: str,
        points: Points,
        radii: Vector,
        *,
        stretch: Vector = (1, 1, 1),
        blend: float = 0.4,
        both_sides: bool = False,
    ) -> None:
        """Add a rigid tapered poly-line to a bone: a horn, a beak. Parameters as for `chain`."""
        for side, mirror in self._sides(both_sides):
            joints = np.asarray(points, float) * mirror
            group = self._new_group(blend * float(np.mean(radii)) * min(stretch))
            carrier = self._find(bone, side)
            for number in range(len(joints) - 1):
                self._add_cone(
                    carrier, group, joints[number : number + 2], radii[number : number + 2], stretch
                )

    def blob(
        self, bone: str, centre: Vector, radii: Vector, *, blend: float = 0.4, both_sides: bool = False
    ) -> None:
        """Add a rigid ellipsoid with these half axes along x, y and z to a bone."""
        for side, mirror in self._sides(both_sides):
            point = np.asarray(centre, float) * mirror
            group = self._new_group(blend * min(radii))
            self._add_cone(self._find(bone, side), group, np.stack([point, point]), (1.0, 1.0), radii)

    def ring(
        self, bone: str, centre: Vector, half_axes: Points, thickness: float, *, both_sides: bool = False
    ) -> None:
        """Add a rigid elliptic ring to a bone; `half_axes` are its two half axes as (2, 3) vectors."""
        self._handles += 2 if both_sides else 1
        turns = np.linspace(0, 2 * np.pi, 17)
        circle = np.stack([np.cos(turns), np.sin(turns)], axis=1)
        loop = np.asarray(centre, float) + circle @ np.asarray(half_axes, float)
        self.stick(bone, loop, [thickness] * 17, both_sides=both_sides)

    @staticmethod
    def _sides(both: bool) -> list[tuple[str, FloatArray]]:
        return [(".L", np.ones(3)), (".R", _MIRROR)] if both else [("", np.ones(3))]

    def _find(self, bone: str, side: str) -> int:
        return self._index[bone.replace(".L.", ".R.") if side == ".R" else bone]

    def _new_group(self, blend: float) -> int:
        self._blends.append(blend)
        return len(self._blends) - 1

    def _add_cone(self, bone: int, group: int, ends: FloatArray, radii: Vector, stretch: Vector) -> None:
        self._cones.append(
            RoundCone(
                bone, group, ends[0], ends[1], float(radii[0]), float(radii[1]), np.asarray(stretch, float)
            )
        )
