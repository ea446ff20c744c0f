# SPDX-License-Identifier: MIT
"""Remove folders, files or missing files from a library. No file on disk is touched.

Without --missing, everything below each FOLDER is forgotten, whether the folder still exists or not; a SOURCE
is a single file, or the text that shapes were added under. With --missing, only files that no longer exist
are forgotten: those below each FOLDER, or all. A folder that is not there, or empty as where a drive is
mounted, keeps its files unless it is named without --missing.

With --json, one line: {"forgotten": [path, …], "shapes", "kept": {folder: number of its missing files, …},
"dry_run"}.

for example:
  shapegoogle forget ~/old-models --library shapes.sglib --dry-run
  shapegoogle forget --missing --library shapes.sglib
"""

from __future__ import annotations

import argparse
import json

from shapegoogle_core.api.text import counted, one_line
from shapegoogle_core.cli.arguments import add_flag, add_library, add_roots, map_roots
from shapegoogle_core.cli.command import DONE, UNUSABLE, Command
from shapegoogle_core.cli.text import put, say

__all__ = ["COMMAND"]


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folders", nargs="*", metavar="FOLDER|SOURCE", help="what to forget")
    add_library(parser)
    add_roots(parser)
    add_flag(parser, "--missing", "forget only files that no longer exist")
    add_flag(parser, "--dry-run", "only list what would be forgotten")
    add_flag(parser, "--json", "print one JSON object")


def _run(options: argparse.Namespace) -> int:
    from shapegoogle_core.library.library import Library
    from shapegoogle_core.library.storage.opening import check_exists

    if not options.folders and not options.missing:
        say("shapegoogle: name the folders or sources to forget, or use --missing")
        return UNUSABLE
    check_exists(options.library)
    with Library.open(options.library, read_only=options.dry_run) as library:
        map_roots(library, options)
        report = library.forget(options.folders, missing=options.missing, dry_run=True)
        if not options.json:
            title = f"{counted(len(report.forgotten), 'source')}, {counted(report.shape_count, 'shape')}"
            put(f"{title}:" if report.forgotten else f"{title} to forget")
            for path in report.forgotten:
                put(one_line(f"  {path}"))
            for folder, count in report.kept:
                say(
                    one_line(
                        f"kept {counted(count, 'missing file')} below '{folder}', which is not there or "
                        "empty; its drive may not be connected: if it was moved use `shapegoogle move`, to "
                        "forget them name it without --missing"
                    )
                )
        if not options.dry_run:
            library.forget(options.folders, missing=options.missing)
    if options.json:
        record = {"forgotten": report.forgotten, "shapes": report.shape_count, "kept": dict(report.kept)}
        put(json.dumps({**record, "dry_run": options.dry_run}))
    elif options.dry_run:
        put("dry run: nothing was changed")
    elif report.forgotten:
        put("forgotten")
    return DONE


COMMAND = Command("forget", str(__doc__), _add_options, _run)
