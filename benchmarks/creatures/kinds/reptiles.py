# SPDX-License-Identifier: MIT
"""Lizards, dinosaurs, turtles and snakes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from benchmarks.creatures.layout import between, offset
from benchmarks.creatures.skeleton import Skeleton, SkeletonBuilder, Wave

__all__ = ["KINDS"]

Random = np.random.Generator
FloatArray = NDArray[np.float64]


def lizard(rng: Random) -> Skeleton:
    """Build a lizard: sprawling legs, toes, a long tail, a back crest; with a long snout a crocodile."""
    builder = SkeletonBuilder()
    length = rng.uniform(0.6, 0.8)
    girth = rng.uniform(0.09, 0.14)
    builder.chain(
        "spine",
        between([0, length / 2, 0], [0, -length / 2, 0], 4),
        np.array([0.8, 1.0, 1.05, 0.95, 0.75]) * girth,
        stretch=(1.15, 1, 0.85),
    )
    snout = rng.uniform(0.12, 0.38)
    neck = np.array([0, -length / 2, 0.02])
    skull = offset(neck, 0, -0.14, 0.03)
    builder.chain("neck", [neck, skull], [0.75 * girth, 0.08], parent="spine.3")
    builder.stick("neck.0", [skull, offset(skull, 0, -snout, -0.03)], [0.085, 0.045], stretch=(1.1, 1, 0.75))
    builder.blob("neck.0", offset(skull, 0.055, -0.03, 0.06), (0.028,) * 3, both_sides=True)
    tail = rng.uniform(0.7, 1.1)
    builder.chain(
        "tail",
        between([0, length / 2, 0], [0, length / 2 + tail, -0.03], 7),
        between(0.75 * girth, 0.028, 7),
        parent="spine.0",
        toward=(0, 0.1, 1),
    )
    for number, y in enumerate(np.linspace(0.35, -0.4, int(rng.integers(3, 6))) * length):
        bone = min(int((0.5 - y / length) * 4), 3)
        builder.stick(
            f"spine.{bone}",
            [[0, y, 0.7 * girth], [0, y + 0.05, girth + 0.04 + 0.01 * (number % 2)]],
            [0.03, 0.024],
            stretch=(0.8, 1, 1),
        )
    reach = rng.uniform(0.2, 0.28)
    for name, y, carrier, lean in (
        ("hind", 0.42 * length, "spine.0", 0.25),
        ("fore", -0.4 * length, "spine.3", -0.2),
    ):
        hip = np.array([0.75 * girth, y, -0.01])
        foot = hip + reach * np.array([1.35, -0.15 + lean, -0.75])
        builder.chain(
            name,
            [hip, hip + reach * np.array([0.85, lean, 0.0]), foot],
            [0.055, 0.042, 0.03],
            parent=carrier,
            toward=(0, -1, 0),
            both_sides=True,
        )
        for toe in ([0.02, -0.1, -0.01], [0.09, -0.05, -0.01], [0.085, 0.035, -0.01]):
            builder.stick(f"{name}.L.1", [foot, foot + toe], [0.026, 0.022], both_sides=True)
    return builder.build(
        {
            "walk": {
                "spine": (0, 30, 0),
                "tail": (0, -50, 0),
                "fore.L": [(30, 0, 0)],
                "fore.R": [(-30, 0, 0)],
                "hind.L": [(-30, 0, 0)],
                "hind.R": [(30, 0, 0)],
            },
            "walk other": {
                "spine": (0, -30, 0),
                "tail": (0, 50, 0),
                "fore.L": [(-30, 0, 0)],
                "fore.R": [(30, 0, 0)],
                "hind.L": [(30, 0, 0)],
                "hind.R": [(-30, 0, 0)],
            },
            "curl": {"spine": (0, 50, 0), "tail": (0, 150, 0), "neck": (0, 25, 0)},
            "swim": {
                "spine": Wave(swing=25, cycles=0.7),
                "tail": Wave(swing=60, cycles=1.0, phase=0.3),
                "fore": [(-50, 10, 0)],
                "hind": [(-45, 10, 0)],
            },
            "rear up": {
                "spine": (-45, 0, 0),
                "neck": (-15, 0, 0),
                "tail": (25, 0, 0),
                "fore": [(30, -15, 0)],
            },
            "tail up": {"tail": (110, 0, 0), "neck": (15, 0, 0)},
        }
    )


def dinosaur(rng: Random) -> Skeleton:
    """Build a dinosaur: two strong legs, tiny arms, a big jaw and a balancing tail."""
    builder = SkeletonBuilder()
    height = rng.uniform(0.65, 0.8)
    girth = rng.uniform(0.17, 0.21)
    builder.chain(
        "spine",
        between([0, 0.12, height], [0, -0.42, height + 0.12], 3),
        np.array([1.0, 1.0, 0.9, 0.62]) * girth,
    )
    neck = np.array([0, -0.44, height + 0.16])
    skull = neck + rng.uniform(0.22, 0.34) * np.array([0, -0.6, 0.75])
    builder.chain("neck", between(neck, skull, 2), [0.12, 0.1, 0.11], parent="spine.2", toward=(0, -0.5, -1))
    jaw = rng.uniform(0.26, 0.36)
    builder.stick("neck.1", [skull, offset(skull, 0, -jaw, 0.03)], [0.11, 0.06], stretch=(0.9, 1, 0.8))
    builder.chain(
        "jaw",
        [offset(skull, 0, 0, -0.06), offset(skull, 0, -0.85 * jaw, -0.13)],
        [0.07, 0.034],
        parent="neck.1",
    )
    builder.blob("neck.1", offset(skull, 0.08, -0.06, 0.07), (0.03,) * 3, both_sides=True)
    builder.chain(
        "tail",
        between([0, 0.15, height], [0, rng.uniform(1.0, 1.3), height + 0.05], 6),
        between(0.92 * girth, 0.032, 6),
        parent="spine.0",
        toward=(0, 0.1, 1),
    )
    x = 0.75 * girth + 0.02
    ankle = np.array([1.15 * x, 0.06, 0.05])
    builder.chain(
        "leg",
        [[x, 0.05, height - 0.04], [1.2 * x, -0.14, 0.55 * height], [1.15 * x, 0.14, 0.28 * height], ankle],
        [0.135, 0.085, 0.055, 0.048],
        parent="spine.0",
        toward=(0, 1, 0),
        both_sides=True,
    )
    for toe in ([-0.07, -0.18, -0.01], [0.05, -0.19, -0.01]):
        builder.stick("leg.L.2", [ankle, ankle + toe], [0.048, 0.034], both_sides=True)
    arm = np.array([0.11, -0.42, height + 0.02])
    builder.chain(
        "arm",
        [arm, offset(arm, 0.05, -0.03, -0.12), offset(arm, 0.06, -0.14, -0.15)],
        [0.04, 0.032, 0.03],
        parent="spine.2",
        toward=(0, -1, 0.3),
        both_sides=True,
    )
    return builder.build(
        {
            "stride": {
                "leg.L": [(-40, 0, 0), (30, 0, 0), (-10, 0, 0)],
                "leg.R": [(35, 0, 0), (10, 0, 0)],
                "tail": (0, 30, 0),
                "spine": (0, -8, 0),
            },
            "roar": {
                "spine": (-25, 0, 0),
                "neck": (-25, 0, 0),
                "jaw": (30, 0, 0),
                "tail": (-20, 0, 0),
                "arm": [(40, 0, 0)],
            },
            "stoop": {"spine": (35, 0, 0), "neck": (30, 0, 0), "tail": (25, 0, 0), "jaw": (15, 0, 0)},
            "turn": {
                "spine": (0, 25, 0),
                "neck": (0, 40, 0),
                "tail": (0, 80, 0),
                "leg.L": [(-20, 0, 0), (20, 0, 0)],
            },
            "crouch": {"leg": [(-45, 5, 0), (70, 0, 0), (-45, 0, 0)], "tail": Wave(swing=50, cycles=1.0)},
            "leap": {
                "leg": [(40, 0, 0), (-20, 0, 0), (20, 0, 0)],
                "arm": [(50, 0, 0)],
                "neck": (-15, 0, 0),
                "tail": (30, 0, 0),
            },
        }
    )


def turtle(rng: Random) -> Skeleton:
    """Build a turtle: a shell with flippers or feet."""
    builder = SkeletonBuilder()
    long, wide = rng.uniform(0.36, 0.46), rng.uniform(0.28, 0.36)
    high = rng.uniform(0.13, 0.24)
    builder.chain("shell", [[0, 0.15, 0], [0, -0.15, 0]], [0.12, 0.12], stretch=(1, 1, 0.7))
    builder.blob("shell.0", (0, 0, 0.04), (wide, long, high))
    builder.stick(
        "shell.0",
        between([0, 0.6 * long, 0.75 * high], [0, -0.6 * long, 0.75 * high], 1),
        [0.05, 0.05],
        stretch=(0.8, 1, 1.6),
    )
    throat = np.array([0, -0.85 * long, 0.02])
    skull = throat + rng.uniform(0.16, 0.26) * np.array([0, -1, 0.25])
    builder.chain("neck", between(throat, skull, 2), [0.075, 0.06, 0.08], parent="shell.0")
    builder.stick("neck.1", [skull, offset(skull, 0, -0.09, -0.02)], [0.082, 0.05])
    fin = rng.uniform(0.2, 0.42)
    builder.chain(
        "fore",
        [
            [0.7 * wide, -0.62 * long, 0],
            [0.75 * wide + 0.5 * fin, -0.8 * long - 0.1 * fin, -0.02],
            [0.75 * wide + fin, -0.7 * long + 0.25 * fin, -0.04],
        ],
        [0.085, 0.085, 0.05],
        parent="shell.0",
        toward=(0, 0, 1),
        stretch=(1, 1, 0.5),
        both_sides=True,
    )
    builder.chain(
        "hind",
        [[0.62 * wide, 0.72 * long, 0], [0.7 * wide + 0.12, long + 0.08, -0.03]],
        [0.08, 0.075],
        parent="shell.0",
        toward=(0, 0, 1),
        stretch=(1, 1, 0.5),
        both_sides=True,
    )
    builder.chain(
        "tail",
        [[0, 0.9 * long, -0.01], [0, 1.3 * long, -0.02]],
        [0.05, 0.028],
        parent="shell.0",
        toward=(0, 0, 1),
    )
    return builder.build(
        {
            "swim up": {"fore": [(40, 0, 0), (15, 0, 0)], "hind": (-20, 0, 0), "neck": (-20, 0, 0)},
            "swim down": {"fore": [(-40, 0, 0), (-15, 0, 0)], "hind": (20, 0, 0), "neck": (15, 0, 0)},
            "row": {"fore": [(0, -45, 0), (0, -20, 0)], "hind": (0, 20, 0)},
            "walk": {
                "fore.L": [(-15, 35, 0)],
                "fore.R": [(-15, -35, 0)],
                "hind.L": [(0, -25, 0)],
                "hind.R": [(0, 25, 0)],
                "neck": (0, 30, 0),
            },
            "look": {"neck": (-25, 45, 0), "tail": (0, 40, 0)},
        }
    )


def snake(rng: Random) -> Skeleton:
    """Build a snake: a long body with a flat head; some have a hood or a rattle."""
    builder = SkeletonBuilder()
    segments = int(rng.integers(14, 20))
    thick = rng.uniform(0.028, 0.04)
    length = rng.uniform(2.0, 2.6)
    place = np.linspace(0, 1, segments + 1)
    radii = thick * (0.45 + 0.8 * np.sin(np.pi * (0.1 + 0.85 * (1 - place))) ** 0.7)
    builder.chain("body", between([0, length / 2, 0], [0, -length / 2, 0], segments), radii.tolist())
    head = np.array([0, -length / 2, 0])
    builder.stick(
        f"body.{segments - 1}",
        [head, offset(head, 0, -2.4 * thick, 0)],
        [1.5 * thick, 0.8 * thick],
        stretch=(1.2, 1, 0.8),
    )
    builder.blob(
        f"body.{segments - 1}",
        head + np.array([0.9, -1.0, 0.85]) * thick,
        (0.45 * thick,) * 3,
        both_sides=True,
    )
    if rng.random() < 0.4:
        builder.blob(f"body.{segments - 2}", offset(head, 0, 0.12, 0), (3.2 * thick, 0.13, 0.9 * thick))
    if rng.random() < 0.4:
        for number in range(3):
            builder.blob("body.0", (0, length / 2 + 1.3 * thick * number, 0), (0.95 * thick,) * 3)
    return builder.build(
        {
            "slither": {"body": Wave(swing=75, cycles=1.5)},
            "slither wide": {"body": Wave(swing=100, cycles=1.0, phase=0.1)},
            "curl": {"body": (0, 260, 0)},
            "rise": {"body": [(0, 12, 0)] * (segments - 7) + [(-18, 0, 0)] * 4 + [(12, 0, 0)] * 3},
            "hook": {"body": [(0, 2, 0)] * (segments // 2) + [(0, 18, 0)] * (segments // 2)},
            "arch": {"body": Wave(bend=85, cycles=1.0)},
        }
    )


KINDS: dict[str, Callable[[Random], Skeleton]] = {
    "lizard": lizard,
    "dinosaur": dinosaur,
    "turtle": turtle,
    "snake": snake,
}
