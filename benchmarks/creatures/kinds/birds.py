# SPDX-License-Identifier: MIT
"""Creatures with wings or feathers."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from benchmarks.creatures.layout import between, offset
from benchmarks.creatures.skeleton import Pose, Skeleton, SkeletonBuilder, Wave

__all__ = ["KINDS"]

Random = np.random.Generator
FloatArray = NDArray[np.float64]


def _wings(
    builder: SkeletonBuilder, parent: str, shoulder: np.ndarray, span: float, chord: float, thick: float
) -> None:
    """Wings spread sideways in three bones, with a fan of feathers at the end."""
    joints = shoulder + span * np.array(
        [[0, 0, 0], [0.33, -0.08, 0.04], [0.68, -0.02, 0.05], [1.0, 0.1, 0.04]]
    )
    builder.chain(
        "wing",
        joints,
        [0.8 * chord, chord, 0.85 * chord, 0.35 * chord],
        parent=parent,
        toward=(0, 0, 1),
        stretch=(1, 1, thick / chord),
        both_sides=True,
    )
    for turn in (0.12, 0.3):
        tip = joints[2] + span * np.array([0.36 - turn / 2, 0.12 + turn, -0.01])
        builder.stick(
            "wing.L.2",
            [offset(joints[2], 0, 0.3 * chord, 0), tip],
            [0.4 * chord, 0.22 * chord],
            stretch=(1, 1, 2 * thick / chord),
            both_sides=True,
        )


_WING_POSES: dict[str, Pose] = {
    "wings up": {"wing": [(35, 0, 0), (15, 0, 0), (10, 0, 0)], "tail": (12, 0, 0)},
    "wings down": {"wing": [(-35, 0, 0), (-15, 0, 0), (-10, 0, 0)], "neck": (-10, 0, 0)},
    "glide": {"wing": [(8, 8, 0), (-8, -20, 0), (0, -10, 0)], "neck": (10, 20, 0)},
    "bank": {
        "wing.L": [(30, 0, 0), (5, 0, 0)],
        "wing.R": [(-25, 0, 0), (5, 0, 0)],
        "neck": (0, 30, 0),
        "tail": (0, 20, 0),
    },
    "fold": {"wing": [(-15, -35, 0), (-10, -35, 0), (0, -25, 0)], "neck": (-15, 0, 0)},
    "land": {"wing": [(45, 10, 0), (-20, 0, 0)], "leg": [(-40, 0, 0), (20, 0, 0)], "tail": (-30, 0, 0)},
}


def bird(rng: Random) -> Skeleton:
    """Build a bird: wings spread, legs down, a beak and a fan tail."""
    builder = SkeletonBuilder()
    length = rng.uniform(0.45, 0.6)
    girth = rng.uniform(0.11, 0.15)
    builder.chain(
        "spine",
        [[0, 0.5 * length, 0], [0, 0.1 * length, -0.01], [0, -0.35 * length, 0.03]],
        [0.6 * girth, girth, 0.8 * girth],
    )
    _wings(
        builder,
        "spine.1",
        np.array([0.5 * girth, -0.2 * length, 0.06]),
        rng.uniform(0.65, 0.95),
        rng.uniform(0.11, 0.15),
        0.03,
    )
    throat = np.array([0, -0.45 * length, 0.07])
    neck = rng.uniform(0.1, 0.35)
    skull = throat + neck * np.array([0, -0.7, 0.7])
    builder.chain(
        "neck", between(throat, skull, 3), between(0.085, 0.06, 3), parent="spine.1", toward=(0, -0.5, -1)
    )
    head = rng.uniform(0.075, 0.095)
    builder.blob("neck.2", skull, (head, 1.1 * head, head))
    beak = rng.uniform(1.0, 2.6)
    builder.stick(
        "neck.2",
        [offset(skull, 0, -0.5 * head, -0.01), offset(skull, 0, -(1.0 + beak) * head, -0.04)],
        [0.45 * head, 0.26 * head],
    )
    builder.blob(
        "neck.2", offset(skull, 0.75 * head, -0.45 * head, 0.3 * head), (0.27 * head,) * 3, both_sides=True
    )
    tail = rng.uniform(0.2, 0.4)
    back = np.array([0, 0.5 * length, 0])
    builder.chain(
        "tail",
        [back, offset(back, 0, 0.5 * tail, 0), offset(back, 0, tail, 0.02)],
        [0.08, 0.1, 0.13],
        parent="spine.0",
        toward=(0, 0.3, 1),
        stretch=(1, 1, 0.3),
    )
    drop = rng.uniform(0.14, 0.36)
    hip = np.array([0.09, 0.16 * length, -0.07])
    foot = hip + drop * np.array([0.1, -0.1, -1])
    builder.chain(
        "leg",
        [hip, hip + drop * np.array([0.05, 0.15, -0.5]), foot],
        [0.05, 0.03, 0.024],
        parent="spine.0",
        toward=(0, 1, 0),
        both_sides=True,
    )
    for toe in ([-0.03, -0.11, -0.02], [0.05, -0.1, -0.02], [0.01, 0.09, -0.02]):
        builder.stick("leg.L.1", [foot, foot + toe], [0.024, 0.022], both_sides=True)
    return builder.build(_WING_POSES)


def ostrich(rng: Random) -> Skeleton:
    """Build a running bird with long neck, long legs, stub wings."""
    builder = SkeletonBuilder()
    height = rng.uniform(0.75, 0.95)
    girth = rng.uniform(0.17, 0.22)
    builder.chain(
        "spine",
        [[0, 0.25, height], [0, 0, height], [0, -0.22, height + 0.02]],
        [0.7 * girth, girth, 0.8 * girth],
    )
    builder.stick(
        "spine.0", [[0, 0.25, height + 0.05], [0, 0.48, height + 0.15]], [0.12, 0.06], stretch=(1, 1, 0.7)
    )
    builder.stick(
        "spine.1",
        [[0.8 * girth, -0.15, height + 0.05], [girth + 0.03, 0.22, height + 0.02]],
        [0.1, 0.06],
        stretch=(0.5, 1, 1),
        both_sides=True,
    )
    base = np.array([0, -0.3, height + 0.08])
    reach = rng.uniform(0.6, 0.9)
    joints = base + reach * np.array(
        [[0, 0, 0], [0, -0.15, 0.12], [0, -0.2, 0.35], [0, -0.19, 0.57], [0, -0.2, 0.8], [0, -0.24, 1.0]]
    )
    builder.chain("neck", joints, between(0.085, 0.04, 5), parent="spine.1", toward=(0, -1, -0.2))
    skull = offset(joints[-1], 0, -0.03, 0.02)
    builder.blob("neck.4", skull, (0.06, 0.085, 0.06))
    builder.stick("neck.4", [skull, offset(skull, 0, -0.17, -0.03)], [0.045, 0.03], stretch=(1, 1, 0.8))
    hip = np.array([0.11, 0.03, height - 0.08])
    ankle = np.array([0.12, 0.02, 0.04])
    builder.chain(
        "leg",
        [hip, [0.13, -0.09, 0.62 * height], [0.12, 0.1, 0.36 * height], ankle],
        [0.1, 0.06, 0.036, 0.032],
        parent="spine.0",
        toward=(0, 1, 0),
        both_sides=True,
    )
    for toe in ([-0.04, -0.16, -0.01], [0.05, -0.14, -0.01]):
        builder.stick("leg.L.2", [ankle, ankle + toe], [0.034, 0.026], both_sides=True)
    return builder.build(
        {
            "run": {
                "leg.L": [(-60, 0, 0), (70, 0, 0), (-40, 0, 0)],
                "leg.R": [(35, 0, 0), (10, 0, 0)],
                "neck": (15, 0, 0),
            },
            "walk": {"leg.L": [(-25, 0, 0), (10, 0, 0)], "leg.R": [(22, 0, 0), (15, 0, 0), (-15, 0, 0)]},
            "peck": {
                "neck": [(85, 0, 0), (30, 0, 0), (15, 0, 0), (10, 0, 0), (20, 0, 0)],
                "spine": (12, 0, 0),
            },
            "bend neck": {"neck": Wave(bend=75, cycles=1.0)},
            "look": {"neck": (-15, 70, 0), "leg.L": [(-12, 0, 0)]},
            "sit": {"leg": [(-60, 5, 0), (105, 0, 0), (-85, 0, 0)], "neck": (-15, 0, 0)},
        }
    )


def dragon(rng: Random) -> Skeleton:
    """Build a dragon: four legs, two wings, long neck, spiked tail, horns."""
    builder = SkeletonBuilder()
    length, height = rng.uniform(0.6, 0.75), rng.uniform(0.38, 0.48)
    girth = rng.uniform(0.13, 0.17)
    builder.chain(
        "spine",
        between([0, length / 2, height], [0, -length / 2, height + 0.05], 3),
        np.array([0.85, 0.95, 1.05, 0.8]) * girth,
    )
    for name, y, knee, parent in (
        ("hind", 0.4 * length, -0.1, "spine.0"),
        ("fore", -0.45 * length, 0.07, "spine.2"),
    ):
        foot = [0.17, y, 0.04]
        builder.chain(
            name,
            [[0.12, y, height - 0.03], [0.17, y + knee, 0.5 * height], foot],
            [0.085, 0.06, 0.045],
            parent=parent,
            toward=(0, 1, 0),
            both_sides=True,
        )
        builder.stick(
            f"{name}.L.1",
            [foot, [0.18, y - 0.12, 0.035]],
            [0.042, 0.034],
            stretch=(1.2, 1, 0.9),
            both_sides=True,
        )
    base = np.array([0, -0.5 * length, height + 0.1])
    reach = rng.uniform(0.4, 0.6)
    skull = base + reach * np.array([0, -0.65, 0.76])
    builder.chain(
        "neck", between(base, skull, 4), between(0.11, 0.075, 4), parent="spine.2", toward=(0, -0.5, -1)
    )
    builder.stick("neck.3", [skull, offset(skull, 0, -rng.uniform(0.18, 0.26), -0.04)], [0.09, 0.05])
    builder.stick(
        "neck.3",
        [offset(skull, 0.05, 0.03, 0.05), offset(skull, 0.09, 0.17, 0.13)],
        [0.032, 0.024],
        both_sides=True,
    )
    back = np.array([0, length / 2, height])
    tail = back + np.array([0, rng.uniform(0.8, 1.1), -0.1])
    builder.chain(
        "tail", between(back, tail, 6), between(0.8 * girth, 0.034, 6), parent="spine.0", toward=(0, 0.1, 1)
    )
    builder.stick("tail.5", [tail, offset(tail, 0, 0.13, 0)], [0.085, 0.045], stretch=(1, 1, 0.4))
    for number, point in enumerate(between(back, tail, 6)[1:5]):
        builder.stick(
            f"tail.{number}",
            [offset(point, 0, -0.06, 0.06), offset(point, 0, 0.0, 0.14 - 0.015 * number)],
            [0.032, 0.024],
            stretch=(0.8, 1, 1),
        )
    _wings(
        builder,
        "spine.1",
        np.array([0.06, -0.22 * length, height + 0.12]),
        rng.uniform(0.6, 0.85),
        rng.uniform(0.11, 0.14),
        0.028,
    )
    poses: dict[str, Pose] = {
        name: {k: v for k, v in pose.items() if k != "leg"} for name, pose in _WING_POSES.items()
    }
    poses["wings up"] = {
        **poses["wings up"],
        "fore": [(-35, 0, 0), (40, 0, 0)],
        "hind": [(30, 0, 0)],
        "tail": (40, 0, 0),
    }
    poses["prowl"] = {
        "neck": (70, 0, 0),
        "tail": (0, 70, 0),
        "fore.L": [(-25, 0, 0)],
        "hind.R": [(-25, 0, 0)],
        "wing": [(20, -25, 0), (-10, -20, 0)],
    }
    poses["coil"] = {
        "neck": Wave(swing=60, cycles=1.0),
        "tail": Wave(swing=90, cycles=1.0),
        "wing": [(25, 0, 0)],
    }
    return builder.build(poses)


KINDS: dict[str, Callable[[Random], Skeleton]] = {
    "bird": bird,
    "ostrich": ostrich,
    "dragon": dragon,
}
