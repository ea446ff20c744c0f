# SPDX-License-Identifier: MIT
"""Measure how long people wait in Blender: the section "blender" of `benchmarks speed`, run by Blender.

    python -m benchmarks.speed.in_blender OUTPUT [--sizes N...] [--repeats N]
    blender --background --python benchmarks/speed/in_blender.py -- OUTPUT [--sizes N...] [--repeats N]

The first runs here if this Python has the bpy module, else in the Blender that the environment variable
BLENDER names or that is on PATH. What is measured is said in `blender.py`.

Writes speed-blender.json, and where matplotlib is installed speed-blender.png, into the folder OUTPUT.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"


def main(arguments: Sequence[str]) -> int:
    import environment

    from benchmarks.speed import blender
    from benchmarks.speed.measuring import Options, installed
    from benchmarks.speed.reporting import line, write_figure, write_rows

    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0], prog=Path(__file__).name)
    parser.add_argument("output", type=Path, metavar="OUTPUT")
    parser.add_argument("--sizes", type=int, nargs="+", default=blender.SIZES, metavar="N")
    parser.add_argument("--repeats", type=int, default=blender.REPEATS, metavar="N")
    options = parser.parse_args(arguments)
    options.output.mkdir(parents=True, exist_ok=True)
    rows = []
    try:
        for row in blender.measure(Options(tuple(options.sizes), options.repeats, options.output)):
            rows.append(row)
            print(line(row), flush=True)
    except environment.SetupError as error:
        print(f"Neither a bpy module nor a Blender: {error}", file=sys.stderr)
        return 2
    write_rows("blender", rows, options.output)
    if installed("matplotlib"):
        write_figure("blender", blender.draw(rows), options.output)
    else:
        print("matplotlib is not installed; there is no picture", file=sys.stderr)
    return 0


if __name__ == "__main__":
    # Blender does not put the folder of a script on the path, and leaves its own arguments in sys.argv.
    sys.path[:0] = [str(SCRIPTS.parent), str(SCRIPTS)]
    code = main(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:])
    sys.stdout.flush()
    # Ends here: the bpy modules of 4.2 and 4.5 can crash while Python shuts down.
    os._exit(code)
