# SPDX-License-Identifier: MIT
"""Entry point of `python -m benchmarks`."""

import os
import shutil
import sys

from benchmarks.command import main

if __name__ == "__main__":
    code = main()
    if "bpy" in sys.modules:
        # The bpy modules of Blender 4.2 and 4.5 can crash while Python shuts down, which removes this folder.
        shutil.rmtree(sys.modules["bpy"].app.tempdir, ignore_errors=True)
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)
    sys.exit(code)
