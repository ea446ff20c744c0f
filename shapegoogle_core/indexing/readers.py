# SPDX-License-Identifier: MIT
"""From a file to its shapes: mesh files are read here, others by another program, such as Blender.

The other program is started once, says that it is there, and is asked for one file after the other. A request
is one line of JSON on its standard input::

    {"path": "…/scene.blend", "output": "…/shapes.bin", "memory_limit": 4096 or null, …options}

The limit is in megabytes, on top of what the program holds before its first request.

It writes the arrays of all shapes into the output file, for each its vertices (float32, x y z) and then its
triangles (int32), little-endian, and answers with one line on its standard output that begins with
`ANSWER`; other lines are its own affair. With "joined", all shapes are parts of one::

    shapegoogle-answer {"ready": true}
    shapegoogle-answer {"shapes": [{"name": "Cube", "vertices": 8, "faces": 12, "matrix": [16 numbers, row by
    row], "twin_of": null}, …], "problems": ["'Cube' has …"], "joined": false, "up_axis": 2}
    shapegoogle-answer {"error": "'scene.blend' is no Blender file"}
"""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
import threading
import time
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh import MESH_SUFFIXES, Mesh, read_mesh
from shapegoogle_core.processes.launching import NO_WINDOW, without_memory_limit

__all__ = [
    "ANSWER",
    "ExternalReader",
    "FileShapes",
    "FoundShape",
    "ReaderError",
    "ReaderOption",
    "end_external_readers",
    "iterate_shapes",
    "read_shapes",
    "readable_suffixes",
]

ANSWER = "shapegoogle-answer "
# How long a program may take to end when its input is closed, in seconds.
PATIENCE = 5.0
# So many of the last lines that a program printed are kept, to say why it ended.
KEPT_LINES = 5


class ReaderError(MeshError):
    """The program that should read a file cannot be started: nothing is known of the file."""


@dataclass(frozen=True, eq=False)
class FoundShape:
    """A shape in a file.

    Attributes
    ----------
    mesh : Mesh
    object_name : str
        Of the object inside the file; empty for a file that is one shape.
    twin_of : int or None
        Index of an earlier shape of the same file that differs only by a motion, a mirroring or one factor
        of scale.
    up_axis : int or None
        Which axis points up, 1 or 2, if the file says so.
    """

    mesh: Mesh
    object_name: str = ""
    twin_of: int | None = None
    up_axis: int | None = None


@dataclass(frozen=True)
class FileShapes:
    """What a file holds.

    Attributes
    ----------
    shapes : sequence of FoundShape
        May be empty: many .blend files hold only materials or lights.
    problems : sequence of str
        A sentence for each part that could not be read.
    """

    shapes: Sequence[FoundShape]
    problems: Sequence[str] = ()


