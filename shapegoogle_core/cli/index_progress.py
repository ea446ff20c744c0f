# SPDX-License-Identifier: MIT
"""Progress of `shapegoogle index` on stderr: a bar on a terminal, an occasional line in a log."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Self

from tqdm import tqdm

from shapegoogle_core.cli.events import Event
from shapegoogle_core.cli.text import say, say_lines
from shapegoogle_core.indexing.progress.events import FileOutcome, IndexingProgress
from shapegoogle_core.processes.progress import SECONDS_BETWEEN_LINES

__all__ = ["IndexProgress"]

# Steps of the bar, which shows the share of the time.
STEPS = 1000


class IndexProgress:
    """Shows the progress of `index_files`, each failed file when it fails, and warnings.

    Use it as a context manager and give `outcome` to `index_files` as `progress`, and `status` as `status`.

    Parameters
    ----------
    total : int
        Number of files.
    verbose : bool
        Also show the traceback of unexpected errors.
    send : callable, optional
        Called with each event, for a program that shows the progress.

    Attributes
    ----------
    done : int
        Number of files counted so far.
    """

    def __init__(
        self, total: int, *, verbose: bool = False, send: Callable[[Event], None] | None = None
    ) -> None:
        self.done = 0
        self._failed = 0
        self._send = send
        self._verbose = verbose
        self._last_line = time.monotonic()
        self._status: IndexingProgress | None = None
        self._bar = tqdm(
            total=STEPS,
            desc=f"0 of {total} files",
            disable=not sys.stderr.isatty(),
            dynamic_ncols=True,
            bar_format="{percentage:3.0f}%|{bar}| {desc}{postfix}",
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.close()

    def outcome(self, outcome: FileOutcome) -> None:
        """Count a file.

        Parameters
        ----------
        outcome : FileOutcome
        """
        self.done += 1
        if self._send is not None:
            self._send(outcome)
        for warning in outcome.warnings:
            self._write(f"warning: {outcome.path}: {warning}")
        if outcome.status == "failed":
            self._failed += 1
            self._bar.set_postfix(failed=self._failed, refresh=False)
            self._write(f"skipped {outcome.path}: {outcome.reason}")
            if self._verbose and outcome.details:
                self._write(outcome.details, say_lines)

    def status(self, status: IndexingProgress) -> None:
        """Show the progress.

        Parameters
        ----------
        status : IndexingProgress
        """
        if self._send is not None:
            self._send(status)
        self._bar.n = max(self._bar.n, round(STEPS * status.share))
        self._bar.set_description_str(status.sentence())
        now = time.monotonic()
        if self._bar.disable and now - self._last_line >= SECONDS_BETWEEN_LINES:
            self._last_line = now
            self._write(f"{status.sentence()}, {self._failed} failed")

    def _write(self, text: str, write: Callable[[str], None] = say) -> None:
        with self._bar.external_write_mode(file=sys.stderr):
            write(text)
