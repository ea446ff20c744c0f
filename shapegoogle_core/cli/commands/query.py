# SPDX-License-Identifier: MIT
r"""Find the shapes of a library that are most like a mesh.

With --json, one line for each mesh:
  {"query": path, "matches": [
    {"name", "source", "object_name", "similarity", "distance", "evidence", "placements"}, …]}
placements is the number of objects that show the shape; placement, the matrix of the one that fits best,
row by row. shape_type says what it is in its file, such as collection, text or scatter; tags, catalog and
frame are there where a shape has them. With --families, versions is the number of other shapes that are the
same; with --versions, version_matches lists them.
A mesh that cannot be read gives {"query": path, "matches": [], "error": "…"}; the others continue.
With --together, all meshes are examples of what you search, and give one line:
  {"query": [path, …], "unlike": [path, …], "matches": […]}
Shapes close to all of them come first; if one example cannot be read, the whole query fails. With
--unlike, also without --together, shapes close to one of its meshes are ranked lower.

similarity  0 to 1: probability that it is the same shape, transformed, and not merely the nearest of many
distance    what the list is sorted by, from 0 (identical) to 2
evidence    {"kind": …} and its values, found by comparing the surfaces; lengths are shares of √area
            of the query:
  identical, moved, scaled, mirrored   a copy; factor: its size, deviation of 95 % of its surface
  re-meshed                            the same surface, another mesh
  version                              nearly the same: subdivided, smoothed, with fewer faces; deviation
  re-posed                             bent; displacement: how far; probability that it is the same shape
  part of, contains                    the query is a part of it, or it is a part of the query; share
  same kind, nothing in common         none of these: another thing of its kind, or just another thing
  similar                              none of all these; null where nothing could be compared

for example:
  shapegoogle query horse.obj --library shapes.sglib
  shapegoogle query poses/*.off --library shapes.sglib --top 1 --json
  shapegoogle query horse.obj pony.obj --together --unlike cow.obj --library shapes.sglib
  shapegoogle query horse.obj --library https://shapes.example --root assets=/mnt/assets
  shapegoogle query bolt.stl --library shapes.sglib --kind scaled --folder D:\models --faces :5000
"""

from __future__ import annotations

import argparse
import json
import traceback
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from shapegoogle_core.api.text import one_line
from shapegoogle_core.cli.arguments import (
    SEARCHED,
    add_filters,
    add_flag,
    add_library,
    add_roots,
    add_value,
    filter_of,
    map_roots,
    number_from,
)
from shapegoogle_core.cli.command import DONE, SOME_FAILED, Command
from shapegoogle_core.cli.inputs import Failures, list_failures
from shapegoogle_core.cli.text import counted, put, say, say_lines, table
from shapegoogle_core.errors import MeshError
from shapegoogle_core.library.search.settings import (
    RANKS,
    CandidateSettings,
    EvidenceSettings,
    RerankSettings,
    SearchSettings,
)

if TYPE_CHECKING:
    from shapegoogle_core.indexing import ShapeReader
    from shapegoogle_core.library.match import Match
    from shapegoogle_core.library.search.query import QueryShapes
    from shapegoogle_core.library.searchable import SearchableLibrary
    from shapegoogle_core.library.storage.records import NewShape
    from shapegoogle_core.mesh import Mesh
    from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["COMMAND"]

LEGEND = """\
similarity: probability that it is the same shape, transformed, and not merely the nearest of many others
likeness:   probability that it is of the same kind, such as another chair
distance:   what the list is sorted by, from 0 (identical) to 2
evidence:   result of comparing the surfaces; ×2 means twice the query's size"""


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("meshes", nargs="+", metavar="MESH", help="file of a mesh or scan")
    add_library(parser, SEARCHED)
    add_roots(parser)
    add_value(parser, "--top", "N", "number of matches (%(default)s)", number_from(1), 10)
    add_flag(parser, "--exact", "compare all shapes in full: slower in a large library, misses nothing")
    parser.add_argument(
        "--rank",
        choices=RANKS,
        default="both",
        help="what comes first: the same shape and then the same kind, or only one of them (%(default)s)",
    )
    stages = "find candidates by this stage of a plug-in instead of by codes; may be given more than once"
    parser.add_argument("--candidates", action="append", metavar="NAME", help=stages)
    add_value(parser, "--reranker", "NAME", "order the matches by this re-ranker of a plug-in")
    add_flag(parser, "--families", "list different shapes, of all copies and versions of each only the best")
    add_flag(parser, "--versions", "the same, each followed by its versions")
    explained = "number of best matches whose surfaces are compared for evidence (%(default)s)"
    add_value(parser, "--evidence", "N", explained, number_from(0), EvidenceSettings.explained)
    add_flag(parser, "--together", "the meshes are examples of one thing: run one query with all of them")
    unlike = "meshes of shapes you do not want"
    parser.add_argument("--unlike", nargs="+", action="extend", default=[], metavar="MESH", help=unlike)
    add_filters(parser)
    add_flag(parser, "--json", "print one JSON object for each query")


