# SPDX-License-Identifier: GPL-3.0-or-later
"""Shape Google without a window: `blender --command shape_google …` and the scripts of the repository."""

from __future__ import annotations

from collections.abc import Sequence

import bpy

__all__ = ["main", "register", "unregister"]

_handle: list[object] = []


def main(arguments: Sequence[str]) -> int:
    """Run the `shapegoogle` command with .blend and .fbx files among its inputs."""
    from shapegoogle_core import cli

    return cli.main(arguments)


def register() -> None:
    """Add `blender --command shape_google`; Blender as a Python module has no command line."""
    if bpy.app.binary_path:
        _handle.append(bpy.utils.register_cli_command("shape_google", main))


def unregister() -> None:
    """Take it back."""
    while _handle:
        bpy.utils.unregister_cli_command(_handle.pop())
