# SPDX-License-Identifier: MIT
"""Records that go into a library and come back from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.decisions.decision import Decision
from shapegoogle_core.library.origin import UNKNOWN, Origin
from shapegoogle_core.library.placement import Placement
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model.signature import ShapeSignature

__all__ = [
    "CopyBatch",
    "NewShape",
    "Rearrangement",
    "Root",
    "ShapeRecord",
    "SourceKey",
    "SourceRecord",
    "StoreSummary",
]


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
        Name of the object inside its source, the first one if several share the mesh; empty for a file that
        is one shape.
    thumbnail : bytes or None
        A picture as PNG, once it is described.
    tags : tuple of str
        Labels to filter searches by.
    placements : tuple of Placement
        The objects that show the mesh, which has the coordinates of the first; empty for a file without
        objects.
    up_axis : int or None
        Axis that points up, 1 or 2, where the source defines it.
    warnings : tuple of str
        A sentence for each part of the file that was left out. They are shown, and not stored.
    preview : bytes or None
        A small mesh to show, see `shapegoogle_core.rendering.make_preview`, once it is described.
    origin : Origin
        What it is in its file.
    named_after_file : bool
        Whether its name is made of that of its file, since its object has only the name that a program gave
        it.
    color : tuple of float or None
        Colour of its picture, sRGB from 0 to 1, where the source gives it one.
    """

    content: Content
    name: str
    object_name: str = ""
    thumbnail: bytes | None = None
    tags: tuple[str, ...] = ()
    placements: tuple[Placement, ...] = ()
    up_axis: int | None = None
    warnings: tuple[str, ...] = ()
    preview: bytes | None = None
    origin: Origin = UNKNOWN
    named_after_file: bool = False
    color: tuple[float, float, float] | None = None

    @property
    def mesh(self: NewShape[Mesh]) -> Mesh:
        """The mesh of a shape that was read."""
        return self.content

    @property
    def signature(self: NewShape[ShapeSignature]) -> ShapeSignature:
        """The signature of a shape that is described."""
        return self.content

    def with_content(
        self, content: Other, thumbnail: bytes | None = None, preview: bytes | None = None
    ) -> NewShape[Other]:
        """Take the shape one step further.

        Parameters
        ----------
        content : object
            Its new content.
        thumbnail : bytes, optional
            A picture as PNG.
        preview : bytes, optional
            A small mesh to show.

        Returns
        -------
        shape : NewShape
        """
        return NewShape(
            content,
            self.name,
            self.object_name,
            thumbnail,
            self.tags,
            self.placements,
            self.up_axis,
            self.warnings,
            preview,
            self.origin,
            self.named_after_file,
            self.color,
        )