@dataclass(frozen=True)
class ReaderOption:
    """A choice that a reader's program offers; the command has an option of this name.

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
        Of the files it reads, in lower case with the dot.
    command : tuple of str
        How it is started.
    title : str
        What errors call it.
    offers : tuple of ReaderOption
        What can be chosen.
    options : tuple of (str, str)
        What was chosen: names and values, sent along with every request.
    time_limit : float
        Seconds that it may take for one file; it is killed then.
    memory_limit : int or None
        Megabytes that it may need for one file; it has to see to that itself.
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
        """Whether this program reads such a file."""
        return path.suffix.lower() in self.suffixes

    def choices_for(self, path: Path) -> str:
        """Write down the options that decide what a file gives; empty if all are the usual ones."""
        if not self.reads(path):
            return ""
        usual = {offer.name: offer.choices[0] for offer in self.offers}
        return "".join(f"+{name}={value}" for name, value in self.options if usual.get(name) != value)


def read_shapes(path: str | Path, reader: ExternalReader | None = None) -> FileShapes:
    """Read all shapes of a file.

    Parameters
    ----------
    path : str or Path
    reader : ExternalReader, optional
        For the files that have one of its suffixes. Its program goes on running, for the next file, until
        `end_external_readers` or the end of this process.

    Returns
    -------
    found : FileShapes
        One shape without an object name if this package itself reads such files.

    Raises
    ------
    MeshError
        If the file cannot be read.
    """
    shapes: list[FoundShape] = []
    problems: list[str] = []
    for found in iterate_shapes(path, reader):
        if isinstance(found, str):
            problems.append(found)
        else:
            shapes.append(found)
    return FileShapes(shapes, problems)


def iterate_shapes(path: str | Path, reader: ExternalReader | None = None) -> Iterator[FoundShape | str]:
    """Read the shapes of a file one by one; otherwise as `read_shapes`.

    Parameters
    ----------
    path : str or Path
    reader : ExternalReader, optional

    Yields
    ------
    found : FoundShape or str
        A sentence for a part that could not be read.

    Raises
    ------
    MeshError
        If the file cannot be read.
    """
    path = Path(path)
    if reader is None or not reader.reads(path):
        yield FoundShape(read_mesh(path))
        return
    if not path.is_file():
        raise MeshError(f"{str(path)!r} is not there, or is no file; check the spelling")
    yield from _programs.setdefault(reader, _Process(reader)).read(path)


def readable_suffixes(reader: ExternalReader | None) -> frozenset[str]:
    """Suffixes of all files that `read_shapes` reads."""
    return MESH_SUFFIXES if reader is None else MESH_SUFFIXES | reader.suffixes


def end_external_readers() -> None:
    """End the programs that `read_shapes` started."""
    while _programs:
        _, program = _programs.popitem()
        program.end()


class _Process:
    """A reader's program, started at the first file and again when it died."""

    def __init__(self, reader: ExternalReader) -> None:
        self._reader = reader
        self._program: subprocess.Popen[str] | None = None

    def read(self, path: Path) -> Iterator[FoundShape | str]:
        with tempfile.TemporaryDirectory(prefix="shapegoogle-", ignore_cleanup_errors=True) as folder:
            output = Path(folder, "shapes.bin")
            request = {
                "path": os.fspath(path.absolute()),
                "output": str(output),
                "memory_limit": self._reader.memory_limit,
                **dict(self._reader.options),
            }
            answer = self._ask(path, json.dumps(request))
            if "error" in answer:
                raise MeshError(str(answer["error"]))
            yield from _shapes(path, answer, output)

    def end(self) -> None:
        """Close the program's input, which ends it, or else kill it."""
        if self._program is None:
            return
        program, self._program = self._program, None
        assert program.stdin is not None
        assert program.stdout is not None
        with suppress(BrokenPipeError):  # it is gone already, which was wanted
            program.stdin.close()
        try:
            program.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            program.kill()
            program.wait()
        program.stdout.close()

    def _ask(self, path: Path, request: str) -> Mapping[str, Any]:
        deadline = time.monotonic() + self._reader.time_limit
        program = self._started(deadline)
        assert program.stdin is not None
        with suppress(BrokenPipeError):  # it died; its last words say how
            print(request, file=program.stdin, flush=True)
        answer, ending = self._answer(program, deadline)
        if answer is not None:
            return answer
        if not ending:
            raise MeshError(
                f"{path.name!r} was not read by {self._reader.title} after {self._reader.time_limit:g} s and "
                "given up; simplify it or raise the time limit"
            )
        raise MeshError(
            f"{path.name!r} crashed {self._reader.title}, which read it ({ending}); open and save it again, "
            "or simplify it"
        )

    def _answer(
        self, program: subprocess.Popen[str], deadline: float
    ) -> tuple[Mapping[str, Any] | None, str]:
        """Wait for an answer; without one the program has ended, as the text says, or was late: no text."""
        assert program.stdout is not None
        timed_out = threading.Event()

        def give_up() -> None:
            timed_out.set()
            program.kill()

        timer = threading.Timer(max(deadline - time.monotonic(), 0.0), give_up)
        timer.start()
        last_lines: deque[str] = deque(maxlen=KEPT_LINES)
        try:
            for line in program.stdout:
                if line.startswith(ANSWER):
                    answer: Mapping[str, Any] = json.loads(line[len(ANSWER) :])
                    return answer, ""
                last_lines.append(line.strip())
        finally:
            timer.cancel()
        self.end()
        printed = "; ".join(line for line in last_lines if line)
        ending = f"exit code {program.returncode}{', last words: ' + printed if printed else ''}"
        return None, "" if timed_out.is_set() else ending

    def _started(self, deadline: float) -> subprocess.Popen[str]:
        if self._program is not None and self._program.poll() is not None:
            self.end()
        if self._program is None:
            try:
                # Its limit is its own affair: a Blender reserves far more than it uses.
                with without_memory_limit():
                    self._program = subprocess.Popen(
                        self._reader.command,
                        stdin=subprocess.PIPE,
                        stdout=subprocess.PIPE,
                        # What it prints there must not end up among the lines of this program.
                        stderr=subprocess.STDOUT,
                        encoding="utf-8",
                        errors="replace",
                        creationflags=NO_WINDOW,
                        env={**os.environ, **dict(self._reader.environment)},
                    )
            except OSError as error:
                raise ReaderError(
                    f"{self._reader.title} cannot be started ({error.strerror or error}: "
                    f"{self._reader.command[0]!r}); install it, or name another one"
                ) from error
            answer, ending = self._answer(self._program, deadline)
            if answer is None:
                raise ReaderError(
                    f"{self._reader.title} cannot be started ({ending or 'it says nothing'}: "
                    f"{self._reader.command[0]!r}); install it again, or name another one"
                )
        return self._program


# The programs that this process has started.
_programs: dict[ExternalReader, _Process] = {}


def _shapes(path: Path, answer: Mapping[str, Any], output: Path) -> Iterator[FoundShape | str]:
    """Take the arrays out of the file that the program wrote, one shape at a time."""
    yield from map(str, answer["problems"])
    up_axis = answer["up_axis"]
    parts: list[Mesh] = []
    places: dict[int, int] = {}  # of the program's shapes among those that are none of the problems
    with output.open("rb") as file:
        for index, record in enumerate(answer["shapes"]):
            vertices = np.fromfile(file, "<f4", 3 * record["vertices"]).reshape(-1, 3)
            faces = np.fromfile(file, "<i4", 3 * record["faces"]).reshape(-1, 3)
            matrix = np.array(record["matrix"], np.float64).reshape(4, 4)
            if np.linalg.det(matrix[:3, :3]) < 0:
                faces = faces[:, ::-1]  # a mirrored object would come out inside out
            name = str(record["name"])
            try:
                mesh = Mesh(vertices @ matrix[:3, :3].T + matrix[:3, 3], faces, name)
            except MeshError as error:
                yield str(error)
                continue
            if answer["joined"]:
                parts.append(mesh)
                continue
            twin_of = places.get(record["twin_of"])
            places[index] = len(places)
            yield FoundShape(mesh, name, twin_of, up_axis)
    if parts:
        yield FoundShape(_joined(parts, path.name), up_axis=up_axis)


def _joined(meshes: Sequence[Mesh], name: str) -> Mesh:
    offsets = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.faces + offset for mesh, offset in zip(meshes, offsets, strict=False)]),
        name,
    )
