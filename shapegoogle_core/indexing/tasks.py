# SPDX-License-Identifier: MIT
"""What a worker process does: read a file, describe one of its shapes, within limits.

Between the two the shapes wait in a file on disk, so that neither process holds more than one at a time.
"""

from __future__ import annotations

import errno
import multiprocessing
import os
import sys
import tempfile
import threading
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from shapegoogle_core.errors import MeshError
from shapegoogle_core.indexing.readers import FoundShape, ReaderError
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeModel, load_model
from shapegoogle_core.model.signature import ShapeSignature
from shapegoogle_core.processes.launching import divert_output
from shapegoogle_core.rendering import thumbnail

__all__ = [
    "DescribedShape",
    "Failure",
    "ReadFile",
    "ReadFunction",
    "ReadShape",
    "describe_in_worker",
    "describe_shape",
    "read_in_worker",
    "start_worker",
]

ReadFunction = Callable[[Path], Iterator[FoundShape | str]]
"""As `iterate_shapes` without its reader."""


@dataclass(frozen=True, eq=False)
class DescribedShape:
    """What a worker makes of one shape.

    Attributes
    ----------
    object_name : str
        Of the object inside its file; empty for a file that is one shape.
    signature : ShapeSignature
    thumbnail : bytes or None
        A picture as PNG.
    """

    object_name: str
    signature: ShapeSignature
    thumbnail: bytes | None


@dataclass(frozen=True)
class Failure:
    """Why a file or shape could not be described.

    Attributes
    ----------
    reason : str
        One sentence for the user.
    details : str
        The traceback of an error nobody foresaw, else empty.
    lasting : bool
        Whether the file is to blame, so that it fails again as long as it does not change.
    """

    reason: str
    details: str = ""
    lasting: bool = True


@dataclass(frozen=True)
class ReadShape:
    """A shape that was read and waits on disk.

    Attributes
    ----------
    offset : int
        Where its arrays begin in the file of `ReadFile`, in bytes.
    name, object_name : str
        What errors call it, and its object inside its file.
    twin_of : int or None
        See `FoundShape`.
    up_axis : int or None
        See `FoundShape`.
    area : float
        In squared units.
    """

    offset: int
    name: str
    object_name: str
    twin_of: int | None
    up_axis: int | None
    area: float


@dataclass(frozen=True)
class ReadFile:
    """A file whose shapes wait on disk.

    Attributes
    ----------
    arrays : Path
        For each shape its vertices and its faces, as `numpy.save` writes them.
    shapes : tuple of ReadShape
    problems : tuple of str
        A sentence for each part that could not be read.
    """

    arrays: Path
    shapes: tuple[ReadShape, ...]
    problems: tuple[str, ...]


def describe_shape(shape: FoundShape, model: ShapeModel) -> DescribedShape:
    """Describe a shape and draw it.

    Parameters
    ----------
    shape : FoundShape
    model : ShapeModel

    Returns
    -------
    described : DescribedShape

    Raises
    ------
    MeshError
        If it cannot be described.
    """
    picture = thumbnail(shape.mesh, up_axis=shape.up_axis)
    return DescribedShape(shape.object_name, model.describe(shape.mesh), picture)


@dataclass(frozen=True)
class _Worker:
    """What a worker process was started with; its limit is in megabytes."""

    read: ReadFunction
    model: ShapeModel
    memory_limit: int


# Set once in each worker process.
_workers: list[_Worker] = []


def start_worker(read: ReadFunction, model_file: Path, memory_limit: int) -> None:
    """Prepare this process for its tasks.

    Parameters
    ----------
    read : callable
        See `ReadFunction`.
    model_file : Path
        In the folder of the run, where other programs that are started put their temporary files too.
    memory_limit : int
        Megabytes that one task may need.
    """
    threading.Thread(target=_end_with_parent, daemon=True).start()
    threadpool_limits(1)
    # What a library prints must not end up in the middle of `--json`.
    os.close(divert_output())
    # Who is killed cleans up nothing; the folder of the run goes away with the run.
    os.environ.update(dict.fromkeys(("TMPDIR", "TEMP", "TMP"), str(model_file.parent)))
    _workers[:] = [_Worker(read, load_model(model_file), memory_limit)]
    _limit_memory(memory_limit)


def _end_with_parent() -> None:
    """End this process when its parent is gone, killed perhaps: nobody else would stop it if it hangs."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _limit_memory(megabytes: int) -> None:
    """Let this process have so much memory on top of what it holds now, and leave no core file in a crash."""
    if sys.platform == "linux":
        import resource

        pages = int(Path("/proc/self/statm").read_text().split()[0])
        limit = pages * resource.getpagesize() + megabytes * 2**20
        _, hard = resource.getrlimit(resource.RLIMIT_AS)
        if hard == resource.RLIM_INFINITY or limit < hard:
            resource.setrlimit(resource.RLIMIT_AS, (limit, hard))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def read_in_worker(path: Path, folder: Path) -> ReadFile | Failure:
    """Read a file.

    Parameters
    ----------
    path : Path
    folder : Path
        For the shapes and all that is temporary; made here.

    Returns
    -------
    found : ReadFile or Failure
    """
    (worker,) = _workers
    try:
        folder.mkdir(exist_ok=True)
        tempfile.tempdir = str(folder)
        arrays = folder / "arrays"
        shapes: list[ReadShape] = []
        problems: list[str] = []
        with arrays.open("wb") as file:
            for found in worker.read(path):
                if isinstance(found, str):
                    problems.append(found)
                    continue
                mesh = found.mesh
                shapes.append(
                    ReadShape(
                        file.tell(), mesh.name, found.object_name, found.twin_of, found.up_axis, mesh.area
                    )
                )
                np.save(file, mesh.vertices)
                np.save(file, mesh.faces)
        return ReadFile(arrays, tuple(shapes), tuple(problems))
    except Exception as error:
        return _failure(path.name, error)


def describe_in_worker(arrays: Path, shape: ReadShape, name: str) -> DescribedShape | Failure:
    """Describe a shape that waits on disk.

    Parameters
    ----------
    arrays : Path
    shape : ReadShape
    name : str
        What errors call it.

    Returns
    -------
    described : DescribedShape or Failure
    """
    (worker,) = _workers
    try:
        with arrays.open("rb") as file:
            file.seek(shape.offset)
            vertices, faces = (np.load(file, allow_pickle=False) for _ in range(2))
        mesh = Mesh(vertices, faces, shape.name)
        return describe_shape(FoundShape(mesh, shape.object_name, None, shape.up_axis), worker.model)
    except Exception as error:
        return _failure(name, error)


def _failure(name: str, error: Exception) -> Failure:
    if isinstance(error, MemoryError) or isinstance(error.__cause__, MemoryError):
        limit = _workers[0].memory_limit
        return Failure(
            f"{name!r} needs more than {limit} MB of memory; simplify it or raise the memory limit"
        )
    if isinstance(error, MeshError):
        return Failure(str(error), lasting=not isinstance(error, ReaderError))
    if isinstance(error, OSError) and error.errno == errno.ENOSPC:
        place = tempfile.gettempdir()
        return Failure(f"{name!r} was not described: no room is left at '{place}'; make some", lasting=False)
    # Turned into text here: an exception of a library may not survive the way to the main process.
    return Failure(
        f"{name!r} cannot be described (unexpected {type(error).__name__}: {error})",
        "".join(traceback.format_exception(error)),
    )
