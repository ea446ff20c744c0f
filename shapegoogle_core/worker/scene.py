# SPDX-License-Identifier: MIT
"""Requests about a scene that is indexed: its shapes are described one by one and stored together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from shapegoogle_core.client import LibraryAddress
from shapegoogle_core.errors import MeshError
from shapegoogle_core.indexing.reading.answer import MeshPlace, read_shape
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeSignature
from shapegoogle_core.worker.packed import Packed
from shapegoogle_core.worker.requests import open_library

__all__ = ["SceneShape", "create_library", "describe", "find_neighbours", "rename_source", "store"]


def create_library(path: Path, model: str) -> None:
    """Create a library if it does not exist.

    Parameters
    ----------
    path : Path
    model : str
        Name or path, as for `load_model`.

    Raises
    ------
    LibraryError
        If it cannot be created.
    ModelError
        If the model cannot be loaded.
    """
    from shapegoogle_core.library.library import Library
    from shapegoogle_core.model import load_model

    if not path.exists():
        Library.open(path, load_model(model)).close()


@dataclass(frozen=True)
class SceneShape:
    """A shape of the open scene that waits to be described; its arrays are in a file.

    Attributes
    ----------
    record : mapping
        As in the answer of an external reader.
    meshes : tuple of MeshPlace
        Those that the numbers of its parts mean.
    arrays : Path
        The file with the arrays.
    source : Path
        The file of the scene, or the label of one that was never saved.
    up_axis : int
    alone : bool
        Whether it is the only shape of the scene.
    is_unsaved : bool
        Whether the scene was never saved, so that no shape is named after its file.
    """

    record: Mapping[str, Any]
    meshes: tuple[MeshPlace, ...]
    arrays: Path
    source: Path
    up_axis: int
    alone: bool
    is_unsaved: bool

    @property
    def name(self) -> str:
        """Name of its object."""
        return str(self.record["name"])

    def read(self) -> NewShape[Mesh]:
        """Read its arrays.

        Returns
        -------
        shape : NewShape

        Raises
        ------
        MeshError
            If it is no usable mesh.
        """
        shape = read_shape(
            self.source, self.record, self.meshes, self.arrays, up_axis=self.up_axis, alone=self.alone
        )
        if shape.named_after_file and self.is_unsaved:
            # The name of a file that was never saved says nothing.
            return replace(shape, name=shape.object_name, named_after_file=False)
        return shape


def describe(path: Path, shape: SceneShape) -> Packed[NewShape[ShapeSignature]] | str:
    """Describe a shape with the model of a library.

    Parameters
    ----------
    path : Path
        The library.
    shape : SceneShape

    Returns
    -------
    described : Packed or str
        With its signature and thumbnail; a sentence if it cannot be described.

    Raises
    ------
    LibraryError
        If the library cannot be opened.
    """
    from shapegoogle_core.indexing import describe_shape

    model = open_library(path).model
    try:
        described = describe_shape(shape.read(), model)
    except MeshError as error:
        return str(error)
    names = tuple(placement.object_name for placement in described.placements)
    return Packed.of(described, model.identifier, names)


def store(
    address: LibraryAddress,
    source: str,
    size: int | None,
    roots: Sequence[str],
    shapes: Sequence[Packed[NewShape[ShapeSignature]]],
) -> None:
    """Store the shapes of a scene in place of those stored for it before; see `find_neighbours`.

    Parameters
    ----------
    address : LibraryAddress
        Of the library, which is a file.
    source : str
        The file of the scene, or the label of one that was never saved.
    size : int or None
        Of the file, in bytes.
    roots : sequence of str
        Folders or files to add to the roots of the library.
    shapes : sequence of Packed

    Raises
    ------
    LibraryError
        If the library cannot be written, or another model described the shapes.
    """
    from shapegoogle_core.library.library import Library

    described = [shape.unpacked() for shape in shapes]
    opened = address.open(read_only=False)
    assert isinstance(opened, Library)
    with opened as library, library.neighbours_later():
        library.add_roots(roots)
        # Without a time or a hash: what is indexed is not what is in the file, which is read again when its
        # folder is indexed.
        library.replace_source(source, size=size, mtime_ns=None, sha256=None, shapes=described)


def find_neighbours(path: Path) -> int:
    """Relate new shapes of a library to the others.

    If this is interrupted, the next run of indexing does it.

    Parameters
    ----------
    path : Path
        The library.

    Returns
    -------
    count : int
        Number of shapes in the library.

    Raises
    ------
    LibraryError
        If the library cannot be read or written.
    """
    from shapegoogle_core.library.library import Library

    with Library.open(path) as library:
        library.update_neighbours()
        return len(library)


def rename_source(path: Path, source: str, file: str) -> None:
    """Have the shapes of a scene that had never been saved become those of its file.

    Parameters
    ----------
    path : Path
        The library. Nothing happens if it is not there any more, or does not know the source.
    source : str
        The label of the scene.
    file : str
        Path of the file, which is added to the roots of the library.

    Raises
    ------
    LibraryError
        If the library cannot be read or written.
    """
    from shapegoogle_core.library.library import Library

    if not path.is_file():
        return
    with Library.open(path) as library:
        library.add_roots([file])
        library.rename_source(source, file)
