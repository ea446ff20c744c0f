# SPDX-License-Identifier: MIT
"""Things to wear and carry: hats, glasses, shoes, suitcases, shields, helmets, rings."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.things.part import (
    Part,
    ball,
    box,
    curve,
    cylinder,
    join,
    lathe,
    loft,
    mirrored_pair,
    ring,
    sheet,
    tube,
)

__all__ = ["KINDS"]


def hat(rng: np.random.Generator) -> list[Part]:
    brim, crown, height, sides = (
        rng.uniform(0.7, 1.1),
        rng.uniform(0.4, 0.5),
        rng.uniform(0.35, 0.8),
        int(rng.choice([12, 20, 28])),
    )
    top = crown * rng.uniform(0.5, 1.0)
    points = [
        (brim, rng.uniform(-0.1, 0.15)),
        (crown * 1.05, 0.0),
        (crown, 0.06),
        (top, height),
        (top * 0.6, height + rng.uniform(-0.08, 0.08)),
        (0.0, height),
    ]
    shell = lathe(points, sides)
    band = lathe([(crown * 1.03, 0.04), (crown * 1.02, 0.14)], sides)
    return [shell.scaled(1, rng.uniform(1, 1.2), 1), band]


def spectacles(rng: np.random.Generator) -> list[Part]:
    radius, gap, rim = rng.uniform(0.24, 0.34), rng.uniform(0.1, 0.16), rng.uniform(0.015, 0.04)
    frame = (
        ring(radius, rim, int(rng.choice([4, 8, 20])), 6)
        .turned("z", 45)
        .scaled(y=rng.uniform(0.7, 1))
        .turned("x", 90)
    )
    x = radius + gap / 2
    parts = [mirrored_pair(frame.at(x))]
    parts.append(tube(curve([[-gap / 2, 0, 0.05], [0, 0, 0.1], [gap / 2, 0, 0.05]], 5), rim * 0.8, 5))
    arm = curve([[x + radius, 0, 0.05], [x + radius, 1.0, 0.05], [x + radius * 0.9, 1.25, -0.2]], 9)
    parts.append(mirrored_pair(tube(arm, rim * 0.8, 5)))
    return parts


def shoe(rng: np.random.Generator) -> list[Part]:
    length, width, heel = (
        rng.uniform(1.0, 1.3),
        rng.uniform(0.36, 0.45),
        rng.choice([0.06, rng.uniform(0.1, 0.4)]),
    )
    ankle = rng.uniform(0.3, 0.9)
    angle = np.linspace(0, 2 * np.pi, 14, endpoint=False)
    loops = []
    for share, high in (
        (0.0, 0.1),
        (0.12, 0.2),
        (0.35, 0.26),
        (0.55, 0.36),
        (0.72, 0.4),
        (0.9, 0.4),
        (1.0, 0.36),
    ):
        half = width / 2 * (0.35 + 0.65 * np.sin(np.pi * min(0.95, share + 0.12)) ** 0.5)
        floor = heel * np.clip((share - 0.35) / 0.4, 0, 1)
        loops.append(
            [
                [half * np.cos(a), (share - 0.5) * length, floor + high / 2 + high / 2 * np.sin(a)]
                for a in angle
            ]
        )
    parts = [loft(loops)]
    parts.append(box(width * 0.6, length * 0.2, heel, top=1.15).at(y=length * 0.38))
    shaft = lathe([(0.17, 0.0), (0.19, ankle), (0.15, ankle), (0.13, 0.0)], 12).at(
        y=length * 0.3, z=heel + 0.25
    )
    return [*parts, shaft]


def suitcase(rng: np.random.Generator) -> list[Part]:
    width, depth, height = rng.uniform(0.9, 1.4), rng.uniform(0.25, 0.45), rng.uniform(0.65, 0.95)
    parts = [box(width, depth, height, top=rng.uniform(0.94, 1))]
    grip = curve(
        [[-0.18, 0, height], [-0.14, 0, height + 0.14], [0.14, 0, height + 0.14], [0.18, 0, height]], 10
    )
    parts.append(tube(grip, 0.03, 6))
    parts += (
        [box(0.06, depth * 1.05, height * 1.01).at(x * width * 0.3) for x in (-1, 1)]
        if rng.random() < 0.5
        else []
    )
    parts += [box(0.1, 0.04, 0.12).at(x * width * 0.3, -depth / 2, height * 0.8) for x in (-1, 1)]
    if rng.random() < 0.4:
        parts += [cylinder(0.05, 0.06, 10).turned("y", 90).at(x * width * 0.42, 0, -0.04) for x in (-1, 1)]
    return parts


def shield(rng: np.random.Generator) -> list[Part]:
    if rng.random() < 0.5:
        sides = int(rng.choice([16, 24]))
        face = lathe([(0.0, rng.uniform(0.15, 0.3)), (0.5, 0.12), (1.0, 0.0)], sides)
        return [
            join([face, ring(1, 0.06, sides, 6), ball(0.2, 0.2, 0.15, 10).at(z=0.2)]).turned("x", 90).at(z=1)
        ]
    half = curve([(0.8, 1.2), (0.85, 0.6), (0.6, -0.2), (0.0, -1.0)], 9)
    across = np.linspace(-1, 1, 7)
    rows = [[[x * width, 0.2 * x * x - 0.2, height] for x in across] for width, height in half]
    front = sheet(rows)
    return [
        front,
        front.at(y=0.06),
        box(0.1, 0.08, 1.8).at(y=-0.2, z=-0.7),
        box(1.2, 0.08, 0.1).at(y=-0.15, z=0.4),
    ]


def helmet(rng: np.random.Generator) -> list[Part]:
    sides = int(rng.choice([12, 18, 24]))
    angle = np.linspace(np.pi / 2, -rng.uniform(0.0, 0.5), 9)
    shell = np.stack([np.cos(angle), np.sin(angle)], 1)
    parts = [lathe([*shell, *(shell[::-1] * 0.93)], sides).scaled(0.8, 1.0, 0.9)]
    style = rng.integers(3)
    if style == 0:
        parts += [cylinder(0.08, 0.8, 8, top=0.01).turned("y", x * 60).at(x * 0.6, 0, 0.4) for x in (-1, 1)]
    elif style == 1:
        parts.append(box(0.06, 1.7, 0.5, top=(1, 0.6)).at(z=0.7))
    parts.append(lathe([(1.0, -0.02), (1.12, -0.06), (1.0, 0.04)], sides).scaled(0.8, 1.0, 0.9))
    if rng.random() < 0.5:
        parts.append(box(0.12, 0.06, 0.6).at(y=-0.95, z=-0.5))
    return parts


def finger_ring(rng: np.random.Generator) -> list[Part]:
    thick, sides = rng.uniform(0.08, 0.16), int(rng.choice([20, 32]))
    band = ring(1.0, thick, sides, int(rng.choice([6, 10]))).scaled(z=rng.uniform(0.8, 2)).turned("x", 90)
    stone = cylinder(0.05, 0.25, 8, top=rng.uniform(0.25, 0.4))
    table = cylinder(stone.vertices[:, 0].max(), 0.12, 8, top=0.2).at(z=0.25)
    return [band, join([stone, table]).at(z=0.95 + thick)]


KINDS: dict[str, Callable[[np.random.Generator], list[Part]]] = {
    "hat": hat,
    "spectacles": spectacles,
    "shoe": shoe,
    "suitcase": suitcase,
    "shield": shield,
    "helmet": helmet,
    "finger ring": finger_ring,
}
