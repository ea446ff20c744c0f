# SPDX-License-Identifier: MIT
"""Tools and weapons: hammers, axes, spanners, saws, scissors, knives, swords, pistols, rifles, keys."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.flat_parts.polygons import circle
from benchmarks.things.part import (
    Part,
    around,
    ball,
    box,
    curve,
    cylinder,
    join,
    lathe,
    loft,
    mirrored_pair,
    prism,
    ring,
    tube,
)

__all__ = ["KINDS"]


def hammer(rng: np.random.Generator) -> list[Part]:
    length, head = rng.uniform(0.8, 1.2), rng.uniform(0.3, 0.45)
    grip = curve([[0, 0, 0], [0, 0, length * 0.5], [0, 0, length]], 6)
    parts = [
        tube(
            grip,
            np.array([1.2, 1, 0.9, 0.8, 0.8, 0.8]) * rng.uniform(0.03, 0.05),
            int(rng.choice([4, 8, 12])),
        )
    ]
    face = rng.uniform(0.05, 0.09)
    if rng.random() < 0.5:
        parts.append(cylinder(face, head * 0.5, int(rng.choice([4, 12]))).turned("y", 90).at(z=length))
        claw = curve([[0, 0, length], [-head * 0.4, 0, length], [-head * 0.6, 0, length - 0.1]], 6)
        parts += [tube(claw + np.array([0, y, 0]), np.linspace(0.05, 0.012, 6), 4) for y in (-0.025, 0.025)]
    else:
        parts.append(
            cylinder(face, head, int(rng.choice([4, 8, 12]))).turned("y", 90).at(-head / 2, 0, length)
        )
    return parts


def axe(rng: np.random.Generator) -> list[Part]:
    length, blade = rng.uniform(0.8, 1.3), rng.uniform(0.2, 0.35)
    bend = rng.uniform(0, 0.06)
    path = curve([[0, 0, 0], [bend, 0, length * 0.4], [0, 0, length]], 7)
    outline = [
        (0.04, 0.08),
        (-0.05, 0.08),
        (-0.05, -0.08),
        (0.04, -0.08),
        (blade, -blade * rng.uniform(0.4, 0.9)),
    ]
    outline += [(blade * 1.12, 0), (blade, blade * rng.uniform(0.4, 0.7))]
    head = prism(outline, 0.06).turned("x", 90).at(y=0.03, z=length * 0.93)
    parts = [tube(path, rng.uniform(0.022, 0.035), 8), head]
    if rng.random() < 0.3:
        parts.append(head.scaled(x=-1))
    return parts


def screwdriver(rng: np.random.Generator) -> list[Part]:
    grip, shaft, radius = rng.uniform(0.3, 0.45), rng.uniform(0.4, 0.7), rng.uniform(0.06, 0.09)
    profile = curve(
        [(radius * 0.7, 0), (radius, grip * 0.3), (radius * 0.75, grip * 0.75), (radius * 0.9, grip)], 9
    )
    parts = [lathe([(0, 0), *profile, (0, grip)], int(rng.choice([6, 8, 12])))]
    parts.append(cylinder(0.018, shaft, 8).at(z=grip))
    parts.append(box(0.05, 0.03, 0.08, top=(rng.uniform(0.4, 1.2), 0.2)).at(z=grip + shaft - 0.01))
    return parts


def spanner(rng: np.random.Generator) -> list[Part]:
    length, width = rng.uniform(0.8, 1.2), rng.uniform(0.07, 0.11)

    def jaw(radius: float) -> list[tuple[float, float]]:
        half = radius * 0.45
        angles = np.radians(np.linspace(40, 320, 12))
        outer = [(-radius * np.cos(a), radius * np.sin(a)) for a in angles]
        return [
            *outer,
            (radius * 0.75, -half),
            (-radius * 0.1, -half),
            (-radius * 0.1, half),
            (radius * 0.75, half),
        ]

    def head(radius: float) -> Part:
        if rng.random() < 0.6:
            points = np.array(jaw(radius))[::-1] * np.array([1, 1])
            return prism(points * np.array([-1, 1]), 0.05).turned("z", 180 + rng.uniform(-20, 20))
        return prism(circle(0, 0, radius, 16), 0.05, [circle(0, 0, radius * 0.6, 6)])

    first, second = rng.uniform(0.13, 0.17), rng.uniform(0.1, 0.15)
    bar = box(length, width, 0.04).at(z=0.005)
    return [bar, head(first).at(length / 2 + 0.06), head(second).turned("z", 180).at(-length / 2 - 0.06)]


def saw(rng: np.random.Generator) -> list[Part]:
    length, high, low = rng.uniform(1, 1.4), rng.uniform(0.18, 0.28), rng.uniform(0.07, 0.14)
    teeth = int(rng.integers(15, 40))
    x = np.linspace(0, length, 2 * teeth + 1)
    lower = [(place, 0.0 if number % 2 else 0.03) for number, place in enumerate(x)]
    blade = prism([*lower, (length, low), (0, high)], 0.012)
    outline = [(-0.32, 0.0), (0.08, 0.0), (0.08, high), (-0.2, high * 1.2), (-0.34, high)]
    handle = prism(outline, 0.06, [circle(-0.13, high * 0.5, high * 0.27, 12)]).at(z=-0.025)
    return [join([blade, handle]).turned("x", 90)]


def scissors(rng: np.random.Generator) -> list[Part]:
    length, grip, opening = rng.uniform(0.5, 0.9), rng.uniform(0.35, 0.5), rng.uniform(5, 25)
    blade = prism([(-0.04, 0), (0.05, 0), (0.05, length * 0.3), (0, length), (-0.04, length * 0.8)], 0.02)
    arm = tube(curve([[0, 0, 0.01], [0.05, -grip * 0.5, 0.01], [0.1, -grip, 0.01]], 6), 0.025, 6)
    loop = (
        ring(rng.uniform(0.09, 0.14), 0.025, 16, 6).scaled(y=rng.uniform(1, 1.6)).at(0.16, -grip - 0.1, 0.01)
    )
    half = join([blade, arm, loop])
    parts = [half.turned("z", opening), half.scaled(x=-1).turned("z", -opening).at(z=0.02)]
    parts.append(cylinder(0.03, 0.06, 10).at(z=-0.01))
    return [join(parts).turned("x", rng.choice([0.0, 90.0]))]


def knife(rng: np.random.Generator) -> list[Part]:
    length, width = rng.uniform(0.6, 1.0), rng.uniform(0.08, 0.16)
    back = rng.uniform(0.6, 1.0)
    outline = [(0, 0), (length * 0.75, -0.0), (length, width * back * 0.9), (length * 0.5, width), (0, width)]
    blade = prism(outline, 0.015)
    grip = box(rng.uniform(0.35, 0.5), width * 0.7, 0.07, top=(0.98, 0.8))
    parts = [blade, grip.at(-0.2, width * 0.55, -0.025)]
    if rng.random() < 0.4:
        parts.append(box(0.04, width * 1.6, 0.09).at(0, width * 0.5, -0.035))
    return [join(parts).turned("x", rng.choice([0.0, 90.0]))]


def sword(rng: np.random.Generator) -> list[Part]:
    length, width, grip = rng.uniform(1.2, 2.0), rng.uniform(0.08, 0.16), rng.uniform(0.25, 0.4)
    bend = rng.choice([0.0, rng.uniform(0.1, 0.3)])
    steps = np.linspace(0, 1, 8)
    loops = []
    for share in steps:
        half = width / 2 * (1 if share < 0.85 else max(0.02, (1 - share) / 0.15))
        x = bend * share**2
        outline = [(half, 0), (0, 0.02), (-half, 0), (0, -0.02)]
        loops.append([[x + a, b, share * length] for a, b in outline])
    guard = rng.uniform(0.25, 0.5)
    parts = [loft(loops), cylinder(0.03, grip, 8).at(z=-grip)]
    bars = (
        box(guard, 0.06, 0.05, top=rng.uniform(0.8, 1.2)) if rng.random() < 0.7 else cylinder(0.12, 0.03, 12)
    )
    parts += [bars.at(z=-0.02), ball(0.05, 0.05, 0.05, 8).at(z=-grip)]
    return parts


def pistol(rng: np.random.Generator) -> list[Part]:
    length, height = rng.uniform(0.7, 1.0), rng.uniform(0.13, 0.18)
    lean = rng.uniform(5, 22)
    grip = box(rng.uniform(0.16, 0.22), 0.12, 0.45, top=rng.uniform(0.8, 1)).turned("y", lean)
    parts = [grip.at(-length * 0.38 - 0.15, 0, -0.42)]
    if rng.random() < 0.4:  # a revolver
        parts.append(cylinder(0.05, length * 0.6, 10).turned("y", 90).at(-length * 0.1, 0, height * 0.6))
        parts.append(cylinder(0.11, 0.24, 12).turned("y", 90).at(-length * 0.35, 0, height * 0.4))
        parts.append(box(0.36, 0.1, 0.2).at(-length * 0.3, 0, -0.05))
        parts.append(box(0.05, 0.03, 0.1).turned("y", -30).at(-length * 0.5, 0, height))
    else:
        parts.append(box(length, 0.12, height))
        parts.append(box(length * 0.6, 0.1, 0.08).at(-length * 0.1, 0, -0.06))
        parts.append(cylinder(0.03, 0.08, 8).turned("y", 90).at(length / 2, 0, height * 0.6))
    parts.append(ring(0.09, 0.015, 14, 5).turned("x", 90).at(-length * 0.15, 0, -0.1))
    parts.append(box(0.03, 0.02, 0.05).at(length * 0.43, 0, height))
    return [join(parts).turned("z", -90)]


def rifle(rng: np.random.Generator) -> list[Part]:
    length = rng.uniform(1.0, 1.5)
    parts = [cylinder(0.025, length * 0.65, 8).turned("y", 90).at(0, 0, 0.1)]
    parts.append(box(0.45, 0.08, rng.uniform(0.12, 0.18)))
    stock = prism(
        [(-0.2, 0.02), (-0.2, 0.12), (-0.75, 0.08), (-0.75, -rng.uniform(0.08, 0.15)), (-0.35, -0.03)], 0.07
    )
    parts.append(stock.turned("x", 90).at(y=0.035))
    parts.append(box(0.4, 0.07, 0.07).at(0.4, 0, 0.02))
    if rng.random() < 0.7:
        parts.append(
            box(0.1, 0.06, rng.uniform(0.15, 0.3)).turned("y", rng.uniform(-25, 5)).at(0.1, 0, -0.24)
        )
    if rng.random() < 0.6:
        parts.append(box(0.08, 0.06, 0.2).turned("y", 20).at(-0.22, 0, -0.18))
    if rng.random() < 0.5:
        parts += [
            cylinder(0.035, 0.3, 10).turned("y", 90).at(-0.15, 0, 0.23),
            box(0.03, 0.03, 0.08).at(0, 0, 0.15),
        ]
    parts.append(box(0.02, 0.015, 0.06).at(length * 0.62, 0, 0.12))
    return [join(parts).turned("z", -90)]


def key(rng: np.random.Generator) -> list[Part]:
    length, radius = rng.uniform(0.6, 0.9), rng.uniform(0.13, 0.2)
    if rng.random() < 0.5:
        bow = prism(circle(0, 0, radius, int(rng.choice([6, 16]))), 0.04, [circle(0, 0, radius * 0.5, 12)])
        shaft = box(length, 0.07, 0.03).at(length / 2 + radius * 0.9, 0, 0.005)
    else:
        bow = ring(radius, 0.035, 18, 6).at(z=0.02)
        shaft = cylinder(0.03, length, 8).turned("y", 90).at(radius, 0, 0.02)
    teeth = [
        box(0.05, rng.uniform(0.05, 0.14), 0.03).at(radius + length * place, -0.07, 0.005)
        for place in np.linspace(0.6, 0.97, int(rng.integers(2, 6)))
    ]
    return [join([bow, shaft, *teeth]).turned("x", rng.choice([0.0, 90.0]))]


def spoon(rng: np.random.Generator) -> list[Part]:
    length, bowl = rng.uniform(0.8, 1.1), rng.uniform(0.13, 0.2)
    angle = np.linspace(0, np.pi / 2, 6)
    shell = lathe(np.stack([np.sin(angle), -0.45 * np.cos(angle)], 1), 14).scaled(bowl * 1.4, bowl, bowl)
    path = curve([[bowl * 1.3, 0, 0], [length * 0.4, 0, 0.08], [length, 0, rng.uniform(0, 0.06)]], 8)
    handle = tube(path, np.linspace(0.02, rng.uniform(0.03, 0.06), 8), 6)
    flat = handle.scaled(z=0.5)
    return [shell, flat]


def umbrella(rng: np.random.Generator) -> list[Part]:
    radius, height, ribs = rng.uniform(0.6, 0.9), rng.uniform(0.9, 1.3), int(rng.choice([6, 8, 10]))
    dome = curve([(0.0, height), (radius * 0.6, height - 0.1), (radius, height - rng.uniform(0.3, 0.45))], 6)
    hook = curve([[0, 0, height * 1.05], [0, 0, 0.1], [0.07, 0, 0], [0.14, 0, 0.1]], 14)
    parts = [lathe(dome, ribs), tube(hook, 0.018, 6)]
    rib = tube([[0.02, 0, height * 0.6], [radius * 0.6, 0, height - 0.12]], 0.008, 4)
    parts.append(around(rib, ribs))
    return parts


def pincers(rng: np.random.Generator) -> list[Part]:
    length, opening = rng.uniform(0.7, 1.0), rng.uniform(6, 18)
    arm = tube(
        curve([[0, 0, 0], [0.12, -length * 0.3, 0], [0.1, -length, 0]], 8), rng.uniform(0.03, 0.045), 8
    )
    jaw = box(0.09, rng.uniform(0.2, 0.4), 0.1, top=0.9).at(-0.04, 0.15, -0.05)
    half = join([arm, jaw]).turned("z", opening)
    return [
        join([mirrored_pair(half), cylinder(0.07, 0.13, 12).at(z=-0.065)]).turned(
            "x", rng.choice([0.0, 90.0])
        )
    ]


KINDS: dict[str, Callable[[np.random.Generator], list[Part]]] = {
    "hammer": hammer,
    "axe": axe,
    "screwdriver": screwdriver,
    "spanner": spanner,
    "saw": saw,
    "scissors": scissors,
    "knife": knife,
    "sword": sword,
    "pistol": pistol,
    "rifle": rifle,
    "key": key,
    "spoon": spoon,
    "umbrella": umbrella,
    "pincers": pincers,
}
