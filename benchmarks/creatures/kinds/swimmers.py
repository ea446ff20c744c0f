# SPDX-License-Identifier: MIT
"""Fish, whales, rays, octopuses and starfish."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.creatures.layout import between, offset
from benchmarks.creatures.skeleton import Pose, Skeleton, SkeletonBuilder, Wave

__all__ = ["KINDS"]

Random = np.random.Generator


def fish(rng: Random) -> Skeleton:
    """Build a fish: compressed sideways, with back fins, paired fins and a forked upright tail."""
    builder = SkeletonBuilder()
    length = rng.uniform(0.9, 1.2)
    deep = rng.uniform(0.11, 0.22)
    segments = 7
    place = np.linspace(0, 1, segments + 1)
    radii = deep * (0.22 + 0.78 * np.sin(np.pi * np.clip(place, 0.02, 0.97) ** 1.4) ** 0.8)
    radii[-1] = 0.55 * deep
    joints = between([0, length / 2, 0], [0, -length / 2, 0], segments)
    slim = rng.uniform(0.45, 0.7)
    builder.chain("body", joints, radii.tolist(), toward=(0, 0, -1), stretch=(slim, 1, 1))
    fork = rng.uniform(0.16, 0.26)
    tail = joints[0]
    for way in (1, -1):
        builder.stick(
            "body.0",
            [offset(tail, 0, -0.03, 0), offset(tail, 0, 0.75 * fork, way * fork)],
            [0.06, 0.045],
            stretch=(0.5, 1, 1),
        )
    builder.blob("body.0", offset(tail, 0, 0.06, 0), (0.028, 0.1, 0.1))
    crest = rng.uniform(0.08, 0.16)
    builder.stick(
        "body.4",
        [offset(joints[4], 0, -0.05, 0.8 * deep), offset(joints[4], 0, 0.1, deep + crest)],
        [0.09, 0.045],
        stretch=(0.35, 1, 1),
    )
    builder.stick(
        "body.2",
        [offset(joints[2], 0, 0, 0.55 * deep), offset(joints[2], 0, 0.09, 0.7 * deep + 0.6 * crest)],
        [0.065, 0.04],
        stretch=(0.45, 1, 1),
    )
    builder.stick(
        "body.2",
        [offset(joints[2], 0, 0, -0.55 * deep), offset(joints[2], 0, 0.09, -0.7 * deep - 0.6 * crest)],
        [0.065, 0.04],
        stretch=(0.45, 1, 1),
    )
    root = offset(joints[5], 0.7 * slim * deep, 0.02, -0.25 * deep)
    builder.chain(
        "fin",
        [root, offset(root, 0.12, 0.12, -0.05)],
        [0.055, 0.065],
        parent="body.5",
        toward=(0, -1, 0),
        stretch=(0.8, 1, 0.45),
        both_sides=True,
    )
    builder.blob(
        "body.6", offset(joints[6], 0.75 * slim * radii[6], -0.02, 0.25 * deep), (0.034,) * 3, both_sides=True
    )
    return builder.build(
        {
            "stroke left": {"body": (0, 55, 0), "fin": (20, 0, 0)},
            "stroke right": {"body": (0, -55, 0), "fin": (-15, 0, 0)},
            "swim": {"body": Wave(swing=55, cycles=1.0), "fin": (10, 0, 0)},
            "swim other": {"body": Wave(swing=55, cycles=1.0, phase=0.5), "fin": (-25, 0, 0)},
            "dive": {"body": (25, 15, 0), "fin": (30, 0, 0)},
        }
    )


def whale(rng: Random) -> Skeleton:
    """Build a whale: round, with flippers and a flat fluke; slim and with a beak a dolphin."""
    builder = SkeletonBuilder()
    length = rng.uniform(1.3, 1.6)
    girth = rng.uniform(0.15, 0.27)
    segments = 7
    place = np.linspace(0, 1, segments + 1)
    radii = girth * np.interp(place, [0, 0.25, 0.6, 0.85, 1], [0.2, 0.5, 1.0, 0.95, 0.6])
    joints = between([0, length / 2, 0], [0, -length / 2, 0], segments)
    builder.chain("body", joints, radii.tolist(), toward=(0, 0, 1))
    tail = joints[0]
    fluke = rng.uniform(0.22, 0.3)
    builder.stick(
        "body.0",
        [tail, offset(tail, fluke, 0.55 * fluke, 0)],
        [0.085, 0.05],
        stretch=(1, 1, 0.55),
        both_sides=True,
    )
    builder.stick(
        "body.3",
        [
            offset(joints[3], 0, -0.04, 0.7 * girth),
            offset(joints[3], 0, 0.1, girth + rng.uniform(0.05, 0.13)),
        ],
        [0.075, 0.036],
        stretch=(0.6, 1, 1),
    )
    root = offset(joints[5], 0.75 * girth, 0, -0.4 * girth)
    fin = rng.uniform(0.22, 0.4)
    builder.chain(
        "fin",
        [root, root + fin * np.array([0.5, 0.2, -0.22]), root + fin * np.array([0.9, 0.55, -0.35])],
        [0.085, 0.075, 0.05],
        parent="body.5",
        toward=(0, 0, 1),
        stretch=(1, 1, 0.5),
        both_sides=True,
    )
    if girth < 0.2:
        builder.stick(
            "body.6", [offset(joints[7], 0, 0, -0.03), offset(joints[7], 0, -0.24, -0.06)], [0.06, 0.04]
        )
    else:
        builder.blob("body.6", offset(joints[7], 0, -0.02, 0.05), (0.62 * girth, 0.8 * girth, 0.62 * girth))
    builder.blob("body.6", offset(joints[6], 0.86 * girth, -0.1, 0.05), (0.036,) * 3, both_sides=True)
    return builder.build(
        {
            "fluke up": {"body": (-50, 0, 0), "fin": (25, 0, 0)},
            "fluke down": {"body": (45, 0, 0), "fin": (-20, 0, 0)},
            "swim": {"body": Wave(bend=40, cycles=1.0), "fin": (20, 20, 0)},
            "turn": {"body": (0, 45, 0), "fin.L": (40, 0, 0), "fin.R": (-20, 0, 0)},
            "breach": {"body": (-28, 20, 0), "fin": (50, -25, 0)},
        }
    )


def ray(rng: Random) -> Skeleton:
    """Build a ray: a flat fish with wing fins and a whip of a tail."""
    builder = SkeletonBuilder()
    long = rng.uniform(0.35, 0.45)
    span = rng.uniform(0.45, 0.7)
    builder.chain("body", between([0, long, 0], [0, -long, 0], 2), [0.07, 0.1, 0.08], stretch=(1.4, 1, 0.8))
    builder.chain(
        "fin",
        [[0.05, 0, 0], [0.35 * span, 0, 0], [0.68 * span, 0.05, 0], [span, 0.16, 0]],
        [0.8 * long, 0.72 * long, 0.42 * long, 0.2 * long],
        parent="body.0",
        toward=(0, 0, 1),
        stretch=(1, 1, 0.16),
        blend=0.6,
        both_sides=True,
    )
    builder.stick("body.1", [[0.1, -0.9 * long, 0], [0.13, -long - 0.15, 0]], [0.036, 0.03], both_sides=True)
    builder.blob("body.1", (0.1, -0.75 * long, 0.07), (0.036,) * 3, both_sides=True)
    builder.chain(
        "tail",
        between([0, 0.95 * long, 0], [0, long + rng.uniform(0.6, 0.95), 0], 7),
        between(0.05, 0.024, 7),
        parent="body.0",
        toward=(0, 0, 1),
    )
    return builder.build(
        {
            "up": {"fin": (70, 0, 0), "tail": (0, 60, 0)},
            "down": {"fin": (-65, 0, 0), "tail": (-40, 0, 0)},
            "wave": {"fin": [(-20, 0, 0), (35, 0, 0), (25, 0, 0)], "tail": Wave(swing=60)},
            "bank": {"fin.L": (55, 0, 0), "fin.R": (-45, 0, 0), "tail": (0, -80, 0)},
            "sting": {"tail": (150, 0, 0), "fin": (20, 0, 0)},
        }
    )


def _arms(
    builder: SkeletonBuilder,
    count: int,
    ring: float,
    length: float,
    radii: tuple[float, float],
    drop: float,
    segments: int,
) -> None:
    """Arms on a ring around the z axis, outward and down by `drop`; a positive bend curls them down."""
    for number in range(count):
        turn = 2 * np.pi * (number + 0.5) / count
        out = np.array([np.cos(turn), np.sin(turn), 0.0])
        way = out - [0, 0, drop]
        way /= np.linalg.norm(way)
        start = ring * out
        builder.chain(
            f"arm{number}",
            between(start, start + length * way, segments),
            between(*radii, segments),
            parent="body.0",
            toward=(0, 0, -1),
        )


def octopus(rng: Random) -> Skeleton:
    """Build an octopus: a bag of a head with eyes over six to eight arms."""
    builder = SkeletonBuilder()
    count = int(rng.integers(6, 9))
    head = rng.uniform(0.17, 0.23)
    builder.chain("body", [[0, 0, 0], [0, 0.02, 0.22]], [0.15, 0.13])
    builder.chain(
        "head",
        [[0, 0.03, 0.24], [0, 0.14, 0.5]],
        [0.14, head],
        parent="body.0",
        toward=(0, -1, 0),
        stretch=(1, 1, 1.1),
    )
    builder.blob("body.0", (0.12, -0.1, 0.17), (0.05,) * 3, both_sides=True)
    _arms(builder, count, 0.1, rng.uniform(0.8, 1.1), (0.062, 0.026), rng.uniform(0.3, 0.9), 9)
    names = [f"arm{number}" for number in range(count)]
    waves: Pose = {
        name: Wave(swing=60, bend=20, cycles=1.0, phase=number / count) for number, name in enumerate(names)
    }
    return builder.build(
        {
            "swim": dict.fromkeys(names, (60, 0, 0)),
            "sprawl": waves,
            "reach up": {
                name: (-70, 0, 0) if number % 2 else (30, 20, 0) for number, name in enumerate(names)
            },
            "curl": {
                name: (150, 0, 0) if number % 3 == 0 else (0, 50, 0) for number, name in enumerate(names)
            },
            "spin": {**dict.fromkeys(names, (10, 110, 0)), "head": (20, 15, 0)},
        }
    )


def starfish(rng: Random) -> Skeleton:
    """Build a starfish: five to seven tapering arms on a disc, with knobs along the back."""
    builder = SkeletonBuilder()
    count = int(rng.integers(5, 8))
    length = rng.uniform(0.5, 0.65)
    root = rng.uniform(0.075, 0.09)
    builder.chain("body", [[0, 0, 0], [0, 0, 0.05]], [0.15, 0.1], toward=(0, -1, 0), stretch=(1, 1, 0.5))
    _arms(builder, count, 0.08, length, (root, 0.035), 0.0, 6)
    for number in range(count):
        turn = 2 * np.pi * (number + 0.5) / count
        out = np.array([np.cos(turn), np.sin(turn), 0.0])
        for place, size in ((0.24, 0.036), (0.4, 0.032), (0.54, 0.028)):
            high = root + (0.035 - root) * (place - 0.08) / length
            builder.blob(
                f"arm{number}.{int(6 * (place - 0.08) / length)}",
                place * offset(out, 0, 0, 0.9 * high),
                (size,) * 3,
            )
    names = [f"arm{number}" for number in range(count)]
    return builder.build(
        {
            "arch": dict.fromkeys(names, (34, 0, 0)),
            "cup": dict.fromkeys(names, (-36, 0, 0)),
            "crawl": {name: (15, 45 if number % 2 else -30, 0) for number, name in enumerate(names)},
            "swirl": dict.fromkeys(names, (0, 48, 0)),
            "flip": {
                name: (-60, 0, 0) if number < count // 2 else (25, 0, 0) for number, name in enumerate(names)
            },
        }
    )


KINDS: dict[str, Callable[[Random], Skeleton]] = {
    "fish": fish,
    "whale": whale,
    "ray": ray,
    "octopus": octopus,
    "starfish": starfish,
}
