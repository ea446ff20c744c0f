# SPDX-License-Identifier: MIT
"""Buildings, their parts, and things of a street."""

from __future__ import annotations

import numpy as np

from benchmarks.objects.parts import Maker, Parts, Random, around, box, extruded, moved, rod, turned

__all__ = ["KINDS"]


def house(random: Random) -> Parts:
    """Make a house with a gable roof, perhaps with a chimney."""
    wide, deep, high, rise = (
        random.uniform(2, 3.5),
        random.uniform(2, 4.5),
        random.uniform(1.2, 2.6),
        random.uniform(0.6, 1.6),
    )
    over = 0.2
    parts = [
        box((wide, deep, high)),
        extruded([[-wide / 2 - over, high], [wide / 2 + over, high], [0, high + rise]], deep + 2 * over),
    ]
    parts += [box((0.5, 0.08, 1), (0.2 * wide, -deep / 2, 0))]
    parts += [
        box((0.4, 0.06, 0.45), (x * wide * 0.3, side * deep / 2, 0.45 * high))
        for x in (-1, 0.9)
        for side in (-1, 1)
    ]
    if random.random() < 0.5:
        parts.append(box((0.3, 0.3, rise + 0.3), (0.25 * wide, 0.2 * deep, high)))
    return parts


def tower(random: Random) -> Parts:
    """Make a round tower with battlements or a pointed roof."""
    high, wide = random.uniform(2.5, 5), random.uniform(0.6, 1)
    parts = [
        rod((0, 0, 0), (0, 0, high), wide * 1.1, wide, sides=20),
        rod((0, 0, high), (0, 0, high + 0.35), 1.2 * wide, sides=20),
    ]
    if random.random() < 0.5:
        return [
            *parts,
            rod((0, 0, high + 0.35), (0, 0, high + 0.35 + random.uniform(1, 2)), 1.3 * wide, 0, sides=20),
        ]
    merlon = box((0.2, 0.35, 0.3), (1.1 * wide, 0, high + 0.35))
    return parts + around(merlon, int(random.integers(6, 11)))


def column(random: Random) -> Parts:
    """Make a column with base and capital."""
    high, wide = random.uniform(1.5, 3), random.uniform(0.14, 0.24)
    square = 2.6 * wide
    return [
        box((square, square, 0.12)),
        turned(
            [
                [0, 0.12],
                [1.25 * wide, 0.12],
                [1.25 * wide, 0.2],
                [wide, 0.26],
                [0.85 * wide, high],
                [1.2 * wide, high + 0.12],
                [0, high + 0.12],
            ],
            20,
        ),
        box((square, square, 0.1), (0, 0, high + 0.12)),
    ]


def staircase(random: Random) -> Parts:
    """Make a flight of stairs, solid or of boards."""
    count, rise, run, wide = (
        int(random.integers(4, 10)),
        random.uniform(0.16, 0.22),
        random.uniform(0.24, 0.34),
        random.uniform(0.8, 1.6),
    )
    solid = random.random() < 0.6
    return [
        box(
            (run * 1.02, wide, (k + 1) * rise if solid else 0.05),
            (k * run, 0, 0 if solid else (k + 1) * rise - 0.05),
        )
        for k in range(count)
    ] + (
        []
        if solid
        else [
            extruded(
                [[0, 0], [0.2, 0], [count * run, (count - 1) * rise], [(count - 1) * run, count * rise]], 0.06
            )
        ]
    )


def fence(random: Random) -> Parts:
    """Make a piece of a fence."""
    count, high, step = int(random.integers(5, 12)), random.uniform(0.7, 1.2), random.uniform(0.16, 0.28)
    parts = [box((0.1, 0.03, high), (k * step, 0, 0)) for k in range(count)]
    return parts + [
        box((count * step, 0.04, 0.08), ((count - 1) * step / 2, 0.03, z * high)) for z in (0.25, 0.75)
    ]


def ladder(random: Random) -> Parts:
    """Make a ladder."""
    high, wide, count = random.uniform(1.6, 3.2), random.uniform(0.35, 0.5), int(random.integers(5, 11))
    parts = [box((0.05, 0.07, high), (side * wide / 2, 0, 0)) for side in (-1, 1)]
    return parts + [
        rod((-wide / 2, 0, z), (wide / 2, 0, z), 0.02) for z in np.linspace(0.15, high - 0.15, count)
    ]


