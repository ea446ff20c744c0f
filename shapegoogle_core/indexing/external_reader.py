# SPDX-License-Identifier: MIT
"""Another program, such as Blender, that reads files which this package does not.

The program is started once, reports that it is ready, and is asked for one file after the other. A request is
one line of JSON on its standard input::

    {"path": "…/scene.blend", "output": "…/shapes.bin", "memory_limit": 4096 or null, …options}

The limit is in megabytes, on top of what the program holds before its first request.

It writes the arrays of all shapes into the output file, for each its vertices (float32, x y z) and then its
triangles (int32), little-endian, in the coordinates of the objects that show it. It answers with one line of
JSON on its message pipe (see `shapegoogle_core.processes.messages`); it may print whatever it likes. A shape
has one placement for each object that shows it; "tags" may be left out. With "joined", all placements are
parts of one shape::

    {"ready": true}
    {"shapes": [{"name": "Cube", "vertices": 8, "faces": 12, "tags": ["prop"],
     "placements": [{"object": "Cube", "matrix": [16 numbers, row by row]}, …]}, …],
     "problems": ["'Cube' has …"], "joined": false, "up_axis": 2}
    {"error": "'scene.blend' is no Blender file"}
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.errors import MeshError
from shapegoogle_core.library.placement import placements_of
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.processes.program import Program
from shapegoogle_core.processes.temporary import temporary_folder

__all__ = ["ExternalReader", "ReaderError", "ReaderOption", "ReaderProcess"]

# Number of a program's last lines that an error message shows.
SHOWN_LINES = 5
# Seconds that a program may take to start.
START_LIMIT = 60.0


class ReaderError(MeshError):
    """The program that should read a file cannot be started: nothing is known about the file."""


@dataclass(frozen=True)
class ReaderOption:
    """An option that a reader's program offers; the command has an option of this name.

    Attributes
    ----------
    name : str
    choices : tuple of str
        The first is the default.
    summary : str
        For the command's help.
    """

    name: str
    choices: tuple[str, ...]
    summary: str


@dataclass(frozen=True)
class ExternalReader:
    """Another program that reads files which this package does not.

    Attributes
    ----------
    suffixes : frozenset of str
        Suffixes of the files it reads, in lower case with the dot.
    command : tuple of str
        The program and its arguments.
    title : str
        Its name in error messages.
    offers : tuple of ReaderOption
        Options that can be chosen.
    options : tuple of (str, str)
        Chosen options: names and values, sent along with every request.
    time_limit : float
        Seconds that it may take for one file, once it has started; it is killed then.
    memory_limit : int or None
        Megabytes that it may need for one file; the program itself has to enforce this.
    environment : tuple of (str, str)
        Environment variables for it, on top of this process's own.
    """

    suffixes: frozenset[str]
    command: tuple[str, ...]
    title: str
    offers: tuple[ReaderOption, ...] = ()
    options: tuple[tuple[str, str], ...] = ()
    time_limit: float = 300.0
    memory_limit: int | None = None
    environment: tuple[tuple[str, str], ...] = field(default=(), repr=False)

    def reads(self, path: Path) -> bool:
        """Whether the program reads such a file, by its suffix.

        Parameters
        ----------
        path : Path

        Returns
        -------
        reads : bool
        """
        return path.suffix.lower() in self.suffixes

    def choices_for(self, path: Path) -> str:
        """Write down the options that change the shapes of a file.

        Parameters
        ----------
        path : Path

        Returns
        -------
        choices : str
            Such as "+objects=assets"; empty if all options have their defaults.
        """
        if not self.reads(path):
            return ""
        defaults = {offer.name: offer.choices[0] for offer in self.offers}
        return "".join(f"+{name}={value}" for name, value in self.options if defaults.get(name) != value)


class ReaderProcess:
    """The running program of a reader, started at the first file and again after it died.

    Parameters
    ----------
    reader : ExternalReader
    """

    def __init__(self, reader: ExternalReader) -> None:
        self._reader = reader
        self._program: Program | None = None

    def read(self, path: Path) -> Iterator[NewShape[Mesh] | str]:
        """Read the shapes of a file one by one.

        Parameters
        ----------
        path : Path

        Yields
        ------
        shape : NewShape or str
            A sentence for a part that cannot be read.

        Raises
        ------
        MeshError
            If the file cannot be read.
        """
        with temporary_folder() as folder:
            output = folder / "shapes.bin"
            request = {
                "path": os.fspath(path.absolute()),
                "output": str(output),
                "memory_limit": self._reader.memory_limit,
                **dict(self._reader.options),
            }
            answer = self._ask(path, request)
            if "error" in answer:
                raise MeshError(str(answer["error"]))
            yield from _shapes(path, answer, output)

    def close(self) -> None:
        """End the program."""
        program, self._program = self._program, None
        if program is not None:
            program.close()

    def _ask(self, path: Path, request: Mapping[str, Any]) -> Mapping[str, Any]:
        program = self._started()
        program.printed.clear()
        program.send(request)
        try:
            answer = program.message(self._reader.time_limit)
        except TimeoutError as error:
            self.close()
            raise MeshError(
                f"{path.name!r} was not read by {self._reader.title} after {self._reader.time_limit:g} s and "
                "given up; simplify it or raise the time limit"
            ) from error
        if not isinstance(answer, dict):
            ending = program.ending(SHOWN_LINES)
            self.close()
            raise MeshError(
                f"{path.name!r} crashed {self._reader.title}, which read it ({ending}); open and save it "
                "again, or simplify it"
            )
        return answer

    def _started(self) -> Program:
        if self._program is not None and self._program.exit_code is not None:
            self.close()
        if self._program is None:
            try:
                self._program = Program(
                    self._reader.command,
                    environment={**os.environ, **dict(self._reader.environment)},
                    with_input=True,
                )
            except OSError as error:
                raise self._not_started(error.strerror or "the system refuses") from error
            try:
                ready = self._program.message(START_LIMIT)
            except TimeoutError as error:
                self.close()
                raise self._not_started("it reports nothing") from error
            if ready is None:
                ending = self._program.ending(SHOWN_LINES)
                self.close()
                raise self._not_started(ending)
        return self._program

    def _not_started(self, reason: str) -> ReaderError:
        return ReaderError(
            f"{self._reader.title} cannot be started ({reason}: {self._reader.command[0]!r}); install it "
            "again, or choose another one"
        )


def _shapes(path: Path, answer: Mapping[str, Any], output: Path) -> Iterator[NewShape[Mesh] | str]:
    """Read the arrays that the program wrote, one shape at a time."""
    yield from map(str, answer["problems"])
    up_axis = answer["up_axis"]
    parts: list[Mesh] = []
    with output.open("rb") as file:
        for record in answer["shapes"]:
            vertices = np.fromfile(file, "<f4", 3 * record["vertices"]).reshape(-1, 3)
            faces = np.fromfile(file, "<i4", 3 * record["faces"]).reshape(-1, 3)
            name = str(record["name"])
            objects = [
                (str(placement["object"]), np.array(placement["matrix"], np.float64).reshape(4, 4))
                for placement in record["placements"]
            ]
            try:
                if answer["joined"]:
                    parts += [_placed(vertices, faces, matrix, own) for own, matrix in objects]
                    continue
                mesh = _placed(vertices, faces, objects[0][1], name)
                placements = placements_of(mesh, objects)
            except MeshError as error:
                yield str(error)
                continue
            tags = tuple(map(str, record.get("tags", ())))
            yield NewShape(mesh, name, objects[0][0], tags=tags, placements=placements, up_axis=up_axis)
    if parts:
        yield NewShape(_joined(parts, path.name), path.name, up_axis=up_axis)


def _placed(vertices: NDArray[np.float32], faces: NDArray[np.int32], matrix: FloatArray, name: str) -> Mesh:
    """Transform a mesh to the coordinates of its file."""
    if np.linalg.det(matrix[:3, :3]) < 0:
        faces = faces[:, ::-1]  # a mirrored object would come out inside out
    return Mesh(vertices @ matrix[:3, :3].T + matrix[:3, 3], faces, name)


def _joined(meshes: Sequence[Mesh], name: str) -> Mesh:
    offsets = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.faces + offset for mesh, offset in zip(meshes, offsets, strict=False)]),
        name,
    )
