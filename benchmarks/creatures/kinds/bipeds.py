# SPDX-License-Identifier: MIT
"""People and apes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from benchmarks.creatures.layout import between
from benchmarks.creatures.skeleton import Pose, Skeleton, SkeletonBuilder, Vector

__all__ = ["BIPED_POSES", "KINDS", "add_arms", "add_human_head"]

Random = np.random.Generator
FloatArray = NDArray[np.float64]

_BACK = (0, 1, 0)

BIPED_POSES: dict[str, Pose] = {
    "stand": {"arm": [(10, 40, 0), (10, 0, 0)]},
    "walk": {
        "leg.L": [(-30, 0, 0), (12, 0, 0)],
        "leg.R": [(22, 0, 0), (25, 0, 0)],
        "arm.L": [(-25, 35, 0), (15, 0, 0)],
        "arm.R": [(40, 35, 0), (30, 0, 0)],
        "spine": (4, 0, 8),
    },
    "run": {
        "leg.L": [(-65, 0, 0), (75, 0, 0)],
        "leg.R": [(30, 0, 0), (55, 0, 0)],
        "arm.L": [(-35, 35, 0), (80, 0, 0)],
        "arm.R": [(45, 30, 0), (85, 0, 0)],
        "spine": (18, 0, 12),
        "neck": (-12, 0, 0),
    },
    "sit": {
        "leg": [(-85, 8, 0), (85, 0, 0)],
        "arm": [(45, 30, 0), (35, 0, 0)],
        "spine": (10, 0, 0),
    },
    "crouch": {
        "leg": [(-95, 18, 0), (115, 0, 0)],
        "arm": [(60, 20, 0), (20, 0, 0)],
        "spine": (40, 0, 0),
        "neck": (-25, 0, 0),
    },
    "reach": {
        "arm.L": [(15, -75, 0), (5, 0, 0)],
        "arm.R": [(10, 35, 0), (20, 0, 0)],
        "spine": (-6, -15, 0),
        "neck": (-20, 0, 0),
        "leg.R": [(15, 5, 0), (20, 0, 0)],
    },
    "kick": {
        "leg.L": [(-75, 10, 0), (10, 0, 0)],
        "leg.R": [(5, 0, 0), (12, 0, 0)],
        "arm.L": [(-30, 0, 0), (15, 0, 0)],
        "arm.R": [(60, -10, 0), (40, 0, 0)],
        "spine": (-10, 0, -15),
    },
    "bow": {"spine": (75, 0, 0), "neck": (20, 0, 0), "arm": [(35, 25, 0), (10, 0, 0)]},
    "wave": {
        "arm.L": [(10, -35, 0), (60, -40, 0)],
        "arm.R": [(20, 45, 0), (60, 0, 0)],
        "spine": (0, 8, 10),
        "neck": (0, -10, 15),
        "leg.R": [(-10, 8, 0), (15, 0, 0)],
    },
    "stretch": {"arm": [(0, -85, 0), (0, 0, 0)], "spine": (-12, 0, 0), "leg": [(0, 22, 0)]},
}


def add_arms(builder: SkeletonBuilder, parent: str, shoulder: Vector, length: float, radius: float) -> None:
    """Add arms in a relaxed A pose with mitten hands: upper arm, forearm, hand.

    Parameters
    ----------
    builder : SkeletonBuilder
    parent : str
        Bone that carries the arms.
    shoulder : (3,) array_like
        Left shoulder.
    length, radius : float
        Of an arm.
    """
    start = np.asarray(shoulder, float)
    out = np.array([0.8, 0.0, -0.6])
    elbow, wrist = start + 0.47 * length * out, start + 0.88 * length * out
    palm = start + 1.06 * length * out
    builder.chain(
        "arm",
        [start, elbow, wrist, palm],
        [1.25 * radius, radius, 0.75 * radius, 0.7 * radius],
        parent=parent,
        toward=(0, -1, 0),
        both_sides=True,
    )
    tip = start + 1.22 * length * out
    builder.stick("arm.L.2", [palm, tip], [0.75 * radius, 0.5 * radius], stretch=(1, 1.3, 1), both_sides=True)
    thumb = palm + np.array([0.02, -0.14, -0.02]) * length
    builder.stick(
        "arm.L.2", [wrist + 0.05 * length * out, thumb], [0.5 * radius, 0.4 * radius], both_sides=True
    )


def add_human_head(
    builder: SkeletonBuilder, parent: str, base: FloatArray, size: float, snout: float
) -> None:
    """Add neck and head with nose, ears and brow.

    Parameters
    ----------
    builder : SkeletonBuilder
    parent : str
        Bone that carries the neck.
    base : (3,) array
        Base of the neck.
    size : float
        Of the head.
    snout : float
        Length of the face in head sizes.
    """
    chin = base + np.array([0, -0.1, 0.85]) * size
    crown = chin + np.array([0, -0.1, 1.1]) * size
    builder.chain(
        "neck",
        [base, chin, crown],
        [0.5 * size, 0.44 * size, 0.4 * size],
        parent=parent,
        toward=(0, -1, 0),
        blend=0.3,
    )
    centre = chin + np.array([0, -0.1, 0.65]) * size
    builder.blob("neck.1", centre, (0.68 * size, 0.8 * size, 0.92 * size), blend=0.12)
    face = centre + np.array([0, -0.75 - 0.4 * snout, -0.35]) * size
    builder.stick("neck.1", [centre, face], [0.5 * size, (0.16 + 0.4 * snout) * size])
    builder.blob(
        "neck.1",
        centre + np.array([0.72, 0.1, 0]) * size,
        (0.14 * size, 0.22 * size, 0.3 * size),
        both_sides=True,
    )


def _biped(
    rng: Random,
    *,
    leg: float,
    torso: float,
    arm: float,
    girth: float,
    shoulders: float,
    head: float,
    snout: float,
) -> Skeleton:
    builder = SkeletonBuilder()
    belly = rng.uniform(0.85, 1.3)
    chest = rng.uniform(0.95, 1.15)
    hip = np.array([0, 0.0, leg])
    neck = hip + np.array([0, 0, torso])
    builder.chain(
        "spine",
        between(hip, neck, 3),
        np.array([1.0, 0.92 * belly, 1.12 * chest, 0.5]) * girth,
        toward=(0, -1, 0),
        blend=0.3,
        stretch=(1.25, 0.9, 1),
    )
    thick = girth * rng.uniform(0.5, 0.62)
    x = max(0.65 * girth, 1.25 * thick)
    ankle = 0.08 * leg
    builder.chain(
        "leg",
        [[x, 0, leg], [1.15 * x, -0.01, 0.53 * leg], [1.25 * x, 0.02, ankle]],
        [1.05 * thick, 0.72 * thick, 0.5 * thick],
        parent="spine.0",
        toward=_BACK,
        both_sides=True,
    )
    foot = rng.uniform(0.24, 0.32) * leg
    builder.stick(
        "leg.L.1",
        [[1.25 * x, 0.04 * leg, 0.6 * ankle], [1.4 * x, -foot, 0.5 * ankle]],
        [0.5 * thick, 0.42 * thick],
        stretch=(1.2, 1, 0.8),
        both_sides=True,
    )
    add_arms(
        builder,
        "spine.2",
        [shoulders, 0, leg + 0.9 * torso],
        arm,
        girth * rng.uniform(0.34, 0.42),
    )
    add_human_head(builder, "spine.2", neck, head, snout)
    return builder.build(BIPED_POSES)


def human(rng: Random) -> Skeleton:
    """Build a person."""
    girth = rng.uniform(0.105, 0.145)
    return _biped(
        rng,
        leg=rng.uniform(0.78, 0.95),
        torso=rng.uniform(0.5, 0.6),
        arm=rng.uniform(0.55, 0.68),
        girth=girth,
        shoulders=1.3 * girth + rng.uniform(0.0, 0.05),
        head=rng.uniform(0.105, 0.135),
        snout=0.0,
    )


def ape(rng: Random) -> Skeleton:
    """Build an ape: short legs, long arms, a heavy trunk and a muzzle."""
    girth = rng.uniform(0.15, 0.19)
    return _biped(
        rng,
        leg=rng.uniform(0.58, 0.68),
        torso=rng.uniform(0.52, 0.62),
        arm=rng.uniform(0.85, 1.05),
        girth=girth,
        shoulders=1.35 * girth,
        head=rng.uniform(0.13, 0.16),
        snout=rng.uniform(0.5, 0.9),
    )


KINDS: dict[str, Callable[[Random], Skeleton]] = {
    "human": human,
    "ape": ape,
}
