# SPDX-License-Identifier: MIT
"""Vehicles on land: cars, vans, buses, lorries, locomotives, tanks, bicycles, motorcycles, carts."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from benchmarks.things.part import Part, around, ball, box, curve, cylinder, join, prism, ring, tube

__all__ = ["KINDS"]


def _wheel(rng: np.random.Generator, radius: float, width: float) -> Part:
    """Build a wheel whose axle is along x, centred at the origin."""
    sides = int(rng.choice([8, 12, 16, 24]))
    tyre = cylinder(radius, width, sides).at(z=-width / 2)
    hub = cylinder(radius * 0.5, width * 1.15, max(6, sides // 2)).at(z=-width * 0.575)
    return join([tyre, hub]).turned("y", 90)


def _wheels(rng: np.random.Generator, radius: float, track: float, places: Sequence[float]) -> list[Part]:
    wheel = _wheel(rng, radius, radius * rng.uniform(0.5, 0.8))
    return [wheel.at(x * track / 2, y, radius) for x in (-1, 1) for y in places]


def _side_view(
    outline: Sequence[tuple[float, float]], width: float, top: float = 1.0, smooth: int = 0
) -> Part:
    """Raise a side view of (y, z) to a body of a width along x, narrower towards its roof."""
    points = curve([*outline, outline[0]], smooth)[:-1] if smooth else np.asarray(outline, np.float64)
    body = prism(points, width).turned("x", 90).turned("z", 90).at(x=-width / 2)
    body.vertices[:, 0] *= 1 - (1 - top) * np.clip(
        (body.vertices[:, 2] - np.ptp(body.vertices[:, 2]) * 0.5) / np.ptp(body.vertices[:, 2]) * 2, 0, 1
    )
    return body


def car(rng: np.random.Generator) -> list[Part]:
    length, width = rng.uniform(3.6, 5.0), rng.uniform(1.6, 1.9)
    belt, roof = rng.uniform(0.75, 0.95), rng.uniform(1.25, 1.6)
    radius, base = rng.uniform(0.28, 0.38), rng.uniform(0.2, 0.35)
    half = length / 2
    bonnet, boot = rng.uniform(0.8, 1.5), rng.choice([0.1, rng.uniform(0.5, 1.1)])
    outline = [(-half, base), (half, base), (half, belt), (half - boot, belt)]
    outline += [(half - boot - rng.uniform(0.2, 0.7), roof), (-half + bonnet + rng.uniform(0.4, 0.9), roof)]
    outline += [(-half + bonnet, belt), (-half + 0.05, belt * 0.85), (-half, belt * 0.7)]
    parts = [_side_view(outline, width, rng.uniform(0.7, 0.95), int(rng.choice([0, 40])))]
    parts += _wheels(rng, radius, width * 0.92, (-length * 0.3, length * 0.29))
    parts += [box(width, 0.12, 0.18).at(y=y * half, z=base) for y in (-1, 1)]
    if rng.random() < 0.5:
        parts += [box(0.2, 0.1, 0.12).at(x * width / 2, -half + bonnet + 0.2, belt) for x in (-1, 1)]
    if rng.random() < 0.3:
        parts.append(box(width * 0.9, 0.3, 0.03).at(y=half - 0.1, z=belt + 0.2))
    return parts


def van(rng: np.random.Generator) -> list[Part]:
    length, width, roof = rng.uniform(4.5, 6), rng.uniform(1.8, 2.1), rng.uniform(1.9, 2.5)
    half, nose = length / 2, rng.uniform(0.4, 1.0)
    outline = [
        (-half, 0.3),
        (half, 0.3),
        (half, roof),
        (-half + nose + 0.5, roof),
        (-half + nose, 1.15),
        (-half, 0.95),
    ]
    parts = [_side_view(outline, width, rng.uniform(0.85, 1))]
    parts += _wheels(rng, rng.uniform(0.33, 0.42), width * 0.92, (-length * 0.32, length * 0.28))
    parts.append(box(width, 0.15, 0.2).at(y=-half, z=0.3))
    return parts


def bus(rng: np.random.Generator) -> list[Part]:
    length, width, height = rng.uniform(9, 13), rng.uniform(2.3, 2.6), rng.uniform(2.6, 4.2)
    parts = [box(width, length, height - 0.4, top=(0.97, 0.98)).at(z=0.4)]
    parts += _wheels(rng, rng.uniform(0.45, 0.55), width * 0.95, (-length * 0.35, length * 0.25))
    count = int(rng.integers(5, 9))
    pane = box(0.05, length / count * 0.8, 0.8)
    rows = (1.4, 3.0) if height > 3.7 else (1.4,)
    for z in rows:
        parts += [
            pane.at(x * width / 2, (n - (count - 1) / 2) * length / count, z)
            for x in (-1, 1)
            for n in range(count)
        ]
    parts.append(box(width * 0.9, 0.05, 1.0).at(y=-length / 2, z=1.4))
    return parts


def lorry(rng: np.random.Generator) -> list[Part]:
    length, width = rng.uniform(6, 12), rng.uniform(2.2, 2.6)
    cab, cab_height = rng.uniform(1.6, 2.4), rng.uniform(2.2, 3.0)
    load = rng.uniform(2.4, 3.8)
    outline = [(0.0, 0.6), (cab, 0.6), (cab, cab_height), (rng.uniform(0.1, 0.7), cab_height), (0.0, 1.6)]
    parts = [_side_view(outline, width).at(y=-length / 2)]
    if rng.random() < 0.5:
        parts.append(box(width * 0.8, 1.0, 1.0).at(y=-length / 2 - 0.4, z=0.6))
    rest = length - cab - 0.3
    middle = length / 2 - rest / 2
    parts.append(box(width * 0.6, length, 0.25).at(z=0.7))
    style = rng.integers(3)
    if style == 0:
        parts.append(box(width, rest, load - 1).at(y=middle, z=1))
    elif style == 1:
        parts.append(
            cylinder(width * 0.45, rest, 16).turned("x", 90).at(y=middle + rest / 2, z=1 + width * 0.45)
        )
    else:
        parts.append(box(width, rest, 0.15).at(y=middle, z=1))
        parts += [box(0.08, rest, 0.7).at(x * width / 2, middle, 1) for x in (-1, 1)]
        parts += [box(width, 0.08, 0.7).at(y=middle + y * rest / 2, z=1) for y in (-1, 1)]
    parts += _wheels(rng, 0.5, width * 0.9, (-length * 0.4, length * 0.22, length * 0.36))
    return parts


def locomotive(rng: np.random.Generator) -> list[Part]:
    length, radius = rng.uniform(5, 7), rng.uniform(0.6, 0.8)
    parts = [box(1.6, length, 0.3).at(z=0.9)]
    boiler = cylinder(radius, length * 0.65, int(rng.choice([12, 20]))).turned("x", 90)
    parts.append(boiler.at(y=length * 0.15, z=1.2 + radius))
    parts.append(box(1.7, length * 0.28, 1.9).at(y=length * 0.33, z=1.2))
    parts.append(box(2.0, length * 0.34, 0.12).at(y=length * 0.33, z=3.1))
    chimney = cylinder(0.16, rng.uniform(0.7, 1.1), 12, top=rng.uniform(0.16, 0.35))
    parts.append(chimney.at(y=-length * 0.38, z=1.1 + 2 * radius))
    parts.append(ball(0.3, 0.3, 0.35, 12).at(y=-length * 0.1, z=1.2 + 2 * radius))
    big = int(rng.integers(2, 5))
    parts += _wheels(rng, 0.55, 1.6, list(np.linspace(-0.05, 0.4, big) * length))
    parts += _wheels(rng, 0.32, 1.5, (-length * 0.42, -length * 0.28))
    parts.append(box(1.8, 0.3, 0.6, top=(1, 0.2)).at(y=-length / 2, z=0.3))
    return parts


def tank(rng: np.random.Generator) -> list[Part]:
    length, width = rng.uniform(5.5, 7), rng.uniform(3, 3.6)
    outline = [
        (-length * 0.42, 0.2),
        (length * 0.42, 0.2),
        (length / 2, 0.7),
        (length * 0.45, 1.0),
        (-length * 0.45, 1.0),
        (-length / 2, 0.7),
    ]
    track = _side_view(outline, 0.6)
    parts = [track.at(x * (width / 2 - 0.3)) for x in (-1, 1)]
    hull = [
        (-length * 0.5, 0.9),
        (-length * 0.4, 0.5),
        (length * 0.45, 0.5),
        (length * 0.48, 1.4),
        (-length * 0.25, 1.4),
    ]
    parts.append(_side_view(hull, width - 1))
    wheels = int(rng.integers(5, 8))
    parts += [
        _wheel(rng, 0.3, 0.7).at(x * (width / 2 - 0.3), y, 0.45)
        for x in (-1, 1)
        for y in np.linspace(-0.35, 0.35, wheels) * length
    ]
    turn = rng.uniform(-40, 40)
    turret = [box(width * 0.55, length * 0.38, 0.7, top=rng.uniform(0.6, 0.85))]
    if rng.random() < 0.4:
        turret = [ball(width * 0.32, length * 0.24, 0.7, 14)]
    barrel = cylinder(0.11, rng.uniform(2.5, 4), 10, top=0.09).turned("x", 90)
    turret += [barrel.at(y=-length * 0.15, z=0.35), cylinder(0.3, 0.2, 10).at(0.4, 0.3, 0.65)]
    parts.append(join(turret).turned("z", turn).at(z=1.4))
    return parts


def bicycle(rng: np.random.Generator) -> list[Part]:
    radius, base = rng.uniform(0.3, 0.36), rng.uniform(0.95, 1.1)
    tyre = ring(radius, rng.uniform(0.012, 0.03), int(rng.choice([16, 24])), 6)
    spokes = around(tube([[0, 0, 0], [radius, 0, 0]], 0.004, 4), int(rng.choice([8, 12, 18])))
    wheel = join([tyre, spokes]).turned("y", 90)
    parts = [wheel.at(y=y * base / 2, z=radius) for y in (-1, 1)]
    rear, front = np.array([0, base / 2, radius]), np.array([0, -base / 2, radius])
    crank, seat = np.array([0, 0.08, radius * 0.9]), np.array([0, 0.22, rng.uniform(0.75, 0.9)])
    head = np.array([0, -base * 0.33, rng.uniform(0.72, 0.85)])
    bars = [(rear, crank), (crank, seat), (rear, seat), (crank, head), (head, front)]
    if rng.random() < 0.75:
        bars.append((seat, head))
    parts += [tube(bar, rng.uniform(0.012, 0.02), 6) for bar in bars]
    grip = head + np.array([0, rng.uniform(-0.1, 0.05), 0.18])
    parts += [
        tube([head, grip], 0.014, 6),
        tube([grip - np.array([0.28, 0, 0]), grip + np.array([0.28, 0, 0])], 0.014, 6),
    ]
    parts += [
        ball(0.07, 0.13, 0.03, 8).at(*(seat + np.array([0, 0.02, 0.08]))),
        tube([seat, seat + np.array([0, 0, 0.08])], 0.012, 6),
    ]
    parts.append(cylinder(0.09, 0.01, 16).turned("y", 90).at(*crank))
    parts += [box(0.09, 0.06, 0.02).at(x * 0.1, 0.08 + x * 0.15, radius * 0.9) for x in (-1, 1)]
    return parts


def motorcycle(rng: np.random.Generator) -> list[Part]:
    radius, base = rng.uniform(0.28, 0.34), rng.uniform(1.3, 1.6)
    tyre = join(
        [
            ring(radius, 0.07, 20, 8),
            cylinder(radius * 0.4, 0.08, 12).at(z=-0.04),
            around(box(radius, 0.03, 0.03).at(radius / 2), 6),
        ]
    )
    parts = [tyre.turned("y", 90).at(y=y * base / 2, z=radius) for y in (-1, 1)]
    parts.append(ball(0.17, rng.uniform(0.28, 0.4), 0.16, 12).at(y=-0.15, z=0.78))
    parts.append(box(0.26, rng.uniform(0.5, 0.75), 0.12, top=(0.7, 0.9)).at(y=0.4, z=0.7))
    parts.append(box(0.34, 0.45, 0.36, top=0.8).at(z=0.26))
    for x in (-1, 1):
        parts.append(tube([[x * 0.09, -base / 2, radius], [x * 0.09, -base / 2 + 0.28, 0.95]], 0.03, 8))
        parts.append(tube([[x * 0.1, 0, 0.4], [x * 0.1, base / 2, radius]], 0.03, 6))
        parts.append(
            tube(curve([[x * 0.15, -0.1, 0.3], [x * 0.2, 0.3, 0.25], [x * 0.2, 0.8, 0.35]], 6), 0.045, 8)
        )
    parts.append(
        tube(
            [[-0.38, -base / 2 + 0.38, 1.0], [0, -base / 2 + 0.28, 0.97], [0.38, -base / 2 + 0.38, 1.0]],
            0.02,
            6,
        )
    )
    parts.append(ball(0.11, 0.1, 0.11, 10).at(y=-base / 2 + 0.15, z=0.88))
    return parts


def cart(rng: np.random.Generator) -> list[Part]:
    length, width, radius = rng.uniform(1.6, 2.4), rng.uniform(0.9, 1.2), rng.uniform(0.35, 0.55)
    floor, wall = radius * 1.2, rng.uniform(0.25, 0.5)
    parts = [box(width, length, 0.06).at(z=floor)]
    lean = rng.uniform(0, 20)
    parts += [box(0.05, length, wall).turned("y", x * lean).at(x * width / 2, z=floor) for x in (-1, 1)]
    parts += [box(width, 0.05, wall).at(y=y * length / 2, z=floor) for y in (-1, 1)]
    spokes = around(box(radius, 0.04, 0.04).at(radius / 2), int(rng.integers(6, 11)))
    wheel = join([ring(radius, 0.04, 20, 6), spokes]).turned("y", 90)
    rows = (0.0,) if rng.random() < 0.5 else (-length * 0.33, length * 0.33)
    parts += [wheel.at(x * (width / 2 + 0.1), y, radius) for x in (-1, 1) for y in rows]
    parts += [
        tube(
            [[x * width * 0.35, -length / 2, floor], [x * width * 0.35, -length / 2 - 1.0, floor + 0.1]],
            0.03,
            6,
        )
        for x in (-1, 1)
    ]
    return parts


KINDS: dict[str, Callable[[np.random.Generator], list[Part]]] = {
    "car": car,
    "van": van,
    "bus": bus,
    "lorry": lorry,
    "locomotive": locomotive,
    "tank": tank,
    "bicycle": bicycle,
    "motorcycle": motorcycle,
    "cart": cart,
}
