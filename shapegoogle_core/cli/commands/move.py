# SPDX-License-Identifier: MIT
"""Tell a library that a folder lies elsewhere now; its files are not read again.

OLD is the folder as it was: one that was indexed, one above or one below. It need not exist any more. NEW is
the folder that has the same files in it now. No file on disk is touched.

With --json, one line: {"moved": [[old path, new path], …], "found": number of these files that are there,
"missing": [new path, …], "merged": [old path, …], "roots": [{"name", "old", "new"}, …], "dry_run"}.
merged are files that the library knew at their new place too.

for example:
  shapegoogle move ~/models /mnt/nas/models --library shapes.sglib --dry-run
  shapegoogle move ~/models /mnt/nas/models --library shapes.sglib
"""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING

from shapegoogle_core.api.arguments import as_path
from shapegoogle_core.api.text import counted, one_line
from shapegoogle_core.cli.arguments import add_flag, add_library
from shapegoogle_core.cli.command import DONE, Command
from shapegoogle_core.cli.text import put

if TYPE_CHECKING:
    from shapegoogle_core.library.roots.moving import MoveReport

__all__ = ["COMMAND"]

# Number of missing files that are listed.
_LISTED = 20


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("old", type=as_path, metavar="OLD", help="folder as it was")
    parser.add_argument("new", type=as_path, metavar="NEW", help="folder as it is now")
    add_library(parser)
    add_flag(parser, "--dry-run", "only say what would be moved, and how many of the files are there")
    add_flag(parser, "--json", "print one JSON object")


def _run(options: argparse.Namespace) -> int:
    from shapegoogle_core.library.library import Library
    from shapegoogle_core.library.storage.opening import check_exists

    check_exists(options.library)
    with Library.open(options.library, read_only=options.dry_run) as library:
        report = library.move(options.old, options.new, dry_run=options.dry_run)
    if options.json:
        put(json.dumps(_record(report, dry_run=options.dry_run)))
    else:
        _show(report, dry_run=options.dry_run)
    return DONE


def _record(report: MoveReport, *, dry_run: bool) -> dict[str, object]:
    return {
        "moved": report.sources,
        "found": report.found,
        "missing": report.missing,
        "merged": report.merged,
        "roots": [{"name": name, "old": old or None, "new": new} for name, old, new in report.roots],
        "dry_run": dry_run,
    }


def _show(report: MoveReport, *, dry_run: bool) -> None:
    for name, old, new in report.roots:
        put(one_line(f"root {name}: {old} → {new}" if old else f"new root {name}: {new}"))
    put(f"{report.found:,} of {counted(len(report.sources), 'file')} found at the new place")
    for path in report.missing[:_LISTED]:
        put(one_line(f"  not there: {path}"))
    if len(report.missing) > _LISTED:
        put(f"  and {len(report.missing) - _LISTED:,} more are not there")
    if report.merged:
        put(f"{counted(len(report.merged), 'file')} known at both places, now one source each")
    put(
        "dry run: nothing was changed" if dry_run else "moved; files that have not changed are not read again"
    )


COMMAND = Command("move", str(__doc__), _add_options, _run)