def _run(options: argparse.Namespace) -> int:
    from shapegoogle_core.client import open_library
    from shapegoogle_core.indexing import ShapeReader

    failed: Failures = []
    search = _search_settings(options)
    with (
        open_library(options.library, search=search) as library,
        ShapeReader(options.reader) as reader,
    ):
        map_roots(library, options)
        if advice := library.reindexing_advice():
            say(advice)
        queries = _Queries(options, library, reader, failed)
        answered = queries.run_together() if options.together else queries.run_each()
    if answered and not options.json:
        put(LEGEND)
    list_failures(failed)
    return SOME_FAILED if failed else DONE


def _search_settings(options: argparse.Namespace) -> SearchSettings:
    search = SearchSettings(rerank=RerankSettings(reranker=options.reranker))
    if options.candidates:
        search = replace(search, candidates=CandidateSettings(stages=tuple(options.candidates)))
    return search


@dataclass(frozen=True)
class _Answer:
    """The matches of a query, and with --versions those that each of them stands for."""

    matches: list[Match]
    versions: list[list[Match]]

    def to_json(self) -> list[dict[str, object]]:
        """Convert to the objects that --json prints."""
        records = [match.to_json() for match in self.matches]
        for record, versions in zip(records, self.versions, strict=False):
            record["version_matches"] = [match.to_json() for match in versions]
        return records


