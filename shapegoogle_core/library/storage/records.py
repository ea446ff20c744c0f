# SPDX-License-Identifier: MIT
"""Records that go into a library and come back from it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["NewShape", "ShapeRecord", "SourceRecord", "StoreSummary"]


Content = TypeVar("Content")
Other = TypeVar("Other")


@dataclass(frozen=True, eq=False)
class NewShape(Generic[Content]):
    """A shape on its way into a library: read from a file, described, stored.

    The type of its content says how far it has come: a ``NewShape[Mesh]`` was read, a
    ``NewShape[ShapeSignature]`` is described and can be stored. Between the two, the mesh may wait elsewhere.

    Attributes
    ----------
    content : Mesh or ShapeSignature
        The mesh that was read, or the result of `ShapeModel.describe`.
    name : str
        Name of the object or of the file.
    object_name : str
        Name of the object inside its source; empty for a file that is one shape.
    thumbnail : bytes or None
        A picture as PNG, once it is described.
    tags : tuple of str
        Labels to filter searches by.
    twin_of : int or None
        Position of an earlier shape of the same source that differs only by a motion, a reflection or a
        uniform scale; such a twin is not described again.
    up_axis : int or None
        Axis that points up, 1 or 2, where the source defines it.
    """

    content: Content
    name: str
    object_name: str = ""
    thumbnail: bytes | None = None
    tags: tuple[str, ...] = ()
    twin_of: int | None = None
    up_axis: int | None = None

    @property
    def mesh(self: NewShape[Mesh]) -> Mesh:
        """The mesh of a shape that was read."""
        return self.content

    @property
    def signature(self: NewShape[ShapeSignature]) -> ShapeSignature:
        """The signature of a shape that is described."""
        return self.content

    def with_content(self, content: Other, thumbnail: bytes | None = None) -> NewShape[Other]:
        """Take the shape one step further.

        Parameters
        ----------
        content : object
            Its new content.
        thumbnail : bytes, optional
            A picture as PNG.

        Returns
        -------
        shape : NewShape
        """
        return NewShape(
            content, self.name, self.object_name, thumbnail, self.tags, self.twin_of, self.up_axis
        )


@dataclass(frozen=True)
class ShapeRecord:
    """A shape of a library without its signature and thumbnail.

    Attributes
    ----------
    shape_id : int
        The shape's number; never given to another shape of the same library.
    name, source, object_name : str
        As they were added; `source` and `object_name` may be empty.
    vertex_count, face_count : int
        Of the mesh as it was read.
    area : float
        Of the mesh as it was read, in squared units of its file.
    extents : (float, float, float)
        Side lengths of the axis-aligned bounding box of the mesh as it was read, in units of its file.
    tags : tuple of str
        In alphabetical order, each once.
    """

    shape_id: int
    name: str
    source: str
    object_name: str
    vertex_count: int
    face_count: int
    area: float
    extents: tuple[float, float, float] = (0.0, 0.0, 0.0)
    tags: tuple[str, ...] = ()


@dataclass(frozen=True)
class SourceRecord:
    """A file as a library knows it: enough to see whether it has changed since.

    Attributes
    ----------
    path : str
        As it was given.
    size : int or None
        In bytes. None: shapes were added under this name, but no file was indexed.
    mtime_ns : int or None
        Time of the last change in nanoseconds, from `os.stat`.
    sha256 : str or None
        Hash of the content in hexadecimal digits, followed by options of the reader that differ from the
        defaults, such as "+objects=assets".
    error : str or None
        Reason why the file, or a part of it, could not be described. Such a file is read again only after a
        change or on request.
    shape_count : int
        Number of shapes read from it.
    """

    path: str
    size: int | None
    mtime_ns: int | None
    sha256: str | None
    error: str | None
    shape_count: int


@dataclass(frozen=True)
class StoreSummary:
    """Numbers about a whole library.

    Attributes
    ----------
    shapes, sources : int
    failed : int
        Sources with an error.
    bytes : int
        Room that the library takes.
    format : int
        Version of its format.
    """

    shapes: int
    sources: int
    failed: int
    bytes: int
    format: int
