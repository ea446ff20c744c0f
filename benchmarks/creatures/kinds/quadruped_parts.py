# SPDX-License-Identifier: MIT
"""Parts and poses that four-legged mammals have in common."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from benchmarks.creatures.layout import between
from benchmarks.creatures.skeleton import Pose, SkeletonBuilder, Vector

__all__ = [
    "BACK",
    "FORWARD",
    "QUADRUPED_POSES",
    "UP",
    "add_ears",
    "add_legs",
    "add_neck_and_head",
    "add_tail",
    "add_torso",
]

FloatArray = NDArray[np.float64]

FORWARD = np.array([0.0, -1.0, 0.0])
UP = np.array([0.0, 0.0, 1.0])
BACK = (0, 1, 0)

QUADRUPED_POSES: dict[str, Pose] = {
    "walk": {
        "hind.L": [(-28, 0, 0), (18, 0, 0)],
        "hind.R": [(20, 0, 0), (10, 0, 0)],
        "fore.L": [(22, 0, 0), (12, 0, 0)],
        "fore.R": [(-28, 0, 0), (25, 0, 0)],
        "neck": (6, 8, 0),
    },
    "gallop": {
        "hind": [(38, 0, 0), (5, 0, 0)],
        "fore": [(-48, 0, 0), (8, 0, 0)],
        "spine": (-14, 0, 0),
        "neck": (18, 0, 0),
        "tail": (25, 0, 0),
    },
    "gather": {
        "hind": [(-42, 0, 0), (25, 0, 0)],
        "fore": [(32, 0, 0), (35, 0, 0)],
        "spine": [(-16, 0, 0), (16, 0, 0), (14, 0, 0)],
        "neck": (-8, 0, 0),
    },
    "sit": {
        "spine": [(-36, 0, 0), (-6, 0, 0)],
        "hind": [(-52, 12, 0), (100, 0, 0), (-55, 0, 0)],
        "fore": [(38, 0, 0), (4, 0, 0)],
        "neck": (22, 0, 0),
    },
    "rear": {
        "spine": [(-48, 0, 0), (-8, 0, 0)],
        "hind": [(35, 0, 0), (12, 0, 0), (-10, 0, 0)],
        "fore.L": [(-25, 0, 0), (75, 0, 0)],
        "fore.R": [(-50, 0, 0), (85, 0, 0)],
        "neck": (22, 0, 0),
        "tail": (-20, 0, 0),
    },
    "graze": {"neck": (62, 10, 0), "head": (5, 0, 0), "fore.L": [(-14, 0, 0)], "fore.R": [(12, 0, 0)]},
    "look back": {"neck": (0, 55, 0), "head": (0, 25, 0), "spine": (0, 18, 0), "tail": (0, 35, 0)},
    "lie": {
        "hind": [(-65, 10, 0), (110, 0, 0), (-75, 0, 0)],
        "fore": [(-55, 6, 0), (100, 0, 0)],
        "neck": (-10, -12, 0),
    },
    "kick": {
        "spine": [(22, 0, 0)],
        "hind": [(58, 0, 0), (-5, 0, 0)],
        "fore": [(-25, 0, 0)],
        "neck": (12, 0, 0),
        "tail": (30, 0, 0),
    },
}


def add_torso(
    builder: SkeletonBuilder, length: float, height: float, radii: Vector, wide: float = 0.9
) -> None:
    """Add the spine from hips to chest.

    Parameters
    ----------
    builder : SkeletonBuilder
    length, height : float
    radii : (4,) array_like
        At hips, waist, ribs and chest.
    wide : float
        Width over depth.
    """
    spine = between([0, length / 2, height], [0, -length / 2, height], 3)
    builder.chain("spine", spine, radii, stretch=(wide, 1, 1))


def add_legs(
    builder: SkeletonBuilder,
    length: float,
    height: float,
    spread: float,
    thick: float,
    thin: float,
    foot: float,
) -> None:
    """Add hind legs with a hock, and fore legs, from the torso down to the ground.

    Parameters
    ----------
    builder : SkeletonBuilder
    length, height : float
        Of the torso.
    spread : float
        Distance of the legs from the middle.
    thick, thin : float
        Radii at hip and ankle.
    foot : float
        Length of the foot.
    """
    middle = 0.55 * thick + 0.45 * thin
    hind, fore = 0.46 * length, -0.44 * length
    ankle = 0.9 * thin
    for name, y, knee, hock, parent in (
        ("hind", hind, -0.1, 0.14, "spine.0"),
        ("fore", fore, 0.06, -0.01, "spine.2"),
    ):
        x = np.array([spread, spread, 1.05 * spread, 1.05 * spread])
        depth = y + np.array([0, knee, hock, 0.55 * hock]) * height
        z = np.array([0.95 * height, 0.56 * height, 0.28 * height, ankle])
        builder.chain(
            name,
            np.stack([x, depth, z], axis=1),
            [thick, middle, thin, 0.95 * thin],
            parent=parent,
            toward=BACK,
            both_sides=True,
        )
        toe = [1.05 * spread, depth[3] - foot, 0.8 * thin]
        builder.stick(f"{name}.L.2", [[x[3], depth[3], ankle], toe], [thin, 0.85 * thin], both_sides=True)


def add_neck_and_head(
    builder: SkeletonBuilder,
    base: FloatArray,
    direction: FloatArray,
    length: float,
    radii: tuple[float, float],
    head: float,
    muzzle: float,
    segments: int = 2,
) -> tuple[FloatArray, FloatArray]:
    """Add neck, skull, muzzle and eye bumps.

    Parameters
    ----------
    builder : SkeletonBuilder
    base : (3,) array
        Of the neck.
    direction : (3,) array
        Of the neck.
    length : float
        Of the neck.
    radii : (float, float)
        Of the neck at both ends.
    head : float
        Radius of the skull.
    muzzle : float
        Length of the muzzle in radii of the skull.
    segments : int
        Of the neck.

    Returns
    -------
    skull, nose : (3,) array
        Centre of the skull and tip of the muzzle.
    """
    top = base + length * direction / np.linalg.norm(direction)
    builder.chain(
        "neck",
        between(base, top, segments),
        between(*radii, segments),
        parent="spine.2",
        toward=(0, -0.5, -1),
    )
    skull = top + head * np.array([0, -0.6, 0.2])
    nose = skull + head * np.array([0, -0.8 - muzzle, -0.3 - 0.25 * muzzle])
    builder.chain("head", [top, skull, nose], [0.9 * head, head, 0.52 * head], parent=f"neck.{segments - 1}")
    builder.blob("head.1", skull + head * np.array([0.75, -0.5, 0.35]), (0.28 * head,) * 3, both_sides=True)
    return skull, nose


def add_ears(builder: SkeletonBuilder, skull: FloatArray, head: float, length: float, wide: float) -> None:
    """Add ears.

    Parameters
    ----------
    builder : SkeletonBuilder
    skull : (3,) array
        Centre of the skull.
    head : float
        Radius of the skull.
    length, wide : float
        Of an ear, in radii of the skull.
    """
    root = skull + head * np.array([0.55, 0.25, 0.6])
    tip = root + length * head * np.array([0.35, 0.15, 1.0])
    builder.stick(
        "head.0", [root, tip], [wide * head, 0.6 * wide * head], stretch=(1, 0.65, 1), both_sides=True
    )


def add_tail(
    builder: SkeletonBuilder,
    base: FloatArray,
    direction: Vector,
    length: float,
    radii: Vector,
) -> None:
    """Add a tail of four segments.

    Parameters
    ----------
    builder : SkeletonBuilder
    base, direction : (3,) array
    length : float
    radii : (2,) array_like
        At both ends.
    """
    way = np.asarray(direction, float)
    points = between(base, base + length * way / np.linalg.norm(way), 4)
    builder.chain("tail", points, between(radii[0], radii[1], 4), parent="spine.0", toward=(0, 0.3, 1))
