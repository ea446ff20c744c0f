# SPDX-License-Identifier: MIT
"""Put the shapes of folders with .blend and mesh files into a library; only new and changed files are read.

    blender --background --python scripts/index_library.py -- FOLDER... --library FILE [--jobs N]
    python scripts/index_library.py FOLDER... --library FILE [--jobs N]       (a Python that has bpy)

`--help` says more. Run it again to go on where it was interrupted. Exit codes: 0 all files indexed, 1 some
failed (each named on stderr), 2 nothing can be done.
"""

import runpy
from pathlib import Path

# Worker processes import the file that started them, and must not start all over again.
if __name__ == "__main__":
    # Blender does not put the folder of a script on the path.
    runpy.run_path(str(Path(__file__).parent / "lib" / "addon_package.py"))["run"](
        "commands", "index", program="index_library.py"
    )
