# SPDX-License-Identifier: MIT
"""Nearly isometric bending of a shape without a skeleton."""

from __future__ import annotations

import zlib

import numpy as np

from shapegoogle_core.mesh import Mesh, check_surface
from shapegoogle_core.mesh.connectivity import edge_lengths
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["bend", "edge_length_changes"]

# Median relative change of edge lengths at strength 1, and the largest angles, however thin the shape is.
_BEND_DISTORTION = 0.03
_MOST_BEND, _MOST_TWIST = np.radians(120), np.radians(90)


def edge_length_changes(before: Mesh, after: Mesh) -> FloatArray:
    """Measure the deviation of a deformation from an isometry.

    Parameters
    ----------
    before, after : Mesh
        Meshes with the same faces.

    Returns
    -------
    changes : (e,) array
        |l′/l − 1| of every edge whose length l before is not 0.

    Raises
    ------
    ValueError
        If the faces differ.
    """
    if not np.array_equal(before.faces, after.faces):
        raise ValueError(f"{before.name!r} and {after.name!r} do not have the same faces")
    old, new = edge_lengths(before), edge_lengths(after)
    return np.abs(new[old > 0] / old[old > 0] - 1)


def bend(mesh: Mesh, seed: int, strength: float = 1.0) -> Mesh:
    """Bend and twist a shape that has no skeleton, nearly isometrically.

    The shape is twisted about a random axis and bent along it, then bent along a second one. Long shapes are
    mostly bent along their length. Angles grow until the median relative change of edge lengths is 3 % times
    the strength, so that a sheet or a rod bends far and a ball hardly, or until they reach 120° of bending
    and 90° of twist. Only the median is bounded: parts far from the axis stretch more.

    Parameters
    ----------
    mesh : Mesh
        Any triangles, including polygon soup.
    seed : int
    strength : float, optional
        Above 0; 1 is gentle.

    Returns
    -------
    bent : Mesh
        With the same faces.

    Raises
    ------
    ValueError
        If the strength is not positive.
    MeshError
        If the mesh has no surface (see `check_surface`).
    """
    if not strength > 0:
        raise ValueError(f"strength must be positive, not {strength}")
    check_surface(mesh)
    rng = np.random.default_rng([zlib.crc32(b"bend"), seed])
    centre = mesh.vertices[mesh.faces].mean(axis=(0, 1))
    spread = np.linalg.svd(mesh.vertices[mesh.faces].mean(axis=1) - centre, full_matrices=False)
    # Axes drawn like points of the shape: mostly along its length.
    axes = rng.standard_normal((2, 3)) * spread[1] @ spread[2]
    sides = np.cross(axes, rng.standard_normal((2, 3)))
    phases, turns = rng.uniform(-0.25, 0.25, 2), rng.choice([-1.0, 1.0], 3)

    def bent(amount: float) -> Mesh:
        points = _twisted(mesh.vertices - centre, axes[0], turns[2] * amount * _MOST_TWIST)
        for axis, side, phase, turn in zip(axes, sides, phases, turns, strict=False):
            points = _curved(points, axis, side, turn * amount * _MOST_BEND / 2, phase)
        return Mesh(points + centre, mesh.faces, f"{mesh.name}-bent-{seed}")

    low, high = 0.0, 1.0
    if np.median(edge_length_changes(mesh, bent(high))) <= strength * _BEND_DISTORTION:
        return bent(high)
    for _ in range(10):
        middle = (low + high) / 2
        if np.median(edge_length_changes(mesh, bent(middle))) <= strength * _BEND_DISTORTION:
            low = middle
        else:
            high = middle
    return bent(low)


def _unit(vector: FloatArray) -> FloatArray:
    return vector / np.linalg.norm(vector)


def _twisted(points: FloatArray, axis: FloatArray, angle: float) -> FloatArray:
    """Rotate points about an axis, by −angle/2 at one end of the shape to angle/2 at the other."""
    axis = _unit(axis)
    along = points @ axis
    turn = (angle * (along - along.min()) / max(float(np.ptp(along)), np.finfo(float).tiny) - angle / 2)[
        :, None
    ]
    across = points - along[:, None] * axis
    twisted: FloatArray = (
        along[:, None] * axis + np.cos(turn) * across + np.sin(turn) * np.cross(axis, across)
    )
    return twisted


def _curved(points: FloatArray, axis: FloatArray, side: FloatArray, angle: float, phase: float) -> FloatArray:
    """Bend a straight axis into a curve, cross sections staying flat, square to it and as large as they are.

    The tangent turns by `angle` over the shape's length; `phase` moves the turning towards one end.
    """
    axis, side = _unit(axis), _unit(side)
    along, offset = points @ axis, points @ side
    extent = max(float(np.ptp(along)), np.finfo(float).tiny)
    share = np.linspace(0, 1, 257)
    # The rate of turning is 1 + 4 · phase · cos(πu) ≥ 0, so the shape never curls back on itself.
    tangent = angle * (share + 4 * phase * np.sin(np.pi * share) / np.pi - 0.5)
    step = extent / 256
    middles = (tangent[1:] + tangent[:-1]) / 2
    forward = np.concatenate([[0], np.cumsum(np.cos(middles))]) * step
    sideways = np.concatenate([[0], np.cumsum(np.sin(middles))]) * step
    place = (along - along.min()) / extent
    turn = np.interp(place, share, tangent)
    new_along = np.interp(place, share, forward) - np.sin(turn) * offset
    new_offset = np.interp(place, share, sideways) + np.cos(turn) * offset
    rest = points - np.outer(along, axis) - np.outer(offset, side)
    return rest + np.outer(new_along, axis) + np.outer(new_offset, side)
