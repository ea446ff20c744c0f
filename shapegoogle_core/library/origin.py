# SPDX-License-Identifier: MIT
"""`Origin`: what a shape is in the file that it comes from."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, TypeAlias, get_args

__all__ = ["SHAPE_TYPES", "UNKNOWN", "Origin", "ShapeType"]

ShapeType: TypeAlias = Literal[
    "file",
    "object",
    "point cloud",
    "curve",
    "text",
    "surface",
    "metaball",
    "collection",
    "instance",
    "scatter",
]
"""A file that is one shape; an object, by its type; a collection as one; an object that shows a collection
as one; an object with all that it instances, by geometry nodes, particles or vertices."""

SHAPE_TYPES: tuple[ShapeType, ...] = get_args(ShapeType)
"""All types of shapes."""


@dataclass(frozen=True)
class Origin:
    """What a shape is in the file that it comes from.

    Attributes
    ----------
    shape_type : str or None
        One of `SHAPE_TYPES`. None on the way into a library: "object" if the shape has an object name, else
        "file".
    catalog : str
        Path of its asset catalog, with "/" between its parts; empty for none.
    frame : int or None
        Frame of the animation that shows it in this pose; None if it was not chosen for its pose.

    Examples
    --------
    >>> from shapegoogle_core.library.origin import Origin
    >>> Origin().completed("Chair").shape_type, Origin("text").completed("Sign").shape_type
    ('object', 'text')
    """

    shape_type: ShapeType | None = None
    catalog: str = ""
    frame: int | None = None

    def completed(self, object_name: str) -> Origin:
        """Fill in the type.

        Parameters
        ----------
        object_name : str
            Of the shape; empty for a file that is one shape.

        Returns
        -------
        origin : Origin
        """
        if self.shape_type is not None:
            return self
        if self == UNKNOWN:  # nearly all shapes; a search completes hundreds
            return _OBJECT if object_name else _FILE
        return replace(self, shape_type="object" if object_name else "file")


UNKNOWN = Origin()
"""Of a shape that was added without any."""

_OBJECT, _FILE = Origin("object"), Origin("file")
