# SPDX-License-Identifier: MIT
"""Seats: chairs, armchairs, sofas, benches, stools, office chairs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.things.part import Part, around, ball, box, curve, cylinder, join, sheet, tube

__all__ = ["KINDS"]


def _legs(rng: np.random.Generator, width: float, depth: float, height: float) -> Part:
    """Build four legs, straight or splayed, square or round."""
    thickness, splay = rng.uniform(0.02, 0.04), rng.choice([0.0, rng.uniform(0.0, 0.08)])
    round_ones = rng.random() < 0.5
    legs = []
    for x in (-1, 1):
        for y in (-1, 1):
            top = np.array([x * (width / 2 - thickness), y * (depth / 2 - thickness), height])
            foot = top + np.array([x * splay, y * splay, -height])
            sides = int(rng.choice([6, 12])) if round_ones else 4
            legs.append(tube([foot, top], [thickness * rng.uniform(0.5, 1), thickness], sides))
    return join(legs)


def _back(rng: np.random.Generator, width: float, height: float) -> Part:
    """Build a back that stands on z = 0: a board, slats, spindles or a frame."""
    thickness = rng.uniform(0.015, 0.04)
    style = rng.integers(4)
    if style == 0:
        return box(width, thickness, height, top=(rng.uniform(0.7, 1.05), 1))
    posts = [box(thickness, thickness, height).at(x * (width - thickness) / 2) for x in (-1, 1)]
    count = int(rng.integers(2, 6))
    if style == 1:
        slat = box(width, thickness / 2, height * 0.5 / count)
        parts = [slat.at(z=height * (0.25 + 0.7 * number / count)) for number in range(count)]
    elif style == 2:
        spindle = cylinder(thickness / 3, height, 6)
        places = np.linspace(-0.4, 0.4, count + 2) * width
        parts = [spindle.at(x) for x in places] + [box(width, thickness, height * 0.12).at(z=height * 0.9)]
    else:
        parts = [box(width, thickness / 2, height * 0.55).at(z=height * 0.4)]
    return join(posts + parts)


def chair(rng: np.random.Generator) -> list[Part]:
    width, depth, height = rng.uniform(0.38, 0.52), rng.uniform(0.36, 0.5), rng.uniform(0.4, 0.5)
    seat = box(width, depth, rng.uniform(0.02, 0.07), top=rng.uniform(0.92, 1.0)).at(z=height)
    back = _back(rng, width, rng.uniform(0.35, 0.6)).turned("x", -rng.uniform(0, 15))
    parts = [seat, _legs(rng, width, depth, height), back.at(y=depth / 2 - 0.02, z=height + 0.02)]
    if rng.random() < 0.3:
        rail = box(0.02, depth * 0.9, 0.02)
        parts += [rail.at(x * (width / 2 - 0.03), z=height * 0.4) for x in (-1, 1)]
    return parts


def office_chair(rng: np.random.Generator) -> list[Part]:
    width, height, sides = rng.uniform(0.42, 0.55), rng.uniform(0.4, 0.52), int(rng.choice([8, 16]))
    foot = tube([[0, 0, 0.08], [0.3, 0, 0.05]], [0.03, 0.02], 6)
    parts = [around(join([foot, ball(0.03, 0.03, 0.03, 8).at(0.3, z=0.03)]), int(rng.integers(4, 7)))]
    parts.append(cylinder(0.03, height, sides))
    parts.append(box(width, width * rng.uniform(0.85, 1), rng.uniform(0.05, 0.1), top=0.9).at(z=height))
    back_height = rng.uniform(0.35, 0.7)
    rows = np.linspace(0, 1, 6)
    across = np.linspace(-1, 1, 6)
    bend = rng.uniform(0.02, 0.1)
    grid = [[[x * width * 0.45, -bend * x * x + 0.08 * z, z * back_height] for x in across] for z in rows]
    back = join([sheet(grid), sheet(grid).at(y=0.05)])
    parts.append(back.at(y=width / 2 - 0.03, z=height + rng.uniform(0.08, 0.2)))
    parts.append(
        tube([[0, 0.1, height], [0, width / 2 + 0.05, height], [0, width / 2 + 0.05, height + 0.4]], 0.02)
    )
    if rng.random() < 0.6:
        arm = join([box(0.04, 0.25, 0.03).at(z=0.22), box(0.03, 0.03, 0.24)])
        parts += [arm.at(x * (width / 2 + 0.03), z=height) for x in (-1, 1)]
    return parts


def sofa(rng: np.random.Generator) -> list[Part]:
    seats = int(rng.integers(2, 4))
    width, depth = 0.65 * seats * rng.uniform(0.9, 1.1), rng.uniform(0.75, 0.95)
    low, high = rng.uniform(0.36, 0.48), rng.uniform(0.7, 0.95)
    arm_width, arm_height = rng.uniform(0.1, 0.25), rng.uniform(0.5, 0.7)
    base = rng.uniform(0.0, 0.12)
    parts = [box(width, depth, low * 0.6).at(z=base)]
    parts.append(
        box(width, depth * 0.25, high - base, top=(1, rng.uniform(0.5, 1))).at(y=depth * 0.38, z=base)
    )
    for x in (-1, 1):
        place = x * (width + arm_width) / 2
        parts.append(box(arm_width, depth, arm_height - base).at(place, z=base))
        if rng.random() < 0.4:
            roll = cylinder(arm_width * 0.6, depth, 12).turned("x", 90)
            parts.append(roll.at(place, depth / 2, arm_height))
    cushion = box(width / seats * 0.96, depth * 0.7, low * 0.4, top=0.93)
    shift = (np.arange(seats) - (seats - 1) / 2) * width / seats
    parts += [cushion.at(x, -depth * 0.1, base + low * 0.6) for x in shift]
    if base > 0.04:
        parts.append(_legs(rng, width, depth, base))
    return parts


def armchair(rng: np.random.Generator) -> list[Part]:
    width, depth, low = rng.uniform(0.5, 0.7), rng.uniform(0.6, 0.8), rng.uniform(0.35, 0.45)
    base = rng.uniform(0.05, 0.2)
    high = rng.uniform(0.75, 1.1)
    parts = [box(width, depth, low - base, top=rng.uniform(0.93, 1)).at(z=base)]
    back = box(width * rng.uniform(1, 1.25), 0.16, high - base, top=(rng.uniform(0.75, 1), 0.8))
    parts.append(back.turned("x", -rng.uniform(3, 15)).at(y=depth / 2 - 0.05, z=base))
    arm = box(0.13, depth * 0.85, rng.uniform(0.5, 0.62) - base, top=(rng.uniform(0.8, 1.3), 1))
    parts += [arm.at(x * (width / 2 + 0.06), z=base) for x in (-1, 1)]
    parts.append(_legs(rng, width, depth, base))
    return parts


def stool(rng: np.random.Generator) -> list[Part]:
    radius, height, sides = rng.uniform(0.15, 0.22), rng.uniform(0.4, 0.8), int(rng.choice([8, 16, 24]))
    parts = [cylinder(radius, rng.uniform(0.02, 0.08), sides).at(z=height)]
    if rng.random() < 0.3:
        parts += [cylinder(0.025, height, 8), cylinder(radius * 1.1, 0.03, sides, top=0.05)]
        return parts
    count, splay = int(rng.integers(3, 5)), rng.uniform(1.0, 1.5)
    leg = tube([[radius * 0.8 * splay, 0, 0], [radius * 0.75, 0, height]], rng.uniform(0.012, 0.025), 6)
    parts.append(around(leg, count, 45))
    if rng.random() < 0.6:
        angle = np.linspace(0, 2 * np.pi, 17)
        circle = np.stack([np.cos(angle), np.sin(angle), 0 * angle], 1) * radius * 0.95
        parts.append(tube(circle, 0.01, 6).at(z=height * rng.uniform(0.25, 0.5)))
    return parts


def bench(rng: np.random.Generator) -> list[Part]:
    width, depth, height = rng.uniform(1.1, 1.9), rng.uniform(0.35, 0.5), rng.uniform(0.4, 0.48)
    slats = int(rng.integers(2, 6))
    slat = box(width, depth / slats * 0.8, 0.03)
    rows = (np.arange(slats) - (slats - 1) / 2) * depth / slats
    parts = [slat.at(y=y, z=height) for y in rows]
    back = [slat.turned("x", 80).at(y=depth / 2 + 0.03 * n, z=height + 0.12 * n) for n in range(1, slats + 1)]
    parts += back[: int(rng.integers(2, 5))]
    for x in (-1, 1):
        frame = [box(0.05, depth, 0.05).at(z=height - 0.05)]
        frame += [box(0.05, 0.05, height).at(y=y * (depth / 2 - 0.03)) for y in (-1, 1)]
        path = curve([[0, depth / 2, height], [0, depth / 2 + 0.15, height + 0.5]], 4)
        frame.append(tube(path, 0.025, 5))
        if rng.random() < 0.5:
            frame.append(box(0.06, depth, 0.04).at(z=height + 0.22))
        parts.append(join(frame).at(x * width * 0.42))
    return parts


KINDS: dict[str, Callable[[np.random.Generator], list[Part]]] = {
    "chair": chair,
    "office chair": office_chair,
    "sofa": sofa,
    "armchair": armchair,
    "stool": stool,
    "bench": bench,
}
