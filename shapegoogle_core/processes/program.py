# SPDX-License-Identifier: MIT
"""Another program that is asked, or watched, by lines of text."""

from __future__ import annotations

import subprocess
import threading
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress

from shapegoogle_core.processes.launching import launch

__all__ = ["Program"]

# Seconds that a program may take to end by itself when it is asked to.
PATIENCE = 5.0
# Number of lines that are kept to explain why a program ended.
KEPT_LINES = 100


class Program:
    """A running program whose output has two kinds of lines: messages and everything else it prints.

    Standard error comes with standard output.

    Parameters
    ----------
    command : sequence of str
        The program and its arguments.
    marker : str
        How a message begins.
    environment : mapping of str to str, optional
        All its environment variables; by default those of this process.
    with_input : bool, optional
        Whether lines can be sent to it.

    Attributes
    ----------
    other_lines : deque of str
        The last lines that were no messages, without line breaks.

    Raises
    ------
    OSError
        If the program cannot be started.

    Examples
    --------
    >>> import sys
    >>> from shapegoogle_core.processes.program import Program
    >>> code = "for line in open(0): print('a banner'); print('answer:', len(line.strip()), flush=True)"
    >>> program = Program([sys.executable, "-c", code], marker="answer: ", with_input=True)
    >>> program.send("horse")
    >>> program.message(time_limit=60)
    '5'
    >>> program.close()
    0
    >>> list(program.other_lines)
    ['a banner']
    """

    def __init__(
        self,
        command: Sequence[str],
        *,
        marker: str,
        environment: Mapping[str, str] | None = None,
        with_input: bool = False,
    ) -> None:
        self.other_lines: deque[str] = deque(maxlen=KEPT_LINES)
        self._marker = marker
        self._late = threading.Event()
        self._process = launch(command, environment=environment, with_input=with_input, join_errors=True)

    @property
    def exit_code(self) -> int | None:
        """Exit code; None while the program runs."""
        return self._process.poll()

    def send(self, line: str) -> None:
        """Send a line to the program; one that has ended does not get it.

        Parameters
        ----------
        line : str
            Without a line break.
        """
        assert self._process.stdin is not None
        with suppress(BrokenPipeError):  # `message` reports that it has ended
            self._process.stdin.write(f"{line}\n".encode())
            self._process.stdin.flush()

    def message(self, time_limit: float | None = None) -> str | None:
        """Wait for the next message.

        Parameters
        ----------
        time_limit : float, optional
            Seconds; the program is killed then.

        Returns
        -------
        message : str or None
            The line after the marker; None if the program has closed its output, as it does when it ends.

        Raises
        ------
        TimeoutError
            If there is no message within the time limit.
        """
        timer = None
        if time_limit is not None:
            timer = threading.Timer(max(time_limit, 0.0), self._give_up)
            timer.start()
        assert self._process.stdout is not None
        try:
            for data in self._process.stdout:
                line = data.decode("utf-8", "replace").rstrip()
                if line.startswith(self._marker):
                    return line.removeprefix(self._marker)
                self.other_lines.append(line)
        finally:
            if timer is not None:
                timer.cancel()
        if self._late.is_set():
            raise TimeoutError(f"no message within {time_limit:g} s")
        return None

    def messages(self) -> Iterator[str]:
        """Iterate over all messages until the program ends.

        Yields
        ------
        message : str
            The line after the marker.
        """
        while (message := self.message()) is not None:
            yield message

    def last_lines(self, count: int) -> str:
        """Join the last lines that were no messages, for an error message.

        Parameters
        ----------
        count : int
            Number of lines, of which empty ones are left out.

        Returns
        -------
        text : str
            Joined by semicolons.
        """
        lines = list(self.other_lines)[-count:]
        return "; ".join(line.strip() for line in lines if line.strip())

    def close(self) -> int:
        """Close the program's input, which asks it to end, and kill it if it does not.

        Returns
        -------
        exit_code : int
        """
        if self._process.stdin is not None:
            with suppress(BrokenPipeError):  # it has ended already
                self._process.stdin.close()
        return self._end()

    def terminate(self) -> int:
        """End the program by SIGTERM, so that it can clean up, and kill it if it does not end.

        Another thread may wait for messages meanwhile, and gets the last ones.

        Returns
        -------
        exit_code : int
        """
        if self._process.poll() is None:
            self._process.terminate()
        return self._wait()

    def wait(self) -> int:
        """Wait until the program has ended.

        Returns
        -------
        exit_code : int
        """
        return self._process.wait()

    def _give_up(self) -> None:
        self._late.set()
        self._process.kill()

    def _wait(self) -> int:
        try:
            return self._process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            return self._process.wait()

    def _end(self) -> int:
        exit_code = self._wait()
        assert self._process.stdout is not None
        self._process.stdout.close()
        return exit_code
