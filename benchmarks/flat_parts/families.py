# SPDX-License-Identifier: MIT
"""Families of flat-sided parts whose members differ a little: other lengths, holes, walls, teeth."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.flat_parts.polygons import Face, circle, prism_faces, rectangle, solid
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["FAMILIES", "FlatPart", "make_parts"]


@dataclass(frozen=True, eq=False)
class FlatPart:
    """A member of a family.

    Attributes
    ----------
    family, name : str
    mesh : Mesh
        In millimetres, with the long thin triangles of a CAD exporter.
    chiral : bool
        Whether its mirror image is another shape.
    """

    family: str
    name: str
    mesh: Mesh
    chiral: bool = False


def plate(
    width: float, depth: float, thickness: float, diameter: float, holes: tuple[int, int], sides: int = 24
) -> Mesh:
    """Make a plate with a grid of round holes."""
    columns, rows = holes
    centers = [
        (width * (i + 1) / (columns + 1), depth * (j + 1) / (rows + 1))
        for i in range(columns)
        for j in range(rows)
    ]
    loops = [circle(x, y, diameter / 2, sides) for x, y in centers]
    return solid(prism_faces(rectangle(width, depth), loops, 0, thickness), "plate")


def tray(width: float, depth: float, height: float, wall: float) -> Mesh:
    """Make an open box with walls of even thickness."""
    outer = rectangle(width, depth)
    inner = rectangle(width - 2 * wall, depth - 2 * wall, wall, wall)
    top, floor = np.full((4, 1), height), np.full((4, 1), wall)
    faces = prism_faces(outer, [], 0, height, ends="low")
    faces += prism_faces(inner, [], wall, height, ends="none")
    faces.append(Face(np.hstack([outer, top]), [np.hstack([inner, top])]))
    faces.append(Face(np.hstack([inner, floor])))
    return solid(faces, "tray")


def gear(teeth: int, radius: float, bore: float, thickness: float) -> Mesh:
    """Make a gear with straight teeth and a round bore."""
    pitch = 2 * np.pi / teeth
    angles = (np.arange(teeth)[:, None] + np.array([-0.27, -0.13, 0.13, 0.27])) * pitch
    radii = np.tile([0.88, 1.0, 1.0, 0.88], (teeth, 1)) * radius
    outline = np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=2).reshape(-1, 2)
    return solid(prism_faces(outline, [circle(0, 0, bore / 2, 32)], 0, thickness), "gear")


def bracket(length: float, leg: float, thickness: float, diameter: float, offset: float = 0.3) -> Mesh:
    """Make an angle bracket with a hole in each leg, the second one off the middle."""
    profile = np.array(
        [[0, 0], [leg, 0], [leg, thickness], [thickness, thickness], [thickness, leg], [0, leg]]
    )
    faces = [Face(np.insert(profile, 1, y, axis=1).astype(float)) for y in (0.0, length)]
    middle = (leg + thickness) / 2
    for number in range(6):
        (x0, z0), (x1, z1) = profile[number], profile[(number + 1) % 6]
        side = np.array([[x0, 0, z0], [x1, 0, z1], [x1, length, z1], [x0, length, z0]], float)
        holes: list[FloatArray] = []
        if number in (0, 2):  # the lying leg, below and above
            loop = circle(middle, 0.5 * length, diameter / 2)
            holes = [np.column_stack([loop, np.full(len(loop), z0)])]
        if number in (3, 5):  # the standing leg, inside and outside
            loop = circle(offset * length, middle, diameter / 2)
            holes = [np.column_stack([np.full(len(loop), x0), loop])]
        faces.append(Face(side, holes))
    lying, standing = (
        circle(middle, 0.5 * length, diameter / 2),
        circle(offset * length, middle, diameter / 2),
    )
    for face in prism_faces(lying, [], 0, thickness, ends="none"):
        faces.append(face)
    for face in prism_faces(standing, [], 0, thickness, ends="none"):
        faces.append(Face(face.outline[:, [2, 0, 1]]))
    return solid(faces, "bracket")


def block(width: float, depth: float, height: float, diameters: Sequence[float]) -> Mesh:
    """Make a box with a row of holes through it."""
    loops = [
        circle(width * (i + 1) / (len(diameters) + 1), depth / 2, diameter / 2)
        for i, diameter in enumerate(diameters)
    ]
    return solid(prism_faces(rectangle(width, depth), loops, 0, height), "block")


def tube(outer: float, inner: float, length: float, sides: int = 32, inner_sides: int = 32) -> Mesh:
    """Make a tube, or a nut with few sides."""
    loops = [circle(0, 0, inner / 2, inner_sides)]
    return solid(prism_faces(circle(0, 0, outer / 2, sides), loops, 0, length), "tube")


def profile(width: float, height: float, thickness: float, length: float) -> Mesh:
    """Make a U profile."""
    w, h, t = width, height, thickness
    outline = [[0, 0], [w, 0], [w, h], [w - t, h], [w - t, t], [t, t], [t, h], [0, h]]
    return solid(prism_faces(np.array(outline, float), [], 0, length), "profile")


_PLATE = "plate with holes"
FAMILIES: dict[str, dict[str, Callable[[], Mesh]]] = {
    _PLATE: {
        "6 mm holes": lambda: plate(300, 200, 5, 6, (2, 2)),
        "7 mm holes": lambda: plate(300, 200, 5, 7, (2, 2)),
        "6.5 mm holes": lambda: plate(300, 200, 5, 6.5, (2, 2)),
        "one hole more": lambda: plate(300, 200, 5, 6, (5, 1)),
        "6 mm thick": lambda: plate(300, 200, 6, 6, (2, 2)),
    },
    "small plate": {
        "4 mm holes": lambda: plate(60, 40, 4, 4, (2, 2)),
        "5 mm holes": lambda: plate(60, 40, 4, 5, (2, 2)),
        "62 mm long": lambda: plate(62, 40, 4, 4, (2, 2)),
        "six holes": lambda: plate(60, 40, 4, 4, (3, 2)),
    },
    "sheet": {
        "300 x 300": lambda: plate(300, 300, 2, 0, (0, 0)),
        "300 x 330": lambda: plate(300, 330, 2, 0, (0, 0)),
        "300 x 303": lambda: plate(300, 303, 2, 0, (0, 0)),
        "3 mm thick": lambda: plate(300, 300, 3, 0, (0, 0)),
    },
    "gear": {
        "20 teeth": lambda: gear(20, 30, 8, 8),
        "21 teeth": lambda: gear(21, 30, 8, 8),
        "24 teeth": lambda: gear(24, 30, 8, 8),
        "9 mm bore": lambda: gear(20, 30, 9, 8),
        "9 mm thick": lambda: gear(20, 30, 8, 9),
    },
    "bracket": {
        "5 mm holes": lambda: bracket(60, 40, 4, 5),
        "6 mm holes": lambda: bracket(60, 40, 4, 6),
        "hole elsewhere": lambda: bracket(60, 40, 4, 5, 0.25),
        "63 mm long": lambda: bracket(63, 40, 4, 5),
    },
    "box with holes": {
        "three holes": lambda: block(80, 30, 25, (10, 10, 10)),
        "one larger": lambda: block(80, 30, 25, (10, 10, 11)),
        "larger in the middle": lambda: block(80, 30, 25, (10, 11, 10)),
        "26 mm high": lambda: block(80, 30, 26, (10, 10, 10)),
    },
    "tray": {
        "100 mm long": lambda: tray(100, 60, 30, 2),
        "110 mm long": lambda: tray(110, 60, 30, 2),
        "101 mm long": lambda: tray(101, 60, 30, 2),
        "thicker walls": lambda: tray(100, 60, 30, 2.5),
    },
    "tube": {
        "20 mm bore": lambda: tube(30, 20, 100),
        "21 mm bore": lambda: tube(30, 21, 100),
        "104 mm long": lambda: tube(30, 20, 104),
        "square bore": lambda: tube(30, 20, 100, 32, 4),
    },
    "nut": {
        "M8": lambda: tube(15, 8, 6.5, 6),
        "M8 high": lambda: tube(15, 8, 7.0, 6),
        "M8.5": lambda: tube(15, 8.5, 6.5, 6),
        "octagonal": lambda: tube(15, 8, 6.5, 8),
    },
    "profile": {
        "500 mm": lambda: profile(40, 30, 3, 500),
        "520 mm": lambda: profile(40, 30, 3, 520),
        "2.5 mm walls": lambda: profile(40, 30, 2.5, 500),
        "41 mm wide": lambda: profile(41, 30, 3, 500),
    },
}
"""Makers of the members of each family, by name."""

_CHIRAL = {"bracket"}


def make_parts(families: Sequence[str] | None = None) -> Iterator[FlatPart]:
    """Make all members of some families.

    Parameters
    ----------
    families : sequence of str, optional
        Keys of `FAMILIES`; all by default.

    Yields
    ------
    part : FlatPart
    """
    for family in FAMILIES if families is None else families:
        for name, make in FAMILIES[family].items():
            yield FlatPart(family, name, make(), family in _CHIRAL)
