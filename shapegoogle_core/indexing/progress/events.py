# SPDX-License-Identifier: MIT
"""What an indexing run reports: its progress, the outcome of each file, and a summary at the end."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from shapegoogle_core.api.text import counted, duration
from shapegoogle_core.indexing.reading.notes import LeftOut, left_out_sentence
from shapegoogle_core.mesh.io.other_formats import SkippedFormat

__all__ = ["FileOutcome", "IndexReport", "IndexSummary", "IndexingProgress"]


@dataclass(frozen=True)
class FileOutcome:
    """Outcome of indexing one file.

    Attributes
    ----------
    path : Path
        Absolute.
    status : str
        "added", "updated" (its content changed), "unchanged" or "failed".
    reason : str
        Why it failed, else empty.
    details : str
        The traceback of an unexpected error, else empty.
    shapes : int
        Number of its shapes that were stored.
    seconds : float
        Time that reading it and describing its shapes took, added up over the processes; 0 for a file
        that was not read.
    warnings : tuple of str
        Sentences of the reader on what it left out or assumed.
    left_out : tuple of LeftOut
        Objects that are no shapes.
    """

    path: Path
    status: Literal["added", "updated", "unchanged", "failed"]
    reason: str = ""
    details: str = ""
    shapes: int = 0
    seconds: float = 0.0
    warnings: tuple[str, ...] = ()
    left_out: tuple[LeftOut, ...] = ()


@dataclass(frozen=True)
class IndexingProgress:
    """Progress of an indexing run.

    Attributes
    ----------
    files_done, files_total : int
    bytes_done, bytes_total : int
        Of the files.
    shapes_done : int
        Number of shapes described so far in this run.
    shapes_waiting : int
        Number of shapes that have been read and wait to be described.
    shapes_expected : int
        Estimate of the number of shapes in the files that have not been read.
    seconds : float
        Since the start.
    seconds_left : float or None
        Estimate; None as long as too little is known.
    scene : bool
        Whether the open scene of Blender is indexed, not files.
    read_share : float or None
        Share of the objects that have been read of files that take long to read; None if there are none.
    """

    files_done: int
    files_total: int
    bytes_done: int
    bytes_total: int
    shapes_done: int = 0
    shapes_waiting: int = 0
    shapes_expected: int = 0
    seconds: float = 0.0
    seconds_left: float | None = None
    scene: bool = False
    read_share: float | None = None

    @property
    def share(self) -> float:
        """Share of the run's time that has passed, 0 to 1; 0 as long as too little is known."""
        if self.seconds_left is None:
            return 0.0
        whole = self.seconds + self.seconds_left
        return self.seconds / whole if whole > 0 else 1.0

    def sentence(self) -> str:
        """Describe the progress for people.

        Returns
        -------
        text : str
            Such as "351 of 352 files, 412 of about 2,350 shapes, 6 min left".
        """
        parts = [] if self.scene else [f"{self.files_done:,} of {counted(self.files_total, 'file')}"]
        if self.read_share is not None:
            parts.append(f"{self.read_share:.0%} of a large file read")
        left = self.shapes_waiting + self.shapes_expected
        shapes = self.shapes_done + left
        if self.seconds_left is None:
            # A file that has not been read may contain one shape or thousands.
            parts.append(counted(self.shapes_done, "shape"))
        elif shapes:
            about = "about " if self.shapes_expected else ""
            parts.append(f"{self.shapes_done:,} of {about}{counted(shapes, 'shape')}")
        if self.seconds_left is None:
            parts.append("estimating the time left")
        elif self.files_done == self.files_total and not left:
            parts.append("done")
        else:
            parts.append(f"{duration(self.seconds_left)} left")
        return ", ".join(parts)


