# SPDX-License-Identifier: MIT
"""`shapegoogle query`: find the shapes of a library that are most like given meshes."""

from __future__ import annotations

import argparse
import json
import sys
import traceback
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from shapegoogle_core.cli.arguments import add_library, number_from
from shapegoogle_core.cli.command import Command
from shapegoogle_core.cli.exit_codes import DONE, SOME_FAILED
from shapegoogle_core.cli.filters import add_filters, filter_of
from shapegoogle_core.cli.inputs import Failures, list_failures
from shapegoogle_core.cli.text import counted
from shapegoogle_core.errors import MeshError
from shapegoogle_core.library.search.settings import EvidenceSettings

if TYPE_CHECKING:
    from shapegoogle_core.indexing import ShapeReader
    from shapegoogle_core.library import Library, Match, NewShape
    from shapegoogle_core.library.search.query_shapes import QueryShapes
    from shapegoogle_core.mesh import Mesh
    from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["COMMAND"]

DETAILS = """\
With --json, one line for each mesh:
  {"query": path, "matches": [{"name", "source", "similarity", "distance", "evidence"}, …]}
A mesh that cannot be read gives {"query": path, "matches": [], "error": "…"}; the others continue.
With --together, all meshes are examples of what you search, and give one line:
  {"query": [path, …], "unlike": [path, …], "matches": […]}
Shapes close to all of them come first; if one example cannot be read, the whole query fails. With
--unlike, also without --together, shapes close to one of its meshes move to the end.

similarity  0 to 1: probability that it is the same shape, transformed, and not merely the nearest of many
distance    what the list is sorted by, from 0 (identical) to 2
evidence    {"kind": …} and its values, found by comparing the surfaces; lengths are shares of √area
            of the query:
  identical, moved, scaled, mirrored   a copy; factor: its size, deviation of 95 % of its surface
  re-meshed                            the same surface, another mesh
  re-posed                             bent; displacement: how far; probability that it is the same shape
  part of, contains                    the query is a part of it, or it is a part of the query; share
  similar                              none of these; null where nothing could be compared

examples:
  shapegoogle query horse.obj --library shapes.sglib
  shapegoogle query poses/*.off --library shapes.sglib --top 1 --json
  shapegoogle query horse.obj pony.obj --together --unlike cow.obj --library shapes.sglib
  shapegoogle query bolt.stl --library shapes.sglib --kind scaled --folder D:\\models --faces :5000
"""

