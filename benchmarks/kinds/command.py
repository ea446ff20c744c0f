# SPDX-License-Identifier: MIT
"""Measure how well a search finds more of the same kind, with and without each of its parts.

    python -m benchmarks kinds [--sets NAME …] [--parts NAME …] [--blend-meshes FOLDER] [--data FOLDER]

Every shape of a labelled set queries for the others of its label. Printed are nearest neighbour, first tier,
second tier and discounted cumulative gain in percent, as the Princeton Shape Benchmark defines them.

development sets   objects and creatures (by kind), poses (individuals in several poses), people (persons in
                   several poses), and the CC0 packs to learn from, labelled by the words of their names
held out           the other CC0 packs; everyday things by kind, upright and turned
measuring          the labelled models of the evaluation data; nothing may be chosen by them
parts              bags: bags of words only; views: appearance from outside only; gradients: views without
                   the network; measures: simple measures only; kind: bags, views and measures together;
                   gate: the same with the gate for the same shape; search: the product's own list of
                   matches, with the walk over the neighbour graph

Signatures are kept in --cache for each mesh, model and state of the code.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import astuple, dataclass
from pathlib import Path

from benchmarks.errors import BenchmarkError
from benchmarks.experiments.retrieval import EVALUATION_DATA, default_cache
from benchmarks.kinds.describing import describe_set
from benchmarks.kinds.parts import PARTS
from benchmarks.kinds.sets import KindSet, evaluation_sets, pack_sets, procedural_sets
from benchmarks.protocol.cache import BenchmarkCache
from benchmarks.protocol.metrics import CategoryScores, category_scores
from shapegoogle_core.cli.arguments import number_from
from shapegoogle_core.cli.command import DONE, SOME_FAILED
from shapegoogle_core.cli.text import say, table
from shapegoogle_core.model import load_model

__all__ = ["add_options", "run"]

PROCEDURAL = ("objects", "soup", "creatures", "poses", "people")
THINGS = ("things", "turned things")
PACKS = ("packs to learn from", "packs held out")
EVALUATION = ("Princeton", "TOSCA", "TOSCA remeshed", "posed characters")
SETS = (*PROCEDURAL, *THINGS, *PACKS, *EVALUATION)


@dataclass(frozen=True)
class _Row:
    """Scores of a part on a set."""

    set_name: str
    use: str
    part: str
    queries: int
    scores: CategoryScores


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    parser.add_argument(
        "--sets",
        nargs="+",
        choices=SETS,
        default=PROCEDURAL,
        metavar="NAME",
        help=f"some of {', '.join(SETS)} (the first four)",
    )
    parser.add_argument(
        "--parts",
        nargs="+",
        choices=tuple(PARTS),
        default=tuple(PARTS),
        metavar="NAME",
        help=f"some of {', '.join(PARTS)} (all)",
    )
    parser.add_argument("--model", default="default", metavar="NAME", help="model (%(default)s)")
    parser.add_argument(
        "--data",
        type=Path,
        default=EVALUATION_DATA,
        metavar="FOLDER",
        help="evaluation data: folder with labels.csv (%(default)s)",
    )
    parser.add_argument(
        "--blend-meshes",
        type=Path,
        metavar="FOLDER",
        help="folder written by `python -m benchmarks blend-meshes`, for the packs and posed characters",
    )
    parser.add_argument(
        "--cache", type=Path, metavar="FOLDER", help="signatures (default: in the user's cache folder)"
    )
    parser.add_argument(
        "--any-code",
        action="store_true",
        help="reuse signatures kept by runs with this option, even if the code has changed since",
    )
    parser.add_argument("--jobs", type=number_from(1), default=1, metavar="N", help="processes (%(default)s)")
    parser.add_argument("--json", action="store_true", help="print one JSON object for each row")


def run(options: argparse.Namespace) -> int:
    """Measure the sets and print the scores.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
        1 if shapes could not be described, each named on stderr.
    """
    sets = _chosen_sets(options)
    model = load_model(options.model)
    cache = BenchmarkCache(options.cache or default_cache())
    rows: list[_Row] = []
    failed = False
    for chosen in sets:
        described = describe_set(
            chosen, model, options.model, cache, jobs=options.jobs, any_code=options.any_code
        )
        for name, reason in described.failures.items():
            failed = True
            say(f"failed: {chosen.name}: {name}: {reason}")
        for name in options.parts:
            distances = PARTS[name](described, model)
            if distances is None:
                say(f"{chosen.name}: the model {model.name!r} has no {name}")
                continue
            scores = category_scores(distances, described.labels)
            rows.append(_Row(chosen.name, chosen.use, name, chosen.query_count, scores))
            if options.json:
                print(json.dumps(_record(rows[-1])), flush=True)
    if not options.json:
        print(_text(rows))
    return SOME_FAILED if failed else DONE


def _chosen_sets(options: argparse.Namespace) -> list[KindSet]:
    """Make the sets that are asked for, in the order of `SETS`."""
    wanted = set(options.sets)
    folder = options.blend_meshes
    if folder is None and wanted & {*PACKS, "posed characters"}:
        raise BenchmarkError("the packs and posed characters need --blend-meshes, the folder of their meshes")
    sets: list[KindSet] = []
    if wanted.intersection((*PROCEDURAL, *THINGS)):
        sets += procedural_sets()
    if wanted.intersection(PACKS):
        sets += pack_sets(folder)
    if wanted.intersection(EVALUATION):
        sets += evaluation_sets(options.data, folder)
    return [made for made in sets if made.name in wanted]


def _record(row: _Row) -> dict[str, object]:
    names = ("NN", "FT", "ST", "DCG")
    percent = [round(100 * score, 1) for score in astuple(row.scores)]
    record = {"set": row.set_name, "use": row.use, "queries": row.queries, "part": row.part}
    return record | dict(zip(names, percent, strict=True))


def _text(rows: list[_Row]) -> str:
    header = ("set", "use", "queries", "part", "NN", "FT", "ST", "DCG")
    cells = [tuple(map(str, _record(row).values())) for row in rows]
    return "\n".join(table([header, *cells], "<<><>>>>"))
