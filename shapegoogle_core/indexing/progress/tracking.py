# SPDX-License-Identifier: MIT
"""Keeping count of an indexing run, and reporting its progress now and then."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path

from shapegoogle_core.indexing.progress.events import IndexingProgress
from shapegoogle_core.indexing.progress.remaining import RemainingTime
from shapegoogle_core.processes.pool import Spent

__all__ = ["SECONDS_BETWEEN_REPORTS", "ProgressTracker"]

SECONDS_BETWEEN_REPORTS = 0.25
"""Seconds between two reports, at least; a run with nothing new reports about once in a second."""


class ProgressTracker:
    """Counts files, bytes and shapes of a run, and reports its progress.

    Parameters
    ----------
    report : callable or None
        Called with an `IndexingProgress`.
    """

    def __init__(self, report: Callable[[IndexingProgress], None] | None) -> None:
        self._report = report
        self._started = time.monotonic()
        self._reported = float("-inf")
        self._sizes: Mapping[Path, int] = {}
        self._files_done = self._bytes_done = 0
        self._remaining: RemainingTime | None = None
        self._reading: list[tuple[int, int]] = []

    def start(
        self,
        sizes: Mapping[Path, int],
        changed: Collection[Path],
        jobs: int,
        several_shapes: Collection[str],
    ) -> None:
        """Learn what there is to do.

        Parameters
        ----------
        sizes : mapping of Path to int
            Bytes of all files, those that have not changed too.
        changed : collection of Path
            Those that have to be opened.
        jobs : int
            Number of processes.
        several_shapes : collection of str
            Suffixes of files that may contain more than one shape.
        """
        self._sizes = sizes
        self._remaining = RemainingTime([(path, sizes[path]) for path in changed], jobs, several_shapes)
        self.report()

    def add(self, path: Path) -> None:
        """Learn of a file that has to be opened too; its size is known by now.

        Parameters
        ----------
        path : Path
        """
        if self._remaining is not None:
            self._remaining.add(path, self._sizes[path])

    def passed_over(self, path: Path) -> None:
        """Note that a file need not be read, since its content is known, or cannot be.

        Parameters
        ----------
        path : Path
        """
        if self._remaining is not None:
            self._remaining.passed_over(path, self._sizes[path])

    def read(self, path: Path, spent: Spent, meshes: Collection[int]) -> None:
        """Note that a file was read, or failed.

        Parameters
        ----------
        path : Path
        spent : Spent
        meshes : collection of int
            Bytes of each mesh that has to be described.
        """
        if self._remaining is not None:
            self._remaining.read(path, self._sizes[path], spent, meshes, time.monotonic())
        self.report()

    def reading(self, progress: Sequence[tuple[int, int]]) -> None:
        """Note how far the files have been read that are being read, as far as that is known.

        Parameters
        ----------
        progress : sequence of (int, int)
            For each the number of objects that have been read, and that of all.
        """
        self._reading = list(progress)

    def described(self, path: Path, mesh: int, spent: Spent) -> None:
        """Note that a shape was described, or failed.

        Parameters
        ----------
        path : Path
        mesh : int
            Bytes of its mesh.
        spent : Spent
        """
        if self._remaining is not None:
            self._remaining.described(path, self._sizes[path], mesh, spent, time.monotonic())
        self.report()

    def file_done(self, path: Path) -> None:
        """Note that a file needs no more work.

        Parameters
        ----------
        path : Path
        """
        self._files_done += 1
        self._bytes_done += self._sizes.get(path, 0)
        self.report()

    def report(self, *, always: bool = False) -> None:
        """Report the progress, unless that has just been done.

        Parameters
        ----------
        always : bool, optional
        """
        now = time.monotonic()
        if self._report is None or self._remaining is None:
            return
        if now - self._reported < SECONDS_BETWEEN_REPORTS and not always:
            return
        self._reported = now
        self._report(
            IndexingProgress(
                files_done=self._files_done,
                files_total=len(self._sizes),
                bytes_done=self._bytes_done,
                bytes_total=sum(self._sizes.values()),
                shapes_done=self._remaining.shapes_done,
                shapes_waiting=self._remaining.shapes_waiting,
                shapes_expected=self._remaining.shapes_expected(),
                seconds=now - self._started,
                seconds_left=self._remaining.seconds_left(now),
                read_share=_share(self._reading),
            )
        )


def _share(progress: Sequence[tuple[int, int]]) -> float | None:
    """Share of the objects of some files that have been read; None if there are none."""
    total = sum(total for _, total in progress)
    return sum(done for done, _ in progress) / total if total else None
