# SPDX-License-Identifier: MIT
"""Watercraft: cargo ships, sailing boats, rowing boats, submarines."""

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
    sheet,
    tube,
)

__all__ = ["KINDS"]


def _hull(length: float, width: float, depth: float, bow: float, deck: bool, stations: int = 10) -> Part:
    """Build a hull with its deck at z = depth; `bow` is the share of its length that narrows, towards -y."""
    loops = []
    for share in np.linspace(0, 1, stations):
        half = width / 2 * min(1.0, (share / bow + 0.02) ** 0.6) * (1 - 0.25 * max(0.0, share - 0.7) / 0.3)
        keel = depth * 0.35 * max(0.0, 1 - share / bow)
        rise = depth * 0.25 * (1 - share) ** 2
        side = [(half, depth + rise), (half * 0.85, depth * 0.45 + keel * 0.5), (0.0, keel)]
        outline = [*side, (-side[1][0], side[1][1]), (-side[0][0], side[0][1])]
        loops.append([[x, (share - 0.5) * length, z] for x, z in outline])
    return loft(loops) if deck else join([sheet(loops), sheet(np.array(loops)[[0, -1]].transpose(1, 0, 2))])


def ship(rng: np.random.Generator) -> list[Part]:
    length, width, depth = rng.uniform(8, 14), rng.uniform(1.4, 2.2), rng.uniform(0.8, 1.3)
    parts = [_hull(length, width, depth, rng.uniform(0.2, 0.35), deck=True)]
    place = rng.choice([0.32, 0.32, 0.0]) * length
    level = depth
    for _ in range(int(rng.integers(2, 5))):
        tall = rng.uniform(0.3, 0.5)
        parts.append(box(width * 0.75, length * rng.uniform(0.08, 0.2), tall, top=0.95).at(y=place, z=level))
        level += tall
    for number in range(int(rng.integers(1, 4))):
        parts.append(cylinder(0.2, rng.uniform(0.6, 1.0), 12).at(y=place + 0.2 + 0.6 * number, z=level - 0.2))
    parts.append(
        tube([[0, -length * 0.2, depth], [0, -length * 0.2, depth + rng.uniform(1.2, 2.4)]], 0.05, 6)
    )
    if rng.random() < 0.5 and place > 0:
        for y in np.arange(-length * 0.35, place - length * 0.12, 0.9):
            parts += [
                box(width * 0.4, 0.8, rng.uniform(0.3, 0.9)).at(x * width * 0.21, y, depth) for x in (-1, 1)
            ]
    return parts


def sailing_boat(rng: np.random.Generator) -> list[Part]:
    length, width, depth = rng.uniform(4, 7), rng.uniform(1.1, 1.6), rng.uniform(0.5, 0.8)
    parts = [_hull(length, width, depth, rng.uniform(0.4, 0.6), deck=True)]
    for number in range(int(rng.integers(1, 3))):
        height, y = rng.uniform(4, 6.5) * (1 - 0.25 * number), -length * 0.1 + number * length * 0.32
        parts.append(tube([[0, y, depth], [0, y, depth + height]], 0.05, 6))
        boom, belly = length * rng.uniform(0.25, 0.4), rng.uniform(0.1, 0.5)
        rows = np.linspace(0, 1, 6)
        sail = [
            [
                [
                    belly * np.sin(np.pi * s) * (1 - t),
                    y + boom * s * (1 - t),
                    depth + 0.5 + (height - 0.7) * t,
                ]
                for s in rows
            ]
            for t in rows
        ]
        parts += [sheet(sail), tube([[0, y, depth + 0.5], [0, y + boom, depth + 0.5]], 0.04, 6)]
        if number == 0 and rng.random() < 0.8:
            jib = [
                [
                    [
                        belly * np.sin(np.pi * s) * (1 - t),
                        y * (1 - s * (1 - t)) + s * (1 - t) * (-length * 0.5) - y * 0,
                        depth + 0.3 + (height - 1) * t,
                    ]
                    for s in rows
                ]
                for t in rows
            ]
            parts.append(sheet(jib))
    if rng.random() < 0.5:
        parts.append(box(width * 0.5, length * 0.2, 0.35, top=0.85).at(y=length * 0.05, z=depth))
    if rng.random() < 0.5:
        parts.append(box(0.08, 0.8, 0.8, top=1.3).at(z=-0.6))
    return parts


def rowing_boat(rng: np.random.Generator) -> list[Part]:
    length, width, depth = rng.uniform(3, 4.5), rng.uniform(1.0, 1.4), rng.uniform(0.4, 0.6)
    hull = _hull(length, width, depth, rng.uniform(0.35, 0.5), deck=False, stations=12)
    parts = [hull, hull.scaled(0.93, 0.96, 0.95).at(z=0.04)]
    for y in np.linspace(-0.2, 0.35, int(rng.integers(2, 4))) * length:
        parts.append(box(width * 0.85, 0.22, 0.04).at(y=y, z=depth * 0.75))
    if rng.random() < 0.7:
        oar = join([tube([[0, 0, 0], [1.7, 0, 0]], 0.025, 6), box(0.5, 0.14, 0.02).at(1.85)])
        oar = oar.turned("y", rng.uniform(5, 20)).turned("z", rng.uniform(-30, 30))
        parts.append(mirrored_pair(oar.at(width * 0.3, 0.1, depth + 0.15)))
    return parts


def submarine(rng: np.random.Generator) -> list[Part]:
    length, radius, sides = rng.uniform(6, 9), rng.uniform(0.5, 0.75), int(rng.choice([10, 16]))
    half = length / 2
    body = curve([(0.0, -half), (radius, -half * 0.75), (radius, half * 0.4), (0.06, half)], 20)
    parts = [lathe(body, sides).turned("x", -90).scaled(z=-1)]
    tower = ball(0.22, rng.uniform(0.5, 0.9), 0.9, 12)
    parts.append(tower.at(y=-half * rng.uniform(0.1, 0.35), z=radius * 0.9))
    parts.append(tube([[0, -half * 0.2, radius], [0, -half * 0.2, radius + 1.4]], 0.04, 6))
    fin = box(0.06, 0.6, 0.9, top=0.7)
    parts += [fin.turned("y", angle).at(y=half * 0.8) for angle in (0, 90, 180, 270)]
    parts.append(mirrored_pair(box(0.6, 0.4, 0.05).at(radius, -half * 0.3, 0.1)))
    blade = box(0.12, 0.04, 0.35).turned("z", 30)
    parts.append(
        join([blade.turned("y", angle) for angle in range(0, 360, int(rng.choice([60, 90])))]).at(
            y=half + 0.05
        )
    )
    return parts


KINDS: dict[str, Callable[[np.random.Generator], list[Part]]] = {
    "ship": ship,
    "sailing boat": sailing_boat,
    "rowing boat": rowing_boat,
    "submarine": submarine,
}
