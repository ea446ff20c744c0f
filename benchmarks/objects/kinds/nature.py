# SPDX-License-Identifier: MIT
"""Plants and stones."""

from __future__ import annotations

import numpy as np

from benchmarks.objects.parts import (
    Maker,
    Parts,
    Random,
    around,
    ball,
    lump,
    moved,
    rod,
    tube,
    turned,
    turned_about,
)

__all__ = ["KINDS"]


def rock(random: Random) -> Parts:
    """Make a rock, with a few broken sides."""
    return [lump(random, random.uniform(0.08, 0.25), sharp=int(random.integers(4, 14)))]


def pebble(random: Random) -> Parts:
    """Make a smooth pebble."""
    return [lump(random, random.uniform(0.03, 0.1), waves=6)]


def rocks(random: Random) -> Parts:
    """Make a heap of rocks."""
    return [
        moved(
            lump(random, 0.15, 2, sharp=6), random.normal(size=3) * [0.9, 0.9, 0.2], random.uniform(0.3, 0.8)
        )
        for _ in range(int(random.integers(3, 7)))
    ]


def crystals(random: Random) -> Parts:
    """Make a cluster of crystals."""
    parts = []
    for _ in range(int(random.integers(4, 9))):
        way = random.normal(size=3) * [0.6, 0.6, 0.2] + [0, 0, 1]
        way *= random.uniform(0.6, 1.6) / np.linalg.norm(way)
        thick, root = random.uniform(0.08, 0.2), random.normal(size=3) * [0.25, 0.25, 0]
        parts += [
            rod(root, root + 0.75 * way, thick, 0.9 * thick, sides=6),
            rod(root + 0.75 * way, root + way, 0.9 * thick, 0, sides=6),
        ]
    return parts


def conifer(random: Random) -> Parts:
    """Make a fir with layers of branches."""
    layers, wide, high = int(random.integers(3, 6)), random.uniform(0.6, 1), random.uniform(1.6, 2.6)
    parts = [rod((0, 0, 0), (0, 0, 0.5), 0.1)]
    for k in range(layers):
        low, size = 0.35 + k * high / layers, wide * (1 - 0.75 * k / layers)
        parts.append(
            rod((0, 0, low), (0, 0, low + 1.5 * high / layers), size, 0, sides=int(random.choice([8, 12])))
        )
    return parts


def tree(random: Random) -> Parts:
    """Make a broad-leaved tree with lumps of leaves."""
    high = random.uniform(0.9, 1.7)
    parts = [rod((0, 0, 0), (0, 0, high), 0.14, 0.08)]
    for _ in range(int(random.integers(3, 7))):
        way = random.normal(size=3) * [0.45, 0.45, 0.3] + [0, 0, high + 0.4]
        parts += [
            rod((0, 0, high * 0.8), way, 0.06, 0.03, sides=8),
            moved(lump(random, 0.12, 2), way, random.uniform(0.35, 0.6)),
        ]
    return parts


def palm(random: Random) -> Parts:
    """Make a palm with a bent trunk."""
    high, lean = random.uniform(1.8, 2.8), random.uniform(0, 0.6)
    z = np.linspace(0, 1, 9)
    trunk = tube(np.stack([lean * z**2, 0 * z, high * z], axis=1), np.linspace(0.13, 0.08, 9))
    s = np.linspace(0, 1, 7)
    drop, long = random.uniform(0.5, 0.9), random.uniform(0.8, 1.2)
    leaf = tube(
        np.stack([long * s, 0 * s, 0.35 * s - drop * s**2], axis=1), 0.015 + 0.09 * np.sin(np.pi * s), 6
    )
    leaf = leaf[0] * [1, 1, 0.8], leaf[1]
    return [trunk, *[moved(one, (lean, 0, high)) for one in around(leaf, int(random.integers(6, 10)))]]


def bare_tree(random: Random) -> Parts:
    """Make a tree without leaves."""
    parts: Parts = []

    def grow(start: np.ndarray, way: np.ndarray, thick: float, depth: int) -> None:
        end = start + way
        parts.append(rod(start, end, thick, 0.65 * thick, sides=8))
        if depth:
            for _ in range(int(random.integers(2, 4))):
                turn = random.normal(size=3) * 0.55 * np.linalg.norm(way)
                grow(end, 0.7 * way + turn + [0, 0, 0.1], 0.6 * thick, depth - 1)

    grow(np.zeros(3), np.array([0, 0, random.uniform(0.8, 1.2)]), 0.13, 3)
    return parts


def mushroom(random: Random) -> Parts:
    """Make a mushroom."""
    high, wide, angle = random.uniform(0.4, 1), random.uniform(0.35, 0.6), np.linspace(0, np.pi / 2, 8)
    dome = np.stack([wide * np.cos(angle), high + random.uniform(0.2, 0.5) * np.sin(angle)], axis=1)
    return [
        turned([[0, 0], [0.16, 0], [0.11, 0.5 * high], [0.1, high], [0, high]]),
        turned(np.concatenate([[[0, high]], dome]), 24),
    ]


def cactus(random: Random) -> Parts:
    """Make a cactus with arms."""
    high = random.uniform(1.2, 2)
    parts = [rod((0, 0, 0), (0, 0, high), 0.2, 0.17), ball(0.17, (0, 0, high))]
    for _ in range(int(random.integers(1, 4))):
        low, reach = random.uniform(0.3, 0.65) * high, random.uniform(0.35, 0.5)
        arm = tube(
            [
                [0, 0, low],
                [0.7 * reach, 0, low],
                [reach, 0, low + 0.12],
                [reach, 0, low + random.uniform(0.35, 0.6)],
            ],
            [0.1, 0.1, 0.1, 0.08],
        )
        parts.append(turned_about(arm, 2, random.uniform(0, 360)))
    return parts


def flower(random: Random) -> Parts:
    """Make a flower with petals."""
    high, count, long = random.uniform(0.9, 1.5), int(random.integers(5, 11)), random.uniform(0.25, 0.45)
    petal = ball(long / 2, (long / 2 + 0.08, 0, high), (1, 0.45, 0.12), 1)
    leaf = ball(0.2, (0.2, 0, 0.3 * high), (1, 0.4, 0.1), 1)
    return [
        rod((0, 0, 0), (0, 0, high), 0.025),
        ball(0.11, (0, 0, high)),
        *around(petal, count),
        *around(leaf, 2, 40),
    ]


KINDS: dict[str, Maker] = {
    "rock": rock,
    "pebble": pebble,
    "heap of rocks": rocks,
    "crystals": crystals,
    "conifer": conifer,
    "tree": tree,
    "palm": palm,
    "bare tree": bare_tree,
    "mushroom": mushroom,
    "cactus": cactus,
    "flower": flower,
}
