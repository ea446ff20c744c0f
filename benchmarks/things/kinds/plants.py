# SPDX-License-Identifier: MIT
"""Plants: conifers, leafy trees, palms, potted plants, flowers, cacti, mushrooms."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.things.part import Part, around, ball, box, curve, cylinder, join, lathe, sheet, tube

__all__ = ["KINDS"]


def _leaf(length: float, width: float, droop: float) -> Part:
    """Build a leaf from the origin along +x."""
    steps = np.linspace(0, 1, 6)
    half = width / 2 * np.sin(np.pi * np.clip(steps, 0.05, 0.97)) ** 0.7
    z = -droop * steps**2
    grid = [
        [[length * s, -h, height], [length * s, 0, height + 0.02], [length * s, h, height]]
        for s, h, height in zip(steps, half, z, strict=True)
    ]
    return sheet(grid)


def conifer(rng: np.random.Generator) -> list[Part]:
    height, radius, layers, sides = (
        rng.uniform(3, 5),
        rng.uniform(0.8, 1.3),
        int(rng.integers(3, 7)),
        int(rng.choice([6, 8, 12])),
    )
    parts = [cylinder(0.15, height * 0.3, 8)]
    for number in range(layers):
        low = height * (0.2 + 0.75 * number / layers)
        wide = radius * (1 - 0.8 * number / layers)
        parts.append(
            cylinder(wide, height * 1.3 / layers, sides, top=0.02).turned("z", rng.uniform(0, 60)).at(z=low)
        )
    return parts


def leafy_tree(rng: np.random.Generator) -> list[Part]:
    trunk, crown = rng.uniform(1.2, 2.2), rng.uniform(0.8, 1.4)
    parts = [
        tube(
            curve([[0, 0, 0], [rng.uniform(-0.15, 0.15), 0, trunk * 0.5], [0, 0, trunk]], 5),
            np.linspace(0.22, 0.12, 5),
            8,
        )
    ]
    for _ in range(int(rng.integers(2, 9))):
        tip = rng.normal(0, 0.45, 3) * crown + [0, 0, trunk + crown * 0.6]
        size = crown * rng.uniform(0.4, 0.8)
        blob = ball(size, size, size * rng.uniform(0.7, 1), int(rng.choice([6, 8, 12])))
        parts += [blob.turned("z", rng.uniform(0, 90)).at(*tip), tube([[0, 0, trunk * 0.85], tip], 0.06, 5)]
    return parts


def bare_tree(rng: np.random.Generator) -> list[Part]:
    parts: list[Part] = []

    def branch(start: np.ndarray, direction: np.ndarray, length: float, radius: float, depth: int) -> None:
        end = start + direction * length
        parts.append(tube([start, end], [radius, radius * 0.65], 5))
        if depth:
            for _ in range(int(rng.integers(2, 4))):
                turned = direction + rng.normal(0, 0.5, 3) + [0, 0, 0.1]
                branch(
                    end,
                    turned / np.linalg.norm(turned),
                    length * rng.uniform(0.6, 0.8),
                    radius * 0.6,
                    depth - 1,
                )

    branch(np.zeros(3), np.array([0, 0, 1.0]), rng.uniform(1.2, 1.8), rng.uniform(0.12, 0.2), 4)
    return parts


def palm(rng: np.random.Generator) -> list[Part]:
    height, lean = rng.uniform(3, 5), rng.uniform(0, 1)
    top = np.array([lean, 0, height])
    trunk = curve([[0, 0, 0], [lean * 0.3, 0, height * 0.5], top], 8)
    leaf = _leaf(rng.uniform(1.4, 2), rng.uniform(0.3, 0.6), rng.uniform(0.8, 1.5))
    parts = [tube(trunk, np.linspace(0.2, 0.12, 8), 8)]
    parts.append(around(leaf.turned("y", -25), int(rng.integers(6, 12))).at(*top))
    return parts


def potted_plant(rng: np.random.Generator) -> list[Part]:
    radius, height, sides = rng.uniform(0.25, 0.4), rng.uniform(0.3, 0.55), int(rng.choice([4, 8, 16]))
    parts = [
        cylinder(radius * 0.7, height, sides, top=radius),
        cylinder(radius * 1.1, 0.08, sides).at(z=height - 0.06),
    ]
    for _ in range(int(rng.integers(8, 22))):
        leaf = _leaf(rng.uniform(0.5, 1.1), rng.uniform(0.08, 0.25), rng.uniform(0.1, 0.5))
        parts.append(leaf.turned("y", -rng.uniform(30, 85)).turned("z", rng.uniform(0, 360)).at(z=height))
    return parts


def flower(rng: np.random.Generator) -> list[Part]:
    height, petals = rng.uniform(1.2, 2), int(rng.integers(5, 13))
    head = [ball(0.14, 0.14, 0.07, 10)]
    head.append(
        around(_leaf(rng.uniform(0.3, 0.5), rng.uniform(0.15, 0.3), rng.uniform(-0.15, 0.15)), petals)
    )
    bend = rng.uniform(0, 0.2)
    stem = curve([[0, 0, 0], [bend, 0, height * 0.5], [0, 0, height]], 7)
    parts = [tube(stem, 0.025, 6), join(head).turned("x", rng.uniform(0, 50)).at(z=height)]
    for _ in range(int(rng.integers(1, 4))):
        leaf = (
            _leaf(rng.uniform(0.4, 0.6), 0.15, 0.1)
            .turned("y", -rng.uniform(20, 50))
            .turned("z", rng.uniform(0, 360))
        )
        parts.append(leaf.at(z=height * rng.uniform(0.2, 0.6)))
    return parts


def cactus(rng: np.random.Generator) -> list[Part]:
    height, radius, sides = rng.uniform(1.8, 2.8), rng.uniform(0.2, 0.32), int(rng.choice([6, 8, 12]))

    def limb(points: list[list[float]], thick: float) -> Part:
        path = curve(points, 10)
        return join([tube(path, thick, sides), ball(thick, thick, thick, sides).at(*path[-1])])

    parts = [limb([[0, 0, 0], [0, 0, height * 0.5], [0, 0, height]], radius)]
    for number in range(int(rng.integers(1, 4))):
        low, reach, tall = height * rng.uniform(0.25, 0.55), rng.uniform(0.5, 0.7), rng.uniform(0.5, 0.9)
        arm = limb(
            [[0, 0, low], [reach * 0.8, 0, low + 0.05], [reach, 0, low + 0.3], [reach, 0, low + 0.3 + tall]],
            radius * 0.7,
        )
        parts.append(arm.turned("z", (0, 180, 90)[number]))
    return parts


def mushroom(rng: np.random.Generator) -> list[Part]:
    height, radius, sides = rng.uniform(0.6, 1.2), rng.uniform(0.4, 0.75), int(rng.choice([8, 16, 24]))
    stem = curve([(rng.uniform(0.12, 0.22), 0), (0.12, height * 0.6), (0.13, height)], 6)
    tall = rng.uniform(0.25, 0.6)
    cap = curve(
        [
            (0.0, height + tall),
            (radius * 0.7, height + tall * 0.7),
            (radius, height),
            (radius * 0.8, height - 0.05),
        ],
        10,
    )
    return [lathe([(0, 0), *stem], sides), lathe([*cap, (0, height)], sides)]


def broom(rng: np.random.Generator) -> list[Part]:
    length, width = rng.uniform(1.2, 1.6), rng.uniform(0.25, 0.4)
    parts = [tube([[0, 0, 0.3], [0, 0, length]], 0.02, 8)]
    if rng.random() < 0.5:
        parts.append(box(width, 0.1, 0.35, top=(0.3, 0.8)))
    else:
        parts.append(cylinder(width / 2, 0.45, 12, top=0.04))
    return [*parts, around(box(0.02, 0.02, 0.1).at(0.05), 6).at(z=0.38)]


KINDS: dict[str, Callable[[np.random.Generator], list[Part]]] = {
    "conifer": conifer,
    "leafy tree": leafy_tree,
    "bare tree": bare_tree,
    "palm": palm,
    "potted plant": potted_plant,
    "flower": flower,
    "cactus": cactus,
    "mushroom": mushroom,
    "broom": broom,
}
