# SPDX-License-Identifier: MIT
"""Furniture, lamps and other things of a room."""

from __future__ import annotations

import numpy as np

from benchmarks.objects.parts import Maker, Parts, Random, around, box, rod, tube, turned

__all__ = ["KINDS"]


def _legs(wide: float, deep: float, high: float, thick: float, round_legs: bool) -> Parts:
    corners = [(x * (wide / 2 - thick), y * (deep / 2 - thick)) for x in (-1, 1) for y in (-1, 1)]
    if round_legs:
        return [rod((x, y, 0), (x, y, high), 0.4 * thick, 0.5 * thick) for x, y in corners]
    return [box((thick, thick, high), (x, y, 0)) for x, y in corners]


def table(random: Random) -> Parts:
    """Make a table with four legs, or round on a foot."""
    wide, deep, high = random.uniform(1, 2.2), random.uniform(0.7, 1.1), random.uniform(0.5, 0.9)
    if random.random() < 0.25:
        return [
            rod((0, 0, high), (0, 0, high + 0.06), wide / 2, sides=28),
            rod((0, 0, 0), (0, 0, high), 0.09),
            rod((0, 0, 0), (0, 0, 0.05), wide / 4, sides=20),
        ]
    legs = _legs(wide, deep, high, random.uniform(0.06, 0.12), bool(random.random() < 0.4))
    return [box((wide, deep, random.uniform(0.04, 0.09)), (0, 0, high)), *legs]


def desk(random: Random) -> Parts:
    """Make a desk with drawers on one side or both."""
    wide, deep, high = random.uniform(1.2, 1.8), random.uniform(0.6, 0.8), random.uniform(0.65, 0.75)
    parts = [
        box((wide, deep, 0.05), (0, 0, high)),
        box((wide * 0.96, 0.03, high * 0.6), (0, deep / 2 - 0.05, high * 0.4)),
    ]
    block, drawers = random.uniform(0.3, 0.45), int(random.integers(2, 5))
    for side in (-1, 1):
        x = side * (wide - block) / 2
        if side == 1 or random.random() < 0.4:
            parts.append(box((block, deep * 0.95, high), (x, 0, 0)))
            parts += [
                box((block * 0.3, 0.04, 0.03), (x, -deep / 2, high * (k + 0.5) / drawers))
                for k in range(drawers)
            ]
        else:
            parts += [box((0.06, 0.06, high), (-wide / 2 + 0.04, y * (deep / 2 - 0.04), 0)) for y in (-1, 1)]
    return parts


def chair(random: Random) -> Parts:
    """Make a chair with four legs and a back of a board, slats or bars."""
    wide, deep, high = random.uniform(0.4, 0.55), random.uniform(0.4, 0.55), random.uniform(0.4, 0.5)
    thick, back = random.uniform(0.035, 0.06), random.uniform(0.4, 0.7)
    parts = [
        box((wide, deep, 0.05), (0, 0, high)),
        *_legs(wide, deep, high, thick, bool(random.random() < 0.4)),
    ]
    y, form = deep / 2 - thick / 2, int(random.integers(3))
    if form == 0:
        parts.append(box((wide, 0.04, back), (0, y, high + 0.05)))
        return parts
    parts += [box((thick, thick, back), (x * (wide - thick) / 2, y, high + 0.05)) for x in (-1, 1)]
    if form == 1:
        parts += [box((wide, 0.025, 0.07), (0, y, high + back * (k + 1) / 3)) for k in range(3)]
    else:
        parts.append(box((wide, 0.03, 0.08), (0, y, high + back - 0.04)))
        parts += [
            rod((x * wide, y, high), (x * wide, y, high + back), 0.012) for x in np.linspace(-0.35, 0.35, 5)
        ]
    return parts


def armchair(random: Random) -> Parts:
    """Make an armchair."""
    return _upholstered(random, random.uniform(0.8, 1.05))


def sofa(random: Random) -> Parts:
    """Make a sofa for two to four people."""
    return _upholstered(random, 0.65 * int(random.integers(2, 5)) + 0.4)


def _upholstered(random: Random, wide: float) -> Parts:
    deep, seat, back = random.uniform(0.8, 1), random.uniform(0.35, 0.45), random.uniform(0.75, 1)
    arm, high = random.uniform(0.12, 0.25), random.uniform(0.5, 0.7)
    seats = max(1, round((wide - 2 * arm) / 0.65))
    one = (wide - 2 * arm) / seats
    parts = [
        box((wide, deep, seat - 0.12), (0, 0, 0.08)),
        box((wide, 0.22, back), (0, deep / 2 - 0.11, 0.08)),
    ]
    parts += [box((arm, deep, high), (x * (wide - arm) / 2, 0, 0.08)) for x in (-1, 1)]
    parts += [
        box((one * 0.97, deep - 0.25, 0.14), ((k - (seats - 1) / 2) * one, -0.1, seat - 0.04))
        for k in range(seats)
    ]
    return [*parts, *_legs(wide, deep, 0.1, 0.06, round_legs=True)]


def stool(random: Random) -> Parts:
    """Make a stool with three or four slanted legs and perhaps a ring."""
    high, wide, legs = random.uniform(0.45, 0.8), random.uniform(0.17, 0.22), int(random.choice([3, 4]))
    parts = [rod((0, 0, high), (0, 0, high + 0.05), wide, sides=24)]
    parts += around(rod((wide * 1.3, 0, 0), (wide * 0.7, 0, high), 0.022), legs)
    if random.random() < 0.5:
        angle = np.linspace(0, 2 * np.pi, 24)
        parts.append(
            tube(np.stack([wide * np.cos(angle), wide * np.sin(angle), 0 * angle + high / 3], axis=1), 0.015)
        )
    return parts


