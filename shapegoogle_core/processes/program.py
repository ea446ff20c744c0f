# SPDX-License-Identifier: MIT
"""Another program that is asked, or watched, by messages."""

from __future__ import annotations

import json
import os
import subprocess
import threading
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

from shapegoogle_core.processes.launching import cause_of_death, launch
from shapegoogle_core.processes.messages import IncompleteMessageError, WrongMessageError, read_document
from shapegoogle_core.processes.signs_of_life import Silence, Standstill
from shapegoogle_core.processes.temporary import VARIABLES, temporary_folder

__all__ = ["Program"]

# Seconds that a program may take to end by itself when it is asked to.
PATIENCE = 5.0
# Seconds to wait for the last lines of a program that has ended: another process may hold its output open.
PATIENCE_FOR_LINES = 1.0
# Seconds from one look for a sign of life to the next.
SECONDS_BETWEEN_LOOKS = 1.0
# Number of lines that are kept to explain why a program ended, and of characters of each.
KEPT_LINES = 100
LINE_LENGTH = 1000


class Program:
    """A running program that sends messages on a pipe of their own; what it prints is kept for errors.

    Its temporary files lie in a folder of their own, which is removed when it has ended, however it ended:
    Blender, for one, leaves folders behind when it is killed.

    Parameters
    ----------
    command : sequence of str
        The program and its arguments. It writes its messages as `messages.MessageWriter` does.
    environment : mapping of str to str, optional
        All its environment variables; by default those of this process.
    with_input : bool, optional
        Whether requests can be sent to it.
    within : Path, optional
        Existing folder that outlasts it, for the folder of its temporary files.

    Attributes
    ----------
    printed : deque of str
        The last lines of its standard output and standard error, without line breaks.

    Raises
    ------
    OSError
        If the program cannot be started.

    Examples
    --------
    >>> import sys
    >>> from shapegoogle_core.processes.program import Program
    >>> code = '''
    ... import json, os, sys
    ... messages = open(int(os.environ["SHAPEGOOGLE_MESSAGES"]), "w")
    ... for line in sys.stdin:
    ...     print("a banner")
    ...     print(json.dumps({"letters": len(json.loads(line))}), file=messages, flush=True)
    ... '''
    >>> program = Program([sys.executable, "-c", code], with_input=True)
    >>> program.send("horse")
    >>> program.message(time_limit=60)
    {'letters': 5}
    >>> program.close()
    0
    >>> program.last_lines(3)
    'a banner'
    """

    def __init__(
        self,
        command: Sequence[str],
        *,
        environment: Mapping[str, str] | None = None,
        with_input: bool = False,
        within: Path | None = None,
    ) -> None:
        self.printed: deque[str] = deque(maxlen=KEPT_LINES)
        self._line_count = 0
        self._late = threading.Event()
        self._resources = ExitStack()
        folder = self._resources.enter_context(temporary_folder(within))
        variables = {**(os.environ if environment is None else environment)}
        variables.update(dict.fromkeys(VARIABLES, str(folder)))
        try:
            self._process, self._messages = launch(command, environment=variables, with_input=with_input)
        except BaseException:
            self._resources.close()
            raise
        # All the time: a program whose output nobody reads waits for ever once its pipe is full.
        self._listener = threading.Thread(target=self._listen, daemon=True)
        self._listener.start()

    @property
    def exit_code(self) -> int | None:
        """Exit code; None while the program runs."""
        return self._process.poll()

    def send(self, request: object) -> None:
        """Send a request to the program; one that has ended does not get it.

        Parameters
        ----------
        request : object
            Sent to its standard input as one line of JSON.
        """
        assert self._process.stdin is not None
        with suppress(BrokenPipeError):  # `message` reports that it has ended
            self._process.stdin.write(json.dumps(request).encode("ascii") + b"\n")
            self._process.stdin.flush()

    def message(self, time_limit: float | None = None, *, patience: float | None = None) -> Any:
        """Wait for the next message.

        Parameters
        ----------
        time_limit : float, optional
            Seconds; the program is killed then. On a busy machine it gets more, see `Standstill`.
        patience : float, optional
            Seconds without any sign of life of the program, which is killed then. As long as it works or
            prints something it may take its time: the machine may be busy with something else.

        Returns
        -------
        message : object
            None if the program has ended, possibly in the middle of a message.

        Raises
        ------
        TimeoutError
            If there is no message within the time limit, or nothing is to be expected any more.
        """
        received = threading.Event()
        watched: list[Silence | Standstill] = []
        pid, pause = self._process.pid, SECONDS_BETWEEN_LOOKS
        if time_limit is not None:
            watched.append(Standstill(pid, time_limit))
            pause = min(pause, max(time_limit, 0.0) / 4)
        if patience is not None:
            watched.append(Silence(pid, patience))
        if watched:
            threading.Thread(target=self._watch, args=(watched, pause, received), daemon=True).start()
        try:
            message = read_document(self._messages)
        except IncompleteMessageError:
            message = None
        except WrongMessageError:
            # What it says next makes no sense either.
            self._process.kill()
            message = None
        finally:
            received.set()
        if message is None and self._late.is_set():
            raise TimeoutError("no message within the time limit")
        return message

    def messages(self) -> Iterator[Any]:
        """Iterate over all messages until the program ends.

        Yields
        ------
        message : object
        """
        while (message := self.message()) is not None:
            yield message

    def last_lines(self, count: int) -> str:
        """Join the last lines that it printed, for an error message.

        Parameters
        ----------
        count : int
            Number of lines; empty ones are left out.

        Returns
        -------
        text : str
            Joined by semicolons.
        """
        if self.exit_code is not None:
            self._listener.join(PATIENCE_FOR_LINES)
        lines = [line for line in map(str.strip, tuple(self.printed)) if line]
        return "; ".join(lines[-count:])

    def ending(self, count: int) -> str:
        """Describe how the program ended, for an error message; it is killed if it has not.

        Parameters
        ----------
        count : int
            Number of lines that it printed at last.

        Returns
        -------
        text : str
            Such as "exit code 3: out of memory".
        """
        cause = cause_of_death(self._wait())
        printed = self.last_lines(count)
        return f"{cause}: {printed}" if printed else cause

    def close(self) -> int:
        """Close the program's input, which asks it to end, and kill it if it does not.

        Returns
        -------
        exit_code : int
        """
        if self._process.stdin is not None:
            with suppress(BrokenPipeError):  # it has ended already
                self._process.stdin.close()
        exit_code = self._wait()
        self._listener.join(PATIENCE_FOR_LINES)
        self._messages.close()
        self._resources.close()
        return exit_code

    def terminate(self) -> int:
        """End the program by SIGTERM, so that it can clean up, and kill it if it does not end.

        Another thread may wait for messages meanwhile, and gets the last ones.

        Returns
        -------
        exit_code : int
        """
        if self._process.poll() is None:
            self._process.terminate()
        exit_code = self._wait()
        self._resources.close()
        return exit_code

    def wait(self) -> int:
        """Wait until the program has ended.

        Returns
        -------
        exit_code : int
        """
        exit_code = self._process.wait()
        self._resources.close()
        return exit_code

    def _listen(self) -> None:
        """Keep the last lines of what it prints."""
        assert self._process.stdout is not None
        with self._process.stdout as output:
            # In pieces: a library may print megabytes without a line break.
            while data := output.readline(LINE_LENGTH):
                self._line_count += 1
                self.printed.append(data.decode("utf-8", "replace").rstrip("\r\n"))

    def _watch(
        self, watched: Sequence[Silence | Standstill], pause: float, received: threading.Event
    ) -> None:
        """Give up on a program that shows no sign of life, or has had its time."""
        while not received.wait(pause):
            if any(one.is_over(self._line_count) for one in watched):
                self._give_up()
                return

    def _give_up(self) -> None:
        self._late.set()
        self._process.kill()

    def _wait(self) -> int:
        try:
            return self._process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            return self._process.wait()
