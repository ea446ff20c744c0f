# SPDX-License-Identifier: MIT
"""Everything that is accepted as a query: meshes, signatures, and sequences of both."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias, cast

from shapegoogle_core.mesh import MeshLike, is_mesh_like
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["QueryShape", "QueryShapes", "as_query_shapes"]

QueryShape: TypeAlias = MeshLike | ShapeSignature
"""A mesh, see `MeshLike`, or a signature."""

QueryShapes: TypeAlias = QueryShape | Sequence[QueryShape]
"""One or several of them."""


def as_query_shapes(shapes: QueryShapes) -> list[QueryShape]:
    """Make a list of one or several shapes.

    Parameters
    ----------
    shapes : MeshLike, ShapeSignature, or sequence of them
        Anything else is treated as one mesh, and refused as such when it is described.

    Returns
    -------
    shapes : list of MeshLike or ShapeSignature
    """
    if isinstance(shapes, list | tuple) and not is_mesh_like(shapes):
        return list(shapes)
    return [cast(QueryShape, shapes)]
