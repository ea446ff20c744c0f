# SPDX-License-Identifier: MIT
"""Copy a library to a new place: a file into a database, or the other way round.

FROM and TO are library files or postgresql:// addresses. TO must be new. Shapes keep their numbers. An
interrupted copy continues when the same command is run again; until it is complete, only `copy` may write to
TO.

With --json, one line: {"copied": shapes copied by this run, "shapes", "sources", "decisions"}.

for example:
  shapegoogle copy shapes.sglib postgresql://server/shapes
  shapegoogle copy postgresql://server/shapes ~/on-my-laptop.sglib
"""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict

from shapegoogle_core.api.text import counted
from shapegoogle_core.cli.arguments import add_flag
from shapegoogle_core.cli.command import DONE, Command
from shapegoogle_core.cli.text import put
from shapegoogle_core.library.storage.address import as_place, shown_place

__all__ = ["COMMAND"]


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("source", type=as_place, metavar="FROM", help="library to copy")
    parser.add_argument("target", type=as_place, metavar="TO", help="new library")
    add_flag(parser, "--json", "print one JSON object")


def _run(options: argparse.Namespace) -> int:
    from shapegoogle_core.library.copying import copy_library
    from shapegoogle_core.processes.progress import progress_bar

    report = copy_library(
        options.source, options.target, lambda shapes: progress_bar(shapes, "copying", len(shapes))
    )
    if options.json:
        put(json.dumps(asdict(report)))
    else:
        put(
            f"{counted(report.copied, 'shape')} copied; '{shown_place(options.target)}' has "
            f"{counted(report.shapes, 'shape')} of {counted(report.sources, 'source')}, all that "
            f"'{shown_place(options.source)}' has"
        )
    return DONE


COMMAND = Command("copy", str(__doc__), _add_options, _run)
