# SPDX-License-Identifier: MIT
"""Reading and describing files in worker processes.

A task of the pool is to read one file, or to describe one shape of it: a file of many objects may take long,
all processes share them, and the limits hold for each.
"""

from __future__ import annotations

import shutil
import traceback
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from typing import Any, Self

from shapegoogle_core.indexing.progress.remaining import describing_order
from shapegoogle_core.indexing.progress.tracking import ProgressTracker
from shapegoogle_core.indexing.reading.describing import (
    Describer,
    Failure,
    ReadFile,
    ReadFunction,
    progress_of,
)
from shapegoogle_core.indexing.reading.external_reader import ExternalReader
from shapegoogle_core.indexing.reading.notes import NO_NOTES, FileNotes
from shapegoogle_core.indexing.settings import IndexSettings
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.signature import ShapeSignature
from shapegoogle_core.processes.pool import CrashError, Pool, PoolTask, Spent, TimeLimitError
from shapegoogle_core.processes.temporary import temporary_folder

__all__ = ["DescribedFile", "FilePool", "FinishedFile"]

# Number of problems of one file that are reported.
SHOWN_PROBLEMS = 20
# Seconds after which the progress is reported again although nothing is done.
SECONDS_WITHOUT_NEWS = 1.0


@dataclass(frozen=True, eq=False)
class DescribedFile:
    """The described shapes of one file.

    Attributes
    ----------
    shapes : tuple of NewShape
        Empty if the file contains no mesh, such as a .blend file of materials.
    problem : str
        A sentence on the parts that could not be described, else empty.
    notes : FileNotes
        Objects that are no shapes, and files that it links.
    """

    shapes: tuple[NewShape[ShapeSignature], ...]
    problem: str = ""
    notes: FileNotes = NO_NOTES


@dataclass(frozen=True, eq=False)
class FinishedFile:
    """A file that needs no more work.

    Attributes
    ----------
    path : Path
    result : DescribedFile or Failure
    seconds : float
        Time that reading and describing took, added up over the processes.
    """

    path: Path
    result: DescribedFile | Failure
    seconds: float


@dataclass(eq=False)
class _FileInWork:
    """A file that is read or described: its folder for temporary files, and the results so far."""

    path: Path
    folder: Path
    found: ReadFile = field(default_factory=lambda: ReadFile((), ()))
    described: dict[int, NewShape[ShapeSignature] | Failure] = field(default_factory=dict)
    mesh_sizes: list[int] = field(default_factory=list)
    seconds: float = 0.0

    def outcome(self) -> DescribedFile | Failure:
        """Summarise the file when all of its shapes are described."""
        failures = [Failure(problem) for problem in self.found.problems]
        described = [self.described[index] for index in range(len(self.found.shapes))]
        failures += [result for result in described if isinstance(result, Failure)]
        shapes = tuple(result for result in described if not isinstance(result, Failure))
        if not failures:
            return DescribedFile(shapes, notes=self.found.notes)
        reasons = _listed(failures)
        if not shapes:
            details = next((failure.details for failure in failures if failure.details), "")
            return Failure(reasons, details, lasting=all(failure.lasting for failure in failures))
        total = len(self.found.shapes) + len(self.found.problems)
        problem = f"{self.path.name!r}: {len(failures)} of {total} objects failed: {reasons}"
        return DescribedFile(shapes, problem, self.found.notes)


def _mesh_sizes(found: ReadFile) -> list[int]:
    """Bytes of each mesh on disk."""
    if not found.shapes:
        return []
    offsets = [shape.content.offset for shape in found.shapes]
    ends = [*offsets[1:], found.shapes[0].content.file.stat().st_size]
    return [end - offset for offset, end in zip(offsets, ends, strict=True)]


def _listed(failures: Sequence[Failure]) -> str:
    reasons = [failure.reason for failure in failures[:SHOWN_PROBLEMS]]
    if len(failures) > SHOWN_PROBLEMS:
        reasons.append(f"and {len(failures) - SHOWN_PROBLEMS} more")
    return "; ".join(reasons)


@dataclass(frozen=True, eq=False)
class _Step:
    """Reading a file, or describing one of its shapes."""

    file: _FileInWork
    shape: int | None = None

    @property
    def name(self) -> str:
        """Name for error messages."""
        return self.file.path.name if self.shape is None else self.file.found.shapes[self.shape].name


