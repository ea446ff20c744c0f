# SPDX-License-Identifier: MIT
"""Upgrade a library that an earlier version of Shape Google has made, after writing a backup.

A file is copied first, to a file beside it with the old format in its name. A database is saved with pg_dump,
which must be on this computer, into a file that pg_restore reads; with --no-backup if you have a backup.
A library that is up to date is left as it is.

for example:
  shapegoogle upgrade shapes.sglib
  shapegoogle upgrade postgresql://owner@server/shapes --backup /backups/shapes.dump
"""

from __future__ import annotations

import argparse

from shapegoogle_core.api.arguments import as_path
from shapegoogle_core.cli.arguments import add_flag, add_value
from shapegoogle_core.cli.command import DONE, Command
from shapegoogle_core.cli.text import put
from shapegoogle_core.library.storage.address import as_place, shown_place

__all__ = ["COMMAND"]


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("library", type=as_place, metavar="LIBRARY", help="file, or postgresql:// address")
    add_value(parser, "--backup", "FILE", "file for the backup, which must not exist", as_path)
    add_flag(parser, "--no-backup", "make no backup, because there is one")


def _run(options: argparse.Namespace) -> int:
    from shapegoogle_core.library.upgrading import upgrade_library

    report = upgrade_library(options.library, options.backup, make_backup=not options.no_backup)
    name = shown_place(options.library)
    if not report.upgraded:
        put(f"'{name}' is up to date (format {report.format})")
        return DONE
    saved = "" if report.backup is None else f"; as it was, it is in '{report.backup}'"
    put(f"'{name}' has format {report.format} now{saved}")
    return DONE


COMMAND = Command("upgrade", str(__doc__), _add_options, _run)
