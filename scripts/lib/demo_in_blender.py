# SPDX-License-Identifier: MIT
"""The demo's part in Blender: an asset library of rigs, indexed and searched by the add-on, and a picture.

    python -m lib.demo_in_blender FOLDER LIBRARY PICTURE       (with the repository and scripts on the path)

`demo.py` runs it with a Python that has the `bpy` module. Run again, it only does what has changed.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("folder", metavar="FOLDER", type=Path, help="for the .blend files")
    parser.add_argument(
        "library", metavar="LIBRARY", type=Path, help="file for what the search needs of them"
    )
    parser.add_argument("picture", metavar="PICTURE", type=Path, help="file for the picture, .png")
    options = parser.parse_args(arguments)
    # Here, not above: worker processes that index import this file too, and bpy cannot be imported in them.
    from lib import demo_blend

    demo_blend.run(options.folder, options.library, options.picture)
    return 0


if __name__ == "__main__":
    code = main()
    from lib.addon_package import end_module

    end_module(code)