def windmill(random: Random) -> Parts:
    """Make a windmill with four sails."""
    high, sail = random.uniform(2, 3), random.uniform(1.1, 1.7)
    blade = [
        rod((0, -0.75, 0), (0, -0.75, sail), 0.035),
        box((0.3, 0.03, 0.75 * sail), (0.17, -0.75, 0.22 * sail)),
    ]
    turned_blades = []
    for k in range(4):
        angle = k * np.pi / 2 + 0.4
        turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
        turned_blades += [(vertices @ turn.T + [0, 0, high], faces) for vertices, faces in blade]
    return [
        rod((0, 0, 0), (0, 0, high), 0.8, 0.5, sides=16),
        rod((0, 0, high), (0, 0, high + 0.6), 0.6, 0, sides=16),
        rod((0, 0, high), (0, -0.8, high), 0.07),
        *turned_blades,
    ]


def bridge(random: Random) -> Parts:
    """Make an arched bridge with railings."""
    long, wide, rise = random.uniform(2.5, 4), random.uniform(0.8, 1.4), random.uniform(0.5, 1)
    x = np.linspace(1, -1, 15)
    above = np.stack([x * long / 2, rise * (1 - x**2) + 0.25], axis=1)
    below = np.stack([x[::-1] * long * 0.4, rise * (1 - x**2)], axis=1)
    outline = np.concatenate([[[-long / 2, 0]], below, [[long / 2, 0]], above])
    parts = [extruded(outline, wide)]
    posts = np.linspace(-0.45, 0.45, 7) * long
    return parts + [
        rod(
            (p, side * wide * 0.45, 0.2),
            (p, side * wide * 0.45, rise * (1 - (2 * p / long) ** 2) + 0.65),
            0.03,
        )
        for p in posts
        for side in (-1, 1)
    ]


def street_lamp(random: Random) -> Parts:
    """Make a street lamp with one arm or two."""
    high, reach = random.uniform(2.5, 4), random.uniform(0.4, 0.9)
    parts = [rod((0, 0, 0), (0, 0, high), 0.07, 0.045), rod((0, 0, 0), (0, 0, 0.3), 0.12)]
    for side in (1, -1)[: int(random.integers(1, 3))]:
        parts += [
            rod((0, 0, high), (side * reach, 0, high + 0.15), 0.03),
            moved(box((0.35, 0.14, 0.08)), (side * reach, 0, high + 0.1)),
        ]
    return parts


def road_sign(random: Random) -> Parts:
    """Make a road sign: round, square or triangular, on a pole."""
    high, sides = random.uniform(1.6, 2.3), int(random.choice([3, 4, 8, 24]))
    angle = 2 * np.pi * (np.arange(sides) + 0.5) / sides - np.pi / 2
    plate = extruded(0.35 * np.stack([np.cos(angle), np.sin(angle)], axis=1), 0.03)
    return [rod((0, 0, 0), (0, 0, high), 0.03), moved(plate, (0, -0.03, high))]


def cannon(random: Random) -> Parts:
    """Make a cannon on a carriage with two wheels."""
    long, wide = random.uniform(1.2, 1.9), random.uniform(0.14, 0.22)
    barrel = moved(
        _lying(
            turned(
                [
                    [0, 0],
                    [1.3 * wide, 0.05],
                    [wide, long],
                    [1.15 * wide, long + 0.02],
                    [1.15 * wide, long + 0.12],
                    [0.5 * wide, long + 0.12],
                    [0.5 * wide, 0.2],
                    [0, 0.2],
                ],
                18,
            )
        ),
        (-0.4 * long, 0, 0.55),
    )
    wheel = _lying(rod((0, 0, -0.04), (0, 0, 0.04), 0.4, sides=18))
    wheels = [
        (vertices[:, [1, 0, 2]] + [0.1, side * 0.3, 0.4], faces[:, ::-1])
        for side in (-1, 1)
        for vertices, faces in [wheel]
    ]
    return [barrel, box((0.6 * long, 0.25, 0.15), (-0.3 * long, 0, 0.35)), *wheels]


def _lying(part: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    return part[0][:, [2, 0, 1]], part[1]


KINDS: dict[str, Maker] = {
    "house": house,
    "tower": tower,
    "column": column,
    "staircase": staircase,
    "fence": fence,
    "ladder": ladder,
    "windmill": windmill,
    "bridge": bridge,
    "street lamp": street_lamp,
    "road sign": road_sign,
    "cannon": cannon,
}
