# SPDX-License-Identifier: MIT
"""Mammals on four legs, and what is put together from them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from benchmarks.creatures.kinds.bipeds import BIPED_POSES, add_arms, add_human_head
from benchmarks.creatures.layout import between, offset
from benchmarks.creatures.skeleton import Pose, Skeleton, SkeletonBuilder, Vector, Wave

__all__ = ["KINDS"]

Random = np.random.Generator
FloatArray = NDArray[np.float64]

_FORWARD = np.array([0.0, -1.0, 0.0])
_UP = np.array([0.0, 0.0, 1.0])
_BACK = (0, 1, 0)

_QUADRUPED_POSES: dict[str, Pose] = {
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


def _add_quadruped_torso(
    builder: SkeletonBuilder, length: float, height: float, radii: Vector, wide: float = 0.9
) -> None:
    """Spine from hips to chest; `radii` at hips, waist, ribs and chest, `wide` is width over depth."""
    spine = between([0, length / 2, height], [0, -length / 2, height], 3)
    builder.chain("spine", spine, radii, stretch=(wide, 1, 1))


def _add_quadruped_legs(
    builder: SkeletonBuilder,
    length: float,
    height: float,
    spread: float,
    thick: float,
    thin: float,
    foot: float,
) -> None:
    """Hind legs with a hock and fore legs, from a torso of this length and height down to the ground.

    `thick` and `thin` are the radii at hip and ankle; `foot` is the length of the foot.
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
            toward=_BACK,
            both_sides=True,
        )
        toe = [1.05 * spread, depth[3] - foot, 0.8 * thin]
        builder.stick(f"{name}.L.2", [[x[3], depth[3], ankle], toe], [thin, 0.85 * thin], both_sides=True)


