# SPDX-License-Identifier: MIT
"""Uploads: read and described in a worker process with limits of time and memory, never in the server."""

from __future__ import annotations

import asyncio
import json
import logging
import shutil
import tempfile
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from shapegoogle_core.errors import MeshError
from shapegoogle_core.indexing import ShapeReader
from shapegoogle_core.indexing.reading.describing import Failure, failure_of
from shapegoogle_core.indexing.reading.notes import FileNotes
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.storage.signature_file import signature_from_bytes, signature_to_bytes
from shapegoogle_core.model import ShapeModel, load_model
from shapegoogle_core.model.signature import ShapeSignature
from shapegoogle_core.processes.pool import CrashError, Pool, TimeLimitError
from shapegoogle_core.processes.temporary import temporary_folder
from shapegoogle_core.rendering import make_preview, thumbnail
from shapegoogle_core.service.settings import ServiceError, ServiceSettings, short_name
from shapegoogle_core.service.spool import Spool

__all__ = ["Uploaded", "UploadedShape", "Uploads", "safe_name"]

_LOG = logging.getLogger("shapegoogle.service")
# Shapes of a file that are described; a .3mf may have hundreds.
MOST_SHAPES = 20
_LONGEST_NAME = 100


@dataclass(frozen=True, eq=False)
class UploadedShape:
    """A shape of an upload, described.

    Attributes
    ----------
    name, object_name : str
    signature : ShapeSignature
        With its surface.
    thumbnail, preview : bytes or None
    """

    name: str
    object_name: str
    signature: ShapeSignature
    thumbnail: bytes | None
    preview: bytes | None


@dataclass(frozen=True, eq=False)
class Uploaded:
    """The shapes of an upload.

    Attributes
    ----------
    shapes : tuple of UploadedShape
    problems : tuple of str
        A sentence for each part that could not be read or was left out.
    """

    shapes: tuple[UploadedShape, ...]
    problems: tuple[str, ...]


class UploadDescriber:
    """Model of a worker process, and its one task.

    Parameters
    ----------
    model_file : Path
    memory_limit : int
        Megabytes, for messages.
    """

    def __init__(self, model_file: Path, memory_limit: int) -> None:
        self._model = load_model(model_file)
        self._memory_limit = memory_limit

    def describe(self, path: Path) -> Uploaded | Failure:
        """Read a file and describe its shapes.

        Parameters
        ----------
        path : Path
            Alone in its folder, which also takes temporary files.

        Returns
        -------
        uploaded : Uploaded or Failure
        """
        tempfile.tempdir = str(path.parent)
        shapes: list[UploadedShape] = []
        problems: list[str] = []
        try:
            with ShapeReader() as reader:
                for found in reader.iterate(path):
                    if isinstance(found, str):
                        problems.append(found)
                        continue
                    if isinstance(found, FileNotes):
                        continue
                    if len(shapes) == MOST_SHAPES:
                        problems.append(
                            f"only the first {MOST_SHAPES} shapes of {path.name!r} were described"
                        )
                        break
                    mesh = found.mesh
                    shapes.append(
                        UploadedShape(
                            found.name,
                            found.object_name,
                            self._model.describe(mesh, keep_surface=True),
                            thumbnail(mesh, up_axis=found.up_axis),
                            make_preview(mesh, found.up_axis),
                        )
                    )
                    problems += found.warnings
            if not shapes:
                reasons = "; ".join(problems)
                raise MeshError(
                    reasons or f"{path.name!r} has no mesh objects; choose a file with a shape in it"
                )
        except Exception as error:
            return failure_of(path.name, error, self._memory_limit)
        return Uploaded(tuple(shapes), tuple(dict.fromkeys(problems)))


