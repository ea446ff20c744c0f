# SPDX-License-Identifier: MIT
"""Spiders, crabs, scorpions, insects."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.creatures.layout import between, offset
from benchmarks.creatures.skeleton import Pose, PoseRule, Skeleton, SkeletonBuilder

__all__ = ["KINDS"]

Random = np.random.Generator


def _side_legs(
    builder: SkeletonBuilder,
    count: int,
    spacing: float,
    root: float,
    length: float,
    radius: float,
    arch: float,
    fan: float,
) -> None:
    """Pairs of jointed legs along the body: up to the knee, down to the foot; positive bends lift them."""
    for number in range(count):
        place = number - (count - 1) / 2
        turn = fan * place / max(count - 1, 1) * 2
        out = np.array([np.cos(turn), np.sin(turn), 0.0])
        start = np.array([root, spacing * place, 0.0])
        knee = start + length * (0.38 * offset(out, 0, 0, 0.38 * arch))
        ankle = start + length * (0.75 * offset(out, 0, 0, -0.1))
        foot = start + length * (0.95 * offset(out, 0, 0, -0.42))
        builder.chain(
            f"leg{number}",
            [start, knee, ankle, foot],
            [1.25 * radius, 1.1 * radius, radius, 0.8 * radius],
            parent="body.0",
            toward=(0, 0, 1),
            both_sides=True,
        )


def _leg_poses(count: int) -> dict[str, Pose]:
    """Gaits and stances of `count` pairs of legs."""

    def all_legs(rule: PoseRule) -> Pose:
        return {f"leg{number}": rule for number in range(count)}

    def alternating(even: PoseRule, odd: PoseRule) -> Pose:
        return {
            f"leg{number}.{side}": odd if (number + shift) % 2 else even
            for number in range(count)
            for shift, side in enumerate("LR")
        }

    forward: PoseRule = [(15, 18, 0), (-10, 0, 0)]
    backward: PoseRule = [(-5, -18, 0), (0, 0, 0)]
    return {
        "step": alternating(backward, forward),
        "other step": alternating(forward, backward),
        "flat": all_legs([(-35, 0, 0), (45, 0, 0), (20, 0, 0)]),
        "curl": all_legs([(25, 0, 0), (-55, 0, 0), (-45, 0, 0)]),
        "stand tall": all_legs([(-45, 0, 0), (-5, 0, 0), (10, 0, 0)]),
        "threaten": {**all_legs([(-8, -8, 0)]), "leg0": [(50, 5, 0), (20, 0, 0)]},
    }


def spider(rng: Random) -> Skeleton:
    """Build a spider: two round parts, eight long legs, palps."""
    builder = SkeletonBuilder()
    front, back = rng.uniform(0.12, 0.16), rng.uniform(0.17, 0.26)
    builder.chain("body", [[0, 0.1, 0], [0, -0.14, 0]], [front, 0.85 * front], stretch=(1, 1, 0.75))
    rear = np.array([0, 0.1 + front, 0.03])
    builder.chain(
        "abdomen", [rear, offset(rear, 0, back, 0.06)], [0.06, back], parent="body.0", toward=(0, 0, 1)
    )
    builder.stick(
        "abdomen.0", [offset(rear, 0, 1.75 * back, 0.02), offset(rear, 0, 2.15 * back, 0)], [0.05, 0.034]
    )
    for x, y in ((0.045, -0.2), (0.1, -0.16)):
        builder.blob("body.0", (x, y, 0.075), (0.032,) * 3, both_sides=True)
    builder.stick(
        "body.0",
        [[0.06, -0.2, -0.02], [0.08, -0.34, -0.02], [0.07, -0.38, -0.12]],
        [0.034, 0.03, 0.028],
        both_sides=True,
    )
    _side_legs(
        builder,
        4,
        0.085,
        0.8 * front,
        rng.uniform(0.75, 1.05),
        rng.uniform(0.026, 0.034),
        rng.uniform(0.8, 1.3),
        0.85,
    )
    return builder.build(_leg_poses(4))


def crab(rng: Random) -> Skeleton:
    """Build a crab: a wide shell, eight legs, two pincers on jointed arms, eyes on stalks."""
    builder = SkeletonBuilder()
    wide, long = rng.uniform(0.28, 0.38), rng.uniform(0.2, 0.26)
    builder.chain("body", [[0, 0.08, 0], [0, -0.08, 0]], [0.1, 0.1])
    builder.blob("body.0", (0, 0, 0.02), (wide, long, 0.11))
    builder.stick(
        "body.0", [[0.6 * wide, -0.1, 0.02], [wide + 0.09, -0.12, 0.03]], [0.05, 0.026], both_sides=True
    )
    builder.stick(
        "body.0", [[0.08, -0.85 * long, 0.05], [0.1, -long - 0.03, 0.17]], [0.028, 0.034], both_sides=True
    )
    _side_legs(
        builder,
        4,
        0.095,
        0.72 * wide,
        rng.uniform(0.5, 0.65),
        rng.uniform(0.027, 0.033),
        rng.uniform(0.5, 0.9),
        0.5,
    )
    root = np.array([0.6 * wide, -0.8 * long, 0])
    reach = rng.uniform(0.36, 0.46)
    wrist = root + reach * np.array([0.3, -1.0, 0.1])
    builder.chain(
        "claw",
        [root, root + reach * np.array([0.7, -0.5, 0.12]), wrist, offset(wrist, -0.03, -0.14, 0.0)],
        [0.05, 0.045, 0.045, 0.075],
        parent="body.0",
        toward=(0, 0, 1),
        both_sides=True,
    )
    palm = offset(wrist, -0.03, -0.14, 0.0)
    builder.stick(
        "claw.L.2",
        [offset(palm, 0.03, 0, 0), offset(palm, 0.07, -0.13, 0), offset(palm, 0.04, -0.23, 0)],
        [0.05, 0.036, 0.024],
        both_sides=True,
    )
    builder.chain(
        "pincer",
        [offset(palm, -0.04, -0.02, 0), offset(palm, -0.14, -0.18, 0.0)],
        [0.036, 0.024],
        parent="claw.L.2",
        toward=(-1, 0, 0),
        both_sides=True,
    )
    poses = _leg_poses(4)
    claws: list[Pose] = [
        {"claw": [(0, 20, 0)], "pincer": (15, 0, 0)},
        {"claw.L": [(35, -10, 0), (10, 0, 0)], "claw.R": [(-10, 15, 0)]},
        {"claw": [(-5, -25, 0), (0, -20, 0)]},
        {"claw": [(10, 30, 0), (0, 30, 0)], "pincer": (-5, 0, 0)},
        {"claw": [(-25, 0, 0), (25, 0, 0)]},
        {"claw": [(50, -15, 0), (10, -10, 0)], "pincer": (20, 0, 0)},
    ]
    return builder.build(
        {name: {**pose, **extra} for (name, pose), extra in zip(poses.items(), claws, strict=True)}
    )


def scorpion(rng: Random) -> Skeleton:
    """Build a scorpion: legs, pincers and a segmented tail with a sting."""
    builder = SkeletonBuilder()
    wide = rng.uniform(0.1, 0.13)
    builder.chain("body", [[0, 0.3, 0], [0, -0.24, 0]], [0.75 * wide, wide], stretch=(1, 1, 0.7))
    for y in np.linspace(0.25, -0.15, 5):
        builder.blob("body.0", (0, y, 0.02), (1.1 * wide, 0.05, 0.75 * wide))
    _side_legs(builder, 4, 0.1, 0.75 * wide, rng.uniform(0.42, 0.55), 0.026, 0.8, 0.6)
    root = np.array([0.07, -0.26, 0])
    reach = rng.uniform(0.38, 0.5)
    wrist = root + reach * np.array([0.45, -0.95, 0.0])
    hand = offset(wrist, -0.01, -0.12, 0)
    builder.chain(
        "claw",
        [root, root + reach * np.array([0.65, -0.45, 0.05]), wrist, hand],
        [0.04, 0.036, 0.036, 0.06],
        parent="body.0",
        toward=(0, 0, 1),
        both_sides=True,
    )
    builder.stick(
        "claw.L.2", [offset(hand, 0.02, 0, 0), offset(hand, 0.05, -0.17, 0)], [0.036, 0.024], both_sides=True
    )
    builder.stick(
        "claw.L.2",
        [offset(hand, -0.03, 0, 0), offset(hand, -0.07, -0.15, 0)],
        [0.034, 0.024],
        both_sides=True,
    )
    segments = int(rng.integers(5, 7))
    tail = between([0, 0.33, 0.0], [0, 0.33 + rng.uniform(0.55, 0.75), 0.12], segments)
    builder.chain("tail", tail, between(0.062, 0.045, segments), parent="body.0", toward=(0, -0.2, 1))
    for number in range(segments):
        builder.blob(f"tail.{number}", (tail[number] + tail[number + 1]) / 2, (0.06, 0.055, 0.06))
    tip = tail[-1]
    builder.stick(
        f"tail.{segments - 1}",
        [tip, offset(tip, 0, 0.07, 0.03), offset(tip, 0, 0.11, 0.14)],
        [0.055, 0.045, 0.024],
    )
    tails: list[Pose] = [
        {"tail": (150, 0, 0)},
        {"tail": (120, 30, 0), "claw": [(0, 20, 0)]},
        {"tail": (10, 60, 0), "claw": [(0, -25, 0)]},
        {"tail": (190, 0, 0), "claw": [(0, 25, 0), (0, 25, 0)]},
        {"tail": (60, -20, 0)},
        {"tail": (200, 0, 0), "claw": [(40, -10, 0)]},
    ]
    poses = _leg_poses(4)
    return builder.build(
        {name: {**pose, **extra} for (name, pose), extra in zip(poses.items(), tails, strict=True)}
    )


def insect(rng: Random) -> Skeleton:
    """Build an ant, a beetle or a dragonfly: six legs, feelers, perhaps wings and mandibles."""
    builder = SkeletonBuilder()
    chest = rng.uniform(0.1, 0.14)
    builder.chain("body", [[0, 0.1, 0], [0, -0.12, 0]], [chest, 0.85 * chest])
    rear = np.array([0, 0.12 + chest, 0])
    long, thick = rng.uniform(0.3, 0.7), rng.uniform(0.08, 0.17)
    builder.chain(
        "abdomen",
        between(rear, offset(rear, 0, long, -0.02), 4),
        [0.05, thick, thick, 0.85 * thick, 0.4 * thick],
        parent="body.0",
        toward=(0, 0, 1),
    )
    neck = np.array([0, -0.14 - 0.6 * chest, 0.02])
    skull = offset(neck, 0, -0.12, 0.0)
    builder.chain("head", [neck, skull], [0.055, 0.105], parent="body.0", toward=(0, 0, -1))
    builder.blob("head.0", offset(skull, 0.08, -0.03, 0.035), (0.05,) * 3, both_sides=True)
    builder.chain(
        "feeler",
        [offset(skull, 0.05, -0.07, 0.05), offset(skull, 0.14, -0.22, 0.16), offset(skull, 0.2, -0.4, 0.14)],
        [0.028, 0.024, 0.024],
        parent="head.0",
        toward=(0, 0, -1),
        both_sides=True,
    )
    if rng.random() < 0.5:
        builder.stick(
            "head.0",
            [
                offset(skull, 0.05, -0.06, -0.04),
                offset(skull, 0.1, -0.18, -0.05),
                offset(skull, 0.06, -0.25, -0.05),
            ],
            [0.032, 0.028, 0.024],
            both_sides=True,
        )
    _side_legs(
        builder,
        3,
        0.13,
        0.75 * chest,
        rng.uniform(0.5, 0.75),
        rng.uniform(0.024, 0.03),
        rng.uniform(0.5, 1.0),
        0.65,
    )
    winged = rng.random() < 0.6
    if winged:
        span, chord = rng.uniform(0.5, 0.8), rng.uniform(0.09, 0.14)
        for name, y, sweep in (("wing", -0.07, -0.22), ("hindwing", 0.13, 0.4)):
            root = np.array([0.4 * chest, y, 0.85 * chest])
            builder.chain(
                name,
                [
                    root,
                    root + span * np.array([0.45, 0.5 * sweep, 0.22]),
                    root + span * np.array([1, sweep, 0.42]),
                ],
                [0.5 * chord, chord, 0.6 * chord],
                parent="body.0",
                toward=(0, 0, 1),
                stretch=(1, 1, 0.25),
                both_sides=True,
            )
    poses = _leg_poses(3)
    bodies: list[Pose] = [
        {"abdomen": (-15, 0, 0), "feeler": (20, 10, 0)},
        {"abdomen": (10, 25, 0), "head": (0, 20, 0)},
        {"abdomen": (-25, 0, 0), "head": (20, 0, 0)},
        {"abdomen": (-60, 0, 0), "feeler": (40, 0, 0)},
        {"abdomen": (35, 0, 0), "head": (-15, 0, 0)},
        {"abdomen": (30, -15, 0), "feeler": (-25, 20, 0)},
    ]
    flaps: list[Pose] = [
        {"wing": (30, 0, 0), "hindwing": (-15, 0, 0)},
        {"wing": (-20, 15, 0), "hindwing": (20, 0, 0)},
        {"wing": (0, -40, 0), "hindwing": (0, -25, 0)},
        {"wing": (50, 0, 0), "hindwing": (45, 0, 0)},
        {"wing": (-25, 0, 0), "hindwing": (-25, 0, 0)},
        {"wing": (35, 20, 0), "hindwing": (10, 0, 0)},
    ]
    return builder.build(
        {
            name: {**legs, **body, **(flap if winged else {})}
            for (name, legs), body, flap in zip(poses.items(), bodies, flaps, strict=True)
        }
    )


KINDS: dict[str, Callable[[Random], Skeleton]] = {
    "spider": spider,
    "crab": crab,
    "scorpion": scorpion,
    "insect": insect,
}
