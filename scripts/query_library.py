# SPDX-License-Identifier: MIT
"""Find the shapes of a library that are most like those of .blend or mesh files.

    blender --background --python scripts/query_library.py -- FILE... --library FILE [--top N] [--json]
    python scripts/query_library.py FILE... --library FILE [--top N] [--json]       (a Python that has bpy)

`--help` says more. Exit codes: 0 all answered, 1 some files failed, 2 nothing can be done.
"""

import runpy
from pathlib import Path

# Worker processes import the file that started them, and must not start all over again.
if __name__ == "__main__":
    # Blender does not put the folder of a script on the path.
    runpy.run_path(str(Path(__file__).parent / "lib" / "addon_package.py"))["run"](
        "commands", "query", program="query_library.py"
    )
