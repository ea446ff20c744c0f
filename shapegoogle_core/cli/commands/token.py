# SPDX-License-Identifier: MIT
"""Create, list and revoke the tokens of a service.

A token is shown once, when it is created; the file keeps only a hash of it. A running service notices changes
of the file at once.

for example:
  shapegoogle token create ana --scope write --token-file tokens.json
  shapegoogle token list --token-file tokens.json
  shapegoogle token revoke ana --token-file tokens.json
"""

from __future__ import annotations

import argparse

from shapegoogle_core.api.arguments import as_path
from shapegoogle_core.cli.command import DONE, SOME_FAILED, UNUSABLE, Command
from shapegoogle_core.cli.text import put, say, table

__all__ = ["COMMAND"]


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("action", choices=("create", "list", "revoke"), help="what to do")
    parser.add_argument("name", nargs="?", default="", metavar="NAME", help="whom the token is for")
    parser.add_argument(
        "--token-file", type=as_path, required=True, metavar="FILE", help="file of the tokens"
    )
    parser.add_argument(
        "--scope",
        choices=("read", "write"),
        default="read",
        help="search and look only, or decide and tag as well (%(default)s)",
    )


def _run(options: argparse.Namespace) -> int:
    from shapegoogle_core.service.tokens import TokenFile

    file = TokenFile(options.token_file)
    if options.action == "list":
        tokens = file.tokens()
        if tokens:
            for line in table([(token.name, token.scope, token.date) for token in tokens], "<<<"):
                put(line)
        else:
            say(f"'{options.token_file}' has no tokens")
        return DONE
    if not options.name:
        say(f"shapegoogle: name the token: shapegoogle token {options.action} NAME")
        return UNUSABLE
    if options.action == "create":
        put(file.create(options.name, options.scope))
        say("keep it: it is not shown again")
        return DONE
    if not file.revoke(options.name):
        say(f"shapegoogle: '{options.token_file}' has no token {options.name!r}")
        return SOME_FAILED
    say(f"{options.name!r} is revoked")
    return DONE


COMMAND = Command("token", str(__doc__), _add_options, _run)
