# SPDX-License-Identifier: MIT
"""Messages between processes, on a pipe of their own.

Standard output and standard error belong to whoever prints: Python, the libraries, Blender. A program that
`launch` starts with a message pipe finds the pipe's number in the environment variable `MESSAGES`. It writes
either lines, one JSON document each and in ASCII, so that no name can break a line; or frames, the length in
eight bytes before the content.
"""

from __future__ import annotations

import json
import os
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import IO, Any, BinaryIO

__all__ = [
    "MESSAGES",
    "IncompleteMessageError",
    "MessageWriter",
    "WrongMessageError",
    "claim_message_pipe",
    "inheritable",
    "read_document",
    "read_frame",
    "write_frame",
]

MESSAGES = "SHAPEGOOGLE_MESSAGES"
"""Environment variable: file descriptor (on Windows: handle) of the pipe to write messages to."""

# Bytes of the length before a frame.
LENGTH_BYTES = 8


class IncompleteMessageError(Exception):
    """The process at the other end died in the middle of a message."""


class WrongMessageError(Exception):
    """The process at the other end sent something that is no message."""


@contextmanager
def inheritable(descriptor: int) -> Iterator[tuple[str, dict[str, Any]]]:
    """Let a program that is started inside the block have one of this process's pipes.

    Parameters
    ----------
    descriptor : int
        The end to write to.

    Yields
    ------
    number : str
        Value of `MESSAGES` for the program.
    options : dict
        Options for `subprocess.Popen`.
    """
    if sys.platform == "win32":
        import msvcrt
        import subprocess

        handle = msvcrt.get_osfhandle(descriptor)
        os.set_handle_inheritable(handle, True)
        try:
            startup = subprocess.STARTUPINFO(lpAttributeList={"handle_list": [handle]})
            yield str(handle), {"startupinfo": startup}
        finally:
            os.set_handle_inheritable(handle, False)
    else:
        yield str(descriptor), {"pass_fds": (descriptor,)}


def claim_message_pipe() -> BinaryIO | None:
    """Take the message pipe that this process was started with.

    No process that is started afterwards has it: the reader would wait for that one too.

    Returns
    -------
    pipe : binary file or None
        To write to, unbuffered; None if there is none, or it was taken before.
    """
    number = os.environ.pop(MESSAGES, None)
    if number is None:
        return None
    if sys.platform == "win32":
        import msvcrt

        descriptor = msvcrt.open_osfhandle(int(number), os.O_WRONLY)
    else:
        descriptor = int(number)
    os.set_inheritable(descriptor, False)
    return os.fdopen(descriptor, "wb", buffering=0)


class MessageWriter:
    """Writes messages, one JSON document per line; threads may share it.

    Parameters
    ----------
    pipe : binary file
        Unbuffered.
    """

    def __init__(self, pipe: BinaryIO) -> None:
        self._pipe = pipe
        # One that a signal handler may take again.
        self._lock = threading.RLock()

    def write(self, message: object) -> None:
        """Write a message, whole.

        Parameters
        ----------
        message : object
            As `json.dumps` takes it.

        Raises
        ------
        BrokenPipeError
            If the reader has gone.
        """
        line = json.dumps(message).encode("ascii") + b"\n"
        with self._lock:
            _write_all(self._pipe, line)


def read_document(pipe: BinaryIO) -> Any:
    """Read a message that a `MessageWriter` has written.

    Parameters
    ----------
    pipe : binary file
        Buffered.

    Returns
    -------
    message : object
        None at the end.

    Raises
    ------
    IncompleteMessageError
        If the line has no end.
    WrongMessageError
        If it is no JSON document.
    """
    line = pipe.readline()
    if not line:
        return None
    if not line.endswith(b"\n"):
        raise IncompleteMessageError
    try:
        return json.loads(line)
    except ValueError as error:
        raise WrongMessageError from error


def write_frame(pipe: IO[bytes], content: bytes) -> None:
    """Write a frame.

    Parameters
    ----------
    pipe : binary file
    content : bytes

    Raises
    ------
    BrokenPipeError
        If the reader has gone.
    """
    _write_all(pipe, len(content).to_bytes(LENGTH_BYTES, "little"))
    _write_all(pipe, content)
    pipe.flush()


def read_frame(pipe: IO[bytes]) -> bytes | None:
    """Read a frame.

    Parameters
    ----------
    pipe : binary file
        Buffered.

    Returns
    -------
    content : bytes or None
        None at the end.

    Raises
    ------
    IncompleteMessageError
        If the pipe ends within the frame.
    """
    length = pipe.read(LENGTH_BYTES)
    if not length:
        return None
    expected = int.from_bytes(length, "little")
    content = pipe.read(expected) if len(length) == LENGTH_BYTES else b""
    if len(length) < LENGTH_BYTES or len(content) < expected:
        raise IncompleteMessageError
    return content


def _write_all(pipe: IO[bytes], content: bytes) -> None:
    """Write everything: an unbuffered pipe may take a part of it only."""
    rest = memoryview(content)
    while rest:
        rest = rest[pipe.write(rest) :]