@dataclass(frozen=True)
class IndexReport:
    """Summary of a run of `index_files`.

    Attributes
    ----------
    added, updated, unchanged : int
        Numbers of files.
    shapes : int
        Number of shapes that were stored.
    failed : list of (Path, str)
        Files that are not completely in the library, with the reasons.
    seconds : float
        Duration of the run.
    updated_shapes : int
        Number of shapes of the updated files alone.
    partial_shapes : int
        Number of shapes of files that count as failed since others of their shapes failed.
    warnings : list of (Path, str)
        Sentences of the readers on what they left out or assumed.
    left_out : tuple of LeftOut
        Objects of the added and updated files that are no shapes.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> report = sg.IndexReport(added=2, updated=0, unchanged=1, shapes=2, failed=[], seconds=0.5)
    >>> report.added + report.updated
    2
    """

    added: int
    updated: int
    unchanged: int
    shapes: int
    failed: list[tuple[Path, str]]
    seconds: float
    updated_shapes: int = 0
    partial_shapes: int = 0
    warnings: list[tuple[Path, str]] = field(default_factory=list)
    left_out: tuple[LeftOut, ...] = ()


@dataclass(frozen=True)
class IndexSummary:
    """What is shown at the end of an indexing run: its report, and what was done to the library besides.

    Attributes
    ----------
    added, updated, unchanged : int
        Numbers of files.
    added_shapes, updated_shapes : int
        Numbers of shapes of the added and the updated files.
    partial_shapes : int
        Number of shapes of files of which other shapes failed.
    failed : tuple of (str, str)
        Inputs that are not, or not completely, in the library, each with the reason.
    warnings : tuple of (str, str)
        Files with sentences of their readers on what was left out or assumed.
    removed : tuple of str
        Files that are gone and whose shapes were removed from the library.
    excluded : tuple of str
        Files and folders that were excluded.
    skipped : tuple of SkippedFormat
        Files in formats that are not read.
    left_out : tuple of LeftOut
        Objects that are no shapes.
    library_shapes : int
        Number of shapes that the library has now.
    seconds : float
        Duration of the run.
    scene : bool
        Whether the open scene of Blender was indexed, not files.
    """

    added: int = 0
    updated: int = 0
    unchanged: int = 0
    added_shapes: int = 0
    updated_shapes: int = 0
    partial_shapes: int = 0
    failed: tuple[tuple[str, str], ...] = ()
    warnings: tuple[tuple[str, str], ...] = ()
    removed: tuple[str, ...] = ()
    excluded: tuple[str, ...] = ()
    skipped: tuple[SkippedFormat, ...] = ()
    left_out: tuple[LeftOut, ...] = ()
    library_shapes: int = 0
    seconds: float = 0.0
    scene: bool = False

    def sentence(self) -> str:
        """Describe the result for people; each number with its noun.

        Returns
        -------
        text : str
            Such as "130 shapes added from 12 files, 3 files unchanged, 1 file failed; 3 objects skipped: 3
            lights".
        """
        left_out = left_out_sentence(self.left_out)
        return f"{self._counts()}; {left_out}" if left_out else self._counts()

    def _counts(self) -> str:
        failed = len(self.failed)
        parts = []
        if self.scene:
            parts.append(f"{counted(self.added_shapes, 'shape')} of this scene")
            if failed:
                parts.append(f"{counted(failed, 'object')} failed")
            return ", ".join(parts)
        if self.added:
            parts.append(f"{counted(self.added_shapes, 'shape')} added from {counted(self.added, 'file')}")
        if self.updated:
            shapes = counted(self.updated_shapes, "shape")
            parts.append(f"{shapes} updated from {counted(self.updated, 'file')}")
        for number, what in ((self.unchanged, "unchanged"), (len(self.removed), "removed")):
            if number:
                parts.append(f"{counted(number, 'file')} {what}")
        if failed:
            stored = f" ({counted(self.partial_shapes, 'shape')} stored)" if self.partial_shapes else ""
            parts.append(f"{counted(failed, 'input')} failed{stored}")
        if self.excluded:
            word = "file or folder" if len(self.excluded) == 1 else "files and folders"
            parts.append(f"{len(self.excluded):,} {word} excluded")
        if self.skipped:
            number = sum(each.files for each in self.skipped)
            formats = ", ".join(each.format for each in self.skipped)
            parts.append(f"{counted(number, 'file')} not read ({formats})")
        if self.warnings:
            parts.append(counted(len(self.warnings), "warning"))
        return ", ".join(parts) or "no files found"
