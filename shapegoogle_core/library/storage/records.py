# SPDX-License-Identifier: MIT
"""What goes into a library and what comes back from it, as plain values."""

from __future__ import annotations

from dataclasses import dataclass

from shapegoogle_core.model.shape_model import ShapeSignature

__all__ = ["NewShape", "ShapeRecord", "SourceRecord"]


@dataclass(frozen=True, eq=False)
class NewShape:
    """A described shape on its way into a library.

    Attributes
    ----------
    signature : ShapeSignature
        What `ShapeModel.describe` returned.
    name : str
        The object's or the file's name.
    object_name : str
        Name of the object inside its source; empty for a file that is one shape.
    thumbnail : bytes or None
        A picture as PNG.
    """

    signature: ShapeSignature
    name: str
    object_name: str = ""
    thumbnail: bytes | None = None


@dataclass(frozen=True)
class ShapeRecord:
    """What a library knows of a shape besides its bags, code and thumbnail.

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
    """

    shape_id: int
    name: str
    source: str
    object_name: str
    vertex_count: int
    face_count: int
    area: float


@dataclass(frozen=True)
class SourceRecord:
    """What a library knows of a file: enough to tell whether it changed since.

    Attributes
    ----------
    path : str
        As it was given.
    size : int or None
        In bytes. None: shapes were added under this name, but no file was indexed.
    mtime_ns : int or None
        Time of the last change, in nanoseconds, as `os.stat` gives it.
    sha256 : str or None
        Hash of the content, in hexadecimal digits; behind it, where they are not the usual ones, the options
        of the program that read it: "+objects=assets".
    error : str or None
        Why the file, or part of it, could not be described. Such a file is worth another try only when it
        changed or the user asks for it.
    shape_count : int
        How many shapes it gave.
    """

    path: str
    size: int | None
    mtime_ns: int | None
    sha256: str | None
    error: str | None
    shape_count: int
