# SPDX-License-Identifier: MIT
"""The `Mesh` value, the input of every other stage."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh.connectivity import used_points
from shapegoogle_core.mesh.measures import box_sides, face_areas

__all__ = ["FloatArray", "IntArray", "Mesh", "counted"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]


@dataclass(frozen=True, eq=False, init=False)
class Mesh:
    """A triangle mesh, or a point cloud when it has no faces.

    Parameters
    ----------
    vertices : (n, 3) array_like of float
        Positions in any unit. Stored as a float64 copy that cannot be written to.
    faces : (m, 3) array_like of int, optional
        Indices of the corners of each triangle, counted from 0. Stored as an int32 copy that cannot be
        written to. Without faces the mesh is a point cloud.
    name : str, optional
        Name in error messages, such as that of a file or object.

    Raises
    ------
    MeshError
        If an array has the wrong shape, a coordinate is not finite or a face index is out of range.

    See Also
    --------
    read_mesh : Read a mesh from a file.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> square = sg.Mesh([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]], [[0, 1, 2], [0, 2, 3]], name="square")
    >>> square
    Mesh('square', 4 vertices, 2 faces)
    >>> square.area
    4.0
    >>> sg.Mesh(square.vertices).is_point_cloud
    True
    """

    vertices: FloatArray
    faces: IntArray = field(default_factory=lambda: np.empty((0, 3), np.int32))
    name: str = "mesh"

    def __init__(self, vertices: ArrayLike, faces: ArrayLike | None = None, name: str = "mesh") -> None:
        try:
            points = np.array(vertices, dtype=np.float64, order="C")
            corners = np.empty((0, 3), np.int64) if faces is None else np.asarray(faces)
        except (TypeError, ValueError) as error:
            raise MeshError(f"{name!r}: vertices and faces must be arrays of numbers") from error
        if corners.size == 0:
            corners = np.empty((0, 3), np.int64)
        if points.ndim != 2 or points.shape[1] != 3:
            raise MeshError(f"{name!r}: vertices must have shape (n, 3), not {points.shape}")
        if corners.ndim != 2 or corners.shape[1] != 3:
            raise MeshError(f"{name!r}: faces must be triangles, shape (m, 3), not {corners.shape}")
        if corners.dtype.kind not in "iu":
            raise MeshError(f"{name!r}: faces must be integers, not {corners.dtype}")
        bad = ~np.isfinite(points).all(axis=1)
        if bad.any():
            raise MeshError(
                f"{name!r}: {int(bad.sum())} of {len(points)} vertices have NaN or infinite coordinates "
                f"(first: vertex {int(bad.argmax())}); repair or export the mesh again"
            )
        if corners.size and (corners.min() < 0 or corners.max() >= len(points)):
            first = corners[(corners < 0) | (corners >= len(points))][0]
            raise MeshError(
                f"{name!r}: a face names vertex {int(first)}, but indices must be 0 to {len(points) - 1}; "
                "subtract 1 if yours count from 1, or export the mesh again if it was cut short"
            )
        indices = corners.astype(np.int32)
        points.setflags(write=False)
        indices.setflags(write=False)
        object.__setattr__(self, "vertices", points)
        object.__setattr__(self, "faces", indices)
        object.__setattr__(self, "name", name)

    @cached_property
    def area(self) -> float:
        """Surface area in squared units of the vertices; 0 for a point cloud."""
        return float(face_areas(self).sum())

    @property
    def extents(self) -> tuple[float, float, float]:
        """Side lengths of the axis-aligned box around the surface; of a point cloud, around its points."""
        points = used_points(self.vertices, self.faces)  # a stray vertex is not part of the surface
        if len(points) == 0:
            return (0.0, 0.0, 0.0)
        x, y, z = box_sides(points).tolist()
        return (x, y, z)

    @property
    def is_point_cloud(self) -> bool:
        """True if there are no faces."""
        return len(self.faces) == 0

    def __repr__(self) -> str:
        vertices = counted(len(self.vertices), "vertex", "vertices")
        return f"Mesh({self.name!r}, {vertices}, {counted(len(self.faces), 'face', 'faces')})"


def counted(number: int, singular: str, plural: str) -> str:
    """Write a number with its noun.

    Parameters
    ----------
    number : int
    singular, plural : str

    Returns
    -------
    text : str
        Such as "1 vertex" or "2 vertices".
    """
    return f"{number} {singular if number == 1 else plural}"
