# SPDX-License-Identifier: MIT
"""Description of a command for the parser."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass

__all__ = ["Command"]


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
