# SPDX-License-Identifier: MIT
"""Another program, such as Blender, that reads files which this package does not.

The program is started once, reports that it is ready, and is asked for one file after the other. A request is
one line of JSON on its standard input::

    {"path": "…/scene.blend", "output": "…/shapes.bin", "memory_limit": 4096 or null, …options}

The limit is in megabytes, on top of what the program holds before its first request.

It writes the arrays of all meshes into the output file, for each its vertices (float32, x y z) and then its
triangles (int32), little-endian, in coordinates of their own. It answers with one line of JSON on its message
pipe (see `shapegoogle_core.processes.messages`); it may print whatever it likes. A shape is one mesh or
several, each with a matrix from its coordinates to those of the shape; it has one placement for each object
that shows it. All but its name, parts and placements may be left out. If each shape has one mesh of its own,
it may give its "vertices" and "faces" itself, in place of "meshes" and "parts". With "joined", all placements
are parts of one shape. Before its answer it may say how many of the file's objects it has read, and how many
there are; each time its time begins anew::

    {"ready": true}
    {"progress": [640, 2000]}
    {"meshes": [{"vertices": 8, "faces": 12}, …],
     "shapes": [{"name": "Cube", "type": "object", "names": ["Oak chair"], "tags": ["prop"],
     "catalog": "Props/Chairs", "color": [0.8, 0.2, 0.1], "frame": 10,
     "parts": [{"mesh": 0, "matrix": [16 numbers, row by row]}, …],
     "placements": [{"object": "Cube", "matrix": [16 numbers]}, …]}, …],
     "problems": ["'Cube' has …"], "left_out": {"light": 7}, "linked": ["…/props.blend"], "joined": false,
     "up_axis": 2}
    {"error": "'scene.blend' is no Blender file"}
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from shapegoogle_core.errors import MeshError
from shapegoogle_core.indexing.reading.answer import shapes_in
from shapegoogle_core.indexing.reading.notes import FileNotes
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.processes.program import Program
from shapegoogle_core.processes.temporary import temporary_folder

__all__ = ["DEFAULT_TIME_LIMIT", "ExternalReader", "ReaderError", "ReaderOption", "ReaderProcess"]

# Number of a program's last lines that an error message shows.
SHOWN_LINES = 5
# What programs print before they crash because they get no memory: Blender, those written in C++, and
# jemalloc, which cannot start its thread then.
OUT_OF_MEMORY = ("Malloc returns null", "std::bad_alloc", "<jemalloc>: background thread creation failed")
# Number of a program's last lines among which that is sought: jemalloc repeats itself.
SEARCHED_LINES = 50
# Seconds for which a program that starts may neither work nor print anything: a busy machine is slow.
START_PATIENCE = 120.0
DEFAULT_TIME_LIMIT = 300.0
"""Seconds for a file where nobody has chosen a limit."""


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
    numbers : bool
        Whether it is a list of whole numbers instead, such as "1,10,20".
    """

    name: str
    choices: tuple[str, ...]
    summary: str
    numbers: bool = False


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
    time_limit : float or None
        Seconds that it may take for one file, once it has started, without saying that it goes on; it is
        killed then. None for those of the run, or `DEFAULT_TIME_LIMIT`.
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
    time_limit: float | None = None
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
    progress : callable, optional
        Called with the number of objects that have been read, and that of all, while a file is read.
    """

    def __init__(self, reader: ExternalReader, progress: Callable[[int, int], None] | None = None) -> None:
        self._reader = reader
        self._progress = progress
        self._limit = DEFAULT_TIME_LIMIT if reader.time_limit is None else reader.time_limit
        self._program: Program | None = None
        # The present one: workers have another one for each file, which the program outlasts.
        self._folder = Path(tempfile.gettempdir())

    def read(self, path: Path) -> Iterator[NewShape[Mesh] | FileNotes | str]:
        """Read the shapes of a file one by one.

        Parameters
        ----------
        path : Path

        Yields
        ------
        shape : NewShape, FileNotes or str
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
            yield from shapes_in(path, answer, output)

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
            while isinstance(answer := program.message(self._limit), dict) and "progress" in answer:
                done, total = answer["progress"]
                if self._progress is not None:
                    self._progress(int(done), int(total))
        except TimeoutError as error:
            self.close()
            raise MeshError(
                f"{path.name!r} was given up, since {self._reader.title} did not get on with it for "
                f"{self._limit:g} s; simplify it or raise the time limit"
            ) from error
        if not isinstance(answer, dict):
            ending, printed = program.ending(SHOWN_LINES), program.ending(SEARCHED_LINES)
            self.close()
            if any(sign in printed for sign in OUT_OF_MEMORY):
                limit = self._reader.memory_limit
                needs = "more memory than there is" if limit is None else f"more than {limit} MB of memory"
                raise MeshError(f"{path.name!r} needs {needs}; simplify it or raise the memory limit")
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
                    within=self._folder,
                )
            except OSError as error:
                raise self._not_started(error.strerror or "the system refuses") from error
            try:
                ready = self._program.message(patience=START_PATIENCE)
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
