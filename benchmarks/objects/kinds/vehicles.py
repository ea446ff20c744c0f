# SPDX-License-Identifier: MIT
"""Vehicles on land, on water and in the air."""

from __future__ import annotations

import numpy as np

from benchmarks.objects.parts import (
    Maker,
    Part,
    Parts,
    Random,
    around,
    ball,
    box,
    extruded,
    moved,
    rod,
    tube,
    turned,
    turned_about,
)

__all__ = ["KINDS"]


def _wheel(radius: float, thick: float, at: tuple[float, float, float]) -> Part:
    return moved(turned_about(rod((0, 0, -thick / 2), (0, 0, thick / 2), radius, sides=18), 0, 90), at)


def _wheels(places: list[float], half: float, radius: float) -> Parts:
    return [_wheel(radius, 0.18, (x, side * half, radius)) for x in places for side in (-1, 1)]


def car(random: Random) -> Parts:
    """Make a car: hood, cabin and four wheels."""
    long, wide, radius = random.uniform(3.2, 4.6), random.uniform(1.5, 1.8), random.uniform(0.28, 0.38)
    low, belt, roof = radius * 0.8, random.uniform(0.75, 0.95), random.uniform(1.25, 1.6)
    front, rear = random.uniform(0.15, 0.3) * long, random.uniform(0.02, 0.2) * long
    body = [
        [-long / 2, low],
        [long / 2, low],
        [long / 2, belt - 0.1],
        [long / 2 - front, belt],
        [-long / 2, belt],
    ]
    cabin = [
        [-long / 2 + rear, belt],
        [long / 2 - front, belt],
        [long / 2 - front - 0.5, roof],
        [-long / 2 + rear + 0.3, roof],
    ]
    parts = [extruded(body, wide), extruded(cabin, wide * 0.88)]
    return parts + _wheels([-0.3 * long, 0.3 * long], wide / 2, radius)


def bus(random: Random) -> Parts:
    """Make a bus."""
    long, high = random.uniform(6.5, 10), random.uniform(2.2, 2.9)
    parts = [box((long, 2.2, high), (0, 0, 0.4))]
    count = int(long / 1.3)
    for side in (-1, 1):
        parts += [
            box((0.9, 0.06, 0.8), ((k - (count - 1) / 2) * 1.2, side * 1.1, 0.55 * high + 0.4))
            for k in range(count)
        ]
    return parts + _wheels([-0.32 * long, 0.34 * long], 1.05, 0.45)


def truck(random: Random) -> Parts:
    """Make a truck with a cab and a box or an open bed."""
    long, high = random.uniform(3.5, 6), random.uniform(1.6, 2.4)
    parts = [box((1.4, 2, 1.9), (long / 2 + 0.85, 0, 0.5)), box((long + 1.5, 1.2, 0.25), (0.7, 0, 0.45))]
    if random.random() < 0.6:
        parts.append(box((long, 2.1, high), (0, 0, 0.7)))
    else:
        parts += [
            box((long, 2.1, 0.1), (0, 0, 0.7)),
            *[box((long, 0.08, 0.6), (0, side, 0.7)) for side in (-1, 1)],
        ]
    return parts + _wheels([-0.35 * long, -0.35 * long + 0.9, long / 2 + 0.9], 0.95, 0.42)


def train(random: Random) -> Parts:
    """Make a locomotive with a boiler, or a wagon."""
    long = random.uniform(4, 6)
    parts = [box((long, 1.8, 0.3), (0, 0, 0.6))]
    if random.random() < 0.6:
        boiler = moved(
            turned_about(rod((0, 0, 0), (0, 0, 0.65 * long), 0.7, sides=20), 1, 90), (-0.15 * long, 0, 1.6)
        )
        parts += [
            boiler,
            box((0.3 * long, 1.8, 1.9), (-0.35 * long, 0, 0.9)),
            rod((0.4 * long, 0, 2.2), (0.4 * long, 0, 3), 0.15, 0.22),
        ]
    else:
        parts.append(box((0.96 * long, 1.9, random.uniform(1.6, 2.2)), (0, 0, 0.9)))
    return parts + _wheels(list(np.linspace(-0.4, 0.4, int(random.integers(3, 6))) * long), 0.75, 0.4)


def bicycle(random: Random) -> Parts:
    """Make a bicycle."""
    size, base = random.uniform(0.3, 0.36), random.uniform(0.5, 0.58)
    angle = np.linspace(0, 2 * np.pi, 25)
    ring = np.stack([size * np.cos(angle), 0 * angle, size + size * np.sin(angle)], axis=1)
    parts = [tube(ring + np.array([x, 0, 0]), 0.025, 6) for x in (-base, base)]
    rear, front = np.array([-base, 0, size]), np.array([base, 0, size])
    pedal, seat, head = (
        np.array([-0.08, 0, size - 0.05]),
        np.array([-0.22, 0, 0.8]),
        np.array([0.38, 0, 0.82]),
    )
    bars = [(rear, pedal), (rear, seat), (pedal, seat), (pedal, head), (seat, head), (head, front)]
    parts += [rod(a, b, 0.022, sides=8) for a, b in bars]
    parts += [
        rod(head + np.array([0, -0.25, 0.12]), head + np.array([0, 0.25, 0.12]), 0.018, sides=8),
        rod(head, head + np.array([0, 0, 0.12]), 0.018, sides=8),
    ]
    for x in (-base, base):
        parts += [
            rod(
                (x, 0, size),
                np.array([x, 0, size]) + size * np.array([np.cos(a), 0, np.sin(a)]),
                0.004,
                sides=4,
            )
            for a in np.arange(8) * np.pi / 4
        ]
    return [
        *parts,
        box((0.26, 0.13, 0.06), (-0.24, 0, 0.86)),
        rod(seat, seat + np.array([-0.02, 0, 0.08]), 0.02, sides=8),
    ]


