# SPDX-License-Identifier: MIT
"""Serve a library to other programs and to a web page.

The page is at the address that is printed. The interface for programs is described there at
/api/openapi.json.
Without tokens the service answers programs of this machine only. To let others search, create tokens and name
their file and an address that they reach:
  shapegoogle token create ana --scope write --token-file tokens.json
  shapegoogle serve --library shapes.sglib --token-file tokens.json --host 0.0.0.0

for example:
  shapegoogle serve --library shapes.sglib
  shapegoogle serve --library shapes.sglib --port 9000 --workers 4
"""

from __future__ import annotations

import argparse
import socket
from importlib.util import find_spec

from shapegoogle_core.api.arguments import as_path
from shapegoogle_core.cli.arguments import add_flag, add_library, add_value, number_from, positive_number
from shapegoogle_core.cli.command import DONE, UNUSABLE, Command
from shapegoogle_core.cli.text import put, say

__all__ = ["COMMAND"]

_PACKAGES = ("fastapi", "uvicorn", "multipart")


def _add_options(parser: argparse.ArgumentParser) -> None:
    add_library(parser)
    add_value(parser, "--host", "ADDRESS", "address to listen at (%(default)s)", str, "127.0.0.1")
    add_value(parser, "--port", "N", "port to listen at, 0 for any (%(default)s)", number_from(0), 8765)
    add_value(parser, "--workers", "N", "number of processes that search (%(default)s)", number_from(1), 1)
    token = "only clients with a token in this file may search"
    add_value(parser, "--token-file", "FILE", token, as_path)
    add_flag(parser, "--allow-download", "let clients download the files that shapes come from")
    limits = parser.add_argument_group("limits")
    add_value(limits, "--max-upload", "MB", "largest upload (%(default)s)", number_from(1), 64)
    seconds = "seconds for reading an upload, and for a search (%(default)g)"
    add_value(limits, "--time-limit", "S", seconds, positive_number, 60.0)
    memory = "memory in MB for reading an upload, on Linux (%(default)s)"
    add_value(limits, "--memory-limit", "MB", memory, number_from(1), 2048)
    add_value(limits, "--rate", "N", "searches of a client in a minute (%(default)s)", number_from(1), 120)


def _run(options: argparse.Namespace) -> int:
    missing = [name for name in _PACKAGES if find_spec(name) is None]
    if missing:
        command = "pip install 'shapegoogle-core[serve]'"
        say(f"shapegoogle: the service needs more packages; install them with: {command}")
        return UNUSABLE
    from shapegoogle_core.api.hosts import is_loopback

    if options.token_file is None and not is_loopback(options.host):
        say(
            f"shapegoogle: at {options.host} everybody in the network could search; create a token with "
            "`shapegoogle token create` and name its file with --token-file"
        )
        return UNUSABLE
    return _serve(options)


def _serve(options: argparse.Namespace) -> int:
    import uvicorn

    from shapegoogle_core.library.library import Library
    from shapegoogle_core.library.storage.address import shown_place
    from shapegoogle_core.processes.temporary import temporary_folder
    from shapegoogle_core.service.settings import ServiceSettings
    from shapegoogle_core.service.tokens import TokenFile

    # Errors now, and not in each process.
    with Library.open(options.library, read_only=True) as library:
        advice, name = library.reindexing_advice(), shown_place(options.library)
    if options.token_file is not None and not TokenFile(options.token_file).tokens():
        command = f"shapegoogle token create NAME --token-file '{options.token_file}'"
        say(f"'{options.token_file}' has no tokens yet; create one with: {command}")
    if advice:
        say(advice)
    try:
        listening = socket.create_server(
            (options.host, options.port),
            family=socket.AF_INET6 if ":" in options.host else socket.AF_INET,
            backlog=1024,
        )
    except OSError as error:
        place = f"{options.host}, port {options.port}"
        say(f"shapegoogle: cannot listen at {place} ({error.strerror}); choose another one")
        return UNUSABLE
    with listening, temporary_folder() as folder:
        port = listening.getsockname()[1]
        settings = ServiceSettings(
            library=str(options.library),
            spool=str(folder),
            host=options.host,
            port=port,
            workers=options.workers,
            token_file=None if options.token_file is None else str(options.token_file.absolute()),
            allow_download=options.allow_download,
            max_upload=options.max_upload,
            time_limit=options.time_limit,
            memory_limit=options.memory_limit,
            rate=options.rate,
        )
        settings.to_environment()
        shown = f"[{options.host}]" if ":" in options.host else options.host
        put(f"'{name}' is at http://{shown}:{port}/ (Ctrl-C ends the service)")
        config = uvicorn.Config(
            "shapegoogle_core.service.app:process_app",
            factory=True,
            workers=options.workers,
            log_level="warning",
            access_log=False,
            server_header=False,
            timeout_keep_alive=30,
            timeout_graceful_shutdown=5,
        )
        run_server(config, listening)
    return DONE


def run_server(config: object, listening: socket.socket) -> None:
    """Run a server, in several processes if there are to be several, until it is interrupted.

    Parameters
    ----------
    config : uvicorn.Config
    listening : socket.socket
        Bound to the address.
    """
    import uvicorn
    from uvicorn.supervisors import Multiprocess

    assert isinstance(config, uvicorn.Config)
    if config.workers > 1:
        Multiprocess(config, sockets=[listening]).run()
    else:
        uvicorn.Server(config).run(sockets=[listening])


COMMAND = Command("serve", str(__doc__), _add_options, _run)
