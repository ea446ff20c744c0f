# SPDX-License-Identifier: MIT
"""Let roles use a library in a PostgreSQL database, or make the index that large libraries need.

--reader   the role may search, and not change anything
--writer   the role may also add and remove shapes
--index    with pgvector 0.7 or later on the server: an IVFFlat index of the codes, with as many lists as the
           square root of the number of shapes, at most 2,000. It is made anew if it is there, which is worth
           it once the number of shapes has doubled. Meanwhile writers wait, and the server needs up to 0.9 GB
           of memory. Below 2,000,000 shapes it is not used.
--sql      print the statements for an administrator, and run none

for example:
  shapegoogle database --library postgresql://owner@server/shapes --reader artists --writer farm
  shapegoogle database --library postgresql://owner@server/shapes --index
"""

from __future__ import annotations

import argparse
import time
from contextlib import closing

from shapegoogle_core.api.text import counted
from shapegoogle_core.cli.arguments import add_flag, add_library
from shapegoogle_core.cli.command import DONE, UNUSABLE, Command
from shapegoogle_core.cli.text import put, say
from shapegoogle_core.library.storage.address import is_database, shown_place

__all__ = ["COMMAND"]

_WAIT = 30.0


def _add_options(parser: argparse.ArgumentParser) -> None:
    add_library(parser, "postgresql:// address, of a role that owns the tables")
    for option, summary in (
        ("--reader", "role that may search"),
        ("--writer", "role that may also change it"),
    ):
        dest = f"{option[2:]}s"
        parser.add_argument(option, dest=dest, action="append", default=[], metavar="ROLE", help=summary)
    add_flag(parser, "--index", "make the index of codes, or make it anew")
    add_flag(parser, "--sql", "only print the statements")


def _run(options: argparse.Namespace) -> int:
    from shapegoogle_core.library.storage.opening import connect

    name = shown_place(options.library)
    if not is_database(options.library):
        say(f"shapegoogle: '{name}' is a file; only databases have roles and this index")
        return UNUSABLE
    if not (options.readers or options.writers or options.index):
        say("shapegoogle: name a --reader or a --writer, or ask for the --index")
        return UNUSABLE
    with closing(connect(options.library, read_only=False, timeout=_WAIT)) as store:
        from shapegoogle_core.library.storage.postgresql import administration

        if store.is_empty():
            say(f"shapegoogle: there is no library in '{name}'; index a folder into it first")
            return UNUSABLE
        store.check_format()
        access = administration.grants(store, options.readers, options.writers)
        index = administration.index_statements(store) if options.index else []
        if options.sql:
            put("\n".join(f"{statement};" for statement in [*access, *index]))
            return DONE
        administration.run_statements(store, access)
        for roles, may in ((options.readers, "search"), (options.writers, "search and change")):
            if roles:
                put(f"{', '.join(roles)}: may {may} '{name}'")
        if index:
            count = store.count()
            say(f"making the index of {counted(count, 'code')}; writers wait meanwhile")
            started = time.monotonic()
            administration.run_statements(store, index)
            put(
                f"index of {counted(count, 'code')} in {counted(store.index_lists(), 'list')} made in "
                f"{time.monotonic() - started:.1f} s"
            )
    return DONE


COMMAND = Command("database", str(__doc__), _add_options, _run)
