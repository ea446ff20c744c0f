# SPDX-License-Identifier: MIT
"""Machine parts: gears, screws, nuts, springs, wheels, pipes, valves."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.flat_parts.polygons import circle
from benchmarks.things.part import Part, around, ball, box, curve, cylinder, join, lathe, prism, ring, tube

__all__ = ["KINDS"]


def gear(rng: np.random.Generator) -> list[Part]:
    teeth, radius = int(rng.integers(10, 36)), 1.0
    depth, thickness = rng.uniform(0.78, 0.9), rng.uniform(0.1, 0.4)
    angles = (np.arange(teeth)[:, None] + np.array([-0.27, -0.13, 0.13, 0.27])) * 2 * np.pi / teeth
    radii = np.tile([depth, 1, 1, depth], (teeth, 1)) * radius
    outline = np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=2).reshape(-1, 2)
    holes = [circle(0, 0, rng.uniform(0.1, 0.3), 16)]
    spokes = int(rng.choice([0, 0, 4, 5, 6]))
    holes += [
        circle(0.57 * np.cos(a), 0.57 * np.sin(a), 0.14, 12)
        for a in 2 * np.pi * np.arange(spokes) / max(spokes, 1)
    ]
    parts = [prism(outline, thickness, holes)]
    if rng.random() < 0.4:
        parts.append(prism(circle(0, 0, 0.42, 16), thickness * 2, holes[:1]).at(z=-thickness / 2))
    return [join(parts).turned("x", rng.choice([0.0, 90.0]))]


def bolt(rng: np.random.Generator) -> list[Part]:
    radius, length = rng.uniform(0.14, 0.25), rng.uniform(0.8, 1.8)
    head = rng.integers(3)
    turns = int(rng.integers(6, 20))
    threads = np.linspace(0, length * rng.uniform(0.5, 0.9), 2 * turns + 1)
    profile = [(radius * (1 if n % 2 else 0.85), z) for n, z in enumerate(threads)]
    parts = [lathe([(0, 0), *profile, (radius * 0.9, length), (0, length)], int(rng.choice([8, 12, 20])))]
    sides = (6, 16, 16)[head]
    wide = radius * rng.uniform(1.7, 2.1)
    top = (wide, wide, wide * 0.5)[head]
    parts.append(cylinder(wide, radius * rng.uniform(1, 1.6), sides, top=top).at(z=length))
    return [join(parts).turned("x", rng.choice([0.0, 180.0, 90.0]))]


def nut(rng: np.random.Generator) -> list[Part]:
    sides, hole, height = int(rng.choice([6, 6, 4])), rng.uniform(0.4, 0.6), rng.uniform(0.4, 0.9)
    parts = [prism(circle(0, 0, 1, sides), height, [circle(0, 0, hole, int(rng.choice([12, 20])))])]
    if rng.random() < 0.4:
        parts.append(prism(circle(0, 0, 1.3, 20), 0.08, [circle(0, 0, hole, 16)]))
    return [join(parts).turned("x", rng.choice([0.0, 90.0]))]


def spring(rng: np.random.Generator) -> list[Part]:
    turns, height = rng.uniform(4, 10), rng.uniform(1.5, 3)
    angle = np.linspace(0, 2 * np.pi * turns, int(turns * 14))
    radius = np.linspace(1, rng.choice([1.0, 0.5]), len(angle)) * rng.uniform(0.4, 0.8)
    path = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.linspace(0, height, len(angle))], 1)
    return [tube(path, rng.uniform(0.04, 0.09), int(rng.choice([5, 8])))]


def wheel(rng: np.random.Generator) -> list[Part]:
    sides, thick = int(rng.choice([16, 24, 32])), rng.uniform(0.07, 0.25)
    spokes = int(rng.choice([3, 4, 5, 6, 8, 10]))
    parts = [ring(1.0, thick, sides, 8), cylinder(0.2, thick * 2.2, 12).at(z=-thick * 1.1)]
    parts.append(around(box(0.9, rng.uniform(0.06, 0.2), thick, top=0.9).at(0.5, 0, -thick / 2), spokes))
    return [join(parts).turned("x", rng.choice([0.0, 90.0]))]


def pipe_bend(rng: np.random.Generator) -> list[Part]:
    radius, sides = rng.uniform(0.18, 0.28), int(rng.choice([8, 16]))
    bend = rng.uniform(0.6, 1.0)
    path = curve(
        [
            [0, 0, 0],
            [0, 0, bend],
            [0.3 * bend, 0, 1.6 * bend],
            [bend, 0, 1.9 * bend],
            [2 * bend, 0, 1.9 * bend],
        ],
        16,
    )
    flange = cylinder(radius * 1.7, 0.1, sides)
    parts = [tube(path, radius, sides), flange, flange.turned("y", 90).at(2 * bend - 0.05, 0, 1.9 * bend)]
    bolts = around(cylinder(0.04, 0.16, 6).at(radius * 1.4, 0, -0.03), int(rng.choice([4, 6])))
    return [*parts, bolts]


def valve(rng: np.random.Generator) -> list[Part]:
    length, radius, sides = rng.uniform(1.2, 1.8), rng.uniform(0.2, 0.3), int(rng.choice([10, 16]))
    pipe = cylinder(radius, length, sides).turned("y", 90).at(-length / 2)
    flange = cylinder(radius * 1.6, 0.1, sides).turned("y", 90)
    parts = [
        pipe,
        flange.at(-length / 2),
        flange.at(length / 2 - 0.1),
        ball(radius * 1.5, radius * 1.4, radius * 1.5, sides),
    ]
    stem = rng.uniform(0.8, 1.2)
    parts += [cylinder(0.1, stem, 8), cylinder(radius, 0.1, sides).at(z=radius * 1.6)]
    hand = join(
        [
            ring(rng.uniform(0.35, 0.5), 0.05, 16, 6),
            around(box(0.4, 0.05, 0.04).at(0.2), int(rng.choice([3, 4, 5]))),
        ]
    )
    return [*parts, hand.at(z=stem)]


def anchor(rng: np.random.Generator) -> list[Part]:
    height, reach = rng.uniform(1.4, 1.8), rng.uniform(0.6, 0.85)
    arms = curve(
        [[-reach, 0, 0.5], [-reach * 0.6, 0, 0.1], [0, 0, 0], [reach * 0.6, 0, 0.1], [reach, 0, 0.5]], 16
    )
    parts = [tube([[0, 0, 0], [0, 0, height]], rng.uniform(0.05, 0.08), 8), tube(arms, 0.07, 8)]
    fluke = box(0.3, 0.08, 0.3, top=0.1)
    parts += [fluke.turned("y", x * 20).at(x * reach, 0, 0.42) for x in (-1, 1)]
    parts.append(tube([[-0.45, 0, height * 0.85], [0.45, 0, height * 0.85]], 0.05, 8))
    parts.append(ring(0.14, 0.035, 14, 6).turned("x", 90).at(z=height + 0.12))
    return parts


KINDS: dict[str, Callable[[np.random.Generator], list[Part]]] = {
    "gear": gear,
    "bolt": bolt,
    "nut": nut,
    "spring": spring,
    "wheel": wheel,
    "pipe bend": pipe_bend,
    "valve": valve,
    "anchor": anchor,
}
