# SPDX-License-Identifier: MIT
"""The `shapegoogle` command: index folders, query with meshes, look into a library, train a model."""

from __future__ import annotations

import argparse
import os
import sys
import traceback
from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib import metadata
from typing import TYPE_CHECKING

from shapegoogle_core.cli import duplicates as duplicates_command
from shapegoogle_core.cli.arguments import INTERRUPTED, UNUSABLE, number_from, positive_number, say
from shapegoogle_core.errors import ShapeGoogleError
from shapegoogle_core.library.search.settings import EvidenceSettings
from shapegoogle_core.processes.launching import orderly_end

if TYPE_CHECKING:
    from shapegoogle_core.indexing import ExternalReader

__all__ = ["main"]

# What a shell reports of a program that writes into a closed pipe, as in `shapegoogle query … | head`.
CLOSED_PIPE = 141

EXIT_CODES = """\
exit codes:
  0    all done
  1    some inputs failed (a mesh that cannot be read, a folder that is missing or holds no meshes);
       each is named on stderr, and the others are done
  2    nothing can be done: wrong usage, or the library or model cannot be opened or written
  130  interrupted, by Ctrl-C or SIGTERM; what was stored stays
"""


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
        Left out, those of the command line.
    reader : ExternalReader, optional
        Another program that reads more kinds of files.
    program : str, optional
        What the help calls the command; `{command}` stands for "index" and so on.

    Returns
    -------
    exit_code : int
        See `EXIT_CODES`.
    """
    for stream in (sys.stdout, sys.stderr):
        # A file name that the terminal's encoding lacks must not end the run.
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    options = _parser(program, reader).parse_args(arguments)
    options.reader = reader
    if reader is not None:
        chosen = [(offer.name, getattr(options, offer.name, offer.choices[0])) for offer in reader.offers]
        options.reader = replace(reader, options=tuple(chosen))
    try:
        with orderly_end():
            exit_code = _command(options.command)(options)
        sys.stdout.flush()
    except ShapeGoogleError as error:
        if options.verbose:
            traceback.print_exc()
        say(f"shapegoogle: {error}")
        return UNUSABLE
    except KeyboardInterrupt:
        say("shapegoogle: interrupted")
        return INTERRUPTED
    except BrokenPipeError:
        # Python flushes stdout once more at exit and must not stumble again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return CLOSED_PIPE
    return exit_code


def _command(name: str) -> Callable[[argparse.Namespace], int]:
    # Help, and saying what is wrong with a command line, need none of what they import.
    from shapegoogle_core.cli import commands

    return {
        "index": commands.index,
        "query": commands.query,
        "info": commands.info,
        "duplicates": duplicates_command.duplicates,
        "train": commands.train,
    }[name]


def _parser(program: str, reader: ExternalReader | None) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=program.partition(" {")[0],
        description="Find a 3D shape again: in another pose, at another size, with another mesh.",
        epilog="examples:\n"
        "  shapegoogle index ~/models --library shapes.sglib\n"
        "  shapegoogle query horse.obj --library shapes.sglib --top 5\n"
        "  shapegoogle query *.stl --library shapes.sglib --json | jq -r '.matches[0].source'\n\n"
        + EXIT_CODES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    version = metadata.version("shapegoogle-core")
    parser.add_argument("--version", action="version", version=f"shapegoogle {version}")
    subparsers = parser.add_subparsers(title="commands", dest="command", metavar="COMMAND", required=True)

    index = _add_command(
        subparsers,
        program,
        "index",
        "put the meshes of folders into a library; only new and changed files are read",
        "Files that cannot be read, take too long or crash their process are skipped and listed at the end.\n"
        "They are tried again when they change, or with --retry.\n\n"
        "examples:\n"
        "  shapegoogle index ~/models ~/scans --library shapes.sglib --jobs 4\n"
        "  shapegoogle index ~/models --library shapes.sglib --prune --json\n",
    )
    index.add_argument(
        "inputs", nargs="+", metavar="FOLDER", help="folder (with all below it) or file of a mesh or scan"
    )
    _library_option(index, "library file; made if there is none")
    _jobs_option(index)
    index.add_argument(
        "--model",
        metavar="FILE",
        help="for a new library: a file made by `train`, or a shipped model: default, paper",
    )
    index.add_argument(
        "--time-limit",
        type=positive_number,
        default=300.0,
        metavar="S",
        help="seconds to read one file, and to describe one shape (%(default)g)",
    )
    index.add_argument(
        "--memory-limit",
        type=number_from(1),
        default=4096,
        metavar="MB",
        help="megabytes to read one file, and to describe one shape (%(default)s); not enforced on macOS and "
        "Windows",
    )
    index.add_argument("--retry", action="store_true", help="try files again that failed before")
    index.add_argument("--reread", action="store_true", help="read all files again, changed or not")
    index.add_argument("--prune", action="store_true", help="forget files that are gone from these folders")
    index.add_argument("--json", action="store_true", help="print one JSON object at the end")
    index.add_argument("--events", action="store_true", help="print one JSON object for each file")

    query = _add_command(
        subparsers,
        program,
        "query",
        "find the shapes of a library that are most like a mesh",
        "With --json, one line for each mesh:\n"
        '  {"query": path, "matches": [{"name", "source", "similarity", "distance", "evidence"}, …]}\n'
        'A mesh that cannot be read gives {"query": path, "matches": [], "error": "…"}; the others go on.\n'
        "With --together all meshes are examples of what you look for, and give one line:\n"
        '  {"query": [path, …], "unlike": [path, …], "matches": […]}\n'
        "What all of them are near to comes first; an example that cannot be read fails the question. With\n"
        "--unlike, also without --together, what is near to one of its meshes falls behind.\n"
        "similarity, 0 to 1: how likely it is the same shape transformed rather than the nearest of many\n"
        'others. distance orders the list, from 0 for the very same to 2. evidence: {"kind": …} and its\n'
        "figures, lengths as shares of √area of the query, found by comparing the surfaces:\n"
        "  identical, moved, scaled, mirrored   a copy; factor: its size, deviation of 95 % of its surface\n"
        "  re-meshed                            the same surface, another mesh\n"
        "  re-posed                             bent; displacement: how far, probability that it is so\n"
        "  part of, contains                    the query is a part of it, or it of the query; share of it\n"
        "  similar                              none of these; null where nothing could be compared\n\n"
        "examples:\n"
        "  shapegoogle query horse.obj --library shapes.sglib\n"
        "  shapegoogle query poses/*.off --library shapes.sglib --top 1 --json\n"
        "  shapegoogle query horse.obj pony.obj --together --unlike cow.obj --library shapes.sglib\n",
    )
    query.add_argument("meshes", nargs="+", metavar="MESH", help="file of a mesh or scan")
    _library_option(query)
    query.add_argument(
        "--top", type=number_from(1), default=10, metavar="N", help="how many matches (%(default)s)"
    )
    query.add_argument(
        "--exact",
        action="store_true",
        help="compare all shapes in full: slower in a large library, misses nothing",
    )
    query.add_argument(
        "--evidence",
        type=number_from(0),
        default=EvidenceSettings.explained,
        metavar="N",
        help="of how many of the best to say what kind of match they are (%(default)s)",
    )
    query.add_argument(
        "--together", action="store_true", help="the meshes are examples of one thing: ask once, for all"
    )
    query.add_argument(
        "--unlike",
        nargs="+",
        action="extend",
        default=[],
        metavar="MESH",
        help="mesh files of what you do not look for",
    )
    query.add_argument("--json", action="store_true", help="print one JSON object for each answer")

    info = _add_command(subparsers, program, "info", "say what a library holds", "")
    _library_option(info)
    info.add_argument("--json", action="store_true", help="print one JSON object")

    duplicates = _add_command(
        subparsers,
        program,
        "duplicates",
        "list copied files and shapes that are the same or hard to tell apart",
        duplicates_command.DETAILS,
    )
    _library_option(duplicates)
    duplicates_command.add_options(duplicates)

    train = _add_command(
        subparsers,
        program,
        "train",
        "learn a model from your own shapes",
        "Needs at least 8 different shapes, better 100 varied ones, and about a second for each version.\n"
        "Use the model for a new library: shapegoogle index FOLDER --library FILE --model MODEL.npz\n\n"
        "--descriptor  what each point of a surface is described by: hks, log-hks or si-hks as the preset\n"
        "              has them; gps, geodesic-histogram or volumetric-hks, which a pose hardly changes\n"
        "              either; or spin-images, shape-context or mesh-hog, which it does\n\n"
        "examples:\n"
        "  shapegoogle train ~/models --output mine.npz\n"
        "  shapegoogle train ~/models --output rigid.npz --descriptor spin-images --descriptor hks\n",
    )
    train.add_argument(
        "inputs", nargs="+", metavar="FOLDER", help="folder (with all below it) or file of a mesh or scan"
    )
    train.add_argument("--output", required=True, metavar="MODEL.npz", help="file to write the model to")
    train.add_argument("--preset", default="default", metavar="NAME", help="settings: 'default' or 'paper'")
    train.add_argument(
        "--descriptor",
        action="append",
        metavar="NAME",
        help="in place of the preset's, see above; may be given more than once",
    )
    train.add_argument(
        "--poses", action="store_true", help="the files of one folder are one shape in several poses"
    )
    train.add_argument(
        "--versions",
        type=number_from(1),
        default=10,
        metavar="N",
        help="transformed versions to learn from, for each shape (%(default)s)",
    )
    train.add_argument("--seed", type=int, default=0, metavar="N", help="of all random choices (%(default)s)")
    _jobs_option(train)

    for command in (index, query, train):
        for offer in () if reader is None else reader.offers:
            command.add_argument(
                f"--{offer.name}",
                choices=offer.choices,
                default=offer.choices[0],
                help=f"{offer.summary} (%(default)s)",
            )
    return parser


def _add_command(
    subparsers: argparse._SubParsersAction[argparse.ArgumentParser],
    program: str,
    name: str,
    summary: str,
    details: str,
) -> argparse.ArgumentParser:
    parser = subparsers.add_parser(
        name,
        prog=program.format(command=name),
        help=summary,
        description=f"{summary[0].upper()}{summary[1:]}.",
        epilog=f"{details}\n{EXIT_CODES}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "-v", "--verbose", action="store_true", help="show where in the program an error arose"
    )
    return parser


def _library_option(parser: argparse.ArgumentParser, summary: str = "library file") -> None:
    parser.add_argument("--library", required=True, metavar="FILE", help=summary)


def _jobs_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--jobs", type=number_from(1), metavar="N", help="worker processes (default: one for each processor)"
    )
