# SPDX-License-Identifier: MIT
"""Aircraft: airliners, fighters, biplanes, helicopters, rockets, airships, satellites."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.things.part import Part, around, ball, box, curve, cylinder, join, lathe, loft, mirrored_pair

__all__ = ["KINDS"]


def _wing(root: float, tip: float, span: float, sweep: float, thickness: float = 0.08) -> Part:
    """Build a wing from the origin along +x; chords are along y, the sweep goes towards +y."""
    loops = []
    for x, chord, shift in ((0.0, root, 0.0), (span, tip, sweep)):
        half = thickness * chord / 2
        outline = [(-0.5, 0), (-0.25, half / chord * 1.6), (0.5, 0), (-0.25, -half / chord)]
        loops.append([[x, shift + y * chord, z * chord] for y, z in outline])
    return loft(loops)


def _fuselage(points: list[tuple[float, float]], sides: int, count: int = 14) -> Part:
    """Turn (radius, y) about the y axis."""
    return lathe(curve(points, count), sides).turned("x", -90).scaled(z=-1)


def airliner(rng: np.random.Generator) -> list[Part]:
    length, radius, sides = rng.uniform(6, 9), rng.uniform(0.35, 0.5), int(rng.choice([8, 12, 20]))
    half = length / 2
    parts = [_fuselage([(0.02, -half), (radius, -half + 0.9), (radius, half - 2.2), (0.08, half)], sides)]
    span, sweep = rng.uniform(3, 4.2), rng.uniform(0.8, 2)
    parts.append(
        mirrored_pair(_wing(1.6, 0.5, span, sweep).turned("y", -rng.uniform(0, 7)).at(z=-radius * 0.5))
    )
    high = rng.random() < 0.3
    tail = mirrored_pair(_wing(0.8, 0.35, span * 0.35, 0.5)).at(y=half - 0.5, z=1.4 if high else 0.1)
    fin = _wing(1.1, 0.5, 1.45, 0.8).turned("y", -90).at(y=half - 0.8)
    parts += [tail, fin]
    engine = lathe([(0.1, -0.5), (0.2, -0.45), (0.22, 0.0), (0.12, 0.5)], 10).turned("x", -90)
    if high:
        parts.append(mirrored_pair(engine.at(radius + 0.2, half - 1.8, 0.15)))
    else:
        for share in (0.35,) if rng.random() < 0.6 else (0.3, 0.55):
            parts.append(mirrored_pair(engine.at(span * share, sweep * share - 0.6, -radius * 0.5 - 0.2)))
    return parts


def fighter(rng: np.random.Generator) -> list[Part]:
    length, radius = rng.uniform(5, 7), rng.uniform(0.3, 0.42)
    half = length / 2
    parts = [
        _fuselage(
            [(0.01, -half), (radius * 0.7, -half * 0.4), (radius, half * 0.3), (radius * 0.8, half)],
            int(rng.choice([6, 10])),
        )
    ]
    parts.append(ball(0.22, 0.7, 0.25, 10).at(y=-half * 0.35, z=radius * 0.6))
    sweep = rng.uniform(0.8, 1.6)
    parts.append(
        mirrored_pair(_wing(rng.uniform(1.8, 2.8), 0.4, rng.uniform(1.6, 2.3), sweep, 0.05)).at(y=half * 0.15)
    )
    parts.append(mirrored_pair(_wing(0.9, 0.4, 0.9, 0.5, 0.05)).at(y=half * 0.85))
    fin = _wing(1.0, 0.45, 0.95, 0.6, 0.05).turned("y", -90)
    if rng.random() < 0.5:
        parts.append(mirrored_pair(fin.turned("y", 15).at(0.35, half * 0.7, radius * 0.6)))
    else:
        parts.append(fin.at(y=half * 0.75, z=radius * 0.6))
    if rng.random() < 0.5:
        missile = _fuselage([(0.01, -0.6), (0.06, -0.4), (0.06, 0.6)], 6, 5)
        parts.append(mirrored_pair(missile.at(rng.uniform(0.9, 1.4), half * 0.3, -0.15)))
    return parts


def biplane(rng: np.random.Generator) -> list[Part]:
    length, span, chord, gap = (
        rng.uniform(5, 6.5),
        rng.uniform(3, 4),
        rng.uniform(0.9, 1.2),
        rng.uniform(0.9, 1.3),
    )
    half = length / 2
    parts = [_fuselage([(0.35, -half), (0.42, -half * 0.4), (0.1, half)], int(rng.choice([6, 12])))]
    wing = mirrored_pair(_wing(chord, chord * 0.9, span, 0.0))
    parts += [wing.at(y=-half * 0.4, z=-0.3), wing.at(y=-half * 0.45, z=gap)]
    strut = box(0.04, 0.06, gap + 0.3).at(z=-0.3)
    parts += [mirrored_pair(strut.at(x * span, -half * 0.42 + y)) for x in (0.2, 0.75) for y in (-0.3, 0.3)]
    parts.append(mirrored_pair(_wing(0.7, 0.5, 1.1, 0.0)).at(y=half * 0.9))
    parts.append(_wing(0.8, 0.5, 0.9, 0.2).turned("y", -90).at(y=half * 0.85))
    blade = box(0.14, 0.03, 1.0, top=0.5)
    parts.append(join([blade, blade.turned("y", 180)]).turned("y", rng.uniform(0, 180)).at(y=-half - 0.1))
    wheel = cylinder(0.3, 0.12, 12).turned("y", 90)
    parts.append(
        mirrored_pair(
            join([wheel, box(0.05, 0.05, 0.7).turned("y", -15).at(z=0)]).at(0.7, -half * 0.6, -0.95)
        )
    )
    return parts


def helicopter(rng: np.random.Generator) -> list[Part]:
    width, length = rng.uniform(0.7, 1.0), rng.uniform(1.2, 1.8)
    parts = [ball(width, length, rng.uniform(0.7, 1.0), int(rng.choice([8, 14])))]
    boom = rng.uniform(2.5, 3.8)
    parts.append(cylinder(0.3, boom, 8, top=0.1).turned("x", -90).at(y=length * 0.6, z=0.25))
    parts.append(_wing(0.6, 0.35, 0.9, 0.35).turned("y", -90).at(y=length * 0.6 + boom, z=0.2))
    blade = box(rng.uniform(3, 4), 0.18, 0.03).at(1.7)
    blades = int(rng.integers(2, 6))
    parts.append(around(blade, blades, rng.uniform(0, 90)).at(z=1.35))
    parts.append(cylinder(0.1, 0.6, 8).at(z=0.8))
    rotor = around(box(0.5, 0.08, 0.02).at(0.25), int(rng.integers(2, 5))).turned("y", 90)
    parts.append(rotor.at(0.15, length * 0.6 + boom, 0.5))
    if rng.random() < 0.6:
        skid = [box(0.08, 2.4, 0.06)] + [
            box(0.06, 0.06, 0.6).turned("y", -20).at(y=y, z=0) for y in (-0.6, 0.6)
        ]
        parts.append(mirrored_pair(join(skid).at(width * 0.9, 0, -1.4)))
    else:
        parts += [
            cylinder(0.22, 0.2, 10).turned("y", 90).at(x, y, -1.1)
            for x, y in ((-0.6, 0.5), (0.5, 0.5), (0, -0.9))
        ]
    return parts


def rocket(rng: np.random.Generator) -> list[Part]:
    radius, height, sides = rng.uniform(0.25, 0.5), rng.uniform(3, 5), int(rng.choice([8, 16]))
    bulge = rng.uniform(1, 1.4)
    profile = curve(
        [(radius * 0.8, 0), (radius * bulge, height * 0.45), (radius * 0.9, height * 0.75), (0.0, height)], 16
    )
    parts = [lathe([(0, 0), *profile], sides)]
    fin = _wing(rng.uniform(0.7, 1.1), 0.5, rng.uniform(0.4, 0.8), rng.uniform(0.2, 0.8), 0.06).turned(
        "x", -90
    )
    parts.append(around(fin.at(radius * 0.8, 0, 0.6), int(rng.integers(3, 5))))
    parts.append(cylinder(radius * 0.6, 0.3, sides, top=radius * 0.4).at(z=-0.28))
    if rng.random() < 0.3:
        booster = lathe([(0, 0), (0.2, 0), (0.2, height * 0.5), (0, height * 0.6)], 10)
        parts.append(mirrored_pair(booster.at(radius * bulge + 0.15)))
    return parts


def airship(rng: np.random.Generator) -> list[Part]:
    length, radius, sides = rng.uniform(5, 8), rng.uniform(0.8, 1.2), int(rng.choice([10, 16]))
    half = length / 2
    parts = [
        _fuselage([(0.0, -half), (radius, -half * 0.4), (radius * 0.9, half * 0.2), (0.05, half)], sides, 18)
    ]
    fin = _wing(1.0, 0.7, radius, 0.3).at(0.15, half * 0.75)
    parts.append(join(fin.turned("y", angle) for angle in (0, 90, 180, 270)))
    parts.append(box(0.5, length * 0.2, 0.4, top=1.1).at(y=-half * 0.3, z=-radius - 0.35))
    return parts


def satellite(rng: np.random.Generator) -> list[Part]:
    size, sides = rng.uniform(0.5, 0.9), int(rng.choice([4, 6, 8, 16]))
    parts = [cylinder(size / 2, size * rng.uniform(1, 1.8), sides)]
    span = rng.uniform(1.2, 2.2)
    panels = int(rng.integers(1, 4))
    panel = join(
        box(span / panels * 0.9, size * 0.9, 0.03).at(size + span * (n + 0.5) / panels) for n in range(panels)
    )
    tilt = rng.uniform(0, 60)
    parts.append(join([panel, box(size, 0.04, 0.04).at(size * 0.7)]).turned("x", tilt).at(z=size * 0.6))
    parts.append(parts[-1].scaled(x=-1))
    dish = lathe([(0.02, 0), (0.3, 0.08), (0.45, 0.22)], 14).scaled(z=1.2)
    parts += [dish.at(z=size * 1.5 + 0.1), cylinder(0.02, 0.8, 6).at(z=size)]
    return parts


KINDS: dict[str, Callable[[np.random.Generator], list[Part]]] = {
    "airliner": airliner,
    "fighter plane": fighter,
    "biplane": biplane,
    "helicopter": helicopter,
    "rocket": rocket,
    "airship": airship,
    "satellite": satellite,
}
