# SPDX-License-Identifier: MIT
"""Four-legged mammals, the kangaroo, and the centaur."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from benchmarks.creatures.kinds.bipeds import BIPED_POSES, add_arms, add_human_head
from benchmarks.creatures.kinds.quadruped_parts import (
    BACK,
    FORWARD,
    QUADRUPED_POSES,
    UP,
    add_ears,
    add_legs,
    add_neck_and_head,
    add_tail,
    add_torso,
)
from benchmarks.creatures.layout import between, offset
from benchmarks.creatures.skeleton import Pose, Skeleton, SkeletonBuilder, Wave

__all__ = ["KINDS"]

Random = np.random.Generator
FloatArray = NDArray[np.float64]


def horse(rng: Random) -> Skeleton:
    """Build a horse: long thin legs, a long neck with a mane, a brush of a tail."""
    builder = SkeletonBuilder()
    length, height = rng.uniform(0.9, 1.15), rng.uniform(0.85, 1.05)
    barrel = rng.uniform(0.19, 0.25)
    add_torso(builder, length, height, np.array([0.95, 0.95, 1.05, 0.9]) * barrel)
    add_legs(builder, length, height, 0.11, rng.uniform(0.085, 0.1), rng.uniform(0.036, 0.048), 0.07)
    chest = np.array([0, -0.5 * length, height + 0.05])
    reach = rng.uniform(0.45, 0.62)
    head = rng.uniform(0.095, 0.12)
    skull, _ = add_neck_and_head(
        builder, chest, FORWARD * 0.8 + UP, reach, (0.15, 0.09), head, rng.uniform(1.8, 2.4), 3
    )
    add_ears(builder, skull, head, rng.uniform(0.9, 1.3), 0.35)
    mane = between(offset(chest, 0, 0.13, 0.1), offset(skull, 0, 0.1, 0.08), 4)
    for number in range(3):
        builder.stick(f"neck.{number}", mane[number : number + 3], [0.045, 0.05, 0.045], stretch=(0.7, 1, 1))
    add_tail(
        builder,
        np.array([0, 0.5 * length + 0.08, height + 0.08]),
        (0, 0.55, -1),
        rng.uniform(0.55, 0.8),
        (0.05, 0.04),
    )
    builder.blob("tail.2", (0, 0.5 * length + 0.33, height - 0.35), (0.055, 0.075, 0.16))
    return builder.build(QUADRUPED_POSES)


def dog(rng: Random) -> Skeleton:
    """Build a dog, or a cat if the muzzle is short."""
    builder = SkeletonBuilder()
    length, height = rng.uniform(0.75, 1.05), rng.uniform(0.4, 0.62)
    barrel = rng.uniform(0.11, 0.16)
    add_torso(builder, length, height, np.array([0.85, 0.8, 1.05, 0.95]) * barrel)
    thin = rng.uniform(0.032, 0.045)
    add_legs(builder, length, height, 0.62 * barrel, 1.9 * thin, thin, 2.2 * thin)
    head = rng.uniform(0.09, 0.125)
    chest = np.array([0, -0.5 * length, height + 0.06])
    skull, nose = add_neck_and_head(
        builder,
        chest,
        FORWARD * 0.9 + UP,
        rng.uniform(0.16, 0.3),
        (0.1, 0.085),
        head,
        rng.uniform(0.2, 1.5),
    )
    builder.blob("head.1", offset(nose, 0, -0.02, 0.02), (0.35 * head, 0.3 * head, 0.3 * head))
    add_ears(builder, skull, head, rng.uniform(0.6, 1.3), rng.uniform(0.4, 0.6))
    tail = np.array([0, 0.5 * length + 0.06, height + 0.05])
    thick = rng.uniform(0.028, 0.06)
    add_tail(builder, tail, (0, 1, rng.uniform(-0.4, 0.9)), rng.uniform(0.3, 0.65), (thick, 0.7 * thick))
    return builder.build(QUADRUPED_POSES)


def deer(rng: Random) -> Skeleton:
    """Build a deer: slender, with branching antlers and a stub of a tail."""
    builder = SkeletonBuilder()
    length, height = rng.uniform(0.75, 0.95), rng.uniform(0.8, 0.98)
    barrel = rng.uniform(0.145, 0.19)
    add_torso(builder, length, height, np.array([0.9, 0.85, 1.05, 0.9]) * barrel)
    add_legs(builder, length, height, 0.09, 0.07, rng.uniform(0.03, 0.037), 0.05)
    head = rng.uniform(0.075, 0.09)
    chest = np.array([0, -0.48 * length, height + 0.04])
    skull, _ = add_neck_and_head(
        builder, chest, FORWARD * 0.55 + UP, rng.uniform(0.38, 0.5), (0.1, 0.065), head, 1.6, 3
    )
    add_ears(builder, skull, head, 1.1, 0.42)
    root = skull + np.array([0.035, 0.02, 0.07])
    span = rng.uniform(0.3, 0.5)
    beam = root + span * np.array([[0, 0, 0], [0.35, 0.2, 0.4], [0.55, 0.05, 0.8], [0.5, -0.25, 1.1]])
    builder.stick("head.0", beam, [0.03, 0.026, 0.024, 0.022], both_sides=True)
    for joint, way in zip(
        beam[: rng.integers(2, 4)], ([0.1, -0.5, 0.35], [0.1, -0.5, 0.3], [0.35, 0.2, 0.3]), strict=False
    ):
        builder.stick("head.0", [joint, joint + 0.6 * span * np.array(way)], [0.024, 0.021], both_sides=True)
    add_tail(builder, np.array([0, 0.5 * length + 0.1, height + 0.05]), (0, 1, -0.3), 0.14, (0.045, 0.03))
    return builder.build(QUADRUPED_POSES)


def elephant(rng: Random) -> Skeleton:
    """Build an elephant: heavy, on columns, with trunk, tusks and large ears."""
    builder = SkeletonBuilder()
    length, height = rng.uniform(0.95, 1.15), rng.uniform(0.75, 0.9)
    barrel = rng.uniform(0.3, 0.36)
    add_torso(builder, length, height, np.array([0.92, 1.0, 1.03, 0.85]) * barrel)
    thin = rng.uniform(0.085, 0.105)
    add_legs(builder, length, height, 0.19, 1.4 * thin, thin, 0.04)
    head = rng.uniform(0.19, 0.23)
    chest = np.array([0, -0.5 * length - 0.1, height + 0.12])
    skull = chest + np.array([0, -0.2, 0.12])
    builder.chain("neck", [chest, skull], [0.2, head], parent="spine.2")
    builder.chain("head", [skull, offset(skull, 0, -0.16, -0.12)], [head, 0.7 * head], parent="neck.0")
    trunk = offset(skull, 0, -0.2, -0.14)
    span = rng.uniform(0.6, 0.8)
    joints = trunk + span * np.array(
        [
            [0, 0, 0],
            [0, -0.16, -0.12],
            [0, -0.23, -0.32],
            [0, -0.24, -0.55],
            [0, -0.24, -0.78],
            [0, -0.27, -1.0],
        ]
    )
    builder.chain("trunk", joints, between(0.1, 0.045, 5), parent="head.0", toward=(0, -1, 0))
    if rng.random() < 0.75:
        root = offset(skull, 0.11, -0.2, -0.17)
        tusk = root + rng.uniform(0.22, 0.36) * np.array([[0, 0, 0], [0.2, -0.5, -0.45], [0.25, -1.0, -0.5]])
        builder.stick("head.0", tusk, [0.045, 0.036, 0.03], both_sides=True)
    flap = rng.uniform(0.16, 0.25)
    builder.chain(
        "ear",
        [offset(skull, 0.75 * head, 0.04, 0.06), offset(skull, 0.75 * head + flap, 0.12, 0.02)],
        [0.13, 0.9 * flap],
        parent="head.0",
        toward=(0, -1, 0),
        stretch=(0.8, 0.2, 1),
        both_sides=True,
    )
    add_tail(builder, np.array([0, 0.5 * length + 0.24, height + 0.05]), (0, 0.35, -1), 0.45, (0.045, 0.032))
    extra: dict[str, Pose] = {
        "trumpet": {
            "trunk": (150, 0, 0),
            "neck": (-20, 0, 0),
            "ear": (25, 0, 0),
            "fore.L": [(-25, 0, 0), (30, 0, 0)],
        },
        "drink": {
            "trunk": [(20, 0, 0), (0, 0, 0), (-40, 0, 0), (-50, 0, 0), (-50, 0, 0)],
            "neck": (15, 0, 0),
        },
        "swing": {"trunk": Wave(swing=50, cycles=0.5), "ear": (-30, 0, 0), "neck": (0, 20, 0)},
    }
    kept = {name: QUADRUPED_POSES[name] for name in ("walk", "rear", "look back")}
    return builder.build({**kept, **extra})


def giraffe(rng: Random) -> Skeleton:
    """Build a giraffe: a very long neck on long legs."""
    builder = SkeletonBuilder()
    length, height = rng.uniform(0.6, 0.75), rng.uniform(0.85, 1.05)
    barrel = rng.uniform(0.15, 0.19)
    add_torso(builder, length, height, np.array([0.85, 0.95, 1.05, 1.0]) * barrel)
    add_legs(builder, length, height, 0.09, 0.075, rng.uniform(0.032, 0.04), 0.04)
    head = rng.uniform(0.075, 0.09)
    chest = np.array([0, -0.47 * length, height + 0.06])
    reach = rng.uniform(0.85, 1.15)
    skull, _ = add_neck_and_head(builder, chest, FORWARD * 0.4 + UP, reach, (0.12, 0.06), head, 1.6, 6)
    add_ears(builder, skull, head, 1.0, 0.4)
    horn = skull + np.array([0.03, -0.01, 0.06])
    builder.stick("head.0", [horn, offset(horn, 0.01, 0.01, 0.11)], [0.024, 0.026], both_sides=True)
    add_tail(builder, np.array([0, 0.5 * length + 0.08, height + 0.05]), (0, 0.4, -1), 0.5, (0.034, 0.028))
    extra: dict[str, Pose] = {
        "drink": {"neck": (125, 0, 0), "fore": [(-8, 22, 0)], "head": (-30, 0, 0)},
        "reach up": {"neck": (-22, 0, 0), "head": (-25, 0, 0)},
        "curve": {"neck": Wave(bend=45, cycles=1.0), "tail": (30, 0, 0)},
    }
    kept = {name: QUADRUPED_POSES[name] for name in ("walk", "gallop", "look back", "lie", "kick")}
    return builder.build({**kept, **extra})


def kangaroo(rng: Random) -> Skeleton:
    """Build a kangaroo: upright on long hind feet, with a heavy tail and small arms."""
    builder = SkeletonBuilder()
    hip = np.array([0, 0, rng.uniform(0.5, 0.6)])
    chest = hip + np.array([0, -0.22, rng.uniform(0.45, 0.58)])
    girth = rng.uniform(0.15, 0.19)
    builder.chain(
        "spine", between(hip, chest, 3), np.array([1.05, 0.95, 0.75, 0.5]) * girth, toward=(0, -1, 0)
    )
    x = 0.85 * girth
    builder.chain(
        "leg",
        [offset(hip, x, 0, -0.03), [1.2 * x, -0.22, 0.3], [1.2 * x, 0.1, 0.1], [1.2 * x, -0.32, 0.04]],
        [0.12, 0.065, 0.045, 0.036],
        parent="spine.0",
        toward=BACK,
        both_sides=True,
    )
    builder.chain(
        "arm",
        [
            offset(chest, 0.08, -0.02, -0.06),
            offset(chest, 0.15, -0.1, -0.22),
            offset(chest, 0.16, -0.27, -0.24),
        ],
        [0.045, 0.034, 0.032],
        parent="spine.2",
        toward=(0, -1, 0.3),
        both_sides=True,
    )
    head = rng.uniform(0.075, 0.09)
    skull, _ = add_neck_and_head(builder, chest, FORWARD * 0.5 + UP, 0.16, (0.085, 0.06), head, 1.3)
    add_ears(builder, skull, head, rng.uniform(1.6, 2.4), 0.4)
    tail = rng.uniform(0.7, 1.0)
    joints = hip + tail * np.array(
        [[0, 0.06, -0.02], [0, 0.25, -0.2], [0, 0.5, -0.38], [0, 0.75, -0.45], [0, 1.0, -0.46]]
    )
    builder.chain("tail", joints, between(0.115, 0.038, 4), parent="spine.0", toward=(0, 0.3, 1))
    return builder.build(
        {
            "hop": {"leg": [(50, 0, 0), (-45, 0, 0), (40, 0, 0)], "spine": (30, 0, 0), "tail": (40, 0, 0)},
            "land": {"leg": [(-40, 0, 0), (20, 0, 0)], "tail": (-15, 0, 0), "spine": (15, 0, 0)},
            "box": {"arm.L": [(75, 0, 0)], "arm.R": [(35, 0, 0), (50, 0, 0)], "spine": (-18, 0, 12)},
            "eat": {"spine": (50, 0, 0), "neck": (40, 0, 0), "arm": [(-40, 0, 0)]},
            "look": {"neck": (0, 50, 0), "head": (0, 30, 0), "tail": (0, 60, 0)},
        }
    )


def centaur(rng: Random) -> Skeleton:
    """Build a centaur: a human torso on a horse's body."""
    builder = SkeletonBuilder()
    length, height = rng.uniform(0.8, 1.0), rng.uniform(0.75, 0.9)
    barrel = rng.uniform(0.17, 0.21)
    add_torso(builder, length, height, np.array([0.95, 0.95, 1.0, 0.9]) * barrel)
    add_legs(builder, length, height, 0.1, 0.08, rng.uniform(0.036, 0.044), 0.06)
    waist = np.array([0, -0.5 * length - 0.02, height + 0.08])
    torso = rng.uniform(0.5, 0.6)
    girth = rng.uniform(0.105, 0.13)
    neck = waist + np.array([0, -0.05, torso])
    builder.chain(
        "torso",
        between(waist, neck, 3),
        np.array([1.05, 0.95, 1.15, 0.5]) * girth,
        parent="spine.2",
        blend=0.3,
        toward=(0, -1, 0),
        stretch=(1.25, 0.9, 1),
    )
    add_arms(builder, "torso.2", offset(neck, 1.35 * girth, 0, -0.06), rng.uniform(0.52, 0.62), 0.043)
    add_human_head(builder, "torso.2", neck, rng.uniform(0.1, 0.12), 0.0)
    add_tail(
        builder,
        np.array([0, 0.5 * length + 0.08, height + 0.06]),
        (0, 0.55, -1),
        rng.uniform(0.5, 0.7),
        (0.05, 0.036),
    )
    poses: dict[str, Pose] = {}
    arms = [
        ("gallop", "run"),
        ("walk", "walk"),
        ("rear", "wave"),
        ("look back", "reach"),
        ("gather", "kick"),
        ("lie", "sit"),
    ]
    for quadruped, biped in arms:
        legs = {
            chain: rule for chain, rule in QUADRUPED_POSES[quadruped].items() if chain not in ("neck", "head")
        }
        upper = {
            chain: rule for chain, rule in BIPED_POSES[biped].items() if chain.startswith(("arm", "neck"))
        }
        poses[quadruped] = {**legs, **upper, "torso": (8, 0, 12)}
    return builder.build(poses)


KINDS: dict[str, Callable[[Random], Skeleton]] = {
    "horse": horse,
    "dog": dog,
    "deer": deer,
    "elephant": elephant,
    "giraffe": giraffe,
    "kangaroo": kangaroo,
    "centaur": centaur,
}
