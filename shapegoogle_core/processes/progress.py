# SPDX-License-Identifier: MIT
"""Progress on stderr: a bar on a terminal, an occasional line in a log."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable, Iterator
from typing import TypeVar

__all__ = ["SECONDS_BETWEEN_LINES", "progress_bar"]

T = TypeVar("T")

SECONDS_BETWEEN_LINES = 10.0
"""Seconds between two lines of progress where stderr is not a terminal."""


def progress_bar(iterable: Iterable[T], description: str, total: int | None = None) -> Iterable[T]:
    """Show the progress of a loop: a bar on a terminal, lines elsewhere.

    Parameters
    ----------
    iterable : iterable
    description : str
        Text in front of the bar.
    total : int, optional
        Number of items, where known.

    Returns
    -------
    iterable : iterable
        The same items.
    """
    if not sys.stderr.isatty():
        return _lines(iterable, description, total)
    from tqdm import tqdm

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
