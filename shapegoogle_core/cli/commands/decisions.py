# SPDX-License-Identifier: MIT
"""List what people decided about the shapes of a library, and undo it.

Decisions are made on the web page of a service, or with `Library.decide`: "not a match", "keep
both", "master", tags. Searches and lists of duplicates follow them.

for example:
  shapegoogle decisions --library shapes.sglib
  shapegoogle decisions --library shapes.sglib --undo 3
"""

from __future__ import annotations

import argparse
import json
from datetime import UTC, datetime

from shapegoogle_core.cli.arguments import SEARCHED, add_flag, add_library, add_value, number_from
from shapegoogle_core.cli.command import DONE, Command
from shapegoogle_core.cli.text import put, say, table

__all__ = ["COMMAND"]


def _add_options(parser: argparse.ArgumentParser) -> None:
    add_library(parser, SEARCHED)
    add_value(parser, "--undo", "N", "take the decision with this number back", number_from(1))
    add_flag(parser, "--json", "print one JSON object for each decision")


def _run(options: argparse.Namespace) -> int:
    from shapegoogle_core.client import LibraryAddress
    from shapegoogle_core.client.opening import token_from_environment

    address = LibraryAddress(options.library, token=token_from_environment())
    with address.open(read_only=options.undo is None) as library:
        made = library.decisions() if options.undo is None else [library.undo(options.undo)]
    if options.json:
        for decision in made:
            put(json.dumps(decision.to_json()))
        return DONE
    if not made:
        say("nothing was decided yet")
        return DONE
    rows = [
        (
            str(decision.number),
            datetime.fromtimestamp(decision.time, UTC).strftime("%Y-%m-%d %H:%M"),
            decision.author,
            decision.sentence,
        )
        for decision in made
    ]
    for line in table(rows, "><<<"):
        put(f"undone: {line}" if options.undo is not None else line)
    return DONE


COMMAND = Command("decisions", str(__doc__), _add_options, _run)
