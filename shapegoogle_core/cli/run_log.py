# SPDX-License-Identifier: MIT
"""The log file of a run: one line per event, with time and level."""

from __future__ import annotations

import logging
import shlex
import sys
from collections.abc import Collection, Sequence
from datetime import datetime
from pathlib import Path

from shapegoogle_core.api.text import one_line
from shapegoogle_core.cli.events import CommandError, Event
from shapegoogle_core.cli.text import say
from shapegoogle_core.errors import ShapeGoogleError
from shapegoogle_core.indexing.progress.events import FileOutcome, IndexSummary
from shapegoogle_core.indexing.reading.notes import left_out_sentence

__all__ = ["RunLog"]

# Bytes of an existing file that are looked at: a text has no zero byte.
BEGINNING = 4096
_LEVELS = {"failed": logging.ERROR}


class _Formatter(logging.Formatter):
    def formatTime(self, record: logging.LogRecord, datefmt: str | None = None) -> str:  # noqa: ARG002
        return datetime.fromtimestamp(record.created).astimezone().isoformat(timespec="seconds")


class _Handler(logging.FileHandler):
    """Says once that the file can no longer be written, as on a full disk; the run goes on."""

    _said = False

    def handleError(self, record: logging.LogRecord) -> None:  # noqa: ARG002
        if not self._said:
            self._said = True
            error = sys.exc_info()[1]
            reason = error.strerror if isinstance(error, OSError) else "its disk may be full"
            say(f"warning: the log '{self.baseFilename}' can no longer be written: {reason}; the run goes on")


class RunLog:
    """Appends the events of a run to a file.

    Parameters
    ----------
    path : Path
        Created if it does not exist.
    other_files : collection of Path
        Files that it must not be: the library, and the inputs.
    suffixes : collection of str
        Suffixes of files that it must not have, in lower case: those of meshes.

    Raises
    ------
    ShapeGoogleError
        If the file cannot be written, or is no text.
    """

    def __init__(self, path: Path, other_files: Collection[Path], suffixes: Collection[str]) -> None:
        _check(path, other_files, suffixes)
        try:
            handler = _Handler(path, "a", encoding="utf-8", errors="backslashreplace")
        except OSError as error:
            raise ShapeGoogleError(
                f"the log '{path}' cannot be written: {error.strerror}; name a file in a folder that exists "
                "and is yours"
            ) from error
        handler.setFormatter(_Formatter("%(asctime)s %(levelname)-7s %(message)s"))
        # Not one of the loggers that all of the program shares: each run has its own file.
        self._logger = logging.Logger("shapegoogle")
        self._logger.addHandler(handler)

    def started(self, version: str, arguments: Sequence[str]) -> None:
        """Write down what was started.

        Parameters
        ----------
        version : str
        arguments : sequence of str
            Of the command.
        """
        self._write(logging.INFO, f"started: shapegoogle {version}: {shlex.join(arguments)}")

    def __call__(self, event: Event) -> None:
        """Write an event; progress is left out.

        Parameters
        ----------
        event : Event
        """
        match event:
            case FileOutcome():
                for warning in event.warnings:
                    self._write(logging.WARNING, f"{event.path}: {warning}")
                text = f"{event.status} {event.path}"
                if event.status == "failed":
                    text += f": {event.reason}"
                elif event.status != "unchanged":
                    text += f" ({event.shapes:,} shape{'' if event.shapes == 1 else 's'})"
                if event.left_out:
                    text += f"; {left_out_sentence(event.left_out)}"
                if event.seconds:
                    text += f" in {event.seconds:.2f} s"
                self._write(_LEVELS.get(event.status, logging.INFO), text, event.details)
            case IndexSummary():
                for path in event.removed:
                    self._write(logging.INFO, f"removed {path}")
                for path in event.excluded:
                    self._write(logging.INFO, f"excluded {path}")
                self._write(logging.INFO, f"finished in {event.seconds:.1f} s: {event.sentence()}")
            case CommandError():
                self.failed(event.reason)

    def failed(self, reason: str, details: str = "") -> None:
        """Write an error.

        Parameters
        ----------
        reason : str
        details : str, optional
            A traceback.
        """
        self._write(logging.ERROR, reason, details)

    def warn(self, text: str) -> None:
        """Write a warning.

        Parameters
        ----------
        text : str
        """
        self._write(logging.WARNING, text)

    def close(self) -> None:
        """Close the file."""
        for handler in self._logger.handlers:
            handler.close()

    def _write(self, level: int, text: str, details: str = "") -> None:
        # The lines of a traceback are indented: every other line begins with a time.
        lines = [one_line(text), *(f"    {one_line(line)}" for line in details.splitlines())]
        self._logger.log(level, "%s", "\n".join(lines))


def _check(path: Path, other_files: Collection[Path], suffixes: Collection[str]) -> None:
    """Refuse to append to what is no log."""
    if path.is_dir():
        raise ShapeGoogleError(f"the log '{path}' is a folder; name a file")
    if path.suffix.lower() in suffixes:
        raise ShapeGoogleError(
            f"the log '{path}' has the name of a mesh file; choose another, such as run.log"
        )
    if not path.exists():
        return
    if any(other.exists() and path.samefile(other) for other in other_files):
        raise ShapeGoogleError(f"the log '{path}' is a file that this run reads or writes; choose another")
    try:
        with path.open("rb") as file:
            is_text = b"\0" not in file.read(BEGINNING) if path.is_file() else True
    except OSError:  # it may be writable all the same
        return
    if not is_text:
        raise ShapeGoogleError(f"the log '{path}' exists and is no text; choose another, such as run.log")