def bench(random: Random) -> Parts:
    """Make a bench of planks, perhaps with a back."""
    wide, high = random.uniform(1.2, 2.2), random.uniform(0.4, 0.5)
    parts = [box((wide, 0.11, 0.04), (0, y, high)) for y in (-0.13, 0, 0.13)]
    parts += [box((0.07, 0.38, high), (x * wide * 0.4, 0, 0)) for x in (-1, 1)]
    if random.random() < 0.6:
        parts += [box((wide, 0.03, 0.1), (0, 0.2, high + z)) for z in (0.2, 0.38)]
        parts += [box((0.06, 0.04, 0.5), (x * wide * 0.4, 0.22, high)) for x in (-1, 1)]
    return parts


def bed(random: Random) -> Parts:
    """Make a bed with pillows."""
    wide, long, head = random.uniform(0.9, 1.9), random.uniform(1.9, 2.2), random.uniform(0.7, 1.2)
    parts = [box((wide, long, 0.2), (0, 0, 0.15)), box((wide * 0.97, long * 0.97, 0.2), (0, 0, 0.33))]
    parts += [
        box((wide, 0.08, head), (0, long / 2, 0)),
        box((wide, 0.08, head * random.uniform(0.4, 0.7)), (0, -long / 2, 0)),
    ]
    pillows = 1 if wide < 1.3 else 2
    return parts + [
        box((0.6, 0.4, 0.12), ((k - (pillows - 1) / 2) * 0.75, long / 2 - 0.35, 0.52)) for k in range(pillows)
    ]


def shelf(random: Random) -> Parts:
    """Make a bookcase, perhaps with books."""
    wide, deep, high, boards = (
        random.uniform(0.6, 1.4),
        0.3,
        random.uniform(1.2, 2.1),
        int(random.integers(4, 7)),
    )
    parts = [box((0.03, deep, high), (x * wide / 2, 0, 0)) for x in (-1, 1)]
    levels = np.linspace(0, high - 0.03, boards)
    parts += [box((wide, deep, 0.03), (0, 0, z)) for z in levels]
    if random.random() < 0.7:
        parts.append(box((wide, 0.02, high), (0, deep / 2, 0)))
    if random.random() < 0.5:
        room = levels[1] - levels[0]
        for z in levels[:-1]:
            x = -wide / 2 + 0.05
            while x < wide / 2 - 0.1:
                thick = random.uniform(0.03, 0.08)
                parts.append(
                    box((thick * 0.9, 0.2, room * random.uniform(0.5, 0.85)), (x + thick / 2, 0, z + 0.03))
                )
                x += thick if random.random() < 0.8 else 0.2
    return parts


def cupboard(random: Random) -> Parts:
    """Make a cupboard or wardrobe with doors."""
    wide, deep, high, doors = (
        random.uniform(0.8, 1.6),
        random.uniform(0.4, 0.6),
        random.uniform(1, 2.1),
        int(random.integers(1, 4)),
    )
    one = wide / doors
    parts = [box((wide, deep, high), (0, 0, 0.08)), *_legs(wide, deep, 0.1, 0.07, round_legs=False)]
    for k in range(doors):
        x = (k - (doors - 1) / 2) * one
        parts.append(box((one * 0.92, 0.03, high * 0.92), (x, -deep / 2, 0.08 + 0.04 * high)))
        parts.append(box((0.03, 0.06, 0.12), (x + 0.35 * one, -deep / 2 - 0.03, high / 2)))
    return parts


def floor_lamp(random: Random) -> Parts:
    """Make a lamp on a pole with a shade."""
    high, wide = random.uniform(0.5, 1.7), random.uniform(0.15, 0.28)
    shade = [
        [wide * random.uniform(0.4, 0.8), high + 0.3],
        [wide, high],
        [wide - 0.015, high],
        [wide * 0.3, high + 0.28],
    ]
    return [
        rod((0, 0, 0), (0, 0, 0.04), random.uniform(0.13, 0.2), sides=24),
        rod((0, 0, 0), (0, 0, high + 0.2), 0.018),
        turned(shade, 24),
    ]


def door(random: Random) -> Parts:
    """Make a door with a frame, panels and a handle."""
    wide, high = random.uniform(0.8, 1.1), random.uniform(1.9, 2.2)
    parts = [box((wide, 0.05, high)), box((wide + 0.2, 0.12, 0.1), (0, 0, high))]
    parts += [box((0.1, 0.12, high), (x * (wide / 2 + 0.05), 0, 0)) for x in (-1, 1)]
    rows = int(random.integers(1, 4))
    parts += [
        box((wide * 0.7, 0.08, high * 0.8 / rows), (0, 0, high * (0.06 + 0.9 * k / rows)))
        for k in range(rows)
    ]
    return [
        *parts,
        rod((0.4 * wide, -0.03, 1), (0.4 * wide, -0.09, 1), 0.03),
        rod((0.42 * wide, -0.09, 1), (0.25 * wide, -0.09, 1), 0.015),
    ]


KINDS: dict[str, Maker] = {
    "table": table,
    "desk": desk,
    "chair": chair,
    "armchair": armchair,
    "sofa": sofa,
    "stool": stool,
    "bench": bench,
    "bed": bed,
    "bookcase": shelf,
    "cupboard": cupboard,
    "lamp": floor_lamp,
    "door": door,
}
