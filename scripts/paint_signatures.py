# SPDX-License-Identifier: MIT
"""Write heat kernel signatures and geometric words onto the meshes of a .blend file, in a copy.

    blender --background --python scripts/paint_signatures.py -- IN.blend --output OUT.blend [--attribute …]
    python scripts/paint_signatures.py IN.blend --output OUT.blend [--attribute …]

`--help` says more. Exit codes: 0 all objects painted, 1 some failed, 2 nothing can be done.
"""

import runpy
from pathlib import Path

if __name__ == "__main__":
    # Blender does not put the folder of a script on the path.
    runpy.run_path(str(Path(__file__).parent / "lib" / "addon_package.py"))["run"]("signature.command")
