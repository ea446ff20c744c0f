# SPDX-License-Identifier: MIT
"""The library of a process of the service: a few threads, each with its own open library.

An open library belongs to one thread. Searching, reading and writing have a thread each, so that a picture
does not wait behind a search. A request waits for its turn, for a limited time, in a line of limited length.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Literal, TypeVar

from shapegoogle_core.library.library import Library
from shapegoogle_core.library.storage.address import as_place
from shapegoogle_core.library.storage.opening import check_exists
from shapegoogle_core.service.settings import ServiceError, ServiceSettings

__all__ = ["Lane", "LibraryLanes"]

Lane = Literal["search", "read"]
T = TypeVar("T")

# Requests that only read may wait in a longer line: a page of the gallery has a hundred pictures.
_READERS_PER_SEARCH = 20


class LibraryLanes:
    """Threads that use a library.

    Parameters
    ----------
    settings : ServiceSettings
    """

    def __init__(self, settings: ServiceSettings) -> None:
        self._settings = settings
        most = settings.max_waiting
        self._lanes: dict[str, _Thread] = {
            "search": _Thread(settings.library, most),
            "read": _Thread(settings.library, most * _READERS_PER_SEARCH),
            "long": _Thread(settings.library, most),
        }
        self._writer = _Thread(settings.library, most)

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
            503 if too many requests wait, 504 if it takes too long.
        """
        thread = self._lanes[lane]
        return await self._finished(thread.submit(lambda: function(thread.library())))

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
        thread = self._lanes["long"]
        return thread.submit(lambda: function(thread.library()))

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

        def changed() -> T:
            # A file that was moved away must not be made anew, empty.
            check_exists(as_place(self._settings.library))
            with Library.open(self._settings.library) as library:
                return function(library)

        return await self._finished(self._writer.submit(changed))

    def close(self) -> None:
        """Wait for what is running, and close the library."""
        for thread in (*self._lanes.values(), self._writer):
            thread.close()

    async def _finished(self, future: asyncio.Future[T]) -> T:
        done, _ = await asyncio.wait([future], timeout=self._settings.time_limit)
        if not done:
            # What runs in a thread cannot be stopped; what still waits can.
            future.cancel()
            raise ServiceError(
                504,
                f"the library did not answer within {self._settings.time_limit:g} s; try again later, or ask "
                "for less",
                retry_after=10,
            )
        return future.result()


class _Thread:
    """One thread, its open library, and the line of those who wait for it."""

    def __init__(self, library: str, most: int) -> None:
        self._address = library
        self._most = most
        self._waiting = 0
        self._executor = ThreadPoolExecutor(1)
        self._library: Library | None = None
        self._identity: tuple[int, int] | None = None

    def submit(self, function: Callable[[], T]) -> asyncio.Future[T]:
        """Put a function into the line."""
        if self._waiting >= self._most:
            raise ServiceError(
                503, "too many requests are waiting; try again in a few seconds", retry_after=5
            )
        self._waiting += 1
        future = asyncio.get_running_loop().run_in_executor(self._executor, function)
        future.add_done_callback(self._leave)
        return future

    def library(self) -> Library:
        """Return the open library; a file that was replaced is opened again. Called in the thread."""
        identity = _identity(self._address)
        if self._library is None or self._identity != identity:
            if self._library is not None:
                self._library.close()
                self._library = None
            self._library, self._identity = Library.open(self._address, read_only=True), identity
        return self._library

    def close(self) -> None:
        """Close the library in its thread, and end the thread."""
        if self._library is not None:
            self._executor.submit(self._library.close)
        self._executor.shutdown(wait=True)

    def _leave(self, _future: asyncio.Future[T]) -> None:
        self._waiting -= 1


def _identity(address: str) -> tuple[int, int] | None:
    """Return what tells a file from another one in its place; None for a database."""
    try:
        status = Path(address).stat()
    except OSError:
        return None
    return status.st_dev, status.st_ino