def cart(random: Random) -> Parts:
    """Make a cart with two spoked wheels and shafts."""
    long, wide, size = random.uniform(1.2, 2), random.uniform(0.8, 1.1), random.uniform(0.4, 0.6)
    parts = [box((long, wide, 0.08), (0, 0, size))]
    parts += [box((long, 0.05, 0.35), (0, side * wide / 2, size)) for side in (-1, 1)]
    parts += [
        rod((long / 2, side * wide * 0.4, size), (long / 2 + 1.1, side * wide * 0.4, size - 0.05), 0.035)
        for side in (-1, 1)
    ]
    angle = np.linspace(0, 2 * np.pi, 25)
    for side in (-1, 1):
        middle = np.array([0, side * (wide / 2 + 0.1), size])
        parts.append(
            tube(middle + size * np.stack([np.cos(angle), 0 * angle, np.sin(angle)], axis=1), 0.045, 6)
        )
        parts += [
            rod(middle, middle + size * np.array([np.cos(a), 0, np.sin(a)]), 0.025, sides=6)
            for a in np.arange(8) * np.pi / 4
        ]
    return parts


def aeroplane(random: Random) -> Parts:
    """Make an aeroplane with wings and tail."""
    long, span, chord = random.uniform(3, 5), random.uniform(1.4, 2.6), random.uniform(0.5, 0.9)
    sweep = random.uniform(0, 0.9)
    body = turned_about(
        turned(
            [[0, 0], [0.12, 0.02], [0.32, 0.3 * long], [0.3, 0.7 * long], [0.12, 0.96 * long], [0, long]], 16
        ),
        1,
        90,
    )
    parts = [moved(body, (-long / 2, 0, 0))]
    outline = np.array([[0, 0], [chord, 0], [0.5 * chord - sweep, span], [-sweep, span]])
    for side in (-1, 1):
        wing = turned_about(extruded(outline, 0.07), 0, -90 * side)
        parts.append(wing)
        parts.append(moved(wing, (-0.42 * long, 0, 0), 0.4))
    parts.append(moved(extruded(outline, 0.07), (-0.42 * long, 0, 0), 0.45))
    return parts


def helicopter(random: Random) -> Parts:
    """Make a helicopter."""
    long, blade, count = random.uniform(1.6, 2.4), random.uniform(1.4, 2), int(random.choice([2, 3, 4]))
    parts = [
        ball(0.6, (0, 0, 0), (1.3, 0.8, 0.9), 3),
        rod((-0.5, 0, 0.1), (-long - 0.5, 0, 0.25), 0.16, 0.06),
    ]
    parts += [
        rod((0, 0, 0.4), (0, 0, 0.75), 0.06),
        *[moved(part, (0, 0, 0.75)) for part in around(box((blade, 0.12, 0.03), (blade / 2, 0, 0)), count)],
    ]
    parts.append(box((0.25, 0.05, 0.55), (-long - 0.45, 0, 0.1)))
    for side in (-1, 1):
        parts += [
            rod((-0.6, side * 0.45, -0.75), (0.7, side * 0.45, -0.75), 0.04),
            *[rod((x, side * 0.3, -0.4), (x, side * 0.45, -0.75), 0.03) for x in (-0.3, 0.35)],
        ]
    return parts


def boat(random: Random) -> Parts:
    """Make a boat, with a mast and sail or with a cabin."""
    long, wide, high = random.uniform(2.2, 3.5), random.uniform(0.4, 0.6), random.uniform(0.4, 0.6)
    x = np.linspace(-1, 1, 13)
    beam = wide * np.sqrt(np.maximum(1 - np.maximum(x, -0.6) ** 2, 0.001)) + 0.01
    outline = np.concatenate([np.stack([x, -beam], axis=1), np.stack([x, beam], axis=1)[::-1]])
    vertices, faces = turned_about(extruded(outline, 1), 0, 90)
    narrow = np.where(vertices[:, 2] < 0, 0.5, 1.0)
    hull = vertices * np.stack([long / 2 * (0.5 + 0.5 * narrow), narrow, 0 * narrow + high], axis=1), faces
    if random.random() < 0.6:
        mast = random.uniform(1.6, 2.4)
        sail = extruded([[0.05, 0.4 + high], [0.05, mast], [-0.45 * long, 0.4 + high]], 0.02)
        return [hull, rod((0.05, 0, 0), (0.05, 0, mast + 0.1), 0.035), sail]
    return [
        hull,
        box((0.35 * long, wide * 1.1, 0.5), (-0.1 * long, 0, high / 2)),
        rod((-0.1 * long, 0, 0.6), (-0.1 * long, 0, 1.2), 0.08),
    ]


def rocket(random: Random) -> Parts:
    """Make a rocket with fins."""
    long, wide = random.uniform(1.6, 3), random.uniform(0.22, 0.36)
    body = turned(
        [
            [0, 0],
            [0.7 * wide, 0],
            [wide, 0.3 * long],
            [wide, 0.7 * long],
            [0.5 * wide, 0.9 * long],
            [0, long],
        ],
        20,
    )
    fin = extruded(
        [[0.6 * wide, 0.3 * long], [0.6 * wide, 0.02], [2.1 * wide, -0.15], [2 * wide, 0.12 * long]], 0.05
    )
    return [body, *around(fin, int(random.choice([3, 4])))]


KINDS: dict[str, Maker] = {
    "car": car,
    "bus": bus,
    "truck": truck,
    "train": train,
    "bicycle": bicycle,
    "cart": cart,
    "aeroplane": aeroplane,
    "helicopter": helicopter,
    "boat": boat,
    "rocket": rocket,
}
