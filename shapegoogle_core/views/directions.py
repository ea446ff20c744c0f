# SPDX-License-Identifier: MIT
"""The twelve directions from which a shape is looked at, and how turning the shape exchanges its pictures.

The viewers stand over the middles of the edges of a cube. The 48 symmetries of the cube (turns by quarters
about the axes, and mirror images) exchange these directions, and with the frames chosen here a picture
becomes another of the twelve, mirrored left to right, upside down, both or not at all. So the pictures of a
turned or mirrored shape need not be drawn.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations, product

import numpy as np
from numpy.typing import NDArray

__all__ = ["DIRECTIONS", "OPPOSITES", "VIEW_ROTATIONS", "Symmetry", "symmetries"]

FloatArray = NDArray[np.float64]


def _frames() -> FloatArray:
    """Rows point right, up and towards the viewer; up is the coordinate axis at a right angle to the view."""
    frames = []
    for up in range(3):
        first, second = (up + 1) % 3, (up + 2) % 3
        for signs in product((1.0, -1.0), repeat=2):
            towards, upwards = np.zeros(3), np.zeros(3)
            towards[[first, second]] = signs
            towards /= np.sqrt(2)
            upwards[up] = 1.0
            frames.append([np.cross(upwards, towards), upwards, towards])
    return np.array(frames)


VIEW_ROTATIONS = _frames()
"""Rotations (12, 3, 3) whose rows point right, up and towards the viewer."""

DIRECTIONS = len(VIEW_ROTATIONS)

OPPOSITES = tuple(
    (front, int((VIEW_ROTATIONS[:, 2] @ frame[2]).argmin()))
    for front, frame in enumerate(VIEW_ROTATIONS)
    if tuple(frame[2].round(3)) > (0, 0, 0)
)
"""The six pairs of opposite directions; each is the other one mirrored left to right, seen from behind."""


@dataclass(frozen=True, eq=False)
class Symmetry:
    """A turn or reflection of space that exchanges the directions.

    Attributes
    ----------
    matrix : (3, 3) array
        A permutation of the axes with signs.
    pictures : (12,) array of int
        Picture i of the transformed shape is this picture of the shape,
    mirrored : (12, 2) array of bool
        mirrored left to right, and upside down.
    """

    matrix: FloatArray
    pictures: NDArray[np.intp]
    mirrored: NDArray[np.bool_]


def symmetries() -> tuple[Symmetry, ...]:
    """List the 48 symmetries of the directions.

    Returns
    -------
    symmetries : tuple of Symmetry
        The identity first; the eight that keep all axes come before the others.

    Examples
    --------
    >>> from shapegoogle_core.views import symmetries
    >>> len(symmetries()), symmetries()[0].pictures.tolist()
    (48, [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11])
    """
    return tuple(
        _symmetry(np.diag(signs)[:, list(axes)])
        for axes in permutations(range(3))
        for signs in product((1.0, -1.0), repeat=3)
    )


def _symmetry(matrix: FloatArray) -> Symmetry:
    frames = VIEW_ROTATIONS @ matrix
    # Of each turned frame the direction that looks the same way.
    pictures = (frames[:, 2] @ VIEW_ROTATIONS[:, 2].T).argmax(axis=1)
    signs = np.einsum("vij,vij->vi", frames, VIEW_ROTATIONS[pictures])
    return Symmetry(matrix, pictures, signs[:, :2] < 0)
