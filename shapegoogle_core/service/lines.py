# SPDX-License-Identifier: MIT
"""Lines of requests that wait for a thread with an open library.

What runs in a thread cannot be stopped. A request that is given up leaves the line at once; if it runs, its
thread is lost until it has finished, and another one goes on with the line. So that this does not pile up,
few threads may be lost at a time; then new requests are refused.
"""

from __future__ import annotations

import asyncio
import queue
import threading
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Generic, TypeVar

from shapegoogle_core.library.library import Library
from shapegoogle_core.service.settings import ServiceError

__all__ = ["LibraryThread", "Line", "Request"]

T = TypeVar("T")

# Each has an open library, with the codes of a whole library in its memory.
_MOST_LOST = 3


@dataclass(frozen=True)
class Request(Generic[T]):
    """A function that waits for its turn.

    Attributes
    ----------
    function : callable
        Called with the thread that runs it.
    outcome : concurrent.futures.Future
    """

    function: Callable[[LibraryThread], T]
    outcome: Future[T] = field(default_factory=Future)

    def run(self, thread: LibraryThread) -> None:
        """Run the function, unless it was given up while it waited."""
        if not self.outcome.set_running_or_notify_cancel():
            return
        try:
            result = self.function(thread)
        except BaseException as error:  # whoever waits for the outcome gets it
            self.outcome.set_exception(error)
        else:
            self.outcome.set_result(result)


class Line:
    """Requests that wait, and the thread that runs one after the other.

    Parameters
    ----------
    library : str
        Path or address, which each thread opens for itself.
    most : int
        Number of requests that may wait.
    """

    def __init__(self, library: str, most: int) -> None:
        self._address = library
        self._most = most
        self._waiting: dict[asyncio.Future[Any], Request[Any]] = {}
        self._requests: queue.SimpleQueue[Request[Any] | None] = queue.SimpleQueue()
        # For what follows, which the threads change too.
        self._lock = threading.Lock()
        self._thread: LibraryThread | None = None
        self._lost: set[LibraryThread] = set()
        self._closed = False

    def submit(self, function: Callable[[LibraryThread], T]) -> asyncio.Future[T]:
        """Put a function into the line.

        Parameters
        ----------
        function : callable

        Returns
        -------
        future : asyncio.Future

        Raises
        ------
        ServiceError
            503 if too many requests wait, or too many that were given up still run.
        """
        if len(self._waiting) >= self._most:
            raise ServiceError(
                503, "too many requests are waiting; try again in a few seconds", retry_after=5
            )
        if not self._has_thread():
            raise ServiceError(
                503, "searches that took too long still occupy the service; try again later", retry_after=30
            )
        request = Request(function)
        future = asyncio.wrap_future(request.outcome)
        self._waiting[future] = request
        future.add_done_callback(self._leave)
        self._requests.put(request)
        return future

    def give_up(self, future: asyncio.Future[Any]) -> None:
        """Wait no longer for a request, and let the others go on.

        Parameters
        ----------
        future : asyncio.Future
            Of `submit`.
        """
        request = self._waiting.pop(future, None)
        # Cancelling only the future of the event loop would reach the request later, when it may have begun.
        running = request is not None and not request.outcome.cancel()
        future.cancel()
        with self._lock:
            if running and self._thread is not None and self._thread.request is request:
                self._lost.add(self._thread)
                self._thread = None
        self._has_thread()

    def close(self, patience: float | None = None) -> None:
        """Give up what waits, wait a little for what runs, close the library and end the thread.

        Parameters
        ----------
        patience : float, optional
            Longest time to wait, in seconds. What runs longer ends with the process. None: as long as it
            takes, so that what changes the library is not broken off.
        """
        with self._lock:
            self._closed = True
            thread = self._thread
        for future, request in list(self._waiting.items()):
            request.outcome.cancel()
            future.cancel()
        self._requests.put(None)
        if thread is not None:
            thread.join(patience)

    def next_request(self, thread: LibraryThread) -> Request[Any] | None:
        """Wait for the next request. Called in a thread, which ends if there is none for it.

        Parameters
        ----------
        thread : LibraryThread

        Returns
        -------
        request : Request or None
        """
        with self._lock:
            thread.request = None
            # One that was lost and has finished helps out if no other goes on.
            self._lost.discard(thread)
            if self._thread is None and not self._closed:
                self._thread = thread
            if self._thread is not thread:
                return None
        request = self._requests.get()
        with self._lock:
            thread.request = request
        return request

    def _leave(self, future: asyncio.Future[Any]) -> None:
        self._waiting.pop(future, None)

    def _has_thread(self) -> bool:
        """Start a thread if there is none, unless too many are lost; return whether there is one."""
        with self._lock:
            if self._thread is None and len(self._lost) < _MOST_LOST and not self._closed:
                self._thread = LibraryThread(self._address, self)
                self._thread.start()
            return self._thread is not None


class LibraryThread(threading.Thread):
    """A thread that runs requests, with a library of its own.

    Parameters
    ----------
    library : str
    line : Line

    Attributes
    ----------
    request : Request or None
        Runs at this moment; changed by the line.
    """

    def __init__(self, library: str, line: Line) -> None:
        # One that never finishes must not keep the process from ending.
        super().__init__(daemon=True)
        self.request: Request[Any] | None = None
        self._address = library
        self._line = line
        self._library: Library | None = None
        self._identity: tuple[int, int] | None = None

    def run(self) -> None:
        """Run one request after the other."""
        while (request := self._line.next_request(self)) is not None:
            request.run(self)
            del request  # with its outcome, which may be large
        if self._library is not None:
            self._library.close()

    def library(self) -> Library:
        """Return the open library; a file that was replaced is opened again. Called in this thread.

        Returns
        -------
        library : Library
        """
        identity = _identity(self._address)
        if self._library is None or self._identity != identity:
            if self._library is not None:
                self._library.close()
                self._library = None
            self._library, self._identity = Library.open(self._address, read_only=True), identity
        return self._library


def _identity(address: str) -> tuple[int, int] | None:
    """Return what tells a file from another one in its place; None for a database."""
    try:
        status = Path(address).stat()
    except OSError:
        return None
    return status.st_dev, status.st_ino
