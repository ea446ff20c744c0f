# SPDX-License-Identifier: MIT
"""Run the add-on's tests in a Blender; pytest's exit code is that of the process.

    blender --background --python tests/run_in_blender.py -- [options of pytest]
    python tests/run_in_blender.py [options of pytest]          (a Python that has the bpy module)

pytest and the packages that the add-on needs must be on that Blender's path: `scripts/test.py` sees to it.
"""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

import bpy
import pytest

ROOT = Path(__file__).resolve().parent.parent


def arguments() -> list[str]:
    """Arguments for pytest; a Blender leaves those behind `--` to its scripts."""
    given = sys.argv[1:]
    if "--" in given:
        given = given[given.index("--") + 1 :]
    elif bpy.app.binary_path:
        given = []
    # Blender counts as one process for pytest: its cache on disk belongs to the run of the core's tests.
    return ["-p", "no:cacheprovider", *(given or ["tests/addon"])]


if __name__ == "__main__":
    os.chdir(ROOT)
    code = pytest.main(arguments())
    sys.stdout.flush()
    sys.stderr.flush()
    # As Blender does when it shuts down.
    shutil.rmtree(bpy.app.tempdir, ignore_errors=True)
    # Ends here: Blender would go on, and the bpy modules of 4.2 and 4.5 can crash while Python shuts down.
    os._exit(int(code))
