# SPDX-License-Identifier: MIT
"""Things that hold something: turned on a lathe, with handles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from benchmarks.objects.parts import (
    Maker,
    Part,
    Parts,
    Random,
    around,
    ball,
    box,
    moved,
    rod,
    tube,
    turned,
    turned_about,
)

__all__ = ["KINDS"]


def _smooth(profile: list[list[float]], steps: int = 4) -> NDArray[np.float64]:
    """Refine a profile between its points by a monotone curve."""
    from scipy.interpolate import PchipInterpolator

    points = np.array(profile, float)
    at = np.arange(len(points))
    fine = np.linspace(0, len(points) - 1, steps * (len(points) - 1) + 1)
    return np.asarray(PchipInterpolator(at, points)(fine))


def _hollow(outside: NDArray[np.float64], wall: float) -> NDArray[np.float64]:
    """Add the inside of a vessel, from the rim down to the axis."""
    inside = outside[1:][::-1].copy()
    inside[:, 0] = np.maximum(inside[:, 0] - wall, 0)
    inside[:, 1] = np.maximum(inside[:, 1], outside[0, 1] + wall)
    return np.concatenate([outside, inside, [[0, outside[0, 1] + wall]]])


def _handle(radius: float, low: float, high: float, reach: float, thick: float) -> Part:
    angle = np.linspace(-np.pi / 2, np.pi / 2, 10)
    path = np.stack(
        [radius + reach * np.cos(angle), 0 * angle, (low + high) / 2 + (high - low) / 2 * np.sin(angle)],
        axis=1,
    )
    return tube(path, thick)


def bottle(random: Random) -> Parts:
    """Make a bottle with a neck, perhaps with a stopper."""
    body, neck, wide = random.uniform(0.6, 1.6), random.uniform(0.3, 0.8), random.uniform(0.3, 0.5)
    throat = wide * random.uniform(0.25, 0.45)
    profile = [
        [0, 0],
        [wide * 0.95, 0],
        [wide, 0.1],
        [wide, body],
        [throat, body + 0.3],
        [throat, body + 0.3 + neck],
    ]
    parts = [turned(np.concatenate([profile, [[0, body + 0.3 + neck]]]))]
    if random.random() < 0.5:
        parts.append(rod((0, 0, body + 0.3 + neck), (0, 0, body + 0.45 + neck), throat * 1.1))
    return parts


def flask(random: Random) -> Parts:
    """Make a round flask with a narrow neck."""
    neck, throat = random.uniform(0.4, 0.9), random.uniform(0.1, 0.2)
    parts = [ball(0.5, (0, 0, 0.5), (1, 1, random.uniform(0.8, 1.1)), 3)]
    parts.append(
        turned([[0, 0.8], [throat, 0.8], [throat, 1 + neck], [1.4 * throat, 1.05 + neck], [0, 1.05 + neck]])
    )
    if random.random() < 0.5:
        parts.append(rod((0, 0, 1 + neck), (0, 0, 1.2 + neck), 0.9 * throat))
    return parts


def vase(random: Random) -> Parts:
    """Make an open vase."""
    height = random.uniform(1.2, 2.2)
    radii = [
        random.uniform(0.25, 0.4),
        random.uniform(0.45, 0.7),
        random.uniform(0.15, 0.3),
        random.uniform(0.3, 0.5),
    ]
    outside = _smooth([[0, 0], *([r, height * k / 3] for k, r in enumerate(radii))])
    return [turned(_hollow(outside, 0.04))]


def bowl(random: Random) -> Parts:
    """Make an open bowl."""
    angle = np.linspace(0, np.pi / 2, 10)
    deep = random.uniform(0.3, 0.8)
    outside = np.stack([np.sin(angle), deep * (1 - np.cos(angle))], axis=1)
    return [turned(_hollow(outside, random.uniform(0.04, 0.09)), 28)]


def mug(random: Random) -> Parts:
    """Make a mug with a handle."""
    height, radius = random.uniform(0.8, 1.4), 0.45
    outside = np.array([[0, 0], [radius * random.uniform(0.8, 1.05), 0], [radius, height]])
    return [
        turned(_hollow(outside, 0.05), 24),
        _handle(
            radius - 0.02, 0.2 * height, 0.8 * height, random.uniform(0.2, 0.35), random.uniform(0.035, 0.06)
        ),
    ]


def goblet(random: Random) -> Parts:
    """Make a cup on a stem."""
    stem, wide, deep = random.uniform(0.4, 0.9), random.uniform(0.3, 0.5), random.uniform(0.4, 0.8)
    foot = random.uniform(0.25, 0.4)
    outside = _smooth(
        [
            [0, 0],
            [foot, 0],
            [foot, 0.04],
            [0.05, 0.1],
            [0.05, stem],
            [wide, stem + 0.5 * deep],
            [wide * 0.95, stem + deep],
        ]
    )
    inside = [[wide * 0.9, stem + deep], [wide * 0.9, stem + 0.55 * deep], [0, stem + 0.15]]
    return [turned(np.concatenate([outside, inside]))]


def jug(random: Random) -> Parts:
    """Make a jug or amphora with one or two handles."""
    height, belly, throat = random.uniform(1.2, 1.9), random.uniform(0.4, 0.6), random.uniform(0.14, 0.22)
    outside = _smooth(
        [[0, 0], [0.25, 0], [belly, 0.45 * height], [throat, 0.8 * height], [1.4 * throat, height]]
    )
    handle = _handle(throat, 0.5 * height, 0.92 * height, random.uniform(0.3, 0.45), 0.05)
    return [turned(_hollow(outside, 0.04)), *around(handle, int(random.choice([1, 2])))]


def teapot(random: Random) -> Parts:
    """Make a teapot with lid, spout and handle."""
    flat = random.uniform(0.7, 1)
    spout = tube([[0.4, 0, 0.35], [0.65, 0, 0.45], [0.8, 0, 0.7], [0.9, 0, 0.85]], [0.13, 0.1, 0.07, 0.05])
    handle = turned_about(_handle(0.42, 0.25, 0.75, random.uniform(0.25, 0.4), 0.05), 2, 180)
    return [
        ball(0.5, (0, 0, 0.5 * flat), (1, 1, flat), 3),
        spout,
        handle,
        ball(0.08, (0, 0, flat + 0.04)),
        rod((0, 0, flat - 0.12), (0, 0, flat), 0.28, 0.2),
    ]


def barrel(random: Random) -> Parts:
    """Make a barrel with hoops."""
    height, bulge = random.uniform(0.9, 1.5), random.uniform(0.06, 0.16)
    z = np.linspace(0, 1, 9)
    radius = 0.45 + bulge * np.sin(np.pi * z)
    wall = np.stack([radius, height * z], axis=1)
    parts = [turned(np.concatenate([[[0, 0]], wall, [[0, height]]]), 18)]
    for at in ([0.15, 0.85], [0.1, 0.35, 0.65, 0.9])[int(random.integers(2))]:
        size = 0.465 + bulge * np.sin(np.pi * at)
        parts.append(
            turned(
                [
                    [size - 0.03, -0.03],
                    [size, -0.03],
                    [size, 0.03],
                    [size - 0.03, 0.03],
                    [size - 0.03, -0.03],
                ],
                18,
                (0, 0, at * height),
            )
        )
    return parts


def bucket(random: Random) -> Parts:
    """Make a bucket with a bail."""
    height, low = random.uniform(0.7, 1.1), random.uniform(0.3, 0.42)
    angle = np.linspace(0, np.pi, 14)
    rise = random.uniform(0.3, 0.6)
    bail = np.stack([0.5 * np.cos(angle), 0 * angle, height + rise * np.sin(angle)], axis=1)
    return [turned(_hollow(np.array([[0, 0], [low, 0], [0.5, height]]), 0.04)), tube(bail, 0.025)]


def chest(random: Random) -> Parts:
    """Make a chest with a round lid and fittings."""
    wide, deep, high = random.uniform(0.9, 1.5), random.uniform(0.5, 0.8), random.uniform(0.35, 0.6)
    lid = turned_about(rod((0, 0, -wide / 2), (0, 0, wide / 2), deep / 2, sides=20), 1, 90)
    lid = moved(lid, (0, 0, high), (1, 1, random.uniform(0.5, 1)))
    bands = [box((0.08, deep * 1.06, high * 1.02), (at * wide, 0, 0)) for at in (-0.35, 0.35)]
    return [box((wide, deep, high)), lid, *bands, box((0.12, 0.08, 0.18), (0, -deep / 2, high - 0.1))]


def crate(random: Random) -> Parts:
    """Make a wooden crate with a frame."""
    size = random.uniform(0.7, 1.3, 3)
    x, y, z = size / 2
    parts = [box(size * 0.94, (0, 0, 0.03 * size[2]))]
    edge = random.uniform(0.08, 0.14)
    for a in (-1, 1):
        for b in (-1, 1):
            parts += [
                box((edge, edge, 2 * z), (a * x, b * y, 0)),
                box((2 * x, edge, edge), (0, a * y, z + b * z - edge / 2)),
                box((edge, 2 * y, edge), (a * x, 0, z + b * z - edge / 2)),
            ]
    return parts


KINDS: dict[str, Maker] = {
    "bottle": bottle,
    "flask": flask,
    "vase": vase,
    "bowl": bowl,
    "mug": mug,
    "goblet": goblet,
    "jug": jug,
    "teapot": teapot,
    "barrel": barrel,
    "bucket": bucket,
    "chest": chest,
    "crate": crate,
}