class FilePool:
    """A pool of processes that read and describe files.

    Use it as a context manager: leaving the block ends the processes, whatever they are doing, and removes
    their temporary files.

    Parameters
    ----------
    model : ShapeModel
    external : ExternalReader or None
        Reads files that this package does not.
    read : callable
        `ShapeReader.iterate`, or another function that a new Python process can import by its name.
    jobs : int
        Number of processes.
    settings : IndexSettings
        Limits of time and memory.
    tracker : ProgressTracker
        Learns of each file that is read and each shape that is described.
    """

    def __init__(
        self,
        model: ShapeModel,
        external: ExternalReader | None,
        read: ReadFunction,
        jobs: int,
        settings: IndexSettings,
        tracker: ProgressTracker,
    ) -> None:
        self._tracker = tracker
        self._external = external
        self._time_limit = settings.time_limit
        self._resources = ExitStack()
        self._folder = self._resources.enter_context(temporary_folder())
        model_file = self._folder / "model.npz"
        model_file.write_bytes(model.to_bytes())
        self._pool = Pool(
            jobs,
            settings.time_limit,
            memory_limit=settings.memory_limit,
            folder=self._folder,
            start=Describer,
            start_arguments=(model_file, external, read, settings.memory_limit),
        )
        self._numbers = count()
        self._files = 0
        self._steps: dict[PoolTask[Any], _Step] = {}

    def __enter__(self) -> Self:
        self._resources.enter_context(self._pool)
        return self

    def __exit__(self, *_error: object) -> None:
        self._resources.close()

    def __len__(self) -> int:
        """Return the number of submitted files that `finished` has not returned yet."""
        return self._files

    def submit(self, path: Path, *, first: bool = False) -> None:
        """Submit a file; the first one starts the processes.

        Parameters
        ----------
        path : Path
        first : bool, optional
            Whether it is read before files that are not, and before shapes of later files are described.
        """
        self._files += 1
        file = _FileInWork(path, self._folder / str(next(self._numbers)))
        # The program that reads it has a limit of its own, which begins anew whenever it gets on.
        limited = self._external is None or not self._external.reads(path)
        task = self._pool.submit(Describer.read, file.path, file.folder, first=first, limited=limited)
        self._steps[task] = _Step(file)

    def finished(self) -> list[FinishedFile]:
        """Wait until at least one file is done.

        Returns
        -------
        files : list of FinishedFile
            All that are done and were not returned before.

        Raises
        ------
        ShapeGoogleError
            If the processes die again and again before any task is done.
        """
        results: list[FinishedFile] = []
        while self._files and not results:
            for task in self._pool.finished(SECONDS_WITHOUT_NEWS):
                step = self._steps.pop(task)
                result, spent = self._result(step, task)
                outcome = self._take(step, result)
                self._track(step, spent)
                if outcome is not None:
                    results.append(FinishedFile(step.file.path, outcome, step.file.seconds))
                    self._files -= 1
                    shutil.rmtree(step.file.folder, ignore_errors=True)
            self._tracker.reading(self._being_read())
            self._tracker.report()
        return results

    def _being_read(self) -> list[tuple[int, int]]:
        """How many objects of the files that are being read have been read, and of how many."""
        folders = [step.file.folder for step in self._steps.values() if step.shape is None]
        return [progress for progress in map(progress_of, folders) if progress is not None]

    def _track(self, step: _Step, spent: Spent) -> None:
        file = step.file
        file.seconds += spent.seconds
        if step.shape is None:
            file.mesh_sizes = _mesh_sizes(file.found)
            self._tracker.read(file.path, spent, file.mesh_sizes)
        else:
            self._tracker.described(file.path, file.mesh_sizes[step.shape], spent)

    def _take(
        self, step: _Step, result: ReadFile | NewShape[ShapeSignature] | Failure
    ) -> DescribedFile | Failure | None:
        """Store the result of a step; returns the outcome of its file if it was the last one."""
        file = step.file
        if isinstance(result, ReadFile):
            file.found = result
            for index in describing_order(_mesh_sizes(result)):
                # Before files that wait to be read, so that few meshes wait on disk.
                task = self._pool.submit(Describer.describe, result.shapes[index], first=True)
                self._steps[task] = _Step(file, index)
        elif step.shape is not None:
            file.described[step.shape] = result
        elif isinstance(result, Failure):
            return result
        return file.outcome() if len(file.described) == len(file.found.shapes) else None

    def _result(
        self, step: _Step, task: PoolTask[Any]
    ) -> tuple[ReadFile | NewShape[ShapeSignature] | Failure, Spent]:
        try:
            result: ReadFile | NewShape[ShapeSignature] | Failure = task.result()
        except TimeLimitError:
            reason = (
                f"{step.name!r} was not done after {self._time_limit:g} s and given up; simplify it or raise "
                "the time limit"
            )
            return Failure(reason), Spent(self._time_limit)
        except CrashError as error:
            did = "read" if step.shape is None else "described"
            reason = (
                f"{step.name!r} crashed the process that {did} it ({error}); export it again or simplify it"
            )
            return Failure(reason, lasting=not error.asked), Spent()
        except Exception as error:
            reason = (
                f"{step.name!r} was lost by the process that worked on it; index it again, and report it "
                "with what --verbose shows if that happens again"
            )
            return Failure(reason, "".join(traceback.format_exception(error))), Spent()
        return result, task.spent
