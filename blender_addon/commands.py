# SPDX-License-Identifier: GPL-3.0-or-later
"""Shape Google without a window: `blender --command shape_google …` and the scripts of the repository."""

from __future__ import annotations

import signal
import sys
from collections.abc import Sequence

import bpy

from . import assets

__all__ = ["main", "register", "unregister"]

COMMAND = "shape_google"
"""What `blender --command` calls it: an identifier, so no hyphen."""

_handle: list[object] = []


def main(arguments: Sequence[str], program: str = f"blender --command {COMMAND}") -> int:
    """Run the `shapegoogle` command with .blend and .fbx files among its inputs.

    Parameters
    ----------
    arguments : sequence of str
        Such as ``["index", "assets", "--library", "shapes.sglib"]``. One more option than the command has:
        ``--objects assets`` takes of a .blend file only what is marked as an asset, if anything is.
    program : str, optional
        What the help calls the command.

    Returns
    -------
    exit_code : int
        As of the command.
    """
    from shapegoogle_core import cli

    # Blender leaves Ctrl-C to itself; here it must end the run in an orderly way.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    remaining, objects = _take_option(list(arguments), "--objects", ("all", "assets"))
    return cli.main(remaining, reader=assets.blend_reader(objects), program=program)


def _take_option(arguments: list[str], name: str, choices: tuple[str, ...]) -> tuple[list[str], str]:
    """Take an option that the core's command does not know out of its arguments; the first is the default."""
    if name not in arguments:
        return arguments, choices[0]
    place = arguments.index(name)
    value = arguments[place + 1] if place + 1 < len(arguments) else ""
    if value not in choices:
        sys.exit(f"{name} must be one of {', '.join(choices)}, not {value!r}")
    return arguments[:place] + arguments[place + 2 :], value


def register() -> None:
    """Add `blender --command shape_google`; Blender as a Python module has no command line."""
    if bpy.app.binary_path:
        _handle.append(bpy.utils.register_cli_command(COMMAND, main))


def unregister() -> None:
    """Take it back."""
    while _handle:
        bpy.utils.unregister_cli_command(_handle.pop())
