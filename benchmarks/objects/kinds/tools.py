# SPDX-License-Identifier: MIT
"""Weapons, tools, instruments and small things that are held in a hand."""

from __future__ import annotations

import numpy as np

from benchmarks.objects.parts import (
    Maker,
    Parts,
    Random,
    around,
    ball,
    box,
    extruded,
    moved,
    rod,
    tube,
    turned,
    turned_about,
)

__all__ = ["KINDS"]


def sword(random: Random) -> Parts:
    """Make a sword with blade, guard, grip and pommel."""
    long, wide, guard = random.uniform(1, 2), random.uniform(0.05, 0.12), random.uniform(0.15, 0.35)
    grip = random.uniform(0.2, 0.45)
    blade = [
        [-wide, 0],
        [wide, 0],
        [wide * random.uniform(0.6, 1), 0.85 * long],
        [0, long],
        [-wide * 0.8, 0.85 * long],
    ]
    return [
        extruded(blade, 0.03),
        box((2 * guard, 0.08, 0.06), (0, 0, -0.06)),
        rod((0, 0, -0.06 - grip), (0, 0, -0.06), 0.035),
        ball(random.uniform(0.05, 0.08), (0, 0, -0.1 - grip)),
    ]


def dagger(random: Random) -> Parts:
    """Make a knife or dagger."""
    long, wide, bent = random.uniform(0.35, 0.6), random.uniform(0.05, 0.08), random.uniform(-0.05, 0.05)
    blade = [[-wide, 0], [wide, 0], [wide + bent, 0.6 * long], [bent, long], [-0.8 * wide + bent, 0.6 * long]]
    return [
        extruded(blade, 0.03),
        box((0.2, 0.06, 0.04), (0, 0, -0.04)),
        rod((0, 0, -0.3), (0, 0, -0.04), 0.035),
    ]


def spear(random: Random) -> Parts:
    """Make a spear or arrow."""
    long, head, wide = random.uniform(1.5, 2.6), random.uniform(0.2, 0.45), random.uniform(0.06, 0.12)
    parts = [rod((0, 0, 0), (0, 0, long), 0.03)]
    tip = [
        [-0.3 * wide, long],
        [0.3 * wide, long],
        [wide, long + 0.3 * head],
        [0, long + head],
        [-wide, long + 0.3 * head],
    ]
    parts.append(extruded(tip, 0.04))
    if random.random() < 0.4:
        parts += around(box((0.15, 0.01, 0.3), (0.08, 0, 0.02)), 3)
    return parts


def axe(random: Random) -> Parts:
    """Make an axe with one blade or two."""
    long, wide, high = random.uniform(0.8, 1.6), random.uniform(0.25, 0.45), random.uniform(0.15, 0.3)
    angle = np.linspace(-1, 1, 7)
    edge = np.stack([wide * (0.7 + 0.3 * np.cos(angle)), long - 0.15 + high * angle], axis=1)
    blade = extruded(np.concatenate([[[0, long - 0.05], [0, long - 0.25]], edge]), 0.06)
    parts = [rod((0, 0, 0), (0, 0, long), 0.035), blade]
    return [*parts, turned_about(blade, 2, 180)] if random.random() < 0.4 else parts


def hammer(random: Random) -> Parts:
    """Make a hammer, of a smith or of a warrior."""
    long, head, thick = random.uniform(0.6, 1.4), random.uniform(0.25, 0.5), random.uniform(0.12, 0.22)
    block = box((head, thick, thick), (0, 0, long - thick / 2))
    if random.random() < 0.5:
        block = rod((-head / 2, 0, long), (head / 2, 0, long), thick / 2, sides=16)
    return [rod((0, 0, 0), (0, 0, long), 0.035), block]


def bow(random: Random) -> Parts:
    """Make a bow with its string."""
    bend, long = random.uniform(0.3, 0.6), random.uniform(0.7, 1.1)
    z = np.linspace(-1, 1, 21)
    curl = random.uniform(0, 0.25)
    x = bend * (1 - z**2) - curl * np.cos(2 * np.pi * z) + curl
    path = np.stack([x, 0 * z, long * z], axis=1)
    return [tube(path, 0.02 + 0.02 * (1 - z**2)), rod(path[0], path[-1], 0.006, sides=6)]


def shield(random: Random) -> Parts:
    """Make a shield, round or with a point, with a boss."""
    boss = ball(random.uniform(0.12, 0.2), (0, -0.08, 0.1), (1, 0.7, 1))
    if random.random() < 0.5:
        disc = turned_about(rod((0, 0, -0.04), (0, 0, 0.04), 0.7, sides=28), 0, 90)
        return [moved(disc, (0, 0, 0.1)), boss]
    wide, high = random.uniform(0.45, 0.6), random.uniform(0.7, 0.9)
    outline = [
        [0, -high],
        [0.7 * wide, -0.4 * high],
        [wide, 0.1],
        [wide, 0.6],
        [0, 0.68],
        [-wide, 0.6],
        [-wide, 0.1],
        [-0.7 * wide, -0.4 * high],
    ]
    return [extruded(outline, random.uniform(0.05, 0.1)), boss]


def key(random: Random) -> Parts:
    """Make a key with a ring and a bit."""
    long = random.uniform(0.6, 1)
    angle = np.linspace(0, 2 * np.pi, 20)
    ring = np.stack([0.18 * np.cos(angle), 0 * angle, long + 0.17 + 0.18 * np.sin(angle)], axis=1)
    teeth = [
        box((0.14 * random.uniform(0.6, 1.2), 0.03, 0.06), (0.1, 0, 0.12 * k))
        for k in range(int(random.integers(2, 4)))
    ]
    return [tube(ring, 0.035), rod((0, 0, 0), (0, 0, long), 0.035), *teeth]


