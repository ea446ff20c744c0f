# SPDX-License-Identifier: MIT
"""The `shapegoogle` command: its parser, and running the chosen command."""

from __future__ import annotations

import argparse
import errno
import json
import os
import sys
import traceback
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NoReturn

from shapegoogle_core import __version__
from shapegoogle_core.api.text import one_line
from shapegoogle_core.cli.arguments import add_value, numbers
from shapegoogle_core.cli.command import CLOSED_PIPE, EXIT_CODES, INTERRUPTED, UNUSABLE
from shapegoogle_core.cli.commands import (
    copy,
    database,
    decisions,
    duplicates,
    forget,
    index,
    info,
    move,
    query,
    serve,
    suggest,
    token,
    train,
    upgrade,
)
from shapegoogle_core.cli.events import CommandError, Event, event_to_json
from shapegoogle_core.cli.text import put, say, say_lines
from shapegoogle_core.errors import ShapeGoogleError
from shapegoogle_core.processes.launching import orderly_end
from shapegoogle_core.processes.messages import MessageWriter, claim_message_pipe
from shapegoogle_core.processes.temporary import remove_abandoned_folders

if TYPE_CHECKING:
    from shapegoogle_core.indexing import ExternalReader, ReaderOption

__all__ = ["COMMANDS", "build_parser", "main"]

COMMANDS = (
    index.COMMAND,
    query.COMMAND,
    suggest.COMMAND,
    info.COMMAND,
    duplicates.COMMAND,
    decisions.COMMAND,
    move.COMMAND,
    forget.COMMAND,
    copy.COMMAND,
    upgrade.COMMAND,
    database.COMMAND,
    train.COMMAND,
    serve.COMMAND,
    token.COMMAND,
)
"""All commands, in the order of the help text."""


def main(
    arguments: Sequence[str] | None = None,
    *,
    reader: ExternalReader | None = None,
    program: str = "shapegoogle {command}",
) -> int:
    """Run the command.

    Parameters
    ----------
    arguments : sequence of str, optional
        By default those of the command line.
    reader : ExternalReader, optional
        Another program that reads more kinds of files.
    program : str, optional
        Name of the command in its help; `{command}` stands for "index" and so on.

    Returns
    -------
    exit_code : int
        See `command`.
    """
    for stream in (sys.stdout, sys.stderr):
        # A file name that the terminal's encoding lacks must not end the run.
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    options = build_parser(program, reader).parse_args(arguments)
    options.reader = reader
    options.arguments = list(sys.argv[1:] if arguments is None else arguments)
    if reader is not None:
        chosen = [(offer.name, getattr(options, offer.name, offer.choices[0])) for offer in reader.offers]
        options.reader = replace(reader, options=tuple(chosen))
    command = next(command for command in COMMANDS if command.name == options.command)
    options.send = _sender(events=getattr(options, "events", False))
    try:
        with orderly_end():
            remove_abandoned_folders()
            exit_code = command.run(options)
        sys.stdout.flush()
    except ShapeGoogleError as error:
        if options.verbose:
            say_lines(traceback.format_exc())
        if options.send is not None:
            options.send(CommandError(str(error)))
        say(f"shapegoogle: {error}")
        return UNUSABLE
    except KeyboardInterrupt:
        say("shapegoogle: interrupted")
        return INTERRUPTED
    except OSError as error:
        if error.errno == errno.EIO:  # the terminal was closed, so nothing can be said
            return INTERRUPTED
        if not isinstance(error, BrokenPipeError):
            raise
        # Python flushes stdout once more at exit, which must not fail again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return CLOSED_PIPE
    return exit_code


class _Parser(argparse.ArgumentParser):
    """Its errors repeat arguments, which may be names of any kind."""

    def error(self, message: str) -> NoReturn:
        super().error(one_line(message))


def _sender(*, events: bool) -> Callable[[Event], None] | None:
    """Return the function that events are sent with, if anyone wants them."""
    pipe = claim_message_pipe()
    if pipe is not None:
        writer = MessageWriter(pipe)
        return lambda event: writer.write(event_to_json(event))
    if events:
        return lambda event: put(json.dumps(event_to_json(event)))
    return None


def build_parser(
    program: str = "shapegoogle {command}", reader: ExternalReader | None = None
) -> argparse.ArgumentParser:
    """Make the parser with all commands and their options.

    Parameters
    ----------
    program : str, optional
        Name of the command in its help, as for `main`.
    reader : ExternalReader, optional
        Another program that reads more kinds of files, with options of its own.

    Returns
    -------
    parser : argparse.ArgumentParser
    """
    parser = _Parser(
        prog=program.partition(" {")[0],
        description="Find a 3D shape again: in another pose, at another size, with another mesh.",
        epilog="examples:\n"
        "  shapegoogle index ~/models --library shapes.sglib\n"
        "  shapegoogle query horse.obj --library shapes.sglib --top 5\n"
        "  shapegoogle query *.stl --library shapes.sglib --json | jq -r '.matches[0].source'\n\n"
        + EXIT_CODES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"shapegoogle {__version__}")
    subparsers = parser.add_subparsers(
        title="commands", dest="command", metavar="COMMAND", required=True, parser_class=_Parser
    )
    for command in COMMANDS:
        summary, _, details = command.help.partition("\n\n")
        options = subparsers.add_parser(
            command.name,
            prog=program.format(command=command.name),
            help=f"{summary[0].lower()}{summary[1:].rstrip('.')}",
            description=summary,
            epilog=f"{details}\n{EXIT_CODES}",
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        options.add_argument("-v", "--verbose", action="store_true", help="show the traceback of errors")
        command.add_options(options)
        if command.reads_files and reader is not None:
            for offer in reader.offers:
                _add_offer(options, offer)
    return parser


def _add_offer(options: argparse.ArgumentParser, offer: ReaderOption) -> None:
    """Add an option that the reader's program offers."""
    option = f"--{offer.name}"
    if offer.numbers:
        add_value(options, option, "N,N,…", offer.summary, numbers, offer.choices[0])
    else:
        help_text = f"{offer.summary} (%(default)s)"
        options.add_argument(option, choices=offer.choices, default=offer.choices[0], help=help_text)
