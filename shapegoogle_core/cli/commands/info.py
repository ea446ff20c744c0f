# SPDX-License-Identifier: MIT
"""Print what a library contains, or which plug-ins are installed.

--plugins lists the descriptors, keypoint detectors, mesh formats, candidate stages and re-rankers that other
packages add, and says why one cannot be used; the exit code is then 1.

for example:
  shapegoogle info --library shapes.sglib
  shapegoogle info --plugins
"""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from pathlib import Path

from shapegoogle_core.api.text import counted, one_line
from shapegoogle_core.cli.arguments import SEARCHED, add_flag, add_library
from shapegoogle_core.cli.command import DONE, SOME_FAILED, Command
from shapegoogle_core.cli.text import put, say, table
from shapegoogle_core.library.storage.address import is_service

__all__ = ["COMMAND"]


def _add_options(parser: argparse.ArgumentParser) -> None:
    which = parser.add_mutually_exclusive_group(required=True)
    add_library(which, SEARCHED, required=False)
    which.add_argument("--plugins", action="store_true", help="list the plug-ins of installed packages")
    add_flag(parser, "--json", "print one JSON object")


def _run(options: argparse.Namespace) -> int:
    if options.plugins:
        return _list_plugins(as_json=options.json)
    from shapegoogle_core.client import open_library
    from shapegoogle_core.library.library import Library

    with open_library(options.library) as library:
        info = library.info()
        roots = library.roots()
        advice = library.reindexing_advice()
        # A service tells only how many files failed.
        sources = library.sources() if isinstance(library, Library) else {}
        failures = {path: source.error for path, source in sources.items() if source.error}
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
        if is_service(options.library):
            put(f"{'root':<{width}}  {one_line(root.name)}")
            continue
        there = "" if Path(root.path).is_dir() else "; not there"
        line = f"{root.name}: {root.path} ({counted(root.source_count, 'source')}{there})"
        put(f"{'root':<{width}}  {one_line(line)}")
    if advice:
        say(advice)
    for path, error in failures.items():
        put(f"  {one_line(f'{path}: {error}')}")
    return DONE


def _list_plugins(*, as_json: bool) -> int:
    from shapegoogle_core.plugins import installed_plugins

    plugins = installed_plugins()
    problems = [plugin.problem for plugin in plugins if plugin.problem]
    if as_json:
        put(json.dumps({"plugins": [asdict(plugin) for plugin in plugins]}))
    elif plugins:
        rows = [("kind", "name", "package", "")]
        rows += [
            (
                plugin.kind,
                plugin.name,
                f"{plugin.package} {plugin.version}",
                "unusable" if plugin.problem else "",
            )
            for plugin in plugins
        ]
        put("\n".join(table(rows, "<<<<")))
    else:
        put("no plug-ins are installed")
    for problem in problems:
        say(problem)
    return SOME_FAILED if problems else DONE


COMMAND = Command("info", str(__doc__), _add_options, _run)
