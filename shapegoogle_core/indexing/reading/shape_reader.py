# SPDX-License-Identifier: MIT
"""From a file to its shapes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from shapegoogle_core.errors import MeshError
from shapegoogle_core.indexing.reading.external_reader import ExternalReader, ReaderProcess
from shapegoogle_core.indexing.reading.naming import is_generic
from shapegoogle_core.indexing.reading.notes import NO_NOTES, FileNotes
from shapegoogle_core.library.placement import placements_of
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.io.objects import MeshObject, read_objects
from shapegoogle_core.mesh.io.reading import READERS

__all__ = ["FileShapes", "ShapeReader", "readable_suffixes"]


@dataclass(frozen=True)
class FileShapes:
    """The shapes of a file.

    Attributes
    ----------
    shapes : sequence of NewShape
        May be empty: many .blend files contain only materials or lights.
    problems : sequence of str
        A sentence for each part that could not be read.
    notes : FileNotes
        Objects that are no shapes, and files that it links.
    """

    shapes: Sequence[NewShape[Mesh]]
    problems: Sequence[str] = ()
    notes: FileNotes = NO_NOTES

    @property
    def warnings(self) -> list[str]:
        """Sentences of all shapes on what was left out, each once."""
        return list(dict.fromkeys(warning for shape in self.shapes for warning in shape.warnings))


def readable_suffixes(external: ExternalReader | None) -> frozenset[str]:
    """List the suffixes of all files that a `ShapeReader` reads.

    Parameters
    ----------
    external : ExternalReader or None

    Returns
    -------
    suffixes : frozenset of str
        In lower case with the dot; those of plug-ins too.
    """
    own = frozenset(READERS)
    return own if external is None else own | external.suffixes


class ShapeReader:
    """Reads the shapes of files, mesh files itself and others through another program.

    Use it as a context manager: the program keeps running from file to file until the block is left.

    Parameters
    ----------
    external : ExternalReader, optional
        Reads the files that have one of its suffixes.
    progress : callable, optional
        Called with the number of objects that the program has read of a file, and that of all, now and then.
    """

    def __init__(
        self,
        external: ExternalReader | None = None,
        progress: Callable[[int, int], None] | None = None,
    ) -> None:
        self._external = external
        self._process = None if external is None else ReaderProcess(external, progress)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()

    def close(self) -> None:
        """End the program, if it runs."""
        if self._process is not None:
            self._process.close()

    def read(self, path: str | Path) -> FileShapes:
        """Read all shapes of a file.

        Parameters
        ----------
        path : str or Path

        Returns
        -------
        found : FileShapes
            The objects of a .3mf; one shape without an object name of any other mesh file.

        Raises
        ------
        MeshError
            If the file cannot be read.
        """
        shapes: list[NewShape[Mesh]] = []
        problems: list[str] = []
        notes = FileNotes()
        for found in self.iterate(path):
            if isinstance(found, str):
                problems.append(found)
            elif isinstance(found, FileNotes):
                notes = found
            else:
                shapes.append(found)
        return FileShapes(shapes, problems, notes)

    def iterate(self, path: str | Path) -> Iterator[NewShape[Mesh] | FileNotes | str]:
        """Read the shapes of a file one by one.

        Parameters
        ----------
        path : str or Path

        Yields
        ------
        found : NewShape, FileNotes or str
            A sentence for a part that could not be read.

        Raises
        ------
        MeshError
            If the file cannot be read.
        """
        path = Path(path)
        if self._external is None or self._process is None or not self._external.reads(path):
            for found in read_objects(path):
                yield found if isinstance(found, str) else _shape(found)
            return
        if not path.is_file():
            raise MeshError(f"{str(path)!r} is not there, or is no file; check the spelling")
        yield from self._process.read(path)


def _shape(found: MeshObject) -> NewShape[Mesh]:
    mesh, name = found.mesh, found.object_name
    places = [(name, matrix) for matrix in found.matrices]
    return NewShape(
        mesh,
        mesh.name,
        name,
        placements=placements_of(mesh, places),
        warnings=found.warnings,
        named_after_file=bool(name) and is_generic(name),
    )
