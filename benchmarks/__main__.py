# SPDX-License-Identifier: MIT
"""`python -m benchmarks`: measure the search as the paper does, and write a report."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from benchmarks import command
from shapegoogle_core.cli.exit_codes import UNUSABLE
from shapegoogle_core.cli.text import say
from shapegoogle_core.errors import ShapeGoogleError

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command.

    Parameters
    ----------
    arguments : sequence of str, optional
        Those of the command line when left out.

    Returns
    -------
    exit_code : int
    """
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks",
        description="Measure the search on collections of meshes, as the paper does.",
        epilog=command.DETAILS,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    command.add_options(parser)
    options = parser.parse_args(arguments)
    try:
        return command.benchmark(options)
    except ShapeGoogleError as error:
        say(f"python -m benchmarks: {error}")
        return UNUSABLE


if __name__ == "__main__":
    sys.exit(main())