@dataclass(frozen=True)
class ShapeRecord:
    """A shape of a library without its signature and thumbnail.

    Attributes
    ----------
    shape_id : int
        The shape's number; never given to another shape of the same library.
    name : str
        As it was added.
    source : str
        Full path of its file, or the text that it was added under; may be empty.
    object_name : str
        Name of the object inside the source, the first one if several share the mesh; may be empty.
    vertex_count, face_count : int
        Of the mesh as it was read.
    area : float
        Of the mesh as it was read, in squared units of its file.
    extents : (float, float, float)
        Side lengths of the axis-aligned bounding box of the mesh as it was read, in units of its file.
    tags : tuple of str
        In alphabetical order, each once.
    placement_count : int
        Number of objects that show the shape; 1 for a file without objects.
    origin : Origin
        What it is in its file; with a type.
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
    placement_count: int = 1
    origin: Origin = UNKNOWN


class SourceKey(NamedTuple):
    """Key of a source in a library.

    Attributes
    ----------
    root : str
        Name of its root; empty for a label.
    path : str
        Path below the root, with "/" between its parts; or the text of a label, as it was given.
    """

    root: str
    path: str


@dataclass(frozen=True)
class Root:
    """A named folder that sources of a library lie below.

    Attributes
    ----------
    name : str
        Each root has another one.
    path : str
        Absolute path of the folder.
    source_count : int
        Number of sources below it.
    stored : str
        Path that the library has for it, if `path` is where it lies on this computer; otherwise empty.
    """

    name: str
    path: str
    source_count: int = 0
    stored: str = ""

    @property
    def key_folder(self) -> str:
        """The path that decides how keys of its sources are written, on all computers alike."""
        return self.stored or self.path


@dataclass(frozen=True)
class SourceRecord:
    """A file as a library knows it: enough to see whether it has changed since.

    Attributes
    ----------
    path : str
        Full path, or the text of a label: a source that is not an indexed file.
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
    root : str
        Name of its root; empty for a label.
    relative : str
        Path below the root, with "/" between its parts; empty for a label.
    """

    path: str
    size: int | None
    mtime_ns: int | None
    sha256: str | None
    error: str | None
    shape_count: int
    root: str = ""
    relative: str = ""

    @classmethod
    def of(
        cls,
        key: SourceKey,
        size: int | None = None,
        mtime_ns: int | None = None,
        sha256: str | None = None,
        error: str | None = None,
    ) -> SourceRecord:
        """Make the record of a source that is stored under a key; its full path is left out below a root."""
        path, relative = ("", key.path) if key.root else (key.path, "")
        return cls(path, size, mtime_ns, sha256, error, 0, key.root, relative)

    @property
    def key(self) -> SourceKey:
        """Key of the source in its library."""
        return SourceKey(self.root, self.relative) if self.root else SourceKey("", self.path)


@dataclass(frozen=True)
class Rearrangement:
    """Changes of roots and of the places of sources, made in one transaction.

    Attributes
    ----------
    roots : tuple of (str, str)
        Names and paths of roots that are new or lie elsewhere now.
    moved : tuple of (SourceKey, SourceKey)
        Former and new keys of sources; the new ones below the roots as they are afterwards.
    removed : tuple of SourceKey
        Sources that are removed first, with their shapes.
    removed_roots : tuple of str
        Names of roots that no source lies below afterwards.
    """

    roots: tuple[tuple[str, str], ...] = ()
    moved: tuple[tuple[SourceKey, SourceKey], ...] = ()
    removed: tuple[SourceKey, ...] = ()
    removed_roots: tuple[str, ...] = ()


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


@dataclass(frozen=True, eq=False)
class CopyBatch:
    """Part of another library, stored in one transaction with the numbers that it has there.

    Attributes
    ----------
    mark : str or None
        Name of the other library while the copy is unfinished; None once it is complete.
    roots : tuple of (str, str)
        Names and paths.
    sources : tuple of SourceRecord
        In place of those with the same keys, whose shapes stay.
    removed_sources : tuple of SourceKey
    shapes : tuple of (int, SourceKey or None, NewShape)
        Numbers, sources and contents of shapes.
    neighbours : mapping of int to (ids, distances)
        Nearest shapes, by number.
    decisions : tuple of Decision
        New ones.
    removed_decisions : tuple of int
        Numbers.
    tags : mapping of int to sequence of str
        All tags of some shapes, by number.
    last_id : int
        No new shape may have a number up to this.
    """

    mark: str | None = None
    roots: tuple[tuple[str, str], ...] = ()
    sources: tuple[SourceRecord, ...] = ()
    removed_sources: tuple[SourceKey, ...] = ()
    shapes: tuple[tuple[int, SourceKey | None, NewShape[ShapeSignature]], ...] = ()
    neighbours: Mapping[int, tuple[NDArray[np.int64], NDArray[np.float32]]] = field(default_factory=dict)
    decisions: tuple[Decision, ...] = ()
    removed_decisions: tuple[int, ...] = ()
    tags: Mapping[int, Sequence[str]] = field(default_factory=dict)
    last_id: int = 0
