# SPDX-License-Identifier: MIT
"""Answers that take longer than a request may: computed once for each state of the library, and kept."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from shapegoogle_core.library.library import Library
from shapegoogle_core.library.storage.address import is_database
from shapegoogle_core.service.library_lanes import LibraryLanes

__all__ = ["LibraryState", "LongAnswers", "state_of"]

# Seconds that a request waits for an answer before it is told to come again.
_PATIENCE = 5.0


@dataclass(frozen=True)
class LibraryState:
    """What tells whether an answer is still right.

    Attributes
    ----------
    shapes : tuple
        Changes when shapes do.
    decisions : tuple of int
        Numbers of all decisions.
    """

    shapes: tuple[object, ...]
    decisions: tuple[int, ...]


class LongAnswers:
    """Computes answers one after the other in the background.

    While somebody indexes, shapes change all the time: then the last answer is returned, and the next one
    computed. After a decision there is a new answer, since whoever decided wants to see the effect.

    Parameters
    ----------
    lanes : LibraryLanes
    """

    def __init__(self, lanes: LibraryLanes) -> None:
        self._lanes = lanes
        self._known: dict[str, tuple[LibraryState, Any]] = {}
        self._running: dict[str, tuple[LibraryState, asyncio.Future[Any]]] = {}

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
        self._collect(name)
        if name in self._known and self._known[name][0] == state:
            return self._known[name][1]
        if name not in self._running:
            self._running[name] = state, self._lanes.start_long(compute)
        if self._is_useful(name, state):
            return self._known[name][1]
        await asyncio.wait([self._running[name][1]], timeout=_PATIENCE)
        self._collect(name)
        return self._known[name][1] if self._is_useful(name, state) else None

    def _is_useful(self, name: str, state: LibraryState) -> bool:
        return name in self._known and self._known[name][0].decisions == state.decisions

    def _collect(self, name: str) -> None:
        """Keep the answer that was computed, if it is done; raises what the computation has raised."""
        if name in self._running and self._running[name][1].done():
            state, future = self._running.pop(name)
            self._known[name] = state, future.result()


def state_of(library: Library) -> LibraryState:
    """Return what tells whether an answer about a library is still right.

    Parameters
    ----------
    library : Library

    Returns
    -------
    state : LibraryState
    """
    info = library.info()
    # Indexing a file again may leave all numbers as they are.
    changed = 0 if is_database(library.name) else library.path.stat().st_mtime_ns
    numbers = [info[name] for name in ("shapes", "sources", "failed", "bytes")]
    return LibraryState((*numbers, changed), tuple(decision.number for decision in library.decisions()))