def spanner(random: Random) -> Parts:
    """Make a spanner with an open jaw, perhaps with a ring at the other end."""
    long, wide = random.uniform(0.8, 1.4), random.uniform(0.06, 0.1)
    jaw = [
        [-0.06, 0],
        [0.06, 0],
        [0.2, 0.15],
        [0.15, 0.38],
        [0.08, 0.38],
        [0.08, 0.18],
        [-0.08, 0.18],
        [-0.08, 0.38],
        [-0.15, 0.38],
        [-0.2, 0.15],
    ]
    parts = [moved(extruded(jaw, 0.08), (0, 0, long)), box((2 * wide, 0.06, long + 0.05))]
    if random.random() < 0.6:
        ring = turned([[0.1, -0.04], [0.2, -0.04], [0.2, 0.04], [0.1, 0.04], [0.1, -0.04]], 16)
        parts.append(moved(turned_about(ring, 0, 90), (0, 0, -0.12)))
    return parts


def screw(random: Random) -> Parts:
    """Make a bolt with a hexagonal or round head and a thread."""
    long, head = random.uniform(0.7, 1.8), random.uniform(0.22, 0.32)
    turns = int(long * 9)
    z = np.linspace(0, 0.8 * long, 10 * turns)
    angle = 2 * np.pi * z * turns / (0.8 * long)
    thread = np.stack([0.12 * np.cos(angle), 0.12 * np.sin(angle), z], axis=1)
    sides = int(random.choice([6, 20]))
    return [
        rod((0, 0, 0), (0, 0, long), 0.12),
        tube(thread, 0.02, 5),
        rod((0, 0, long), (0, 0, long + 0.18), head, sides=sides),
    ]


def book(random: Random) -> Parts:
    """Make a book with covers, lying or standing."""
    wide, thick, high = random.uniform(0.6, 0.8), random.uniform(0.1, 0.3), random.uniform(0.9, 1.1)
    covers = [box((wide, 0.03, high), (0, side * thick / 2, 0)) for side in (-1, 1)]
    return [
        *covers,
        box((0.03, thick, high), (-wide / 2, 0, 0)),
        box((wide * 0.95, thick, high * 0.96), (-0.01, 0, 0.02 * high)),
    ]


def candle(random: Random) -> Parts:
    """Make a candle on a holder."""
    high, thick = random.uniform(0.3, 0.9), random.uniform(0.06, 0.12)
    return [
        turned([[0, 0], [0.25, 0], [0.3, 0.08], [0.27, 0.08], [0.22, 0.03], [0, 0.03]], 20),
        rod((0, 0, 0.03), (0, 0, high), thick),
        rod((0, 0, high), (0, 0, high + 0.06), 0.012, sides=6),
    ]


def umbrella(random: Random) -> Parts:
    """Make an open umbrella."""
    angle, wide = np.linspace(0, 0.45 * np.pi, 8), random.uniform(0.6, 0.9)
    deep = random.uniform(0.3, 0.5)
    top = np.stack([wide * np.sin(angle), 1 + deep * np.cos(angle)], axis=1)
    hook = np.array([[0, 0, 1.3], [0, 0, 0.1], [0, 0, 0], [0.05, 0, -0.07], [0.12, 0, -0.07], [0.16, 0, 0]])
    return [
        turned(np.concatenate([top, (top - [0, 0.02])[::-1]]), int(random.choice([8, 10, 12]))),
        tube(hook, 0.018),
    ]


def hat(random: Random) -> Parts:
    """Make a hat with a brim, or a pointed one."""
    brim, high, crown = random.uniform(0.6, 0.9), random.uniform(0.4, 1), random.uniform(0.3, 0.4)
    top = crown * float(random.choice([0.05, 0.8, 1.05]))
    return [
        turned([[crown - 0.03, 0], [brim, 0.02], [brim, 0.05], [crown, 0.05], [top, high], [0, high]], 24)
    ]


def guitar(random: Random) -> Parts:
    """Make a guitar."""
    angle = np.linspace(0, 2 * np.pi, 32, endpoint=False)
    waist = random.uniform(0.12, 0.22)
    wide = 0.32 + 0.1 * np.cos(angle + np.pi) - waist * np.sin(angle) ** 8
    outline = np.stack([wide * np.sin(angle), 0.5 + 0.5 * -np.cos(angle)], axis=1)
    long = random.uniform(0.7, 1)
    return [
        extruded(outline, random.uniform(0.12, 0.2)),
        box((0.07, 0.06, long), (0, -0.06, 0.7)),
        box((0.12, 0.05, 0.22), (0, -0.05, 0.7 + long)),
        *[
            rod((x, -0.05, 0.74 + long + z), (1.8 * x, -0.05, 0.74 + long + z), 0.015)
            for x in (-0.06, 0.06)
            for z in (0, 0.06, 0.12)
        ],
    ]


KINDS: dict[str, Maker] = {
    "sword": sword,
    "dagger": dagger,
    "spear": spear,
    "axe": axe,
    "hammer": hammer,
    "bow": bow,
    "shield": shield,
    "key": key,
    "spanner": spanner,
    "screw": screw,
    "book": book,
    "candle": candle,
    "umbrella": umbrella,
    "hat": hat,
    "guitar": guitar,
}
