# SPDX-License-Identifier: MIT
"""Suggest tags, catalogs, folders and name words for a mesh: those of its nearest relatives in a library.

Only what is in the library already is suggested. The confidence is the share of the relatives that have it,
from 0 to 1; nearer relatives have more weight.

tag      a tag of relatives, such as those of Blender's assets
catalog  an asset catalog of relatives
folder   name of the folder that the files of relatives lie in
word     a word of their names

With --json, one line for each mesh:
  {"query": path, "suggestions": [{"kind", "text", "confidence", "relatives": [name, …]}, …]}
A mesh that cannot be read gives {"query": path, "suggestions": [], "error": "…"}; the others continue.

for example:
  shapegoogle suggest chair.obj --library shapes.sglib
  shapegoogle suggest new/*.blend --library shapes.sglib --json
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING

from shapegoogle_core.api.text import one_line
from shapegoogle_core.cli.arguments import (
    SEARCHED,
    add_flag,
    add_library,
    add_roots,
    add_value,
    map_roots,
    number_from,
)
from shapegoogle_core.cli.command import DONE, SOME_FAILED, Command
from shapegoogle_core.cli.inputs import Failures, list_failures
from shapegoogle_core.cli.text import put, say, table
from shapegoogle_core.errors import MeshError

if TYPE_CHECKING:
    from shapegoogle_core.library.suggestions import Suggestion

__all__ = ["COMMAND"]


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("meshes", nargs="+", metavar="MESH", help="file of a mesh or scan")
    add_library(parser, SEARCHED)
    add_roots(parser)
    add_value(
        parser, "--top", "N", "largest number of suggestions for each mesh (%(default)s)", number_from(1), 10
    )
    add_value(parser, "--relatives", "N", "number of nearest relatives (%(default)s)", number_from(1), 8)
    add_flag(parser, "--json", "print one JSON object for each mesh")


def _run(options: argparse.Namespace) -> int:
    from shapegoogle_core.client import open_library
    from shapegoogle_core.indexing import ShapeReader

    failed: Failures = []
    with open_library(options.library) as library, ShapeReader(options.reader) as reader:
        map_roots(library, options)
        for path in options.meshes:
            try:
                found = reader.read(path)
                failed.extend((Path(path), problem) for problem in found.problems)
                for warning in found.warnings:
                    say(f"warning: {path}: {warning}")
                if not found.shapes:
                    raise MeshError(
                        f"{Path(path).name!r} has no mesh objects; choose a file with a shape in it"
                    )
                for shape in found.shapes:
                    suggested = library.suggest(shape.mesh, relatives=options.relatives)[: options.top]
                    _print(options, path, shape.object_name, suggested)
                continue
            except MeshError as error:
                reason = str(error)
            except MemoryError:
                reason = f"{path!r} does not fit into memory"
            failed.append((Path(path), reason))
            if options.json:
                put(json.dumps({"query": path, "suggestions": [], "error": reason}))
    list_failures(failed)
    return SOME_FAILED if failed else DONE


def _print(options: argparse.Namespace, path: str, object_name: str, suggested: list[Suggestion]) -> None:
    if options.json:
        record: dict[str, object] = {"query": path}
        if object_name:
            record["object"] = object_name
        put(json.dumps(record | {"suggestions": [one.to_json() for one in suggested]}))
        return
    title = one_line(f"{path}, {object_name}" if object_name else path)
    if not suggested:
        put(f"{title}: its relatives have no tags, catalogs, folders or names to suggest\n")
        return
    rows = [("confidence", "kind", "suggestion", "relatives that have it")]
    rows += [(f"{one.confidence:.2f}", one.kind, one.text, ", ".join(one.relatives)) for one in suggested]
    put("\n".join([title, *table(rows, "><<<")]) + "\n")


COMMAND = Command("suggest", str(__doc__), _add_options, _run, reads_files=True)
