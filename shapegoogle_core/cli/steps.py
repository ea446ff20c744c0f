# SPDX-License-Identifier: MIT
"""Progress of the steps of a command: on stderr, and to the program that has started the command."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

from shapegoogle_core.cli.events import Event, StepProgress
from shapegoogle_core.processes.progress import progress_bar

__all__ = ["StepReporter"]

T = TypeVar("T")

SECONDS_BETWEEN_EVENTS = 0.25


class StepReporter:
    """Reports the progress of loops; call it as `progress_bar`.

    Parameters
    ----------
    send : callable or None
        Called with a `StepProgress` at the beginning of each step and several times in a second.
    """

    def __init__(self, send: Callable[[Event], None] | None) -> None:
        self._send = send

    def __call__(self, iterable: Iterable[T], description: str, total: int | None = None) -> Iterable[T]:
        """Report the progress of a loop.

        Parameters
        ----------
        iterable : iterable
        description : str
            Name of the step.
        total : int, optional
            Number of items, where known.

        Returns
        -------
        iterable : iterable
            The same items.
        """
        shown = progress_bar(iterable, description, total)
        return shown if self._send is None else self._sending(self._send, shown, description, total)

    @staticmethod
    def _sending(
        send: Callable[[Event], None], items: Iterable[T], step: str, total: int | None
    ) -> Iterator[T]:
        sent = float("-inf")
        for done, item in enumerate(items):
            now = time.monotonic()
            if now - sent >= SECONDS_BETWEEN_EVENTS:
                sent = now
                send(StepProgress(step, done, total))
            yield item
