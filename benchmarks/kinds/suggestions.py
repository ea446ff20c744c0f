# SPDX-License-Identifier: MIT
"""Measure how often the first suggested folder and the first suggested word of a name are right.

    python -m benchmarks suggestions --blend-meshes FOLDER [--relatives N]

All shapes of the .blend library are in one library, each in the folder of its pack and under its name. Each
asks in turn for suggestions; it is not one of its own relatives, so this is leave-one-out. A folder is right
if it is the shape's pack, and a word if the shape's own name has it. Nothing may be chosen by the figures of
the packs held out or of the posed characters.

possible   shapes whose folder, or a word of whose name, another shape has: the others cannot be right
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.errors import BenchmarkError
from benchmarks.kinds.describing import DescribedSet
from benchmarks.kinds.packs import add_pack_options, described_packs
from shapegoogle_core.cli.arguments import number_from
from shapegoogle_core.cli.command import DONE
from shapegoogle_core.cli.text import say, table
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.suggestions.suggest import RELATIVES, Suggestion, SuggestionKind
from shapegoogle_core.library.suggestions.words import name_words
from shapegoogle_core.model import ShapeModel, load_model

__all__ = ["Answer", "add_options", "answers", "run"]


@dataclass(frozen=True)
class Answer:
    """What was suggested for a shape.

    Attributes
    ----------
    pack : str
    possible : dict of str to bool
        Whether a "folder", or a "word", can be right at all.
    right : dict of str to bool
        Whether the first one is.
    confidence : dict of str to float
        Of the first one; 0 if there is none.
    """

    pack: str
    possible: Mapping[SuggestionKind, bool]
    right: Mapping[SuggestionKind, bool]
    confidence: Mapping[SuggestionKind, float]


_KINDS: tuple[SuggestionKind, ...] = ("folder", "word")


def answers(described: DescribedSet, model: ShapeModel, relatives: int = RELATIVES) -> list[Answer]:
    """Ask for suggestions for each shape among the others.

    Parameters
    ----------
    described : DescribedSet
        Labelled by pack.
    model : ShapeModel
    relatives : int, optional

    Returns
    -------
    answers : list of Answer
    """
    own: list[Mapping[SuggestionKind, set[str]]] = [
        {"folder": {pack}, "word": set(name_words(name))}
        for name, pack in zip(described.names, described.labels, strict=True)
    ]
    found = []
    with tempfile.TemporaryDirectory() as folder, Library.open(Path(folder, "packs.sglib"), model) as library:
        ids = [
            library.add_signature(signature, name, source=Path(folder, pack, name))
            for signature, name, pack in zip(
                described.signatures, described.names, described.labels, strict=True
            )
        ]
        for row, shape_id in enumerate(ids):
            suggested = library.suggest(shape_id, relatives=relatives)
            others = own[:row] + own[row + 1 :]
            first = {kind: _first(suggested, kind) for kind in _KINDS}
            found.append(
                Answer(
                    described.labels[row],
                    {kind: any(own[row][kind] & other[kind] for other in others) for kind in _KINDS},
                    {kind: one is not None and one.text in own[row][kind] for kind, one in first.items()},
                    {kind: 0.0 if one is None else one.confidence for kind, one in first.items()},
                )
            )
    return found


def _first(suggested: Sequence[Suggestion], kind: SuggestionKind) -> Suggestion | None:
    return next((one for one in suggested if one.kind == kind), None)


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    add_pack_options(parser)
    parser.add_argument(
        "--relatives",
        type=number_from(1),
        default=RELATIVES,
        metavar="N",
        help="nearest relatives that vote (%(default)s)",
    )


def run(options: argparse.Namespace) -> int:
    """Measure, and print a row for each pack.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
    """
    model = load_model(options.model)
    described = described_packs(options, model)
    for name, reason in described.failures.items():
        say(f"left out: {name}: {reason}")
    if not described.names:
        raise BenchmarkError(f"'{options.blend_meshes}' has no shape that can be described")
    print(_text(answers(described, model, options.relatives)))
    return DONE


def _text(found: Sequence[Answer]) -> str:
    header = ["pack", "shapes"]
    for kind in _KINDS:
        header += [f"{kind}: possible", "right", "right if confidence ≥ 0.5"]
    packs = sorted({answer.pack for answer in found})
    rows = [[pack, *_cells([answer for answer in found if answer.pack == pack])] for pack in packs]
    return "\n".join(table([header, *rows, ["all", *_cells(found)]], "<" + ">" * (len(header) - 1)))


def _cells(some: Sequence[Answer]) -> list[str]:
    cells = [str(len(some))]
    for kind in _KINDS:
        sure = [answer.right[kind] for answer in some if answer.confidence[kind] >= 0.5]
        right = 100 * float(np.mean([answer.right[kind] for answer in some]))
        cells += [
            str(sum(answer.possible[kind] for answer in some)),
            f"{right:.0f} %",
            f"{sum(sure)} of {len(sure)}",
        ]
    return cells
