# SPDX-License-Identifier: MIT
"""Hands, plants and objects with joints."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.creatures.layout import between, offset
from benchmarks.creatures.skeleton import Pose, Skeleton, SkeletonBuilder, Wave

__all__ = ["KINDS"]

Random = np.random.Generator


def hand(rng: Random) -> Skeleton:
    """Build a hand: a palm with thumb and three or four fingers of three bones, and a stump of forearm."""
    builder = SkeletonBuilder()
    fingers = int(rng.choice([3, 4, 4, 4]))
    wide, long = rng.uniform(0.2, 0.25), rng.uniform(0.4, 0.5)
    thick = rng.uniform(0.05, 0.062)
    wrist = 0.2
    builder.chain(
        "arm",
        [[0, 0, -wrist - rng.uniform(0.2, 0.4)], [0, 0, -wrist], [0, 0, 0]],
        [0.13, 0.1, 0.11],
        toward=(0, -1, 0),
        stretch=(1.1, 0.8, 1),
    )
    knuckles = np.linspace(-wide, wide, fingers)
    for number, x in enumerate(knuckles):
        builder.stick(
            "arm.1", [[0.45 * x, 0, -0.04], [0.95 * x, 0, 0.8 * long]], [0.085, 0.07], stretch=(1, 0.85, 1)
        )
        reach = long * rng.uniform(0.9, 1.05) * (1 - 0.25 * (x / wide) ** 2)
        root = np.array([x, 0, 0.82 * long])
        way = np.array([0.22 * x / wide, 0, 1.0])
        builder.chain(
            f"finger{number}",
            root + np.array([[0], [0.46], [0.77], [1.05]]) * reach * way,
            [1.15 * thick, 1.05 * thick, 0.95 * thick, 0.85 * thick],
            parent="arm.1",
            toward=(0, -1, 0),
        )
        for joint in (0.46, 0.77):
            builder.blob(
                f"finger{number}.{0 if joint < 0.5 else 1}",
                root + joint * reach * offset(way, 0, 0.35 * thick, 0),
                (0.95 * thick, 0.85 * thick, 0.8 * thick),
            )
    root = np.array([-0.6 * wide, -0.02, 0.05])
    builder.chain(
        "thumb",
        [
            root,
            offset(root, -0.2, -0.05, 0.13),
            offset(root, -0.31, -0.07, 0.27),
            offset(root, -0.38, -0.08, 0.42),
        ],
        [0.1, 0.075, 1.15 * thick, thick],
        parent="arm.1",
        toward=(0.6, -1, 0),
    )
    names = [f"finger{number}" for number in range(fingers)]

    def curled(*straight: int) -> Pose:
        return {
            name: [(8, 0, 0)] if n in straight else [(65, 0, 0), (80, 0, 0), (45, 0, 0)]
            for n, name in enumerate(names)
        }

    return builder.build(
        {
            "fist": {**curled(), "thumb": [(25, 0, 0), (40, 0, 0), (25, 0, 0)]},
            "point": {**curled(0), "thumb": [(20, 0, 0), (30, 0, 0)]},
            "victory": {**curled(0, 1), "thumb": [(30, 0, 0), (35, 0, 0)]},
            "thumb up": {**curled(), "thumb": [(-10, -15, 0)]},
            "relax": {name: [(20 + 5 * n, 0, 0), (25, 0, 0), (15, 0, 0)] for n, name in enumerate(names)},
            "spread": {
                **{name: [(-8, 14 * np.sign(x), 0)] for name, x in zip(names, knuckles, strict=True)},
                "thumb": [(-15, -15, 0)],
            },
            "claw": {
                **{name: [(-5, 0, 0), (60, 0, 0), (45, 0, 0)] for name in names},
                "thumb": [(0, 0, 0), (45, 0, 0)],
            },
            "bend wrist": {"arm": [(0, 0, 0), (45, 10, 0)], names[-1]: [(30, 0, 0)]},
        }
    )


def desk_lamp(rng: Random) -> Skeleton:
    """Build a desk lamp: a disc foot, two arms, a shade."""
    builder = SkeletonBuilder()
    foot = rng.uniform(0.2, 0.28)
    lower, upper = rng.uniform(0.45, 0.65), rng.uniform(0.4, 0.6)
    thin = rng.uniform(0.026, 0.036)
    builder.chain("foot", [[0, 0, 0], [0, 0, 0.08]], [0.05, 0.05], toward=(0, -1, 0))
    builder.blob("foot.0", (0, 0, 0), (foot, foot, 0.05))
    elbow = np.array([0, 0.35 * lower, 0.08 + 0.93 * lower])
    wrist = elbow + upper * np.array([0, -0.85, 0.5])
    builder.chain("arm", [[0, 0, 0.08], elbow, wrist], [thin] * 3, parent="foot.0", toward=(0, -1, 0))
    for bone, joint in (("arm.0", [0, 0, 0.09]), ("arm.1", elbow), ("arm.1", wrist)):
        builder.blob(bone, joint, (1.9 * thin, 1.6 * thin, 1.6 * thin))
    shade = rng.uniform(0.13, 0.18)
    mouth = wrist + np.array([0, -0.2, -0.14])
    builder.chain(
        "shade",
        [wrist, wrist + 0.3 * (mouth - wrist), mouth],
        [0.05, 0.45 * shade, shade],
        parent="arm.1",
        toward=(0, 0, -1),
    )
    builder.blob("shade.1", offset(mouth, 0, -0.11, -0.08), (0.07,) * 3)
    if rng.random() < 0.5:
        builder.ring("foot.0", (0, 0.9 * foot, 0.09), [[0, 0.08, 0], [0, 0, 0.08]], 0.03)
    return builder.build(
        {
            "low": {"arm": [(55, 0, 0), (-20, 0, 0)], "shade": [(20, 0, 0)]},
            "high": {"arm": [(10, 0, 0), (-50, 0, 0)], "shade": [(40, 0, 0)]},
            "fold": {"arm": [(-35, 0, 0), (75, 0, 0)], "shade": [(-10, 0, 0)]},
            "turn": {"arm": [(20, 0, 0), (10, 45, 0)], "shade": [(0, 30, 0)]},
            "lean back": {"arm": [(-35, 10, 0), (15, 0, 0)], "shade": [(-25, 0, 0)]},
        }
    )


def chain(rng: Random) -> Skeleton:
    """Build a chain: rings joined by bars, a pendant at the end."""
    builder = SkeletonBuilder()
    count = int(rng.integers(5, 9))
    radius, thin = rng.uniform(0.075, 0.1), rng.uniform(0.024, 0.032)
    stretch = rng.uniform(1.0, 1.5)
    half = radius * stretch
    bar = rng.uniform(0.06, 0.12)
    step = 2 * half + bar
    joints = between([0, 0, 0], [0, count * step, 0], count)
    builder.chain("links", joints, [thin] * (count + 1), toward=(0, 0, 1), bare=True)
    for number in range(count):
        centre = np.array([0, (number + 0.5) * step, 0])
        across = [radius, 0, 0] if number % 2 else [0, 0, radius]
        builder.ring(f"links.{number}", centre, [across, [0, half, 0]], 1.2 * thin)
        for end in (joints[number], joints[number + 1]):
            inner = end + (centre - end) * 0.5 * bar / (0.5 * step)
            builder.stick(f"links.{number}", [end, inner], [thin, thin])
    end = np.array([0, count * step, 0])
    builder.chain(
        "pendant",
        [end, offset(end, 0, 0.16, 0)],
        [0.05, 0.1],
        parent=f"links.{count - 1}",
        toward=(0, 0, 1),
        stretch=(1, 1, 0.6),
    )
    return builder.build(
        {
            "bow": {"links": (150, 0, 0)},
            "wave": {"links": Wave(bend=90, cycles=1.0)},
            "spiral": {"links": (90, 170, 0), "pendant": (20, 0, 0)},
            "sway": {"links": Wave(swing=95, cycles=1.0, phase=0.2)},
            "hook": {"links": [(0, 10, 0)] * (count // 2) + [(0, 45, 0)] * (count - count // 2)},
        }
    )


def scissors(rng: Random) -> Skeleton:
    """Build scissors: two blades and two ring handles around a pivot."""
    builder = SkeletonBuilder()
    blade, grip = rng.uniform(0.6, 0.85), rng.uniform(0.25, 0.4)
    thick = rng.uniform(0.045, 0.06)
    open_ = 0.28
    builder.chain("pivot", [[0, 0, -0.03], [0, 0, 0.03]], [1.3 * thick] * 2, toward=(0, -1, 0))
    tip = blade * np.array([np.sin(open_), -np.cos(open_), 0])
    builder.chain(
        "blade",
        [[0.02, -0.02, 0], tip],
        [1.25 * thick, 0.6 * thick],
        parent="pivot.0",
        toward=(1, 0, 0),
        stretch=(1, 1, 0.6),
        both_sides=True,
    )
    wide = rng.uniform(0.11, 0.14)
    neck = grip * np.array([np.sin(0.5), np.cos(0.5), 0])
    builder.chain(
        "grip",
        [[0.02, 0.02, 0], neck],
        [thick, 0.8 * thick],
        parent="pivot.0",
        toward=(1, 0, 0),
        both_sides=True,
    )
    way = neck / grip
    centre = neck + rng.uniform(1.1, 1.5) * wide * way
    long = float(np.linalg.norm(centre - neck))
    across = wide * np.array([way[1], -way[0], 0])
    builder.ring("grip.L.0", centre, [long * way, across], 0.65 * thick, both_sides=True)
    builder.blob("pivot.0", (0, 0, 0.05), (0.05, 0.05, 0.045))
    return builder.build(
        {
            "close": {"blade": (-10, 0, 0), "grip": (-8, 0, 0)},
            "wide": {"blade": (35, 0, 0), "grip": (28, 0, 0)},
            "open": {"blade": (18, 0, 0), "grip": (14, 0, 0)},
            "bent": {"blade.L": (30, 15, 0), "blade.R": (5, 0, 0), "grip": (15, 0, 0)},
        }
    )


def tree(rng: Random) -> Skeleton:
    """Build a tree: a trunk with roots and two orders of branches; it sways."""
    builder = SkeletonBuilder()
    height = rng.uniform(0.9, 1.2)
    builder.chain(
        "trunk",
        between([0, 0, 0], [0.03, 0, height], 4),
        between(rng.uniform(0.085, 0.12), 0.045, 4),
        toward=(0, -1, 0),
    )
    for turn in np.linspace(0, 2 * np.pi, int(rng.integers(3, 6)), endpoint=False) + 0.4:
        out = np.array([np.cos(turn), np.sin(turn), 0])
        builder.stick("trunk.0", [[0, 0, 0.06], 0.17 * out, 0.3 * out - [0, 0, 0.05]], [0.07, 0.05, 0.03])
    names = []
    count = int(rng.integers(5, 8))
    for number in range(count):
        place = 0.42 + 0.55 * number / (count - 1)
        turn = 2.4 * number + rng.uniform(-0.25, 0.25)
        way = np.array([np.cos(turn), np.sin(turn), rng.uniform(0.45, 0.85)])
        way /= np.linalg.norm(way)
        root = np.array([0.03 * place, 0, place * height])
        reach = rng.uniform(0.4, 0.6) * (1.2 - 0.5 * place)
        name = f"branch{number}"
        parent = f"trunk.{min(int(place * 4), 3)}"
        builder.chain(
            name,
            root + np.array([[0.0], [0.35], [0.7], [1.0]]) * reach * way,
            [0.045, 0.038, 0.032, 0.026],
            parent=parent,
            toward=(0, 0, -1),
        )
        for sign in (1, -1):
            twig = way + sign * 0.8 * np.array([-np.sin(turn), np.cos(turn), 0.1])
            start = root + (0.55 + 0.1 * sign) * reach * way
            builder.stick(f"{name}.1", [start, start + 0.38 * reach * twig], [0.03, 0.025])
        names.append(name)
    return builder.build(
        {
            "droop": {**dict.fromkeys(names, (45, 0, 0)), "trunk": (5, 5, 0)},
            "raise": dict.fromkeys(names, (-30, 0, 0)),
            "wind": {**dict.fromkeys(names, (0, 35, 0)), "trunk": (0, 30, 0)},
            "gust": {**dict.fromkeys(names, (20, -30, 0)), "trunk": (35, 0, 0)},
            "twist": {**dict.fromkeys(names, Wave(swing=35, bend=20)), "trunk": (0, 10, 60)},
        }
    )


def excavator_arm(rng: Random) -> Skeleton:
    """Build an excavator arm: a block on a plate with a boom of three parts and a gripper."""
    builder = SkeletonBuilder()
    wide = rng.uniform(0.17, 0.23)
    builder.chain("base", [[0, 0, 0], [0, 0, 0.2]], [0.12, 0.12], toward=(0, -1, 0))
    builder.blob("base.0", (0, 0, -0.08), (1.5 * wide, 1.7 * wide, 0.06), blend=0.2)
    builder.blob("base.0", (0, 0.08, 0.12), (wide, 1.15 * wide, 0.14), blend=0.15)
    one, two = rng.uniform(0.5, 0.7), rng.uniform(0.4, 0.55)
    shoulder = np.array([0, -0.05, 0.26])
    elbow = shoulder + one * np.array([0, -0.45, 0.89])
    wrist = elbow + two * np.array([0, -0.9, -0.1])
    builder.chain(
        "boom",
        [shoulder, elbow, wrist, offset(wrist, 0, -0.12, -0.1)],
        [0.085, 0.065, 0.05, 0.055],
        parent="base.0",
        toward=(0, -1, -0.5),
        stretch=(0.8, 1, 1),
    )
    builder.blob("boom.1", elbow, (0.085, 0.09, 0.09))
    palm = offset(wrist, 0, -0.13, -0.12)
    for name, x, y in (("claw0", 0.1, -0.05), ("claw1", -0.1, -0.05), ("claw2", 0.0, 0.1)):
        out = np.array([x, y, 0.0])
        builder.chain(
            name,
            [
                palm + 0.3 * out,
                palm + 1.1 * offset(out, 0, -0.05, -0.11),
                palm + 0.75 * offset(out, 0, -0.1, -0.25),
            ],
            [0.04, 0.034, 0.026],
            parent="boom.2",
            toward=tuple(offset(out, 0, -0.01, 0.05)),
        )
    grip: Pose = {name: [(-20, 0, 0), (-15, 0, 0)] for name in ("claw0", "claw1", "claw2")}
    open_: Pose = {name: [(30, 0, 0), (10, 0, 0)] for name in ("claw0", "claw1", "claw2")}
    return builder.build(
        {
            "dig": {"boom": [(40, 0, 0), (35, 0, 0), (20, 0, 0)], **open_},
            "lift": {"boom": [(-25, 0, 0), (-30, 0, 0)], **grip},
            "reach": {"boom": [(25, 0, 0), (-35, 0, 0), (-20, 0, 0)], **open_},
            "tuck": {"boom": [(-20, 0, 0), (60, 0, 0), (30, 0, 0)], **grip},
            "turn": {"boom": [(10, 45, 0), (0, 20, 0), (0, 0, 40)]},
        }
    )


KINDS: dict[str, Callable[[Random], Skeleton]] = {
    "hand": hand,
    "desk lamp": desk_lamp,
    "chain": chain,
    "scissors": scissors,
    "tree": tree,
    "excavator arm": excavator_arm,
}
