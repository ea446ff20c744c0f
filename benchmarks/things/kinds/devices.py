# SPDX-License-Identifier: MIT
"""Devices: keyboards, monitors, laptops, telephones, cameras, fans, clocks, street lamps, signs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.things.part import Part, around, ball, box, curve, cylinder, join, lathe, ring, tube

__all__ = ["KINDS"]


def _keys(rng: np.random.Generator, width: float, depth: float, rows: int) -> Part:
    columns = int(rng.integers(10, 16))
    size = min(width / columns, depth / rows) * 0.8
    cap = box(width / columns * 0.8, depth / rows * 0.8, size * 0.4, top=0.85)
    places = [
        cap.at((x - (columns - 1) / 2) * width / columns, (y - (rows - 1) / 2) * depth / rows)
        for x in range(columns)
        for y in range(rows)
        if y > 0 or not 3 < x < columns - 4
    ]
    space = box(width / columns * (columns - 8), depth / rows * 0.8, size * 0.4)
    return join([*places, space.at(y=-(rows - 1) / 2 * depth / rows)])


def keyboard(rng: np.random.Generator) -> list[Part]:
    width, depth = rng.uniform(1.2, 1.8), rng.uniform(0.45, 0.6)
    tilt = rng.uniform(0, 8)
    body = box(width, depth, rng.uniform(0.04, 0.1), top=0.97)
    keys = _keys(rng, width * 0.93, depth * 0.85, int(rng.integers(4, 7)))
    return [join([body, keys.at(z=body.vertices[:, 2].max())]).turned("x", tilt)]


def monitor(rng: np.random.Generator) -> list[Part]:
    width, height = rng.uniform(1.0, 1.5), rng.uniform(0.65, 0.9)
    lift = rng.uniform(0.2, 0.4)
    parts = [
        box(width, 0.08, height).at(z=lift),
        box(width * 0.92, 0.02, height * 0.9).at(y=-0.05, z=lift + height * 0.05),
    ]
    if rng.random() < 0.4:  # an old deep one
        parts.append(
            box(height * 0.9, width * 0.9, 0.5, top=0.6).turned("x", -90).at(y=0.04, z=lift + height / 2)
        )
    parts.append(box(0.15, 0.08, lift + 0.2).at(y=0.08))
    style = rng.random() < 0.5
    parts.append(cylinder(0.3, 0.04, 20) if style else box(0.6, 0.4, 0.04))
    return parts


def laptop(rng: np.random.Generator) -> list[Part]:
    width, depth = rng.uniform(1.1, 1.4), rng.uniform(0.75, 0.95)
    angle = rng.uniform(70, 125)
    lid = join([box(width, depth, 0.03), box(width * 0.92, depth * 0.85, 0.005).at(z=0.03)])
    screen = lid.at(y=-depth / 2).turned("x", -angle).at(y=depth / 2, z=0.06)
    if angle:
        screen = lid.at(y=depth / 2).turned("x", 180 - angle).at(y=depth / 2, z=0.05)
    base = [box(width, depth, 0.05), _keys(rng, width * 0.85, depth * 0.45, 5).at(y=depth * 0.15, z=0.05)]
    base.append(box(width * 0.3, depth * 0.25, 0.008).at(y=-depth * 0.3, z=0.05))
    return [*base, screen]


def telephone(rng: np.random.Generator) -> list[Part]:
    width, depth = rng.uniform(0.7, 0.9), rng.uniform(0.75, 0.95)
    parts = [box(width, depth, rng.uniform(0.25, 0.4), top=(rng.uniform(0.6, 0.9), rng.uniform(0.4, 0.8)))]
    high = parts[0].vertices[:, 2].max()
    if rng.random() < 0.5:
        parts.append(cylinder(0.24, 0.05, 20).turned("x", 35).at(y=-depth * 0.2, z=high * 0.75))
    else:
        parts += [
            box(0.1, 0.1, 0.05).at((x - 1) * 0.14, (y - 1.5) * 0.13 - 0.1, high * 0.95)
            for x in range(3)
            for y in range(4)
        ]
    reach = width * rng.uniform(0.6, 0.7)
    arch = curve([[-reach, 0, 0], [-reach * 0.6, 0, 0.13], [reach * 0.6, 0, 0.13], [reach, 0, 0]], 10)
    handset = [
        tube(arch, 0.06, 8),
        cylinder(0.12, 0.12, 12).at(-reach, 0, -0.1),
        cylinder(0.12, 0.12, 12).at(reach, 0, -0.1),
    ]
    parts.append(join(handset).at(y=depth * 0.15, z=high + 0.1))
    return parts


def camera(rng: np.random.Generator) -> list[Part]:
    width, height, depth = rng.uniform(1.1, 1.5), rng.uniform(0.7, 0.9), rng.uniform(0.35, 0.5)
    radius, sides = rng.uniform(0.25, 0.36), int(rng.choice([12, 20]))
    parts = [box(width, depth, height)]
    barrel = [
        (radius, 0),
        (radius, rng.uniform(0.2, 0.7)),
        (radius * 0.9, 0.75),
        (radius * 0.7, 0.72),
        (0, 0.6),
    ]
    parts.append(lathe(barrel, sides).turned("x", 90).at(rng.uniform(-0.1, 0.15), -depth / 2, height * 0.48))
    parts.append(box(0.4, depth * 0.9, 0.2, top=0.6).at(z=height))
    parts += [cylinder(0.09, 0.08, 12).at(x * width * 0.36, z=height) for x in (-1, 1)]
    if rng.random() < 0.5:
        parts.append(box(0.2, 0.15, height * 0.95).at(-width * 0.42, -depth / 2))
    return parts


def fan(rng: np.random.Generator) -> list[Part]:
    height, radius = rng.uniform(0.6, 1.6), rng.uniform(0.4, 0.55)
    blade = box(radius * 0.85, rng.uniform(0.15, 0.25), 0.02).at(radius * 0.45).turned("x", 20)
    head = [around(blade, int(rng.integers(3, 6))), cylinder(0.1, 0.3, 12).at(z=-0.25)]
    head += [ring(radius, 0.015, 24, 5).at(z=z) for z in (-0.08, 0.08)]
    head.append(
        around(
            tube(curve([[0, 0, 0.15], [radius * 0.7, 0, 0.14], [radius, 0, 0]], 5), 0.007, 4),
            int(rng.choice([12, 20])),
        )
    )
    parts = [join(head).turned("x", 90 + rng.uniform(-15, 15)).at(z=height + radius)]
    parts += [
        cylinder(0.04, height + radius * 0.9, 8).at(y=0.12),
        cylinder(rng.uniform(0.25, 0.4), 0.06, 20, top=0.15),
    ]
    return parts


def street_lamp(rng: np.random.Generator) -> list[Part]:
    height, reach = rng.uniform(3, 5), rng.uniform(0.5, 1.2)
    parts = [cylinder(0.12, 0.5, 10, top=0.07)]
    if rng.random() < 0.5:
        arm = curve([[0, 0, 0], [0, 0, height * 0.85], [0, -reach * 0.4, height], [0, -reach, height]], 14)
        lamp = join(
            [
                tube(arm, np.linspace(0.07, 0.04, 14), 8),
                box(0.25, 0.6, 0.12, top=0.7).at(0, -reach - 0.2, height - 0.06),
            ]
        )
        parts.append(lamp)
        if rng.random() < 0.3:
            parts.append(lamp.scaled(y=-1))
    else:
        parts.append(tube([[0, 0, 0], [0, 0, height * 0.8]], 0.06, 8))
        parts.append(cylinder(0.15, 0.5, int(rng.choice([4, 6, 8])), top=0.25).at(z=height * 0.8))
        parts.append(cylinder(0.32, 0.2, 8, top=0.03).at(z=height * 0.8 + 0.5))
    return parts


def traffic_sign(rng: np.random.Generator) -> list[Part]:
    height, size, sides = rng.uniform(2, 2.6), rng.uniform(0.3, 0.42), int(rng.choice([3, 4, 8, 24]))
    plate = (
        cylinder(size, 0.03, sides)
        .turned("z", 90 if sides == 3 else 45 if sides == 4 else 22.5)
        .turned("x", 90)
    )
    parts = [
        tube([[0, 0, 0], [0, 0, height + size * 0.5]], rng.uniform(0.025, 0.04), 8),
        plate.at(y=-0.03, z=height),
    ]
    if rng.random() < 0.3:
        parts.append(box(size * 1.6, 0.03, size * 0.5).at(y=-0.04, z=height - size * 1.8))
    return parts


def clock(rng: np.random.Generator) -> list[Part]:
    sides = int(rng.choice([12, 24, 32]))
    face = [cylinder(1, 0.2, sides), ring(1, 0.07, sides, 6).at(z=0.2)]
    face.append(around(box(0.14, 0.04, 0.03).at(0.83, 0, 0.2), 12))
    face += [
        box(0.05, length, 0.03).at(0, length / 2, 0.22).turned("z", rng.uniform(0, 360))
        for length in (0.5, 0.75)
    ]
    parts = [join(face).turned("x", 90).at(z=1.1)]
    if rng.random() < 0.6:
        parts += [cylinder(0.06, 0.35, 8).turned("y", x * 25).at(x * -0.6, 0, 0.1) for x in (-1, 1)]
        parts += [ball(0.3, 0.2, 0.2, 10).turned("y", x * 35).at(x * 0.65, -0.1, 2.05) for x in (-1, 1)]
    return parts


KINDS: dict[str, Callable[[np.random.Generator], list[Part]]] = {
    "keyboard": keyboard,
    "monitor": monitor,
    "laptop": laptop,
    "telephone": telephone,
    "camera": camera,
    "fan": fan,
    "street lamp": street_lamp,
    "traffic sign": traffic_sign,
    "clock": clock,
}
