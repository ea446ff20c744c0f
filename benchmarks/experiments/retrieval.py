# SPDX-License-Identifier: MIT
"""Measure retrieval as in the paper (SHREC 2010, robust large-scale retrieval), and write a report.

    python -m benchmarks retrieval --nulls FOLDER [--negatives FOLDER] [--queries FOLDER] [--labelled FOLDER]
    python -m benchmarks retrieval --data FOLDER [--blend-meshes FOLDER] [--parts PART …]

Each query is a version of one null shape, which is to be found among many others. For each variant of the
search the report gives the mean average precision by class of transformation and strength, ROC curves with
the equal error rate, and for labelled collections nearest neighbour, first and second tier and discounted
cumulative gain.

--nulls       shapes to be found, one mesh file each
--negatives   unrelated shapes
--queries     versions of the null shapes, named <null>.<transformation>.<strength>.<suffix>, such as
              0001.isometry.3.off. For each of ten transformations without such files, queries are generated
              from the null shapes; other poses (isometry) cannot be generated.
--labelled    one sub-folder for each class; every shape queries for the others of its class

--data        the evaluation data: a folder with labels.csv and the collections it names. The database is the
              lowest pose of each class of TOSCA and the unrelated shapes of PSB; queries are the next five
              poses of each class and ten transformations of each null shape in five strengths. Also measured:
              remeshed TOSCA shapes (a report of its own, in the folder "remeshed"), all poses of TOSCA as
              categories and, with --blend-meshes, the posed characters of the .blend library.

--variants    models: only the models of --model, which takes minutes for hundreds of shapes;
              all: also the paper's descriptors, bags, vocabularies and codes, other descriptors and
              baselines, learnt from procedural creatures (and from --train), which takes hours at first;
              or names of rows with * and ?, such as "HKS*48 words"; all local descriptors in the same bag of
              words on preprocessed meshes are "*, by area · 48 words · preprocessed".

Intermediate results are kept in --cache: an interrupted run continues where it stopped, and a second one is
quick. A thousand shapes take some megabytes for the models and 8 GB for all variants; the folder can be
deleted at any time.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from pathlib import Path

from benchmarks.errors import BenchmarkError
from benchmarks.protocol import evaluation_data
from benchmarks.protocol.cache import BenchmarkCache
from benchmarks.protocol.collection import Collection, LabelledCollection, read_collection, read_labelled
from benchmarks.protocol.protocol import run_benchmark
from benchmarks.protocol.results import load_result, save_result
from benchmarks.protocol.tables import text_table
from benchmarks.report import write_report
from benchmarks.variants.variants import choose_variants
from shapegoogle_core.cli.arguments import number_from
from shapegoogle_core.cli.command import DONE, SOME_FAILED
from shapegoogle_core.cli.text import say
from shapegoogle_core.processes.launching import default_jobs

__all__ = ["EVALUATION_DATA", "add_options", "default_cache", "run"]

PARTS = ("retrieval", "categories", "remeshed")

EVALUATION_DATA = Path(
    os.environ.get("SHAPEGOOGLE_DATA", Path(__file__).resolve().parents[3] / "shared" / "data")
)
"""Folder of the evaluation data: that of the environment variable, or next to the repository."""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    folders = parser.add_argument_group("folders of meshes")
    folders.add_argument("--nulls", metavar="FOLDER", help="shapes to be found")
    folders.add_argument("--negatives", metavar="FOLDER", help="unrelated shapes")
    folders.add_argument("--queries", metavar="FOLDER", help="versions of the null shapes")
    folders.add_argument("--no-generate", action="store_true", help="use only the queries of --queries")
    folders.add_argument(
        "--labelled",
        action="append",
        default=[],
        metavar="FOLDER",
        help="collection with a sub-folder for each class; may be given more than once",
    )
    data = parser.add_argument_group("evaluation data, without --nulls")
    data.add_argument(
        "--data",
        type=Path,
        default=EVALUATION_DATA,
        metavar="FOLDER",
        help="folder with labels.csv (%(default)s)",
    )
    data.add_argument(
        "--blend-meshes",
        type=Path,
        metavar="FOLDER",
        help="folder written by `python -m benchmarks blend-meshes`",
    )
    data.add_argument(
        "--parts",
        nargs="+",
        choices=PARTS,
        default=PARTS,
        metavar="PART",
        help=f"some of {', '.join(PARTS)}; categories include retrieval",
    )
    parser.add_argument(
        "--model",
        nargs="+",
        default=["paper", "default"],
        metavar="NAME",
        help="model files or shipped models; the report has details of the last one (paper default)",
    )
    parser.add_argument(
        "--variants", default="models", metavar="NAMES", help="all, models, or names of rows (%(default)s)"
    )
    parser.add_argument("--train", metavar="FOLDER", help="more shapes for the variants to learn from")
    parser.add_argument(
        "--cache", metavar="FOLDER", help="intermediate results (default: in the user's cache folder)"
    )
    parser.add_argument(
        "--output", default="benchmark", metavar="FOLDER", help="benchmark.json and index.html (%(default)s)"
    )
    parser.add_argument("--compare", metavar="JSON", help="benchmark.json of an earlier run to compare with")
    parser.add_argument(
        "--jobs", type=number_from(1), metavar="N", help="worker processes (default: one for each processor)"
    )
    parser.add_argument(
        "--seed", type=int, default=0, metavar="N", help="seed of all random choices (%(default)s)"
    )


def run(options: argparse.Namespace) -> int:
    """Measure retrieval.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
        1 if shapes failed, each named on stderr.
    """
    if options.nulls is None:
        return _measure_evaluation_data(options)
    collection = read_collection(
        options.nulls,
        options.negatives,
        options.queries,
        seed=options.seed,
        generate=not options.no_generate,
    )
    labelled = [read_labelled(folder) for folder in options.labelled]
    return _measure(collection, labelled, options, Path(options.output), options.compare)


def _measure_evaluation_data(options: argparse.Namespace) -> int:
    """Measure the parts of the evaluation data; the result of the worst part is the exit code."""
    for name in ("negatives", "queries", "labelled"):
        if getattr(options, name):
            raise BenchmarkError(f"--{name} needs --nulls, the folder of the shapes to be found")
    if options.train is not None:
        evaluation_data.check_training(Path(options.train))
    labels = evaluation_data.read_labels(options.data)
    output = Path(options.output)
    labelled = []
    if "categories" in options.parts:
        labelled.append(evaluation_data.labelled_collection(labels["tosca"], "TOSCA"))
        people = (
            [] if options.blend_meshes is None else evaluation_data.posed_characters(options.blend_meshes)
        )
        if people:
            labelled.append(evaluation_data.labelled_collection(people, "posed characters"))
        else:
            print("the posed characters are left out: --blend-meshes names no folder that holds them")
    codes = []
    if "retrieval" in options.parts or labelled:
        collection = evaluation_data.retrieval_collection(labels, options.seed)
        codes.append(_measure(collection, labelled, options, output, options.compare))
    if "remeshed" in options.parts:
        compare = options.compare
        if compare and len(options.parts) > 1:
            earlier = Path(compare).parent / "remeshed" / "benchmark.json"
            compare = earlier if earlier.is_file() else None
            if compare is None:
                print(
                    f"'{earlier}' does not exist, so the remeshed shapes are not compared with an earlier run"
                )
        collection = evaluation_data.remeshed_collection(labels)
        codes.append(_measure(collection, [], options, output / "remeshed", compare))
    return max(codes)


def _measure(
    collection: Collection,
    labelled: Sequence[LabelledCollection],
    options: argparse.Namespace,
    output: Path,
    compare: str | Path | None,
) -> int:
    """Measure a collection, write the report and print the main table."""
    # Wrong arguments are reported now and not after an hour.
    compare_with = None if compare is None else load_result(Path(compare))
    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BenchmarkError(f"cannot make the folder '{output}': {error.strerror}") from error
    cache = BenchmarkCache(Path(options.cache) if options.cache else default_cache())
    jobs = options.jobs or default_jobs()
    variants = choose_variants(options.variants, options.model, train=options.train, seed=options.seed)
    result = run_benchmark(collection, labelled, variants, cache, jobs=jobs, seed=options.seed)
    save_result(result, output / "benchmark.json")
    page = write_report(result, collection, output, compare_with)
    print(text_table(result))
    print(f"\nreport: {page}")
    for problem in result.problems:
        say(f"{problem.kind}: {problem.shape}: {problem.reason}")
    return SOME_FAILED if any(problem.kind == "failed" for problem in result.problems) else DONE


def default_cache() -> Path:
    """Return the folder for intermediate results, in the user's cache folder."""
    import platformdirs

    return Path(platformdirs.user_cache_dir("shapegoogle", appauthor=False)) / "benchmark"