def _neck_and_head(
    builder: SkeletonBuilder,
    base: FloatArray,
    direction: FloatArray,
    length: float,
    radii: tuple[float, float],
    head: float,
    muzzle: float,
    segments: int = 2,
) -> tuple[FloatArray, FloatArray]:
    """Neck, skull and muzzle with eye bumps; returns the skull's centre and the tip of the muzzle.

    `head` is the skull's radius, `muzzle` the length of the muzzle in skull radii.
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


def _ears(builder: SkeletonBuilder, skull: FloatArray, head: float, length: float, wide: float) -> None:
    root = skull + head * np.array([0.55, 0.25, 0.6])
    tip = root + length * head * np.array([0.35, 0.15, 1.0])
    builder.stick(
        "head.0", [root, tip], [wide * head, 0.6 * wide * head], stretch=(1, 0.65, 1), both_sides=True
    )


def _tail(
    builder: SkeletonBuilder,
    base: FloatArray,
    direction: Vector,
    length: float,
    radii: Vector,
) -> None:
    way = np.asarray(direction, float)
    points = between(base, base + length * way / np.linalg.norm(way), 4)
    builder.chain("tail", points, between(radii[0], radii[1], 4), parent="spine.0", toward=(0, 0.3, 1))


def horse(rng: Random) -> Skeleton:
    """Build a horse: long thin legs, a long neck with a mane, a brush of a tail."""
    builder = SkeletonBuilder()
    length, height = rng.uniform(0.9, 1.15), rng.uniform(0.85, 1.05)
    barrel = rng.uniform(0.19, 0.25)
    _add_quadruped_torso(builder, length, height, np.array([0.95, 0.95, 1.05, 0.9]) * barrel)
    _add_quadruped_legs(
        builder, length, height, 0.11, rng.uniform(0.085, 0.1), rng.uniform(0.036, 0.048), 0.07
    )
    chest = np.array([0, -0.5 * length, height + 0.05])
    reach = rng.uniform(0.45, 0.62)
    head = rng.uniform(0.095, 0.12)
    skull, _ = _neck_and_head(
        builder, chest, _FORWARD * 0.8 + _UP, reach, (0.15, 0.09), head, rng.uniform(1.8, 2.4), 3
    )
    _ears(builder, skull, head, rng.uniform(0.9, 1.3), 0.35)
    mane = between(offset(chest, 0, 0.13, 0.1), offset(skull, 0, 0.1, 0.08), 4)
    for number in range(3):
        builder.stick(f"neck.{number}", mane[number : number + 3], [0.045, 0.05, 0.045], stretch=(0.7, 1, 1))
    _tail(
        builder,
        np.array([0, 0.5 * length + 0.08, height + 0.08]),
        (0, 0.55, -1),
        rng.uniform(0.55, 0.8),
        (0.05, 0.04),
    )
    builder.blob("tail.2", (0, 0.5 * length + 0.33, height - 0.35), (0.055, 0.075, 0.16))
    return builder.build(_QUADRUPED_POSES)


def dog(rng: Random) -> Skeleton:
    """Build a dog, or a cat if the muzzle is short."""
    builder = SkeletonBuilder()
    length, height = rng.uniform(0.75, 1.05), rng.uniform(0.4, 0.62)
    barrel = rng.uniform(0.11, 0.16)
    _add_quadruped_torso(builder, length, height, np.array([0.85, 0.8, 1.05, 0.95]) * barrel)
    thin = rng.uniform(0.032, 0.045)
    _add_quadruped_legs(builder, length, height, 0.62 * barrel, 1.9 * thin, thin, 2.2 * thin)
    head = rng.uniform(0.09, 0.125)
    chest = np.array([0, -0.5 * length, height + 0.06])
    skull, nose = _neck_and_head(
        builder,
        chest,
        _FORWARD * 0.9 + _UP,
        rng.uniform(0.16, 0.3),
        (0.1, 0.085),
        head,
        rng.uniform(0.2, 1.5),
    )
    builder.blob("head.1", offset(nose, 0, -0.02, 0.02), (0.35 * head, 0.3 * head, 0.3 * head))
    _ears(builder, skull, head, rng.uniform(0.6, 1.3), rng.uniform(0.4, 0.6))
    tail = np.array([0, 0.5 * length + 0.06, height + 0.05])
    thick = rng.uniform(0.028, 0.06)
    _tail(builder, tail, (0, 1, rng.uniform(-0.4, 0.9)), rng.uniform(0.3, 0.65), (thick, 0.7 * thick))
    return builder.build(_QUADRUPED_POSES)


def deer(rng: Random) -> Skeleton:
    """Build a deer: slender, with branching antlers and a stub of a tail."""
    builder = SkeletonBuilder()
    length, height = rng.uniform(0.75, 0.95), rng.uniform(0.8, 0.98)
    barrel = rng.uniform(0.145, 0.19)
    _add_quadruped_torso(builder, length, height, np.array([0.9, 0.85, 1.05, 0.9]) * barrel)
    _add_quadruped_legs(builder, length, height, 0.09, 0.07, rng.uniform(0.03, 0.037), 0.05)
    head = rng.uniform(0.075, 0.09)
    chest = np.array([0, -0.48 * length, height + 0.04])
    skull, _ = _neck_and_head(
        builder, chest, _FORWARD * 0.55 + _UP, rng.uniform(0.38, 0.5), (0.1, 0.065), head, 1.6, 3
    )
    _ears(builder, skull, head, 1.1, 0.42)
    root = skull + np.array([0.035, 0.02, 0.07])
    span = rng.uniform(0.3, 0.5)
    beam = root + span * np.array([[0, 0, 0], [0.35, 0.2, 0.4], [0.55, 0.05, 0.8], [0.5, -0.25, 1.1]])
    builder.stick("head.0", beam, [0.03, 0.026, 0.024, 0.022], both_sides=True)
    for joint, way in zip(
        beam[: rng.integers(2, 4)], ([0.1, -0.5, 0.35], [0.1, -0.5, 0.3], [0.35, 0.2, 0.3]), strict=False
    ):
        builder.stick("head.0", [joint, joint + 0.6 * span * np.array(way)], [0.024, 0.021], both_sides=True)
    _tail(builder, np.array([0, 0.5 * length + 0.1, height + 0.05]), (0, 1, -0.3), 0.14, (0.045, 0.03))
    return builder.build(_QUADRUPED_POSES)


def elephant(rng: Random) -> Skeleton:
    """Build an elephant: heavy, on columns, with trunk, tusks and large ears."""
    builder = SkeletonBuilder()
    length, height = rng.uniform(0.95, 1.15), rng.uniform(0.75, 0.9)
    barrel = rng.uniform(0.3, 0.36)
    _add_quadruped_torso(builder, length, height, np.array([0.92, 1.0, 1.03, 0.85]) * barrel)
    thin = rng.uniform(0.085, 0.105)
    _add_quadruped_legs(builder, length, height, 0.19, 1.4 * thin, thin, 0.04)
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
    _tail(builder, np.array([0, 0.5 * length + 0.24, height + 0.05]), (0, 0.35, -1), 0.45, (0.045, 0.032))
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
    kept = {name: _QUADRUPED_POSES[name] for name in ("walk", "rear", "look back")}
    return builder.build({**kept, **extra})


def giraffe(rng: Random) -> Skeleton:
    """Build a giraffe: a very long neck on long legs."""
    builder = SkeletonBuilder()
    length, height = rng.uniform(0.6, 0.75), rng.uniform(0.85, 1.05)
    barrel = rng.uniform(0.15, 0.19)
    _add_quadruped_torso(builder, length, height, np.array([0.85, 0.95, 1.05, 1.0]) * barrel)
    _add_quadruped_legs(builder, length, height, 0.09, 0.075, rng.uniform(0.032, 0.04), 0.04)
    head = rng.uniform(0.075, 0.09)
    chest = np.array([0, -0.47 * length, height + 0.06])
    reach = rng.uniform(0.85, 1.15)
    skull, _ = _neck_and_head(builder, chest, _FORWARD * 0.4 + _UP, reach, (0.12, 0.06), head, 1.6, 6)
    _ears(builder, skull, head, 1.0, 0.4)
    horn = skull + np.array([0.03, -0.01, 0.06])
    builder.stick("head.0", [horn, offset(horn, 0.01, 0.01, 0.11)], [0.024, 0.026], both_sides=True)
    _tail(builder, np.array([0, 0.5 * length + 0.08, height + 0.05]), (0, 0.4, -1), 0.5, (0.034, 0.028))
    extra: dict[str, Pose] = {
        "drink": {"neck": (125, 0, 0), "fore": [(-8, 22, 0)], "head": (-30, 0, 0)},
        "reach up": {"neck": (-22, 0, 0), "head": (-25, 0, 0)},
        "curve": {"neck": Wave(bend=45, cycles=1.0), "tail": (30, 0, 0)},
    }
    kept = {name: _QUADRUPED_POSES[name] for name in ("walk", "gallop", "look back", "lie", "kick")}
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
        toward=_BACK,
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
    skull, _ = _neck_and_head(builder, chest, _FORWARD * 0.5 + _UP, 0.16, (0.085, 0.06), head, 1.3)
    _ears(builder, skull, head, rng.uniform(1.6, 2.4), 0.4)
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
    _add_quadruped_torso(builder, length, height, np.array([0.95, 0.95, 1.0, 0.9]) * barrel)
    _add_quadruped_legs(builder, length, height, 0.1, 0.08, rng.uniform(0.036, 0.044), 0.06)
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
    _tail(
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
            chain: rule
            for chain, rule in _QUADRUPED_POSES[quadruped].items()
            if chain not in ("neck", "head")
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
