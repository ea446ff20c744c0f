# SPDX-License-Identifier: MIT
"""Draw what a search finds for twenty things of the .blend library, to be looked at as an artist would.

    python -m benchmarks kinds-picture --blend-meshes FOLDER [--output FILE.png]

All shapes of the .blend library are in one library. The things are spread evenly over it, in the order of
packs and names; each row shows one and its first matches, with kind, similarity and likeness.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.figures.contact_sheet import contact_sheet
from benchmarks.kinds.describing import DescribedSet
from benchmarks.kinds.packs import add_pack_options, described_packs
from benchmarks.kinds.sets import KindShape, pack_shapes
from shapegoogle_core.cli.arguments import number_from
from shapegoogle_core.cli.command import DONE
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.match import Match
from shapegoogle_core.model import ShapeModel, load_model
from shapegoogle_core.rendering import canonical_view, render

if TYPE_CHECKING:
    from PIL import Image

__all__ = ["add_options", "rows_of", "run"]

_PIXELS = 120
_MATCHES = 7


def rows_of(
    described: DescribedSet, model: ShapeModel, things: int, top: int = _MATCHES
) -> list[tuple[str, list[Match]]]:
    """Search with some things, spread evenly over a set.

    Parameters
    ----------
    described : DescribedSet
    model : ShapeModel
    things : int
    top : int, optional
        Number of matches of each, without itself.

    Returns
    -------
    rows : list of (str, list of Match)
        Name of each thing, and its matches.
    """
    chosen = np.linspace(0, len(described.names), things, endpoint=False).astype(int).tolist()
    with tempfile.TemporaryDirectory() as folder, Library.open(Path(folder, "packs.sglib"), model) as library:
        ids = [
            library.add_signature(signature, name)
            for signature, name in zip(described.signatures, described.names, strict=True)
        ]
        return [
            (
                described.names[row],
                [
                    match
                    for match in library.query(described.signatures[row], top=top + 1)
                    if match.shape_id != ids[row]
                ][:top],
            )
            for row in dict.fromkeys(chosen)
        ]


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    add_pack_options(parser)
    parser.add_argument(
        "--things", type=number_from(1), default=20, metavar="N", help="number of rows (%(default)s)"
    )
    parser.add_argument(
        "--output", type=Path, default=Path("kinds.png"), metavar="FILE", help="picture (%(default)s)"
    )


def run(options: argparse.Namespace) -> int:
    """Search, and save the picture.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
    """
    model = load_model(options.model)
    shapes = pack_shapes(options.blend_meshes)
    described = described_packs(options, model)
    _sheet(rows_of(described, model, options.things), shapes).save(options.output, optimize=True)
    print(f"{options.output}: {options.output.stat().st_size / 1000:.0f} kB")
    return DONE


def _sheet(rows: Sequence[tuple[str, Sequence[Match]]], shapes: Sequence[KindShape]) -> Image.Image:
    by_name = {shape.name: shape for shape in shapes}
    images, captions = [], []
    for name, matches in rows:
        for shown in (name, *(match.name for match in matches)):
            mesh = by_name[shown].mesh()
            images.append(render(mesh, None, (_PIXELS, _PIXELS), view=canonical_view(mesh)))
        captions += [f"{name}\n({by_name[name].label})", *map(_caption, matches)]
    return contact_sheet(images, captions, columns=1 + _MATCHES)


def _caption(match: Match) -> str:
    kind = match.evidence.kind if match.evidence else ""
    likeness = "" if match.likeness is None else f", likeness {match.likeness:.2f}"
    return f"{match.name}\n{kind} {match.similarity:.2f}{likeness}"