LEGEND = """\
similarity: probability that it is the same shape, transformed, and not merely the nearest of many others
distance:   what the list is sorted by, from 0 (identical) to 2
evidence:   result of comparing the surfaces; ×2 means twice the query's size"""


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("meshes", nargs="+", metavar="MESH", help="file of a mesh or scan")
    add_library(parser)
    parser.add_argument(
        "--top", type=number_from(1), default=10, metavar="N", help="number of matches (%(default)s)"
    )
    parser.add_argument(
        "--exact",
        action="store_true",
        help="compare all shapes in full: slower in a large library, misses nothing",
    )
    parser.add_argument(
        "--evidence",
        type=number_from(0),
        default=EvidenceSettings.explained,
        metavar="N",
        help="number of best matches whose surfaces are compared for evidence (%(default)s)",
    )
    parser.add_argument(
        "--together",
        action="store_true",
        help="the meshes are examples of one thing: run one query with all of them",
    )
    parser.add_argument(
        "--unlike",
        nargs="+",
        action="extend",
        default=[],
        metavar="MESH",
        help="mesh files of what you do not search",
    )
    add_filters(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object for each query")


def _run(options: argparse.Namespace) -> int:
    from shapegoogle_core.indexing import ShapeReader
    from shapegoogle_core.library import Library

    failed: Failures = []
    with Library.open(options.library, read_only=True) as library, ShapeReader(options.reader) as reader:
        unlike = _examples(library, reader, options.unlike, options, failed)
        if options.together:
            answered = _query_together(library, reader, options, unlike, failed)
        else:
            answers = [_query_file(library, reader, path, options, unlike, failed) for path in options.meshes]
            answered = any(answers)
    if answered and not options.json:
        print(LEGEND)
    list_failures(failed)
    return SOME_FAILED if failed else DONE


def _query_together(
    library: Library,
    reader: ShapeReader,
    options: argparse.Namespace,
    unlike: list[ShapeSignature] | str,
    failed: Failures,
) -> bool:
    """Run one query with all meshes; whether there is an answer."""
    like = _examples(library, reader, options.meshes, options, failed)
    if isinstance(like, str) or isinstance(unlike, str):
        # Without one of its examples it would be another query.
        reasons = [reason for reason in (like, unlike) if isinstance(reason, str)]
        _print_answer(options, options.meshes, None, "; ".join(reasons))
        return False
    matches = _matches(library, like, options, unlike)
    _print_answer(options, options.meshes, None, matches, len(library))
    return True


def _query_file(
    library: Library,
    reader: ShapeReader,
    path: str,
    options: argparse.Namespace,
    unlike: list[ShapeSignature] | str,
    failed: Failures,
) -> bool:
    """Run a query with each shape of a file; whether one of them has an answer."""
    if isinstance(unlike, str):
        _print_answer(options, path, None, unlike)
        return False
    try:
        found = _read(reader, path, failed)
    except (MeshError, MemoryError) as error:
        _print_answer(options, path, None, _note_failure(path, error, options, failed))
        return False
    answered = False
    for shape in found:
        try:
            matches = _matches(library, shape.mesh, options, unlike)
        except (MeshError, MemoryError) as error:
            _print_answer(options, path, shape, _note_failure(path, error, options, failed))
        else:
            _print_answer(options, path, shape, matches, len(library))
            answered = True
    return answered


def _matches(
    library: Library,
    shapes: QueryShapes,
    options: argparse.Namespace,
    unlike: list[ShapeSignature],
) -> list[Match]:
    return library.query(
        shapes,
        top=options.top,
        explain=options.evidence,
        exact=options.exact,
        unlike=unlike,
        where=filter_of(options),
    )


def _examples(
    library: Library,
    reader: ShapeReader,
    paths: Sequence[str],
    options: argparse.Namespace,
    failed: Failures,
) -> list[ShapeSignature] | str:
    """Describe all shapes of some example files; a sentence if one of the files fails."""
    signatures: list[ShapeSignature] = []
    reasons = []
    for path in paths:
        try:
            found = _read(reader, path, failed)
            signatures += [library.model.describe(shape.mesh, keep_surface=True) for shape in found]
        except (MeshError, MemoryError) as error:
            reasons.append(_note_failure(path, error, options, failed))
    return "; ".join(reasons) if reasons else signatures


def _read(reader: ShapeReader, path: str, failed: Failures) -> Sequence[NewShape[Mesh]]:
    """Read all shapes of a query file, at least one; objects that cannot be read are noted as failed."""
    found = reader.read(path)
    failed += [(Path(path), problem) for problem in found.problems]
    if not found.shapes:
        raise MeshError(f"{Path(path).name!r} has no mesh objects; choose a file with a shape in it")
    return found.shapes


def _note_failure(path: str, error: BaseException, options: argparse.Namespace, failed: Failures) -> str:
    if options.verbose:
        traceback.print_exception(error)
    reason = str(error) if isinstance(error, MeshError) else f"{path!r} does not fit into memory"
    failed.append((Path(path), reason))
    return reason


def _print_answer(
    options: argparse.Namespace,
    query: str | list[str],
    shape: NewShape[Mesh] | None,
    answer: list[Match] | str,
    shapes: int = 0,
) -> None:
    """Print the matches of one query, or the sentence that says why there are none.

    The query is a file, one shape of a file, or several files together.
    """
    record: dict[str, object] = {"query": query}
    title = query if isinstance(query, str) else " and ".join(query)
    if shape is not None and shape.object_name:
        record["object"] = shape.object_name
        title = f"{title}, {shape.object_name}"
    if options.together or options.unlike:
        record["unlike"] = options.unlike
    if options.unlike:
        title = f"{title}, not like {' and '.join(options.unlike)}"
    if isinstance(answer, str):
        record |= {"matches": [], "error": answer}
    else:
        record["matches"] = [match.to_json() for match in answer]
        if not options.json:
            print(_match_table(title, answer, shapes), end="\n\n")
    if options.json:
        print(json.dumps(record))
    # The program at the other end of a pipe gets each answer as soon as it is known.
    sys.stdout.flush()


def _match_table(query: str, matches: list[Match], shapes: int) -> str:
    from shapegoogle_core.rendering.text import evidence_text

    rows = [("", "similarity", "distance", "evidence", "name", "source")]
    rows += [
        (
            str(rank),
            _similarity(match),
            f"{match.distance:.4f}",
            evidence_text(match.evidence),
            match.name,
            match.source,
        )
        for rank, match in enumerate(matches, start=1)
    ]
    ranks, similarities, distances, kinds, names, _ = (
        max(map(len, column)) for column in zip(*rows, strict=True)
    )
    lines = [
        f"{rank:>{ranks}}  {similarity:>{similarities}}  {distance:>{distances}}  {kind:<{kinds}}  "
        f"{name:<{names}}  {source}"
        for rank, similarity, distance, kind, name, source in rows
    ]
    return "\n".join(
        [f"{query}: the best {len(matches)} of {counted(shapes, 'shape')}", *map(str.rstrip, lines)]
    )


def _similarity(match: Match) -> str:
    """Format the similarity so that only identical shapes show 1."""
    rounded = f"{match.similarity:.3f}"
    return ">0.999" if rounded == "1.000" and match.distance > 0 else rounded


COMMAND = Command(
    "query",
    "find the shapes of a library that are most like a mesh",
    DETAILS,
    _add_options,
    _run,
    reads_files=True,
)
