# SPDX-License-Identifier: GPL-3.0-or-later
"""Shape Google without a window: `blender --command shape_google …` and the scripts of the repository."""

from __future__ import annotations

import signal
import sys
from collections.abc import Sequence

import bpy

from . import connections, needs, state

__all__ = ["main", "register", "unregister"]

COMMAND = "shape_google"
"""Name of the command for `blender --command`, which has to be an identifier."""
# As `shapegoogle_core.cli.command.UNUSABLE`, which cannot be imported without numpy.
UNUSABLE = 2


def main(arguments: Sequence[str], program: str = f"blender --command {COMMAND} {{command}}") -> int:
    """Run the `shapegoogle` command with .blend and .fbx files among its inputs.

    Parameters
    ----------
    arguments : sequence of str
        Such as ``["index", "assets", "--library", "shapes.sglib"]``; "paint" is `signature.command`.
    program : str, optional
        Name of the command in its help.

    Returns
    -------
    exit_code : int
        As of the command.
    """
    missing = needs.sentence()
    if missing:
        print(f"shapegoogle: {missing}", file=sys.stderr)
        return UNUSABLE
    from shapegoogle_core import cli
    from shapegoogle_core.processes.launching import orderly_end

    # Blender handles Ctrl-C itself; here it has to end the run so that the library stays whole. So does
    # SIGTERM, with which the window ends a background run.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    if arguments[:1] == ["paint"]:
        with orderly_end():
            from .signature import command

            return command.main(arguments[1:])
    return cli.main(arguments, reader=connections.blend_reader(), program=program)


def register() -> None:
    """Add `blender --command shape_google`; Blender as a Python module has no command line."""
    if bpy.app.binary_path:
        state.current().command = bpy.utils.register_cli_command(COMMAND, main)


def unregister() -> None:
    """Remove the command."""
    if state.current().command is not None:
        bpy.utils.unregister_cli_command(state.current().command)
        state.current().command = None
