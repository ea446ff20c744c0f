# SPDX-License-Identifier: MIT
"""Buildings: houses, churches, castles, skyscrapers, bridges, windmills, stairs, fences, doors, wells."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.flat_parts.polygons import circle
from benchmarks.things.part import Part, around, ball, box, cylinder, join, prism, tube

__all__ = ["KINDS"]


def _gable(width: float, depth: float, height: float, over: float = 0.2) -> Part:
    """Build a gable roof whose ridge is along y."""
    half = width / 2 + over
    return (
        prism([(-half, 0), (half, 0), (0, height)], depth + 2 * over).turned("x", 90).at(y=depth / 2 + over)
    )


def house(rng: np.random.Generator) -> list[Part]:
    width, depth, height = rng.uniform(4, 7), rng.uniform(5, 9), rng.uniform(2.5, 5)
    roof = rng.uniform(1.5, 3)
    parts = [box(width, depth, height)]
    if rng.random() < 0.75:
        parts.append(_gable(width, depth, roof).at(z=height))
    else:
        parts.append(box(width * 1.08, depth * 1.08, roof, top=(0.1, rng.uniform(0.1, 0.5))).at(z=height))
    parts.append(box(1.0, 0.15, 2.0).at(rng.uniform(-1, 1), -depth / 2))
    window = box(0.9, 0.12, 1.0)
    floors = max(1, int(height // 2.4))
    for level in range(floors):
        parts += [
            window.at(x * width * 0.32, y * depth / 2, 1 + 2.4 * level) for x in (-1, 1) for y in (-1, 1)
        ]
        parts += [
            window.turned("z", 90).at(x * width / 2, y * depth * 0.25, 1 + 2.4 * level)
            for x in (-1, 1)
            for y in (-1, 1)
        ]
    if rng.random() < 0.7:
        parts.append(box(0.6, 0.6, roof).at(width * 0.25, depth * 0.2, height + roof * 0.35))
    if rng.random() < 0.4:
        wing = [
            box(width * 0.6, depth * 0.5, height * 0.9),
            _gable(width * 0.6, depth * 0.5, roof * 0.7).at(z=height * 0.9),
        ]
        parts.append(join(wing).turned("z", 90).at(width * 0.6))
    return parts


def church(rng: np.random.Generator) -> list[Part]:
    width, depth, height = rng.uniform(4, 6), rng.uniform(9, 14), rng.uniform(4, 6)
    tower, tall, spire = rng.uniform(2.2, 3.2), rng.uniform(8, 12), rng.uniform(3, 7)
    parts = [box(width, depth, height), _gable(width, depth, rng.uniform(2.5, 4)).at(z=height)]
    parts.append(box(tower, tower, tall).at(y=-depth / 2))
    parts.append(
        cylinder(tower * 0.75, spire, 4 if rng.random() < 0.6 else 8, top=0.01)
        .turned("z", 45)
        .at(y=-depth / 2, z=tall)
    )
    parts += [
        box(0.12, 0.12, 1.0).at(y=-depth / 2, z=tall + spire),
        box(0.6, 0.12, 0.12).at(y=-depth / 2, z=tall + spire + 0.6),
    ]
    count = int(rng.integers(3, 6))
    parts += [
        box(0.2, 0.8, 2.5).at(x * width / 2, (n + 0.5) / count * depth * 0.85 - depth * 0.35, 1.2)
        for x in (-1, 1)
        for n in range(count)
    ]
    if rng.random() < 0.4:
        nave = [box(width * 0.9, width * 2, height), _gable(width * 0.9, width * 2, 2.5).at(z=height)]
        parts.append(join(nave).turned("z", 90).at(y=depth * 0.2))
    return parts


def castle(rng: np.random.Generator) -> list[Part]:
    size, wall, sides = rng.uniform(8, 12), rng.uniform(2.5, 4), int(rng.choice([4, 8, 12]))
    tower, radius = wall * rng.uniform(1.3, 1.8), rng.uniform(1, 1.5)
    parts: list[Part] = []
    teeth = int(rng.integers(5, 9))
    crenel = join(
        box(size / teeth * 0.5, 0.5, 0.6).at((n - (teeth - 1) / 2) * size / teeth, 0, wall)
        for n in range(teeth)
    )
    side = join([box(size, 0.6, wall), crenel]).at(y=-size / 2)
    parts += [side.turned("z", angle) for angle in (0, 90, 180, 270)]
    turret = [cylinder(radius, tower, sides), cylinder(radius * 1.2, 0.5, sides).at(z=tower)]
    if rng.random() < 0.6:
        turret.append(cylinder(radius * 1.3, radius * 1.8, sides, top=0.01).at(z=tower + 0.5))
    parts += [join(turret).at(x * size / 2, y * size / 2) for x in (-1, 1) for y in (-1, 1)]
    parts.append(box(size * 0.35, size * 0.35, wall * rng.uniform(1.3, 2.2)).at(y=size * 0.1))
    parts.append(box(1.8, 0.9, wall * 0.7).at(y=-size / 2))
    return parts


def skyscraper(rng: np.random.Generator) -> list[Part]:
    width, depth = rng.uniform(3, 5), rng.uniform(3, 5)
    level, parts = 0.0, []
    for _ in range(int(rng.integers(1, 5))):
        tall = rng.uniform(5, 12)
        sides = int(rng.choice([4, 4, 4, 8, 16]))
        body = cylinder(0.71, tall, sides).turned("z", 180 / sides).scaled(width, depth, 1)
        parts.append(body.at(z=level))
        floors = int(tall / 0.9)
        if rng.random() < 0.6:
            parts += [body.scaled(1.02, 1.02, 0.03).at(z=level + 0.9 * n) for n in range(floors)]
        level += tall
        width, depth = width * rng.uniform(0.6, 0.85), depth * rng.uniform(0.6, 0.85)
    if rng.random() < 0.6:
        parts.append(cylinder(0.15, rng.uniform(2, 5), 6, top=0.02).at(z=level))
    return parts


def bridge(rng: np.random.Generator) -> list[Part]:
    length, width = rng.uniform(14, 24), rng.uniform(2, 3)
    deck = rng.uniform(2, 4)
    parts = [box(width, length, 0.4).at(z=deck)]
    parts += [box(0.1, length, 0.5).at(x * width / 2, 0, deck + 0.4) for x in (-1, 1)]
    if rng.random() < 0.5:  # suspended
        high = rng.uniform(3, 6)
        for x in (-1, 1):
            parts += [box(0.4, 0.5, deck + high).at(x * width / 2, y * length * 0.3) for y in (-1, 1)]
            y = np.linspace(-0.3, 0.3, 13) * length
            sag = deck + 0.6 + high * 0.92 * (y / (0.3 * length)) ** 2
            parts.append(tube(np.stack([np.full(13, x * width / 2), y, sag], 1), 0.08, 5))
            parts += [
                box(0.06, 0.06, z - deck).at(x * width / 2, place, deck)
                for place, z in zip(y, sag, strict=True)
            ]
            parts += [
                tube(
                    [[x * width / 2, s * length * 0.3, deck + high], [x * width / 2, s * length / 2, deck]],
                    0.08,
                    5,
                )
                for s in (-1, 1)
            ]
    else:
        arches = int(rng.integers(2, 6))
        span = length / arches
        angle = np.linspace(0, np.pi, 11)
        radius = min(span * 0.42, deck * 0.95)
        opening = [(-radius * np.cos(a), radius * np.sin(a)) for a in angle]
        outline = [(-span / 2, 0), *opening, (span / 2, 0), (span / 2, deck), (-span / 2, deck)]
        arch = prism(outline, width).turned("x", 90).turned("z", 90).at(x=-width / 2)
        parts += [arch.at(y=(n - (arches - 1) / 2) * span) for n in range(arches)]
    return parts


def windmill(rng: np.random.Generator) -> list[Part]:
    height, radius, sides = rng.uniform(5, 8), rng.uniform(1.2, 1.8), int(rng.choice([6, 8, 16]))
    parts = [cylinder(radius, height, sides, top=radius * rng.uniform(0.5, 0.8))]
    parts.append(ball(radius * 0.8, radius * 0.8, radius * 0.8, 10).at(z=height))
    reach = rng.uniform(3, 4.5)
    sail = join(
        [box(0.15, 0.1, reach), box(rng.uniform(0.5, 0.9), 0.05, reach * 0.75).at(0.35, 0, reach * 0.25)]
    )
    count = int(rng.choice([4, 4, 4, 6]))
    turn = rng.uniform(0, 90)
    wings = join(sail.turned("y", turn + 360 * n / count) for n in range(count))
    parts += [
        wings.at(y=-radius - 0.2, z=height),
        box(0.3, radius + 0.4, 0.3).at(y=-radius / 2, z=height - 0.15),
    ]
    parts.append(box(0.9, 0.2, 1.8).at(y=-radius))
    return parts


def stairs(rng: np.random.Generator) -> list[Part]:
    count, width, rise, going = (
        int(rng.integers(5, 14)),
        rng.uniform(0.9, 1.6),
        rng.uniform(0.15, 0.2),
        rng.uniform(0.24, 0.32),
    )
    if rng.random() < 0.3:  # spiral
        turn, inner = rng.uniform(18, 30), 0.15
        step = box(width, 0.32, 0.06).at(width / 2 + inner)
        parts = [step.turned("z", turn * n).at(z=rise * (n + 1)) for n in range(count)]
        return [*parts, cylinder(inner, rise * (count + 4), 12)]
    solid_steps = rng.random() < 0.5
    parts = [
        box(width, going, rise * (n + 1) if solid_steps else 0.05).at(
            y=n * going, z=0 if solid_steps else rise * (n + 1)
        )
        for n in range(count)
    ]
    if rng.random() < 0.6:
        for x in (-1, 1):
            rail = [[x * width / 2, 0, 0.9 + rise], [x * width / 2, going * (count - 1), 0.9 + rise * count]]
            parts.append(tube(rail, 0.03, 6))
            parts += [
                box(0.03, 0.03, 0.9).at(x * width / 2, n * going, rise * (n + 1)) for n in range(0, count, 2)
            ]
    return parts


def fence(rng: np.random.Generator) -> list[Part]:
    count, height = int(rng.integers(8, 18)), rng.uniform(0.9, 1.5)
    pale = rng.uniform(0.05, 0.1)
    gap = pale * rng.uniform(1.4, 2.5)
    tip = box(pale, 0.03, 0.1, top=(0.05, 1)) if rng.random() < 0.6 else box(pale, 0.03, 0.05)
    post = join([box(pale, 0.03, height), tip.at(z=height)])
    shift = (np.arange(count) - (count - 1) / 2) * gap
    parts = [post.at(x) for x in shift]
    parts += [box(gap * count, 0.04, 0.08).at(y=0.03, z=height * z) for z in (0.2, 0.75)]
    return parts


def tent(rng: np.random.Generator) -> list[Part]:
    width, depth, height = rng.uniform(1.8, 2.6), rng.uniform(2, 3), rng.uniform(1.2, 1.8)
    if rng.random() < 0.3:
        sides = int(rng.choice([6, 8, 12]))
        return [
            cylinder(width * 0.6, height * 0.6, sides),
            cylinder(width * 0.65, height, sides, top=0.02).at(z=height * 0.6),
        ]
    opening = [(-0.35, 0), (0, height * 0.75), (0.35, 0)]
    front = (
        prism([(-width / 2, 0), *opening, (width / 2, 0), (0, height)], 0.02).turned("x", 90).at(y=-depth / 2)
    )
    roof = _gable(width, depth, height, 0)
    parts = [roof, front]
    parts += [
        tube([[0, y * depth / 2, height], [x * width * 0.3, y * depth * 0.8, 0]], 0.01, 4)
        for x in (-1, 1)
        for y in (-1, 1)
    ]
    return parts


def door(rng: np.random.Generator) -> list[Part]:
    width, height = rng.uniform(0.8, 1.1), rng.uniform(1.9, 2.2)
    parts = [box(width, 0.05, height)]
    rows, columns = int(rng.integers(1, 4)), int(rng.integers(1, 3))
    panel = box(width / columns * 0.7, 0.08, height / rows * 0.75)
    parts += [
        panel.at((x - (columns - 1) / 2) * width / columns * 0.9, 0, (y + 0.12) * height / rows)
        for x in range(columns)
        for y in range(rows)
    ]
    parts.append(ball(0.04, 0.12, 0.04, 8).at(width * 0.42, 0, height * 0.48))
    if rng.random() < 0.7:
        parts += [box(0.1, 0.12, height + 0.1).at(x * (width / 2 + 0.06)) for x in (-1, 1)]
        parts.append(box(width + 0.3, 0.12, 0.1).at(z=height + 0.02))
    return parts


def column(rng: np.random.Generator) -> list[Part]:
    height, radius, flutes = rng.uniform(3, 6), rng.uniform(0.3, 0.5), int(rng.choice([0, 12, 20]))
    if flutes:
        angles = np.linspace(0, 2 * np.pi, 2 * flutes, endpoint=False)
        radii = np.where(np.arange(2 * flutes) % 2, radius, radius * 0.9)
        shaft = prism(np.stack([radii * np.cos(angles), radii * np.sin(angles)], 1), height)
    else:
        shaft = prism(circle(0, 0, radius, 16), height)
    narrow = 1 - 0.15 * shaft.vertices[:, 2:] / height
    shaft.vertices[:, :2] *= narrow
    base = rng.uniform(2.4, 2.9) * radius
    parts = [shaft, box(base, base, 0.2).at(z=-0.25), cylinder(base * 0.48, 0.12, 20).at(z=-0.06)]
    parts += [
        cylinder(radius, 0.2, 20, top=base * 0.5).at(z=height),
        box(base, base, 0.15).at(z=height + 0.2),
    ]
    return parts


def well(rng: np.random.Generator) -> list[Part]:
    radius, wall, sides = rng.uniform(0.7, 1.0), rng.uniform(0.7, 1.0), int(rng.choice([8, 12, 20]))
    ring_wall = prism(circle(0, 0, radius, sides), wall, [circle(0, 0, radius * 0.75, sides)])
    high = rng.uniform(1.6, 2.2)
    parts = [ring_wall, *(box(0.12, 0.12, high).at(x * radius * 0.9) for x in (-1, 1))]
    parts.append(_gable(radius * 2, radius * 2.2, rng.uniform(0.5, 0.9)).turned("z", 90).at(z=high))
    parts.append(cylinder(0.08, radius * 1.8, 8).turned("y", 90).at(-radius * 0.9, 0, high * 0.75))
    parts += [
        tube([[0, 0, high * 0.75], [0, 0, wall]], 0.015, 4),
        cylinder(0.15, 0.25, 10, top=0.2).at(z=wall - 0.1),
    ]
    return [*parts, around(box(0.2, 0.25, 0.15).at(radius), 8)]


KINDS: dict[str, Callable[[np.random.Generator], list[Part]]] = {
    "house": house,
    "church": church,
    "castle": castle,
    "skyscraper": skyscraper,
    "bridge": bridge,
    "windmill": windmill,
    "stairs": stairs,
    "fence": fence,
    "tent": tent,
    "door": door,
    "column": column,
    "well": well,
}
