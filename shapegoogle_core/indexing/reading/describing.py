# SPDX-License-Identifier: MIT
"""Work on one file in a worker process: reading it, and describing one of its shapes.

Between the two steps the meshes wait in a file on disk, so that no process holds more than one at a time.
"""

from __future__ import annotations

import errno
import tempfile
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from shapegoogle_core.errors import MeshError, PluginError
from shapegoogle_core.indexing.reading.external_reader import ExternalReader, ReaderError
from shapegoogle_core.indexing.reading.notes import NO_NOTES, FileNotes
from shapegoogle_core.indexing.reading.shape_reader import ShapeReader
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeModel, load_model
from shapegoogle_core.model.signature import ShapeSignature
from shapegoogle_core.rendering import make_preview, thumbnail

__all__ = [
    "Describer",
    "Failure",
    "MeshOnDisk",
    "ReadFile",
    "ReadFunction",
    "describe_shape",
    "failure_of",
    "progress_of",
]

# Width of pictures: the largest that Blender's gallery shows.
_PICTURE = 256
# Name of the file that says how far a file has been read.
_PROGRESS = "progress"

ReadFunction = Callable[[ShapeReader, Path], Iterator[NewShape[Mesh] | FileNotes | str]]
"""`ShapeReader.iterate` or a function like it."""


@dataclass(frozen=True)
class Failure:
    """Reason why a file or shape could not be described.

    Attributes
    ----------
    reason : str
        One sentence for the user.
    details : str
        The traceback of an unexpected error, else empty.
    lasting : bool
        Whether the file is to blame, so that it fails again as long as it does not change.
    """

    reason: str
    details: str = ""
    lasting: bool = True


@dataclass(frozen=True)
class MeshOnDisk:
    """A mesh that was read and waits to be described.

    Attributes
    ----------
    file : Path
        Contains the vertices and the faces, as `numpy.save` writes them.
    offset : int
        Start of its arrays in the file, in bytes.
    """

    file: Path
    offset: int


@dataclass(frozen=True)
class ReadFile:
    """A file whose meshes wait on disk.

    Attributes
    ----------
    shapes : tuple of NewShape
    problems : tuple of str
        A sentence for each part that could not be read.
    notes : FileNotes
    """

    shapes: tuple[NewShape[MeshOnDisk], ...]
    problems: tuple[str, ...]
    notes: FileNotes = NO_NOTES


def describe_shape(shape: NewShape[Mesh], model: ShapeModel) -> NewShape[ShapeSignature]:
    """Describe a shape, draw its thumbnail and make its preview.

    Parameters
    ----------
    shape : NewShape
        With its mesh.
    model : ShapeModel

    Returns
    -------
    described : NewShape
        With its signature, thumbnail and preview.

    Raises
    ------
    MeshError
        If it cannot be described.
    """
    picture = thumbnail(shape.mesh, _PICTURE, shape.color, shape.up_axis)
    preview = make_preview(shape.mesh, shape.up_axis)
    return shape.with_content(model.describe(shape.mesh), picture, preview)


class Describer:
    """A worker process's model and reader, and its two tasks.

    Parameters
    ----------
    model_file : Path
    external : ExternalReader or None
        Reads files that this package does not.
    read : callable
        See `ReadFunction`.
    memory_limit : int
        Megabytes that one task may need, for messages.
    """

    def __init__(
        self, model_file: Path, external: ExternalReader | None, read: ReadFunction, memory_limit: int
    ) -> None:
        self._model = load_model(model_file)
        self._reader = ShapeReader(external, self._note_progress)
        self._folder: Path | None = None
        self._read = read
        self._memory_limit = memory_limit

    def read(self, path: Path, folder: Path) -> ReadFile | Failure:
        """Read a file.

        Parameters
        ----------
        path : Path
        folder : Path
            For the meshes and all temporary files; created here.

        Returns
        -------
        found : ReadFile or Failure
        """
        try:
            folder.mkdir(exist_ok=True)
            tempfile.tempdir, self._folder = str(folder), folder
            shapes: list[NewShape[MeshOnDisk]] = []
            problems: list[str] = []
            notes = FileNotes()
            arrays = folder / "arrays"
            with arrays.open("wb") as file:
                for found in self._read(self._reader, path):
                    if isinstance(found, str):
                        problems.append(found)
                        continue
                    if isinstance(found, FileNotes):
                        notes = found
                        continue
                    mesh = found.mesh
                    waiting = MeshOnDisk(arrays, file.tell())
                    shapes.append(found.with_content(waiting))
                    np.save(file, mesh.vertices)
                    np.save(file, mesh.faces)
            return ReadFile(tuple(shapes), tuple(problems), notes)
        except Exception as error:
            return failure_of(path.name, error, self._memory_limit)

    def _note_progress(self, done: int, total: int) -> None:
        """Leave word for the process that shows the progress, see `progress_of`."""
        if self._folder is not None:
            written = self._folder / f"{_PROGRESS}.new"
            written.write_text(f"{done} {total}", encoding="ascii")
            written.replace(self._folder / _PROGRESS)

    def describe(self, shape: NewShape[MeshOnDisk]) -> NewShape[ShapeSignature] | Failure:
        """Describe a shape whose mesh waits on disk.

        Parameters
        ----------
        shape : NewShape

        Returns
        -------
        described : NewShape or Failure
        """
        try:
            with shape.content.file.open("rb") as file:
                file.seek(shape.content.offset)
                vertices, faces = (np.load(file, allow_pickle=False) for _ in range(2))
            return describe_shape(shape.with_content(Mesh(vertices, faces, shape.name)), self._model)
        except Exception as error:
            return failure_of(shape.name, error, self._memory_limit)


def progress_of(folder: Path) -> tuple[int, int] | None:
    """Say how far a file has been read.

    Parameters
    ----------
    folder : Path
        That `Describer.read` was given.

    Returns
    -------
    progress : (int, int) or None
        Number of objects that have been read, and of all; None if nothing is known.
    """
    try:
        done, total = map(int, (folder / _PROGRESS).read_text(encoding="ascii").split())
    except (OSError, ValueError):  # not begun, or not replaced while it was read, as Windows may refuse
        return None
    return done, total


def failure_of(name: str, error: Exception, memory_limit: int) -> Failure:
    """Turn an error into the reason why a file or shape could not be described.

    Parameters
    ----------
    name : str
        Of the file or shape.
    error : Exception
    memory_limit : int
        Megabytes that the task could use.

    Returns
    -------
    failure : Failure
    """
    if isinstance(error, MemoryError) or isinstance(error.__cause__, MemoryError):
        return Failure(
            f"{name!r} needs more than {memory_limit} MB of memory; simplify it or raise the memory limit"
        )
    if isinstance(error, MeshError):
        return Failure(str(error), lasting=not isinstance(error, (ReaderError, PluginError)))
    if isinstance(error, PluginError):
        return Failure(str(error), lasting=False)
    if isinstance(error, OSError) and error.errno == errno.ENOSPC:
        place = tempfile.gettempdir()
        return Failure(
            f"{name!r} was not described: the disk of '{place}' is full; free some space", lasting=False
        )
    # Turned into text here: an exception of a library may not be picklable.
    return Failure(
        f"{name!r} cannot be described because of a fault in Shape Google, not in the file; report it with "
        "what --verbose shows",
        "".join(traceback.format_exception(error)),
    )
