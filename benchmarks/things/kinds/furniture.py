# SPDX-License-Identifier: MIT
"""Furniture: tables, desks, beds, shelves, cupboards, lamps."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.things.part import Part, around, ball, box, curve, cylinder, join, lathe, tube

__all__ = ["KINDS"]


def table(rng: np.random.Generator) -> list[Part]:
    width, depth, height = rng.uniform(0.9, 2.0), rng.uniform(0.7, 1.0), rng.uniform(0.65, 0.8)
    thickness = rng.uniform(0.02, 0.06)
    leg = rng.uniform(0.04, 0.1)
    parts = [box(width, depth, thickness).at(z=height)]
    if rng.random() < 0.25:  # trestles
        trestle = join(
            [box(leg, depth * 0.8, leg), box(leg, leg, height), box(leg, depth * 0.8, leg).at(z=height - leg)]
        )
        parts += [trestle.at(x * width * 0.35) for x in (-1, 1)]
        parts.append(box(width * 0.7, leg / 2, leg).at(z=height * 0.4))
        return parts
    taper, sides = rng.uniform(0.5, 1), int(rng.choice([4, 4, 12]))
    for x in (-1, 1):
        for y in (-1, 1):
            post = cylinder(leg * taper * 0.7, height, sides, top=leg * 0.7).turned("z", 45)
            parts.append(post.at(x * (width / 2 - leg), y * (depth / 2 - leg)))
    if rng.random() < 0.6:
        parts.append(box(width - 2 * leg, depth - 2 * leg, 0.08).at(z=height - 0.08))
    return parts


def round_table(rng: np.random.Generator) -> list[Part]:
    radius, height, sides = rng.uniform(0.4, 0.7), rng.uniform(0.6, 0.8), int(rng.choice([12, 24, 32]))
    parts = [cylinder(radius, rng.uniform(0.02, 0.05), sides).at(z=height)]
    column = curve([(0.05, 0), (rng.uniform(0.04, 0.12), 0.3), (0.04, 0.6), (0.08, 1)], 9)
    parts.append(lathe(column * np.array([1, height]), max(6, sides // 2)))
    if rng.random() < 0.5:
        parts.append(lathe([(0, 0), (radius * 0.6, 0), (radius * 0.55, 0.03), (0.05, 0.08)], sides))
    else:
        foot = tube(curve([[0, 0, 0.25], [radius * 0.4, 0, 0.12], [radius * 0.65, 0, 0.0]], 6), 0.025, 6)
        parts.append(around(foot, int(rng.integers(3, 5))))
    return parts


def desk(rng: np.random.Generator) -> list[Part]:
    width, depth, height = rng.uniform(1.1, 1.7), rng.uniform(0.55, 0.8), rng.uniform(0.68, 0.78)
    chest = rng.uniform(0.3, 0.45)
    parts = [box(width, depth, 0.04).at(z=height)]
    sides = (-1, 1) if rng.random() < 0.5 else (1,)
    drawers = int(rng.integers(2, 5))
    for x in sides:
        parts.append(box(chest, depth * 0.9, height).at(x * (width - chest) / 2))
        drawer = box(chest * 0.9, 0.03, height / drawers * 0.85)
        knob = box(chest * 0.3, 0.04, 0.02).at(z=height / drawers * 0.4)
        for number in range(drawers):
            place = (x * (width - chest) / 2, -depth * 0.46, height * (number + 0.05) / drawers)
            parts.append(join([drawer, knob.at(y=-0.02)]).at(*place))
    if len(sides) == 1:
        parts.append(box(0.04, depth * 0.9, height).at(-width / 2 + 0.03))
    parts.append(box(width * 0.95, 0.02, height * rng.uniform(0.3, 0.8)).at(y=depth * 0.4, z=height * 0.2))
    return parts


def bed(rng: np.random.Generator) -> list[Part]:
    width, length, height = rng.uniform(0.9, 1.9), rng.uniform(1.9, 2.2), rng.uniform(0.25, 0.45)
    head, foot = rng.uniform(0.6, 1.2), rng.choice([0.0, rng.uniform(0.4, 0.7)])
    parts = [box(width, length, 0.12).at(z=height - 0.12)]
    parts.append(box(width * 0.97, length * 0.97, rng.uniform(0.12, 0.25), top=0.97).at(z=height))
    parts.append(box(width * 1.03, 0.07, head, top=(rng.uniform(0.8, 1), 1)).at(y=length / 2))
    if foot:
        parts.append(box(width * 1.03, 0.07, foot).at(y=-length / 2))
    parts += [
        box(0.08, 0.08, height).at(x * (width / 2 - 0.05), y * (length / 2 - 0.05))
        for x in (-1, 1)
        for y in (-1, 1)
    ]
    pillows = 2 if width > 1.3 else 1
    pillow = ball(width / pillows * 0.4, 0.2, 0.08, 12)
    shift = (np.arange(pillows) - (pillows - 1) / 2) * width / pillows
    parts += [pillow.at(x, length * 0.36, height + 0.25) for x in shift]
    if rng.random() < 0.2:
        parts.append(box(width, length * 0.6, 0.06, top=0.95).at(y=-length * 0.18, z=height + 0.22))
    return parts


def shelf(rng: np.random.Generator) -> list[Part]:
    width, depth, height = rng.uniform(0.6, 1.3), rng.uniform(0.22, 0.38), rng.uniform(1.2, 2.1)
    rows, board = int(rng.integers(3, 7)), rng.uniform(0.015, 0.035)
    parts = [box(board, depth, height).at(x * width / 2) for x in (-1, 1)]
    levels = np.linspace(0.02, height - board, rows + 1)
    parts += [box(width, depth, board).at(z=z) for z in levels]
    if rng.random() < 0.6:
        parts.append(box(width, 0.01, height).at(y=depth / 2))
    if rng.random() < 0.5:
        for z in levels[:-1]:
            x = -width / 2 + 0.03
            while x < width / 2 * rng.uniform(0.2, 1):
                book = box(rng.uniform(0.02, 0.06), depth * 0.7, height / rows * rng.uniform(0.5, 0.85))
                parts.append(book.at(x, z=z + board))
                x += 0.07
    return parts


def cupboard(rng: np.random.Generator) -> list[Part]:
    width, depth, height = rng.uniform(0.8, 1.5), rng.uniform(0.4, 0.6), rng.uniform(1.2, 2.1)
    base = rng.uniform(0, 0.15)
    parts = [box(width, depth, height - base).at(z=base)]
    doors = int(rng.integers(2, 4))
    low = rng.choice([0.02, 0.3])
    for number in range(doors):
        x = (number - (doors - 1) / 2) * width / doors
        door = box(width / doors * 0.94, 0.03, (height - base) * (0.96 - low))
        knob = ball(0.025, 0.025, 0.025, 8).at(width / doors * 0.38, -0.04, height * 0.35)
        parts.append(join([door, knob]).at(x, -depth / 2, base + height * low))
        if low > 0.1:
            parts.append(
                box(width / doors * 0.94, 0.03, height * 0.2).at(x, -depth / 2, base + height * 0.04)
            )
    if rng.random() < 0.6:
        parts.append(box(width * 1.08, depth * 1.08, 0.05, top=rng.uniform(0.9, 1.1)).at(z=height))
    if base > 0.04:
        parts += [
            box(0.07, 0.07, base).at(x * (width / 2 - 0.06), y * (depth / 2 - 0.06))
            for x in (-1, 1)
            for y in (-1, 1)
        ]
    return parts


def floor_lamp(rng: np.random.Generator) -> list[Part]:
    height, sides = rng.uniform(1.2, 1.8), int(rng.choice([8, 16, 24]))
    radius, shade = rng.uniform(0.15, 0.3), rng.uniform(0.2, 0.4)
    parts = [cylinder(rng.uniform(0.12, 0.2), 0.03, sides, top=0.1)]
    if rng.random() < 0.3:
        leg = tube([[0.25, 0, 0], [0, 0, height * 0.6]], 0.015, 6)
        parts = [around(leg, 3)]
    parts.append(cylinder(0.015, height, 8))
    parts.append(
        lathe([(radius, 0), (radius * rng.uniform(0.3, 1.0), shade)], sides).at(z=height - shade * 0.7)
    )
    return parts


def table_lamp(rng: np.random.Generator) -> list[Part]:
    sides = int(rng.choice([8, 16, 24]))
    body = curve([(0.1, 0), (rng.uniform(0.05, 0.18), 0.12), (rng.uniform(0.03, 0.08), 0.3), (0.02, 0.4)], 12)
    radius, shade = rng.uniform(0.18, 0.28), rng.uniform(0.18, 0.3)
    parts = [lathe([(0, 0), *body], sides), cylinder(0.012, 0.5, 8)]
    parts.append(lathe([(radius, 0), (radius * rng.uniform(0.3, 0.8), shade)], sides).at(z=0.38))
    return parts


def desk_lamp(rng: np.random.Generator) -> list[Part]:
    sides = int(rng.choice([8, 16, 24]))
    reach, rise = rng.uniform(0.1, 0.3), rng.uniform(0.3, 0.45)
    elbow = np.array([0, reach, rise])
    tip = elbow + np.array([0, -rng.uniform(0.3, 0.45), rng.uniform(0.0, 0.2)])
    shade = lathe([(0.02, 0.12), (0.04, 0.12), (rng.uniform(0.08, 0.13), 0)], sides).turned(
        "x", rng.uniform(-40, 10)
    )
    parts = [cylinder(rng.uniform(0.09, 0.14), 0.03, sides), tube([[0, 0, 0.02], elbow], 0.012, 6)]
    parts += [
        tube([elbow, tip], 0.012, 6),
        shade.at(*(tip - np.array([0, 0, 0.1]))),
        ball(0.02, 0.02, 0.02, 8).at(*elbow),
    ]
    return parts


KINDS: dict[str, Callable[[np.random.Generator], list[Part]]] = {
    "table": table,
    "round table": round_table,
    "desk": desk,
    "bed": bed,
    "shelf": shelf,
    "cupboard": cupboard,
    "floor lamp": floor_lamp,
    "table lamp": table_lamp,
    "desk lamp": desk_lamp,
}
