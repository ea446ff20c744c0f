# SPDX-License-Identifier: MIT
"""All shapes of the .blend library in one set: the options of commands that need it, and its signatures."""

from __future__ import annotations

import argparse
from pathlib import Path

from benchmarks.experiments.retrieval import default_cache
from benchmarks.kinds.describing import DescribedSet, describe_set
from benchmarks.kinds.sets import MEASURING, KindSet, pack_shapes
from benchmarks.protocol.cache import BenchmarkCache
from shapegoogle_core.cli.arguments import number_from
from shapegoogle_core.model import ShapeModel

__all__ = ["add_pack_options", "described_packs"]


def add_pack_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that say which shapes there are, and how they are described.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    parser.add_argument(
        "--blend-meshes", type=Path, required=True, metavar="FOLDER", help="exported .blend meshes"
    )
    parser.add_argument("--model", default="default", metavar="NAME", help="model (%(default)s)")
    parser.add_argument(
        "--cache", type=Path, metavar="FOLDER", help="signatures (default: in the user's cache folder)"
    )
    parser.add_argument(
        "--any-code",
        action="store_true",
        help="reuse signatures kept by runs with this option, even if the code has changed since",
    )
    parser.add_argument("--jobs", type=number_from(1), default=1, metavar="N", help="processes (%(default)s)")


def described_packs(options: argparse.Namespace, model: ShapeModel) -> DescribedSet:
    """Describe all shapes, labelled by their pack.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_pack_options`.
    model : ShapeModel
        The one that the options name.

    Returns
    -------
    described : DescribedSet
    """
    return describe_set(
        KindSet("packs", MEASURING, tuple(pack_shapes(options.blend_meshes))),
        model,
        options.model,
        BenchmarkCache(options.cache or default_cache()),
        jobs=options.jobs,
        any_code=options.any_code,
    )
