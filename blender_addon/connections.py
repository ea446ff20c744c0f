# SPDX-License-Identifier: GPL-3.0-or-later
"""Connections to other programs: asset libraries, the Blender that reads files, the command as a process."""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import bpy

from .reading.importers import importable_suffixes

if TYPE_CHECKING:
    from shapegoogle_core.indexing import ExternalReader

__all__ = [
    "asset_libraries",
    "blend_reader",
    "package_command",
]

# Factory settings exclude other add-ons and the user's start-up file; scripts in files do not run.
_QUIET_BLENDER = ("--background", "--factory-startup", "--disable-autoexec", "--python-exit-code", "1")


def asset_libraries() -> list[tuple[str, Path]]:
    """Names and folders of the asset libraries in Blender's preferences, whether they exist or not."""
    libraries = bpy.context.preferences.filepaths.asset_libraries
    return [(library.name, Path(bpy.path.abspath(library.path))) for library in libraries if library.path]


def blend_reader() -> ExternalReader:
    """Return the Blender that reads .blend files and what it imports for the core.

    Returns
    -------
    reader : ExternalReader
        This Blender once more, in the background; where Blender is a Python module, this Python.
    """
    from shapegoogle_core.indexing import ExternalReader, ReaderOption

    script = str(Path(__file__).with_name("reading") / "reader.py")
    command: tuple[str, ...]
    if bpy.app.binary_path:
        command = (bpy.app.binary_path, *_QUIET_BLENDER, "--python", script)
    else:
        command = (sys.executable, script)
    return ExternalReader(
        suffixes=frozenset((".blend", *importable_suffixes())),
        command=command,
        title=f"Blender {bpy.app.version_string}",
        offers=(
            ReaderOption(
                "objects",
                ("all", "assets"),
                "objects of a .blend file that are shapes: all meshes, or only those marked as assets if "
                "there are any",
            ),
            ReaderOption(
                "frames",
                ("",),
                "frames of animated .blend files, such as 1,10,20: each pose of an object is a shape of its "
                'own, such as "Horse @ 10" (default: the frame that the file was saved at)',
                numbers=True,
            ),
        ),
    )


def package_command(arguments: Sequence[str]) -> tuple[list[str], dict[str, str]]:
    """Command line that runs this add-on's `commands.main` in a process of its own.

    Parameters
    ----------
    arguments : sequence of str
        As for `commands.main`.

    Returns
    -------
    command : list of str
    environment : dict
        The environment variables to run it with.
    """
    package = importlib.import_module(__package__ or "").__name__
    run = f"import sys, importlib; sys.exit(importlib.import_module({package + '.commands'!r}).main(sys.argv"
    environment = dict(os.environ)
    if bpy.app.binary_path:
        # `--addons` also where the user has not saved that the add-on is on.
        options = ["--background", "--disable-autoexec", "--python-exit-code", "1", "--addons", package]
        # Worker processes import their parent's main file, and Blender calls it "<blender string>".
        code = f"__file__ = None; {run}[sys.argv.index('--') + 1:]))"
        return [bpy.app.binary_path, *options, "--python-expr", code, "--", *arguments], environment
    # The other process has to find this package wherever it starts.
    paths = [str(Path(__file__).parents[package.count(".") + 1]), environment.get("PYTHONPATH", "")]
    environment["PYTHONPATH"] = os.pathsep.join(path for path in paths if path)
    return [sys.executable, "-c", run + "[1:]))", *arguments], environment
