# SPDX-License-Identifier: MIT
"""Draw a figure of the documentation.

    python -m benchmarks figures NAME [--output FILE.png]

keypoints    docs/images/keypoints.png: keypoints of each detector, on creatures in two poses and with noise
operators    docs/images/operator_convergence.png: error of eigenvalues against degrees of freedom; also
             prints the orders of convergence
signatures   docs/images/signatures.png: the attributes that the add-on paints, on creatures in several poses
             (paper, figure 5); needs the module bpy
"""

from __future__ import annotations

import argparse
import importlib
from pathlib import Path

from benchmarks.command import check_packages

__all__ = ["add_options", "run"]

_IMAGES = Path(__file__).resolve().parents[2] / "docs" / "images"

FIGURES = {
    "keypoints": "keypoints.png",
    "operators": "operator_convergence.png",
    "signatures": "signatures.png",
}
"""File name of each figure; the module of its name has `draw(path)`."""

NEEDS = {"operators": ("matplotlib",), "signatures": ("bpy",)}
"""Modules that a figure needs."""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    parser.add_argument("figure", choices=tuple(FIGURES), metavar="NAME", help=", ".join(FIGURES))
    parser.add_argument("--output", type=Path, metavar="FILE", help="default: its place in docs/images")


def run(options: argparse.Namespace) -> int:
    """Draw the figure.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
    """
    check_packages(NEEDS.get(options.figure, ()))
    path = options.output or _IMAGES / FIGURES[options.figure]
    importlib.import_module(f"benchmarks.figures.{options.figure}").draw(path)
    print(f"{path}: {path.stat().st_size / 1000:.0f} kB")
    return 0
