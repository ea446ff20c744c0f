# SPDX-License-Identifier: MIT
"""Description of a command for the parser, and the exit codes of all commands."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass

__all__ = ["CLOSED_PIPE", "DONE", "EXIT_CODES", "INTERRUPTED", "SOME_FAILED", "UNUSABLE", "Command"]


@dataclass(frozen=True)
class Command:
    """One command of `shapegoogle`.

    Attributes
    ----------
    name : str
        As typed: "index".
    help : str
        Docstring of the command's module: one line for the list of commands, an empty line, and the text
        below the options in the command's own help.
    add_options : callable
        Adds the options of the command to its parser.
    run : callable
        Runs the command with its parsed options and returns the exit code. It may import whatever it needs;
        the module must not, since help texts show every command.
    reads_files : bool
        Whether the command reads mesh files, and so takes the options of an external reader.
    """

    name: str
    help: str
    add_options: Callable[[argparse.ArgumentParser], None]
    run: Callable[[argparse.Namespace], int]
    reads_files: bool = False


DONE = 0
SOME_FAILED = 1
"""Some inputs failed, each named on stderr; the others are done."""
UNUSABLE = 2
"""Nothing was done: wrong usage, or a library, model or file that cannot be opened or written."""
INTERRUPTED = 130
"""Interrupted by Ctrl-C (SIGINT) or SIGTERM."""
CLOSED_PIPE = 141
"""Output closed by the reader of a pipe, as in `shapegoogle query … | head`; shells report the same code."""

EXIT_CODES = """\
exit codes:
  0    everything done
  1    some inputs failed (a mesh that cannot be read, a folder that is missing or contains no meshes);
       each is named on stderr, and the others are done
  2    nothing was done: wrong usage, or the library or model cannot be opened or written
  130  interrupted by Ctrl-C or SIGTERM; everything stored so far is kept
"""
"""Section of every help text."""
