# SPDX-License-Identifier: MIT
"""Vessels: bottles, cups, glasses, vases, pots, jugs, barrels, buckets."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.things.part import Part, ball, curve, cylinder, join, lathe, ring, tube
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["KINDS"]


def _sides(rng: np.random.Generator) -> int:
    return int(rng.choice([8, 12, 16, 24, 32]))


def _hollow(profile: FloatArray, wall: float) -> FloatArray:
    """Add an inner wall and a floor to an outer profile of (radius, z)."""
    inner = profile[::-1].copy()
    inner[:, 0] = np.maximum(inner[:, 0] - wall, wall / 4)
    inner[-1, 1] += wall
    inner[inner[:, 1] < profile[0, 1] + wall, 1] = profile[0, 1] + wall
    return np.concatenate([[(0.0, profile[0, 1])], profile, inner, [(0.0, profile[0, 1] + wall)]])


def _handle(rng: np.random.Generator, x: float, low: float, high: float) -> Part:
    reach, thick = rng.uniform(0.35, 0.7) * (high - low), rng.uniform(0.08, 0.13) * (high - low)
    path = curve(
        [
            [x, 0, low],
            [x + reach, 0, low * 0.7 + high * 0.3],
            [x + reach, 0, high * 0.8 + low * 0.2],
            [x, 0, high],
        ],
        12,
    )
    return tube(path, thick, int(rng.choice([5, 8])))


def bottle(rng: np.random.Generator) -> list[Part]:
    radius, neck = rng.uniform(0.12, 0.22), rng.uniform(0.035, 0.07)
    shoulder, length = rng.uniform(0.45, 0.7), rng.uniform(0.15, 0.3)
    points = [(radius * rng.uniform(0.85, 1), 0), (radius, 0.04), (radius, shoulder * 0.9)]
    points += [(neck, shoulder + 0.15), (neck, shoulder + 0.15 + length)]
    profile = curve(points, 18)
    parts = [lathe([(0, 0), *profile, (0, profile[-1, 1])], _sides(rng))]
    if rng.random() < 0.6:
        parts.append(cylinder(neck * 1.25, 0.06, 12).at(z=shoulder + 0.12 + length))
    return parts


def mug(rng: np.random.Generator) -> list[Part]:
    height, radius = rng.uniform(0.7, 1.1), rng.uniform(0.35, 0.48)
    profile = curve(
        [
            (radius * rng.uniform(0.7, 1), 0),
            (radius, height * 0.4),
            (radius * rng.uniform(0.95, 1.15), height),
        ],
        8,
    )
    return [
        lathe(_hollow(profile, 0.04), _sides(rng)),
        _handle(rng, radius * 0.95, height * 0.2, height * 0.8),
    ]


def teacup(rng: np.random.Generator) -> list[Part]:
    height, radius, sides = rng.uniform(0.35, 0.5), rng.uniform(0.42, 0.55), _sides(rng)
    profile = curve([(radius * 0.4, 0), (radius * 0.75, height * 0.3), (radius, height)], 8)
    parts = [lathe(_hollow(profile, 0.03), sides), _handle(rng, radius * 0.85, height * 0.35, height * 0.85)]
    parts.append(
        lathe([(0, 0), (0.35, 0), (0.8, 0.1), (0.78, 0.12), (0.35, 0.03), (0, 0.03)], sides).at(z=-0.03)
    )
    return parts


def wine_glass(rng: np.random.Generator) -> list[Part]:
    stem, bowl, radius = rng.uniform(0.4, 0.7), rng.uniform(0.4, 0.7), rng.uniform(0.2, 0.32)
    outer = curve(
        [(0.02, stem), (radius, stem + bowl * 0.45), (radius * rng.uniform(0.7, 1.2), stem + bowl)], 10
    )
    inner = outer[::-1] * np.array([0.93, 1.0])
    foot = [(0, 0), (rng.uniform(0.2, 0.28), 0), (0.15, 0.02), (0.02, 0.06)]
    return [lathe([*foot, *outer, *inner], _sides(rng))]


def vase(rng: np.random.Generator) -> list[Part]:
    height = rng.uniform(0.9, 1.4)
    points = [(rng.uniform(0.15, 0.25), 0), (rng.uniform(0.3, 0.45), height * rng.uniform(0.3, 0.55))]
    points += [(rng.uniform(0.1, 0.18), height * 0.8), (rng.uniform(0.18, 0.3), height)]
    parts = [lathe(_hollow(curve(points, 20), 0.03), _sides(rng))]
    if rng.random() < 0.25:
        grip = _handle(rng, 0.25, height * 0.5, height * 0.8)
        parts += [grip, grip.scaled(x=-1)]
    return parts


def bowl(rng: np.random.Generator) -> list[Part]:
    radius, height = rng.uniform(0.6, 0.9), rng.uniform(0.3, 0.5)
    profile = curve([(radius * rng.uniform(0.2, 0.5), 0), (radius * 0.8, height * 0.4), (radius, height)], 9)
    parts = [lathe(_hollow(profile, 0.04), _sides(rng))]
    if rng.random() < 0.4:
        parts.append(cylinder(radius * 0.35, 0.08, 16, top=radius * 0.3).at(z=-0.07))
    return parts


def cooking_pot(rng: np.random.Generator) -> list[Part]:
    radius, height, sides = rng.uniform(0.4, 0.6), rng.uniform(0.4, 0.75), _sides(rng)
    parts = [lathe(_hollow(np.array([(radius, 0.0), (radius, height)]), 0.03), sides)]
    grip = curve(
        [[radius, -0.15, height * 0.8], [radius + 0.15, 0, height * 0.8], [radius, 0.15, height * 0.8]], 8
    )
    parts += [tube(grip, 0.025, 6), tube(grip, 0.025, 6).scaled(x=-1)]
    if rng.random() < 0.6:
        lid = curve([(radius * 1.02, height), (radius * 0.6, height + 0.08), (0.0, height + 0.1)], 6)
        parts += [lathe(lid, sides), ball(0.06, 0.06, 0.05, 8).at(z=height + 0.15)]
    return parts


def frying_pan(rng: np.random.Generator) -> list[Part]:
    radius, height = rng.uniform(0.4, 0.55), rng.uniform(0.08, 0.16)
    pan = lathe(_hollow(np.array([(radius * 0.85, 0.0), (radius, height)]), 0.02), _sides(rng))
    length = rng.uniform(0.6, 0.9)
    path = curve(
        [
            [radius, 0, height * 0.8],
            [radius + length * 0.5, 0, height * 1.3],
            [radius + length, 0, height * 1.5],
        ],
        6,
    )
    return [pan, tube(path, rng.uniform(0.025, 0.05), 6)]


def teapot(rng: np.random.Generator) -> list[Part]:
    height, radius, sides = rng.uniform(0.6, 0.9), rng.uniform(0.4, 0.55), _sides(rng)
    profile = curve([(radius * 0.6, 0), (radius, height * 0.45), (radius * 0.5, height)], 12)
    parts = [lathe([(0, 0), *profile], sides)]
    lid = curve([(radius * 0.5, height), (radius * 0.3, height + 0.07), (0.0, height + 0.09)], 5)
    parts += [lathe(lid, sides), ball(0.06, 0.06, 0.06, 8).at(z=height + 0.12)]
    spout = curve(
        [
            [-radius * 0.85, 0, height * 0.3],
            [-radius * 1.4, 0, height * 0.5],
            [-radius * 1.7, 0, height * 0.95],
        ],
        9,
    )
    parts.append(tube(spout, np.linspace(0.13, 0.05, 9), 8))
    parts.append(_handle(rng, radius * 0.85, height * 0.2, height * 0.85))
    return parts


def jug(rng: np.random.Generator) -> list[Part]:
    height, radius = rng.uniform(0.9, 1.3), rng.uniform(0.3, 0.42)
    points = [
        (radius * 0.8, 0),
        (radius, height * 0.35),
        (radius * 0.6, height * 0.8),
        (radius * 0.75, height),
    ]
    body = lathe(_hollow(curve(points, 14), 0.03), _sides(rng))
    pull = np.clip((body.vertices[:, 2] / height - 0.8) / 0.2, 0, 1) * np.clip(-body.vertices[:, 0], 0, None)
    body.vertices[:, 0] -= pull * rng.uniform(0.4, 0.8)  # the lip
    return [body, _handle(rng, radius * 0.75, height * 0.3, height * 0.9)]


def barrel(rng: np.random.Generator) -> list[Part]:
    height, radius, bulge = rng.uniform(0.9, 1.3), rng.uniform(0.32, 0.42), rng.uniform(1.1, 1.3)
    profile = curve([(radius, 0), (radius * bulge, height / 2), (radius, height)], 9)
    sides = _sides(rng)
    parts = [
        lathe(
            [(0, 0.04), (radius * 0.95, 0.04), *profile, (radius * 0.95, height - 0.04), (0, height - 0.04)],
            sides,
        )
    ]
    for share in (0.12, 0.33, 0.67, 0.88):
        here = radius * (1 + (bulge - 1) * (1 - (2 * share - 1) ** 2))
        parts.append(
            lathe([(here, -0.03), (here + 0.02, -0.03), (here + 0.02, 0.03), (here, 0.03)], sides).at(
                z=share * height
            )
        )
    return parts


def bucket(rng: np.random.Generator) -> list[Part]:
    height, radius, sides = rng.uniform(0.6, 0.9), rng.uniform(0.35, 0.45), _sides(rng)
    low = radius * rng.uniform(0.65, 0.85)
    parts = [
        lathe(_hollow(np.array([(low, 0.0), (radius, height)]), 0.02), sides),
        ring(radius, 0.02, sides, 6).at(z=height),
    ]
    angle = np.linspace(0, np.pi, 14)
    bow = np.stack([np.cos(angle), 0 * angle, np.sin(angle)], 1) * radius * 1.03
    parts.append(join([tube(bow, 0.012, 6)]).turned("x", rng.uniform(-70, 70)).at(z=height))
    return parts


KINDS: dict[str, Callable[[np.random.Generator], list[Part]]] = {
    "bottle": bottle,
    "mug": mug,
    "teacup": teacup,
    "wine glass": wine_glass,
    "vase": vase,
    "bowl": bowl,
    "cooking pot": cooking_pot,
    "frying pan": frying_pan,
    "teapot": teapot,
    "jug": jug,
    "barrel": barrel,
    "bucket": bucket,
}
