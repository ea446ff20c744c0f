# SPDX-License-Identifier: MIT
"""`Placement`: where an object of a file puts a mesh that several objects may share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.connectivity import used_vertices
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["Placement", "placements_of"]

# Coordinates that are computed at once: 32 MB.
_AT_ONCE = 4_000_000


@dataclass(frozen=True, eq=False)
class Placement:
    """An object that shows the mesh of an entry, and where.

    Objects that share a mesh are one entry of a library with many placements. The mesh of the entry has the
    coordinates of its first placement; M_i M_0⁻¹ carries it to placement i.

    Attributes
    ----------
    object_name : str
        Name of the object inside its file.
    matrix : (4, 4) array of float64
        From the coordinates of the object to those of its file.
    extents : (float, float, float) or None
        Side lengths of the axis-aligned bounding box of the placed mesh; None: those of the first placement,
        scaled.

    Examples
    --------
    >>> import numpy as np
    >>> from shapegoogle_core.library.placement import Placement
    >>> mirrored = Placement("Wing.R", np.diag([-2.0, 2.0, 2.0, 1.0]))
    >>> mirrored.scale, mirrored.is_mirrored
    (2.0, True)
    """

    object_name: str
    matrix: FloatArray
    extents: tuple[float, float, float] | None = None

    @property
    def scale(self) -> float:
        """Factor of all lengths; of a matrix that stretches, its root mean square."""
        return float(np.sqrt((self.matrix[:3, :3] ** 2).sum() / 3))

    @property
    def is_mirrored(self) -> bool:
        """Whether it turns the mesh into its mirror image."""
        return bool(np.linalg.det(self.matrix[:3, :3]) < 0)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Placement):
            return NotImplemented
        same = (self.object_name, self.extents) == (other.object_name, other.extents)
        return same and np.array_equal(self.matrix, other.matrix)

    def __hash__(self) -> int:
        return hash((self.object_name, self.extents, self.matrix.tobytes()))


def placements_of(mesh: Mesh, objects: Sequence[tuple[str, FloatArray]]) -> tuple[Placement, ...]:
    """Describe the objects that share a mesh.

    Parameters
    ----------
    mesh : Mesh
        In the coordinates of its file, as the first of the objects places it.
    objects : sequence of (str, (4, 4) array)
        Name and matrix of each object. If there are several, each matrix is a motion with a uniform scale,
        mirroring or not.

    Returns
    -------
    placements : tuple of Placement
        With their exact extents.

    Examples
    --------
    >>> import numpy as np
    >>> import shapegoogle_core as sg
    >>> from shapegoogle_core.library.placement import placements_of
    >>> mesh = sg.Mesh([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]], [[0, 1, 2], [0, 1, 3]])
    >>> objects = [("A", np.eye(4)), ("B", np.diag([2.0, 2.0, 2.0, 1.0]))]
    >>> [placement.extents for placement in placements_of(mesh, objects)]
    [(1.0, 2.0, 3.0), (2.0, 4.0, 6.0)]
    """
    matrices = [np.asarray(matrix, np.float64).reshape(4, 4) for _, matrix in objects]
    extents = [mesh.extents]
    if len(objects) > 1:
        points = mesh.vertices
        if not mesh.is_point_cloud:
            points = points[used_vertices(mesh.faces, len(points))[0]]
        back = np.linalg.inv(matrices[0][:3, :3])
        # Each row is one axis of the file, as it lies in the first placement.
        axes = np.concatenate([matrix[:3, :3] @ back for matrix in matrices[1:]])
        step = 3 * max(1, _AT_ONCE // (3 * len(points)))
        lengths = np.concatenate(
            [np.ptp(points @ axes[start : start + step].T, axis=0) for start in range(0, len(axes), step)]
        )
        extents += [(float(x), float(y), float(z)) for x, y, z in lengths.reshape(-1, 3)]
    return tuple(
        Placement(name, matrix, own)
        for (name, _), matrix, own in zip(objects, matrices, extents, strict=False)
    )