@dataclass(frozen=True)
class _Queries:
    """The queries of one command line, in an open library."""

    options: argparse.Namespace
    library: SearchableLibrary
    reader: ShapeReader
    failed: Failures

    def run_together(self) -> bool:
        """Run one query with all meshes; whether there is an answer."""
        meshes = self.options.meshes
        try:
            like, unlike = self._examples(meshes, self.options.unlike)
        except MeshError as error:
            # Without one of its examples it would be another query.
            self._print(meshes, None, str(error))
            return False
        self._print(meshes, None, self._answer(like, unlike))
        return True

    def run_each(self) -> bool:
        """Run a query with each shape of each file; whether one of them has an answer."""
        try:
            (unlike,) = self._examples(self.options.unlike)
        except MeshError as error:
            for path in self.options.meshes:
                self._print(path, None, str(error))
            return False
        answers = [self._run_file(path, unlike) for path in self.options.meshes]
        return any(answers)

    def _run_file(self, path: str, unlike: list[ShapeSignature]) -> bool:
        answered = False
        try:
            shapes = self._read(path)
        except (MeshError, MemoryError) as error:
            self._print(path, None, self._failure(path, error))
            return False
        for shape in shapes:
            try:
                answer = self._answer(shape.mesh, unlike)
            except (MeshError, MemoryError) as error:
                self._print(path, shape, self._failure(path, error))
            else:
                self._print(path, shape, answer)
                answered = True
        return answered

    def _answer(self, asked: Mesh | list[ShapeSignature], unlike: list[ShapeSignature]) -> _Answer:
        shapes: QueryShapes = asked
        if self.options.versions and not isinstance(asked, list):
            # Described once, for both searches.
            shapes = self.library.model.describe(asked, keep_surface=True)
        matches = self.library.query(
            shapes,
            top=self.options.top,
            explain=self.options.evidence,
            exact=self.options.exact,
            unlike=unlike,
            where=filter_of(self.options),
            families=self.options.families or self.options.versions,
            rank=self.options.rank,
        )
        if not self.options.versions:
            return _Answer(matches, [])
        families = [
            self.library.versions(shapes, match, explain=self.options.evidence) if match.versions else []
            for match in matches
        ]
        return _Answer(
            matches,
            [
                [version for version in family if version.shape_id != match.shape_id]
                for match, family in zip(matches, families, strict=True)
            ],
        )

    def _examples(self, *groups: Sequence[str]) -> list[list[ShapeSignature]]:
        """Describe all shapes of groups of files; raises `MeshError` if one of the files fails."""
        described: list[list[ShapeSignature]] = [[] for _ in groups]
        reasons = []
        for signatures, paths in zip(described, groups, strict=True):
            for path in paths:
                try:
                    for shape in self._read(path):
                        signatures.append(self.library.model.describe(shape.mesh, keep_surface=True))
                except (MeshError, MemoryError) as error:
                    reasons.append(self._failure(path, error))
        if reasons:
            raise MeshError("; ".join(reasons))
        return described

    def _read(self, path: str) -> Sequence[NewShape[Mesh]]:
        """Read all shapes of a query file, at least one; objects that cannot be read are noted as failed."""
        found = self.reader.read(path)
        self.failed.extend((Path(path), problem) for problem in found.problems)
        for warning in found.warnings:
            say(f"warning: {path}: {warning}")
        if not found.shapes:
            raise MeshError(f"{Path(path).name!r} has no mesh objects; choose a file with a shape in it")
        return found.shapes

    def _failure(self, path: str, error: BaseException) -> str:
        """Note a failure and return its reason."""
        if self.options.verbose:
            say_lines("".join(traceback.format_exception(error)))
        reason = str(error) if isinstance(error, MeshError) else f"{path!r} does not fit into memory"
        self.failed.append((Path(path), reason))
        return reason

    def _print(self, query: str | list[str], shape: NewShape[Mesh] | None, answer: _Answer | str) -> None:
        """Print the matches of one query, or the sentence that says why there are none.

        The query is a file, one shape of a file, or several files together.
        """
        record: dict[str, object] = {"query": query}
        title = query if isinstance(query, str) else " and ".join(query)
        unlike = self.options.unlike
        if shape is not None and shape.object_name:
            record["object"] = shape.object_name
            title = f"{title}, {shape.object_name}"
        if self.options.together or unlike:
            record["unlike"] = unlike
        if unlike:
            title = f"{title}, not like {' and '.join(unlike)}"
        if isinstance(answer, str):
            record |= {"matches": [], "error": answer}
        else:
            record["matches"] = answer.to_json()
            if not self.options.json:
                put(f"{_match_table(one_line(title), answer, len(self.library))}\n")
        if self.options.json:
            put(json.dumps(record))


def _match_table(query: str, answer: _Answer, shapes: int) -> str:
    matches = answer.matches
    if not matches:
        none = f"none of {counted(shapes, 'shape')} meets the filters" if shapes else "the library is empty"
        return f"{query}: {none}"
    rows = [("", "similarity", "likeness", "distance", "evidence", "name", "source")]
    for rank, match in enumerate(matches, start=1):
        rows.append(_row(str(rank), match))
        versions = answer.versions[rank - 1] if answer.versions else []
        rows += [_row(f"{rank}.{number}", version) for number, version in enumerate(versions, start=1)]
    title = f"{query}: the best {len(matches)} of {counted(shapes, 'shape')}"
    return "\n".join([title, *table(rows, ">>>><<<")])


def _row(rank: str, match: Match) -> tuple[str, str, str, str, str, str, str]:
    from shapegoogle_core.rendering.text import evidence_text

    likeness = "" if match.likeness is None else f"{match.likeness:.2f}"
    figures = (_similarity(match), likeness, f"{match.distance:.4f}")
    return (rank, *figures, evidence_text(match.evidence), _name(match), match.source)


def _name(match: Match) -> str:
    """Format the name, with the number of objects that show the shape, and of its other versions."""
    name = match.name if match.placement_count == 1 else f"{match.name} ×{match.placement_count:,}"
    if (
        match.placement is not None
        and match.placement_count > 1
        and match.placement.object_name != match.name
    ):
        name = f"{match.placement.object_name} ({name})"  # the evidence is of that one
    return f"{name} and {counted(match.versions, 'version')}" if match.versions else name


def _similarity(match: Match) -> str:
    """Format the similarity so that only identical shapes show 1."""
    rounded = f"{match.similarity:.3f}"
    return ">0.999" if rounded == "1.000" and match.distance > 0 else rounded


COMMAND = Command("query", str(__doc__), _add_options, _run, reads_files=True)
