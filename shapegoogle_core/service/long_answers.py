# SPDX-License-Identifier: MIT
"""Answers that take longer than a request may: computed once for each state of the library, and kept."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from typing import Any

from shapegoogle_core.library.library import Library
from shapegoogle_core.library.storage.address import is_database
from shapegoogle_core.service.library_lanes import LibraryLanes

__all__ = ["LongAnswers", "state_of"]

# Seconds that a request waits for an answer before it is told to come again.
_PATIENCE = 5.0


class LongAnswers:
    """Computes answers one after the other in the background.

    Parameters
    ----------
    lanes : LibraryLanes
    """

    def __init__(self, lanes: LibraryLanes) -> None:
        self._lanes = lanes
        self._answers: dict[str, tuple[str, asyncio.Future[Any]]] = {}

    async def get(self, name: str, compute: Callable[[Library], Any]) -> Any | None:
        """Return an answer, or None while it is computed.

        Parameters
        ----------
        name : str
            Of the answer.
        compute : callable
            Called if the library has changed since the last time.

        Returns
        -------
        answer : object or None
        """
        state = await self._lanes.run("read", state_of)
        known = self._answers.get(name)
        if known is None or known[0] != state or (known[1].done() and known[1].exception() is not None):
            if known is not None and not known[1].done():
                # The library changes while somebody indexes: no second one before the first is done.
                return None
            future = self._lanes.start_long(compute)
            self._answers[name] = state, future
            known = state, future
        done, _ = await asyncio.wait([known[1]], timeout=_PATIENCE)
        return known[1].result() if done else None


def state_of(library: Library) -> str:
    """Return a text that changes when shapes or decisions of a library do."""
    info = library.info()
    decisions = library.decisions()
    numbers = [info[name] for name in ("shapes", "sources", "failed", "bytes")]
    # Indexing a file again may leave all numbers as they are.
    changed = 0 if is_database(library.name) else library.path.stat().st_mtime_ns
    return json.dumps([*numbers, changed, [decision.number for decision in decisions]])
