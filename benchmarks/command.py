# SPDX-License-Identifier: MIT
"""`python -m benchmarks`: measure the search as the paper does, and write a report."""

from __future__ import annotations

import argparse
import importlib.util
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from shapegoogle_core.cli.arguments import number_from
from shapegoogle_core.cli.exit_codes import DONE, SOME_FAILED
from shapegoogle_core.cli.text import say
from shapegoogle_core.errors import BenchmarkError

if TYPE_CHECKING:
    from benchmarks.protocol.collection import Collection, LabelledCollection

__all__ = ["DETAILS", "add_options", "add_run_options", "benchmark", "measure"]

DETAILS = """\
A re-creation of the protocol of SHREC 2010, robust large-scale retrieval: which null shape is a query a
version of, among many others? For each variant of the search it gives the mean average precision by class
of transformation and strength, ROC curves with the equal error rate, and for labelled collections nearest
neighbour, first and second tier and discounted cumulative gain.

--nulls      the shapes to be found, one mesh file for each
--negatives  shapes that nobody looks for
--queries    versions of the null shapes, named <null>.<transformation>.<strength>.<suffix>, as
             0001.isometry.3.off. Of ten classes of transformations queries are made of the null shapes where
             this folder has none; other poses (isometry) cannot be made.
--labelled   one sub-folder for each class; every shape asks for the others of its class
--variants   models: the models of --model alone, which takes minutes for hundreds of shapes;
             all: also the paper's descriptors, bags, vocabularies and codes, other descriptors and baselines,
             learnt from procedural creatures (and from --train), which takes some hours the first time;
             or names of rows with * and ?, such as "HKS*48 words". In one bag of 48 words by area on mended
             meshes ("*, by area · 48 words · mended") stand HKS, SI-HKS, log HKS, WKS, GPS, volumetric HKS,
             geodesic histogram, spin image, shape context and mesh HOG. One vector for a whole shape are
             Shape-DNA, diffusion distances, GPS distances, D2 distribution and moments

What was computed is kept in --cache: a run that was ended goes on where it was, a second one is quick.
For a thousand shapes that is some megabytes for the models and 8 GB for all variants; delete it at any time.

examples:
  python -m benchmarks --nulls nulls --negatives psb --queries poses --output report
  python -m benchmarks --nulls nulls --negatives psb --model mine.npz --compare report/benchmark.json
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    parser.add_argument("--nulls", required=True, metavar="FOLDER", help="shapes to be found")
    parser.add_argument("--negatives", metavar="FOLDER", help="unrelated shapes")
    parser.add_argument("--queries", metavar="FOLDER", help="versions of the null shapes")
    parser.add_argument("--no-generate", action="store_true", help="ask only the queries of --queries")
    parser.add_argument(
        "--labelled",
        action="append",
        default=[],
        metavar="FOLDER",
        help="collection with a sub-folder for each class; may be given more than once",
    )
    add_run_options(parser)


def add_run_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that do not say what the collection is.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    parser.add_argument(
        "--model",
        nargs="+",
        default=["paper", "default"],
        metavar="NAME",
        help="model files or shipped models; the report looks closely at the last one (paper default)",
    )
    parser.add_argument(
        "--variants", default="models", metavar="NAMES", help="all, models, or names of rows (%(default)s)"
    )
    parser.add_argument("--train", metavar="FOLDER", help="more shapes that the variants learn from")
    parser.add_argument(
        "--cache", metavar="FOLDER", help="what is kept between runs (default: in the user's cache folder)"
    )
    parser.add_argument(
        "--output", default="benchmark", metavar="FOLDER", help="benchmark.json and index.html (%(default)s)"
    )
    parser.add_argument("--compare", metavar="JSON", help="benchmark.json of an earlier run to compare with")
    parser.add_argument(
        "--jobs", type=number_from(1), metavar="N", help="worker processes (default: one for each processor)"
    )
    parser.add_argument(
        "--seed", type=int, default=0, metavar="N", help="of all random choices (%(default)s)"
    )


def benchmark(options: argparse.Namespace) -> int:
    """Measure the search on folders of meshes.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
    """
    _check_extra()
    from benchmarks.protocol.collection import read_collection, read_labelled

    collection = read_collection(
        options.nulls,
        options.negatives,
        options.queries,
        seed=options.seed,
        generate=not options.no_generate,
    )
    labelled = [read_labelled(folder) for folder in options.labelled]
    return measure(collection, labelled, options, Path(options.output))


def measure(
    collection: Collection, labelled: Sequence[LabelledCollection], options: argparse.Namespace, output: Path
) -> int:
    """Measure the search on a collection, write the report and print the main table.

    Parameters
    ----------
    collection : Collection
    labelled : sequence of LabelledCollection
    options : argparse.Namespace
        As from `add_run_options`.
    output : Path
        Folder of the report.

    Returns
    -------
    exit_code : int
    """
    _check_extra()
    from benchmarks.protocol.protocol import run_benchmark
    from benchmarks.protocol.results import load_result, save_result
    from benchmarks.protocol.spectra_cache import BenchmarkCache
    from benchmarks.protocol.tables import text_table
    from benchmarks.report import write_report
    from benchmarks.variants.variants import choose_variants
    from shapegoogle_core.indexing import default_jobs

    # What can be known now had better not be said after an hour.
    compare_with = None if options.compare is None else load_result(Path(options.compare))
    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BenchmarkError(f"cannot make the folder '{output}': {error.strerror or error}") from error
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
    """Return the folder for what is kept between runs, in the user's cache folder."""
    import platformdirs

    return Path(platformdirs.user_cache_dir("shapegoogle", appauthor=False)) / "benchmark"


def _check_extra() -> None:
    missing = [
        name
        for name in ("jinja2", "matplotlib", "platformdirs", "skimage")
        if importlib.util.find_spec(name) is None
    ]
    if missing:
        raise BenchmarkError(
            f"the benchmark needs {', '.join(missing)}; install it with: "
            "pip install 'shapegoogle-core[benchmark]'"
        )
