# SPDX-License-Identifier: MIT
"""Print what a library contains."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from shapegoogle_core.api.text import counted, one_line
from shapegoogle_core.cli.arguments import add_flag, add_library
from shapegoogle_core.cli.command import DONE, Command
from shapegoogle_core.cli.text import put, say

__all__ = ["COMMAND"]


def _add_options(parser: argparse.ArgumentParser) -> None:
    add_library(parser)
    add_flag(parser, "--json", "print one JSON object")


def _run(options: argparse.Namespace) -> int:
    from shapegoogle_core.library.library import Library

    with Library.open(options.library, read_only=True) as library:
        info = library.info()
        roots = library.roots()
        advice = library.reindexing_advice()
        failures = {path: source.error for path, source in library.sources().items() if source.error}
    if options.json:
        put(json.dumps({**info, "failures": failures}))
        return DONE
    width = max(map(len, info))
    for key, value in info.items():
        if key == "roots":
            continue
        shown = f"{value:,}" if isinstance(value, int) else value
        put(f"{key.replace('_', ' '):<{width}}  {one_line(str(shown))}")
    for root in roots:
        there = "" if Path(root.path).is_dir() else "; not there"
        line = f"{root.name}: {root.path} ({counted(root.source_count, 'source')}{there})"
        put(f"{'root':<{width}}  {one_line(line)}")
    if advice:
        say(advice)
    for path, error in failures.items():
        put(f"  {one_line(f'{path}: {error}')}")
    return DONE


COMMAND = Command("info", str(__doc__), _add_options, _run)
