# SPDX-License-Identifier: MIT
"""The library of a process of the service: a few threads, each with its own open library.

An open library belongs to one thread. Searching, reading and writing have a line each, so that a picture
does not wait behind a search. A request waits for its turn and runs for a limited time, in a line of limited
length.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Literal, TypeVar

from shapegoogle_core.library.library import Library
from shapegoogle_core.library.storage.address import as_place
from shapegoogle_core.library.storage.opening import check_exists
from shapegoogle_core.service.lines import LibraryThread, Line
from shapegoogle_core.service.settings import ServiceError, ServiceSettings

__all__ = ["Lane", "LibraryLanes"]

Lane = Literal["search", "read"]
T = TypeVar("T")

# Requests that only read may wait in a longer line: a page of the gallery has a hundred pictures.
_READERS_PER_SEARCH = 20
# Seconds that shutting down waits for a search; duplicates of a large library may take an hour.
_PATIENCE = 1.0


class LibraryLanes:
    """Threads that use a library.

    Parameters
    ----------
    settings : ServiceSettings
    """

    def __init__(self, settings: ServiceSettings) -> None:
        self._settings = settings
        most = settings.max_waiting
        self._lanes: dict[str, Line] = {
            "search": Line(settings.library, most),
            "read": Line(settings.library, most * _READERS_PER_SEARCH),
            "long": Line(settings.library, most),
        }
        self._writer = Line(settings.library, most)

    async def run(self, lane: Lane, function: Callable[[Library], T]) -> T:
        """Run a function with the library, which is open for reading only.

        Parameters
        ----------
        lane : {"search", "read"}
        function : callable

        Returns
        -------
        result : object

        Raises
        ------
        ServiceError
            503 if too many requests wait, or still run though they were given up; 504 if it takes too long.
        """
        return await self._finished(self._lanes[lane], lambda thread: function(thread.library()))

    def start_long(self, function: Callable[[Library], T]) -> asyncio.Future[T]:
        """Run a function with the library in the background, however long it takes.

        Parameters
        ----------
        function : callable

        Returns
        -------
        future : asyncio.Future

        Raises
        ------
        ServiceError
            503 if too many wait.
        """
        return self._lanes["long"].submit(lambda thread: function(thread.library()))

    async def write(self, function: Callable[[Library], T]) -> T:
        """Run a function with the library open for writing, as briefly as possible.

        Parameters
        ----------
        function : callable

        Returns
        -------
        result : object

        Raises
        ------
        ServiceError
            See `run`.
        """

        def changed(_thread: LibraryThread) -> T:
            # A file that was moved away must not be made anew, empty.
            check_exists(as_place(self._settings.library))
            with Library.open(self._settings.library) as library:
                return function(library)

        return await self._finished(self._writer, changed)

    def close(self) -> None:
        """Wait for what changes the library, and a moment for what only reads; close the library."""
        for line in self._lanes.values():
            line.close(_PATIENCE)
        self._writer.close()

    async def _finished(self, line: Line, function: Callable[[LibraryThread], T]) -> T:
        future = line.submit(function)
        done, _ = await asyncio.wait([future], timeout=self._settings.time_limit)
        if not done:
            line.give_up(future)
            raise ServiceError(
                504,
                f"the library did not answer within {self._settings.time_limit:g} s; try again later, or ask "
                "for less",
                retry_after=10,
            )
        return future.result()
