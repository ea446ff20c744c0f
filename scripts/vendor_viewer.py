# SPDX-License-Identifier: MIT
"""Build the 3-D viewer of the service's web page: the parts of three.js that it uses, as one file.

    python3 scripts/vendor_viewer.py

Needs Node.js with npm, and the npm registry. The versions below and the entry that this script writes decide
the content; nothing else goes into the file. The built file and its licence are kept in the repository, so
that nobody needs Node.js to run or test the page.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

TARGET = Path(__file__).resolve().parents[1] / "shapegoogle_core" / "service" / "page" / "vendor"
THREE, ESBUILD = "0.187.0", "0.28.2"
# What shapegoogle_core/service/page/viewer.js imports.
NAMES = (
    *("AmbientLight", "BufferAttribute", "BufferGeometry", "DirectionalLight", "DoubleSide", "Group"),
    *("HemisphereLight", "Mesh", "MeshStandardMaterial", "PerspectiveCamera", "Points", "PointsMaterial"),
    *("Quaternion", "Scene", "Vector3", "WebGLRenderer"),
)
ENTRY = f"""\
export {{ {", ".join(NAMES)} }} from "three";
export {{ OrbitControls }} from "three/addons/controls/OrbitControls.js";
"""
BANNER = (
    f"/* three.js {THREE}, MIT licence, see three.LICENSE.txt; "
    f"built with esbuild {ESBUILD} by scripts/vendor_viewer.py */"
)


def main() -> int:
    npm = shutil.which("npm")
    if npm is None:
        print("Node.js with npm is needed: install it from your system's packages", file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "package.json").write_text('{"private": true}')
        (folder / "entry.js").write_text(ENTRY)
        packages = [f"three@{THREE}", f"esbuild@{ESBUILD}"]
        subprocess.run([npm, "install", "--no-audit", "--no-fund", *packages], cwd=folder, check=True)
        command = [str(folder / "node_modules" / ".bin" / "esbuild"), "entry.js", "--bundle", "--minify"]
        command += ["--format=esm", "--target=es2021", "--legal-comments=none", f"--banner:js={BANNER}"]
        TARGET.mkdir(parents=True, exist_ok=True)
        subprocess.run([*command, f"--outfile={TARGET / 'three.js'}"], cwd=folder, check=True)
        shutil.copyfile(folder / "node_modules" / "three" / "LICENSE", TARGET / "three.LICENSE.txt")
    print(f"{TARGET / 'three.js'}: {(TARGET / 'three.js').stat().st_size:,} bytes")
    return 0


if __name__ == "__main__":
    sys.exit(main())