class Uploads:
    """Reads uploads and keeps what was described in the spool.

    Parameters
    ----------
    settings : ServiceSettings
    spool : Spool
    model : ShapeModel
        Of the library.
    """

    def __init__(self, settings: ServiceSettings, spool: Spool, model: ShapeModel) -> None:
        self._settings = settings
        self._spool = spool
        self._resources = ExitStack()
        self.folder = self._resources.enter_context(temporary_folder())
        model_file = self.folder / "model.npz"
        model_file.write_bytes(model.to_bytes())
        self._model = model
        self._pool = Pool(
            1,
            settings.time_limit,
            memory_limit=settings.memory_limit,
            folder=self.folder,
            start=UploadDescriber,
            start_arguments=(model_file, settings.memory_limit),
        )
        self._resources.enter_context(self._pool)
        # The pool is used by one thread only, so uploads take turns.
        self._executor = ThreadPoolExecutor(1)
        self._waiting = 0

    async def describe(self, path: Path) -> tuple[str, Uploaded]:
        """Describe the shapes of a file, and keep them.

        Parameters
        ----------
        path : Path
            Alone in its folder, which is removed in any case.

        Returns
        -------
        name : str
            Name of the upload in the spool.
        uploaded : Uploaded

        Raises
        ------
        ServiceError
            422 if the file cannot be read, 504 if that takes too long, 503 if too many uploads wait.
        """
        if self._waiting >= self._settings.max_waiting:
            shutil.rmtree(path.parent, ignore_errors=True)
            raise ServiceError(503, "too many uploads are waiting; try again in a few seconds", retry_after=5)
        self._waiting += 1
        try:
            return await asyncio.get_running_loop().run_in_executor(self._executor, self._describe, path)
        finally:
            self._waiting -= 1

    def signature(self, library: Library, name: str, index: int) -> ShapeSignature:
        """Return the signature of a shape of an earlier upload.

        Parameters
        ----------
        library : Library
        name : str
            As a client sent it.
        index : int

        Returns
        -------
        signature : ShapeSignature
            As exact as when it was described.

        Raises
        ------
        ServiceError
            404 if there is none.
        """
        return signature_from_bytes(
            self._spool.get(name, f"{index}.sig"), library.model, short_name(library.name)
        )

    def close(self) -> None:
        """End the worker process and remove its files."""
        self._resources.close()
        self._executor.shutdown(wait=True)

    def _describe(self, path: Path) -> tuple[str, Uploaded]:
        try:
            uploaded = self._described(path)
        finally:
            shutil.rmtree(path.parent, ignore_errors=True)
        name = self._spool.new_name()
        for index, shape in enumerate(uploaded.shapes):
            self._spool.put(name, f"{index}.sig", signature_to_bytes(shape.signature, exact=True))
            for part, content in (("png", shape.thumbnail), ("preview", shape.preview)):
                if content is not None:
                    self._spool.put(name, f"{index}.{part}", content)
        listed = [[shape.name, shape.object_name] for shape in uploaded.shapes]
        self._spool.put(name, "names.json", json.dumps(listed).encode())
        return name, uploaded

    def _described(self, path: Path) -> Uploaded:
        task = self._pool.submit(UploadDescriber.describe, path)
        while not task.done:
            self._pool.finished()
        try:
            result = task.result()
        except TimeLimitError as error:
            raise ServiceError(
                504,
                f"{path.name!r} was not done after {self._settings.time_limit:g} s and given up; simplify it",
            ) from error
        except CrashError as error:
            raise ServiceError(
                422, f"{path.name!r} crashed the process that read it; export it again or simplify it"
            ) from error
        if isinstance(result, Failure):
            if result.details:
                _LOG.error("An upload failed: %s\n%s", result.reason, result.details)
            raise ServiceError(500 if result.details else 422, result.reason)
        return result


def safe_name(name: str) -> str:
    r"""Return the file name of an upload without folders and without what a file name cannot have.

    Parameters
    ----------
    name : str
        As a client sent it.

    Returns
    -------
    name : str
        Not empty; with the same suffix.

    Examples
    --------
    >>> from shapegoogle_core.service.uploads import safe_name
    >>> [safe_name(name) for name in ("../../etc/passwd", r"C:\models\oak chair.OBJ", "..", "")]
    ['passwd', 'oak chair.OBJ', 'upload', 'upload']
    """
    last = PurePosixPath(name.replace("\\", "/")).name
    cleaned = "".join(
        character if character.isprintable() and character not in '<>:"|?*/' else "_" for character in last
    )
    suffix = PurePosixPath(cleaned).suffix[:10]
    stem = cleaned.removesuffix(suffix)[:_LONGEST_NAME]
    while len(f"{stem}{suffix}".encode("utf-8", "replace")) > 200:
        stem = stem[:-1]
    return f"{stem}{suffix}" if stem.strip(" .") else "upload"
