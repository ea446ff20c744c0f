# SPDX-License-Identifier: MIT
"""Progress on stderr: a bar on a terminal, a line now and then in a log."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterable, Iterator
from types import TracebackType
from typing import Self, TypeVar

from tqdm import tqdm

from shapegoogle_core.indexing import FileOutcome

__all__ = ["IndexProgress", "progress_bar"]

T = TypeVar("T")

SECONDS_BETWEEN_LINES = 10.0


class IndexProgress:
    """Shows how far `index_files` is, and each file that fails when it fails.

    Use it as a context manager and give it to `index_files` as `progress`.

    Parameters
    ----------
    total : int
        How many files there are.
    verbose : bool
        Also show the traceback of errors that nobody foresaw.
    events : bool
        Also print one line of JSON for each file on stdout, for a program that shows the progress:
        ``{"done": 3, "total": 8, "path": …, "status": "added", "reason": ""}``.
    """

    def __init__(self, total: int, *, verbose: bool = False, events: bool = False) -> None:
        self.done = 0
        self._events = events
        self._failed = 0
        self._total = total
        self._verbose = verbose
        self._started = self._last_line = time.monotonic()
        self._bar = tqdm(total=total, unit="file", disable=not sys.stderr.isatty(), dynamic_ncols=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bar.close()

    def __call__(self, outcome: FileOutcome) -> None:
        """Count a file."""
        self.done += 1
        if self._events:
            event = {
                "done": self.done,
                "total": self._total,
                "path": str(outcome.path),
                "status": outcome.status,
                "reason": outcome.reason,
            }
            print(json.dumps(event), flush=True)
        if outcome.status == "failed":
            self._failed += 1
            self._bar.set_postfix(failed=self._failed)
            self._write(f"skipped {outcome.path}: {outcome.reason}")
            if self._verbose and outcome.details:
                self._write(outcome.details)
        self._bar.update()
        now = time.monotonic()
        if self._bar.disable and now - self._last_line >= SECONDS_BETWEEN_LINES:
            self._last_line = now
            rate = self.done / (now - self._started)
            self._write(f"{self.done} of {self._total} files, {rate:.1f} per second, {self._failed} failed")

    def _write(self, text: str) -> None:
        with self._bar.external_write_mode(file=sys.stderr):
            print(text, file=sys.stderr, flush=True)


def progress_bar(iterable: Iterable[T], description: str, total: int | None = None) -> Iterable[T]:
    """Wrap an iterable in a bar on a terminal, a line elsewhere; what `train_model` takes as `progress`."""
    if not sys.stderr.isatty():
        return _lines(iterable, description, total)
    wrapped: Iterable[T] = tqdm(iterable, description, total, dynamic_ncols=True)
    return wrapped


def _lines(iterable: Iterable[T], description: str, total: int | None) -> Iterator[T]:
    of_all = "" if total is None else f" of {total}"
    print(f"{description} …", file=sys.stderr, flush=True)
    last_line = time.monotonic()
    for number, item in enumerate(iterable, start=1):
        yield item
        if time.monotonic() - last_line >= SECONDS_BETWEEN_LINES:
            last_line = time.monotonic()
            print(f"{description}: {number}{of_all}", file=sys.stderr, flush=True)
