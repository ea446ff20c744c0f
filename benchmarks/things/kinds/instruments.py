# SPDX-License-Identifier: MIT
"""Things to play with: guitars, pianos, drums, trumpets, chess pieces, skateboards."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.things.part import Part, around, ball, box, curve, cylinder, join, lathe, loft, prism, tube

__all__ = ["KINDS"]


def guitar(rng: np.random.Generator) -> list[Part]:
    lower, waist, upper = rng.uniform(0.36, 0.44), rng.uniform(0.2, 0.28), rng.uniform(0.26, 0.34)
    length, thick = rng.uniform(0.9, 1.1), rng.uniform(0.08, 0.22)
    half = curve(
        [(0, 0), (lower, length * 0.25), (waist, length * 0.58), (upper, length * 0.82), (0.06, length)], 18
    )
    outline = np.concatenate([half, half[::-1][:-1] * np.array([-1, 1])])
    neck = rng.uniform(0.8, 1.1)
    parts = [prism(outline[:-1] if np.allclose(outline[0], outline[-1]) else outline, thick)]
    parts.append(box(0.11, neck + 0.2, 0.05).at(y=length + neck / 2 - 0.1, z=thick))
    parts.append(box(0.16, 0.25, 0.05, top=0.9).at(y=length + neck + 0.1, z=thick))
    parts += [
        cylinder(0.02, 0.1, 6).turned("y", x * 90).at(x * 0.08, length + neck + y, thick + 0.02)
        for x in (-1, 1)
        for y in (0.03, 0.1, 0.17)
    ]
    parts += [
        cylinder(0.11, 0.02, 16).at(y=length * 0.6, z=thick),
        box(0.25, 0.05, 0.04).at(y=length * 0.25, z=thick),
    ]
    return [join(parts).turned("x", 90)]


def grand_piano(rng: np.random.Generator) -> list[Part]:
    width, length, height = rng.uniform(1.4, 1.6), rng.uniform(1.5, 2.4), 0.7
    outline = [
        (-width / 2, 0),
        (width / 2, 0),
        (width / 2, length * 0.35),
        (width * 0.25, length * 0.6),
        (width * 0.1, length * 0.9),
        (-width * 0.2, length),
        (-width / 2, length * 0.95),
    ]
    parts = [prism(outline, 0.3).at(z=height), box(width, 0.28, 0.12).at(y=-0.14, z=height)]
    keys = 26
    parts += [
        box(width / keys * 0.8, 0.22, 0.03).at((n - keys / 2 + 0.5) * width / keys, -0.14, height + 0.12)
        for n in range(keys)
    ]
    if rng.random() < 0.6:
        lid = prism(outline, 0.03).at(width / 2).turned("y", rng.uniform(20, 40)).at(-width / 2)
        parts.append(lid.at(z=height + 0.32))
    parts += [
        cylinder(0.05, height, 8, top=0.09).at(x, y)
        for x, y in ((-width * 0.42, 0.1), (width * 0.42, 0.1), (-width * 0.2, length * 0.85))
    ]
    return parts


def drum(rng: np.random.Generator) -> list[Part]:
    radius, height, sides = rng.uniform(0.4, 0.6), rng.uniform(0.3, 0.9), int(rng.choice([16, 24]))
    parts = [cylinder(radius, height, sides, top=radius * rng.uniform(0.85, 1.1))]
    top = parts[0].vertices[:, 0].max()
    parts += [
        lathe([(top, 0), (top + 0.04, 0), (top + 0.04, 0.06), (top, 0.06)], sides).at(z=z)
        for z in (0, height - 0.06)
    ]
    lug = box(0.04, 0.05, height * 0.8).at(top + 0.02, 0, height * 0.1)
    parts.append(around(lug, int(rng.choice([6, 8, 10]))))
    if rng.random() < 0.4:
        leg = tube([[radius * 0.5, 0, 0], [radius * 1.1, 0, -0.7]], 0.02, 6)
        parts.append(around(leg, 3))
    return parts


def trumpet(rng: np.random.Generator) -> list[Part]:
    length, bell = rng.uniform(1.0, 1.3), rng.uniform(0.16, 0.24)
    profile = curve([(0.025, 0), (0.03, length * 0.6), (0.07, length * 0.88), (bell, length)], 14)
    parts = [lathe(profile, 14).turned("y", 90)]
    loop = rng.uniform(0.12, 0.18)
    path = curve(
        [
            [0.3, 0, 0],
            [0.15, 0, -loop * 0.5],
            [0.3, 0, -loop],
            [0.75, 0, -loop],
            [0.9, 0, -loop * 0.5],
            [0.75, 0, 0],
        ],
        24,
    )
    parts.append(tube(path + np.array([0, 0.05, 0]), 0.025, 8))
    parts += [cylinder(0.035, loop * 2.2, 10).at(0.42 + 0.09 * n, 0.03, -loop * 1.5) for n in range(3)]
    parts += [cylinder(0.025, 0.04, 8).at(0.42 + 0.09 * n, 0.03, loop * 0.75) for n in range(3)]
    parts.append(lathe([(0.02, 0), (0.05, -0.08)], 10).turned("y", 90))
    return parts


def chess_piece(rng: np.random.Generator) -> list[Part]:
    sides, height = int(rng.choice([12, 20, 28])), rng.uniform(0.9, 1.5)
    points = [
        (0.0, 0),
        (rng.uniform(0.3, 0.38), 0),
        (0.32, 0.12),
        (0.2, 0.22),
        (rng.uniform(0.12, 0.18), height * 0.6),
    ]
    points += [(0.22, height * 0.66), (0.12, height * 0.7)]
    body = lathe(points, sides)
    top = rng.integers(3)
    if top == 0:
        crown = [ball(0.2, 0.2, 0.2, sides).at(z=height * 0.82)]
    elif top == 1:
        crown = [
            ball(0.17, 0.17, 0.26, sides).at(z=height * 0.85),
            ball(0.04, 0.04, 0.04, 8).at(z=height * 0.85 + 0.28),
        ]
    else:
        crown = [lathe([(0.13, 0), (0.24, 0.3), (0.15, 0.34), (0, 0.4)], sides).at(z=height * 0.68)]
        crown += [
            box(0.04, 0.04, 0.16).at(z=height * 0.68 + 0.38),
            box(0.12, 0.04, 0.04).at(z=height * 0.68 + 0.45),
        ]
    return [body, *crown]


def skateboard(rng: np.random.Generator) -> list[Part]:
    length, width, kick = rng.uniform(1.6, 2.2), rng.uniform(0.38, 0.5), rng.uniform(0.05, 0.2)
    steps = np.linspace(-1, 1, 11)
    loops = []
    for share in steps:
        half = width / 2 * (1 - max(0.0, abs(share) - 0.75) * 2.2)
        z = 0.18 + kick * max(0.0, abs(share) - 0.65) / 0.35
        loops.append(
            [
                [-half, share * length / 2, z],
                [half, share * length / 2, z],
                [half, share * length / 2, z + 0.03],
                [-half, share * length / 2, z + 0.03],
            ]
        )
    wheel = cylinder(0.07, 0.08, 12).turned("y", 90)
    parts = [loft(loops)]
    for y in (-length * 0.3, length * 0.3):
        parts += [wheel.at(x * width * 0.35 - 0.04, y, 0.07) for x in (-1, 1)]
        parts += [box(width * 0.7, 0.04, 0.04).at(y=y, z=0.05), box(0.12, 0.15, 0.1, top=1.3).at(y=y, z=0.09)]
    return parts


KINDS: dict[str, Callable[[np.random.Generator], list[Part]]] = {
    "guitar": guitar,
    "grand piano": grand_piano,
    "drum": drum,
    "trumpet": trumpet,
    "chess piece": chess_piece,
    "skateboard": skateboard,
}
