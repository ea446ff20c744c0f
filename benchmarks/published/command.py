# SPDX-License-Identifier: MIT
"""Measure the search on a published collection of labelled shapes, in the layout in which it is distributed.

    python -m benchmarks published LAYOUT FOLDER [--classes FILE.cla] [--model NAME …] [--parts NAME …]

Every shape queries for the others of its class. Printed are, in percent, nearest neighbour (NN), first and
second tier (FT, ST), E-measure of the first 32 (E) and discounted cumulative gain (DCG), as the program
psbTable of the Princeton Shape Benchmark computes them, and the mean average precision (mAP).

psb      Princeton Shape Benchmark: models m<number>.off anywhere below FOLDER, and a .cla file
shrec11  SHREC'11, non-rigid watertight meshes: T<number>.off and test.cla
shrec07  SHREC'07, watertight models: 1.off to 400.off, twenty of each class in sequence; or with --classes
tosca    TOSCA: <class><number>.mat, or .vert with .tri beside it, or a mesh file such as .off
folders  any collection with one sub-folder for each class

Files are only read. Signatures are kept in --cache for each mesh, model and state of the code. Choose nothing
by the results if you want to publish them.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from benchmarks.experiments.retrieval import default_cache
from benchmarks.kinds.describing import describe_set
from benchmarks.kinds.parts import PARTS
from benchmarks.kinds.sets import MEASURING, KindSet, KindShape
from benchmarks.protocol.cache import BenchmarkCache, content_digest, digest
from benchmarks.published.layouts import LAYOUTS, PublishedShape, read_layout
from benchmarks.published.scores import published_scores
from shapegoogle_core.cli.arguments import number_from
from shapegoogle_core.cli.command import DONE, SOME_FAILED
from shapegoogle_core.cli.text import say, table
from shapegoogle_core.model import load_model

__all__ = ["add_options", "run"]


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    parser.add_argument("layout", choices=tuple(LAYOUTS), help="how the collection is distributed, see above")
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="where it was unpacked")
    parser.add_argument(
        "--classes",
        type=Path,
        metavar="FILE",
        help="classification file (.cla); by default the only one in FOLDER",
    )
    parser.add_argument(
        "--model",
        nargs="+",
        default=["paper", "default"],
        metavar="NAME",
        help="model files or shipped models (paper default)",
    )
    parser.add_argument(
        "--parts",
        nargs="+",
        choices=tuple(PARTS),
        default=("bags", "search"),
        metavar="NAME",
        help=f"what ranks: some of {', '.join(PARTS)} (bags search)",
    )
    parser.add_argument(
        "--cache", type=Path, metavar="FOLDER", help="signatures (default: in the user's cache folder)"
    )
    parser.add_argument("--jobs", type=number_from(1), default=1, metavar="N", help="processes (%(default)s)")
    parser.add_argument("--json", action="store_true", help="print one JSON object for each row")


def run(options: argparse.Namespace) -> int:
    """Measure the collection and print the scores.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
        1 if shapes could not be described, each named on stderr; they are left out.
    """
    shapes = read_layout(options.layout, options.folder, options.classes)
    collection = KindSet(options.folder.resolve().name, MEASURING, tuple(map(_with_key, shapes)))
    classes = len(set(collection.labels))
    if not options.json:
        print(
            f"{collection.name}: {len(shapes)} shapes in {classes} classes, {collection.query_count} queries"
        )
    cache = BenchmarkCache(options.cache or default_cache())
    rows: list[dict[str, object]] = []
    failed = False
    for name in options.model:
        model = load_model(name)
        described = describe_set(collection, model, name, cache, jobs=options.jobs)
        for shape, reason in described.failures.items():
            failed = True
            say(f"failed: {shape}: {reason}")
        for part in options.parts:
            distances = PARTS[part](described, model)
            if distances is None:
                say(f"the model {model.name!r} has no {part}")
                continue
            scores = published_scores(distances, described.labels).percent()
            rows.append({"model": model.name, "part": part, **scores})
            if options.json:
                print(json.dumps({"set": collection.name, "shapes": len(shapes), **rows[-1]}), flush=True)
    if rows and not options.json:
        cells = [tuple(map(str, row.values())) for row in rows]
        print("\n".join(table([tuple(rows[0]), *cells], "<<" + ">" * (len(rows[0]) - 2))))
    return SOME_FAILED if failed else DONE


def _with_key(shape: PublishedShape) -> KindShape:
    contents = [content_digest(path) if path.is_file() else "" for path in shape.files]
    key = digest(*contents, *(path.suffix.lower() for path in shape.files))
    return KindShape(shape.name, shape.label, key, shape.mesh)
