# SPDX-License-Identifier: MIT
"""Plain solids, of which libraries hold many and which resemble each other."""

from __future__ import annotations

import numpy as np

from benchmarks.objects.parts import Maker, Parts, Random, ball, box, extruded, rod, tube, turned

__all__ = ["KINDS"]


def cuboid(random: Random) -> Parts:
    """Make a box."""
    return [box(random.uniform(0.3, 1.5, 3))]


def ellipsoid(random: Random) -> Parts:
    """Make a ball or an ellipsoid."""
    return [ball(1, stretch=random.uniform(0.7, 1.3, 3), detail=3)]


def cylinder(random: Random) -> Parts:
    """Make a cylinder."""
    return [rod((0, 0, 0), (0, 0, random.uniform(0.3, 4)), 0.5, sides=int(random.choice([16, 24, 32])))]


def cone(random: Random) -> Parts:
    """Make a cone or a truncated cone."""
    tip = float(random.choice([0, random.uniform(0.1, 0.35)]))
    return [rod((0, 0, 0), (0, 0, random.uniform(0.6, 2.5)), 0.5, tip, sides=24)]


def pyramid(random: Random) -> Parts:
    """Make a pyramid."""
    return [rod((0, 0, 0), (0, 0, random.uniform(0.5, 1.6)), 0.7, 0, sides=int(random.integers(3, 6)))]


def prism(random: Random) -> Parts:
    """Make a prism."""
    return [rod((0, 0, 0), (0, 0, random.uniform(0.4, 3)), 0.6, sides=int(random.integers(3, 8)))]


def torus(random: Random) -> Parts:
    """Make a ring."""
    angle = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    thin = random.uniform(0.08, 0.4)
    return [turned(_closed(np.stack([1 + thin * np.cos(angle), thin * np.sin(angle)], axis=1)), 32)]


def disc(random: Random) -> Parts:
    """Make a flat disc."""
    return [rod((0, 0, 0), (0, 0, random.uniform(0.04, 0.15)), 1, sides=32)]


def star(random: Random) -> Parts:
    """Make a flat star."""
    count = int(random.integers(4, 8))
    angle = np.arange(2 * count) * np.pi / count
    radius = np.where(np.arange(2 * count) % 2, random.uniform(0.35, 0.6), 1)
    return [
        extruded(np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1), random.uniform(0.1, 0.4))
    ]


def helix(random: Random) -> Parts:
    """Make a spring."""
    turns, height = random.uniform(3, 7), random.uniform(1.5, 3)
    step = np.linspace(0, 1, int(turns * 18))
    angle = 2 * np.pi * turns * step
    path = np.stack([0.5 * np.cos(angle), 0.5 * np.sin(angle), height * step], axis=1)
    return [tube(path, random.uniform(0.05, 0.11))]


def ell(random: Random) -> Parts:
    """Make an angle of two legs."""
    long, thick = random.uniform(0.6, 1.6), random.uniform(0.15, 0.35)
    outline = [[0, 0], [1, 0], [1, thick], [thick, thick], [thick, long], [0, long]]
    return [extruded(outline, random.uniform(0.2, 1))]


def arch(random: Random) -> Parts:
    """Make half a ring."""
    angle = np.linspace(0, np.pi, 16)
    outer = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    inner = random.uniform(0.55, 0.85) * outer[::-1]
    return [extruded(np.concatenate([outer, inner]), random.uniform(0.2, 0.6))]


def capsule(random: Random) -> Parts:
    """Make a rod with round ends."""
    angle, long = np.linspace(0, np.pi / 2, 8), random.uniform(0.5, 3)
    end = np.stack([np.cos(angle), np.sin(angle)], axis=1) * 0.5
    return [
        turned(np.concatenate([(end * [1, -1] - [0, long / 2])[::-1], end + np.array([0, long / 2])]), 24)
    ]


def _closed(profile: np.ndarray) -> np.ndarray:
    return np.concatenate([profile, profile[:1]])


KINDS: dict[str, Maker] = {
    "cuboid": cuboid,
    "ellipsoid": ellipsoid,
    "cylinder": cylinder,
    "cone": cone,
    "pyramid": pyramid,
    "prism": prism,
    "torus": torus,
    "disc": disc,
    "star": star,
    "helix": helix,
    "angle": ell,
    "arch": arch,
    "capsule": capsule,
}
