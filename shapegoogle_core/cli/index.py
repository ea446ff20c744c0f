# SPDX-License-Identifier: MIT
"""Add the meshes of folders to a library; only new and changed files are read.

Files that cannot be read, take too long or crash their process are skipped and listed at the end.
They are tried again when they change, or with --retry.

for example:
  shapegoogle index ~/models ~/scans --library shapes.sglib --jobs 4
  shapegoogle index ~/models --library shapes.sglib --prune --json
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING

from shapegoogle_core.cli.arguments import (
    add_flag,
    add_inputs,
    add_jobs,
    add_library,
    add_value,
    named_folder,
    number_from,
    positive_number,
)
from shapegoogle_core.cli.command import DONE, INTERRUPTED, SOME_FAILED, UNUSABLE, Command
from shapegoogle_core.cli.events import summary_to_json
from shapegoogle_core.cli.inputs import Failures, find_files, list_failures
from shapegoogle_core.cli.text import counted, put, say
from shapegoogle_core.indexing.events import IndexSummary
from shapegoogle_core.indexing.settings import IndexSettings

if TYPE_CHECKING:
    from shapegoogle_core.indexing import IndexReport

__all__ = ["COMMAND"]


def _add_options(parser: argparse.ArgumentParser) -> None:
    add_inputs(parser, least=0)
    root = "index FOLDER as the root NAME, instead of one named after the folder; may be repeated"
    parser.add_argument(
        "--root", action="append", default=[], type=named_folder, metavar="NAME=FOLDER", help=root
    )
    add_library(parser, "library file; created if it does not exist")
    add_jobs(parser)
    model = "model of a new library: a file written by `train`, or a shipped model: default, paper"
    add_value(parser, "--model", "FILE", model)
    seconds = "seconds for reading one file, and for describing one shape (%(default)g)"
    add_value(parser, "--time-limit", "S", seconds, positive_number, IndexSettings.time_limit)
    megabytes = (
        "megabytes for reading one file, and for describing one shape (%(default)s); not enforced on macOS "
        "and Windows"
    )
    add_value(parser, "--memory-limit", "MB", megabytes, number_from(1), IndexSettings.memory_limit)
    add_flag(parser, "--retry", "try files again that failed before")
    add_flag(parser, "--reread", "read all files again, changed or not")
    add_flag(parser, "--prune", "remove files from the library that are gone from these folders")
    add_flag(parser, "--json", "print one JSON object at the end")
    add_flag(parser, "--events", "print JSON objects, one per line, for each file and for the progress")


def _run(options: argparse.Namespace) -> int:
    from shapegoogle_core.cli.index_progress import IndexProgress
    from shapegoogle_core.indexing import index_files
    from shapegoogle_core.library.library import Library
    from shapegoogle_core.model import load_model

    failed: Failures = []
    options.inputs += [folder for _, folder in options.root if folder not in options.inputs]
    if not options.inputs:
        say("shapegoogle: name the folders or files to index")
        return UNUSABLE
    paths = find_files(options, failed)
    known = options.library.exists()
    if not paths and not (options.prune and known):
        # A misspelt folder must not create a library.
        shapes = _shape_count(options.library) if known else 0
        summary = IndexSummary(failed=_as_text(failed), library_shapes=shapes)
        _report(summary, options, printed=options.json)
        list_failures(failed)
        return SOME_FAILED
    settings = IndexSettings(
        options.jobs, options.time_limit, options.memory_limit, options.retry, options.reread
    )
    model = None if options.model is None else load_model(options.model)
    with Library.open(options.library, model) as library:
        folders = [entry for entry in options.inputs if _has_entries(entry)]
        removed = library.remove_missing(folders) if options.prune else []
        gone = [] if options.prune else library.missing(folders)
        away = [root for root in library.roots() if not Path(root.path).is_dir()]
        for name, folder in [*options.root, *(("", folder) for folder in options.inputs)]:
            if folder.is_dir():
                library.add_root(folder, name)
        progress = IndexProgress(len(paths), verbose=options.verbose, send=options.send)
        try:
            with progress:
                report = index_files(
                    library,
                    paths,
                    settings,
                    reader=options.reader,
                    progress=progress.outcome,
                    status=progress.status,
                )
        except KeyboardInterrupt:
            say(
                f"shapegoogle: interrupted after {progress.done} of {len(paths)} files; "
                "everything stored so far is kept, run the same command again to continue"
            )
            return INTERRUPTED
        shapes = len(library)
    failed += report.failed
    _report(_summary(report, failed, removed, shapes), options)
    if gone:
        say(f"{counted(len(gone), 'indexed file')} no longer there; remove with --prune")
    for root in away:
        say(
            f"the folder '{root.path}' of the root {root.name!r} is not there; if it was moved, run "
            f"`shapegoogle move '{root.path}' NEW --library {options.library}`"
        )
    list_failures(failed)
    return SOME_FAILED if failed else DONE


def _summary(report: IndexReport, failed: Failures, removed: list[str], shapes: int) -> IndexSummary:
    return IndexSummary(
        added=report.added,
        updated=report.updated,
        unchanged=report.unchanged,
        added_shapes=report.shapes - report.updated_shapes - report.partial_shapes,
        updated_shapes=report.updated_shapes,
        partial_shapes=report.partial_shapes,
        failed=_as_text(failed),
        warnings=_as_text(report.warnings),
        removed=tuple(removed),
        library_shapes=shapes,
        seconds=report.seconds,
    )


def _as_text(entries: list[tuple[Path, str]]) -> tuple[tuple[str, str], ...]:
    return tuple((str(path), sentence) for path, sentence in entries)


def _report(summary: IndexSummary, options: argparse.Namespace, *, printed: bool = True) -> None:
    """Send the result of the run, and print it."""
    if options.send is not None:
        options.send(summary)
    if options.json:
        put(json.dumps(summary_to_json(summary)))
    if options.json or not printed:
        return
    library = f"the library has {counted(summary.library_shapes, 'shape')}"
    if summary.added or summary.updated or summary.removed or summary.failed:
        new = summary.added_shapes + summary.updated_shapes + summary.partial_shapes
        rate = f" ({new / summary.seconds:.1f} shapes/s)" if new else ""
        put(f"{summary.sentence()}; took {summary.seconds:.1f} s{rate}; {library}")
    else:
        put(f"nothing to do: {summary.sentence()}; {library}")


def _shape_count(library: Path) -> int:
    from shapegoogle_core.library.library import Library

    with Library.open(library, read_only=True) as opened:
        return len(opened)


def _has_entries(folder: Path) -> bool:
    """Whether missing files of a folder count as gone: an empty folder may be where a drive is mounted."""
    try:
        return any(folder.iterdir())
    except OSError:  # not a folder, missing or unreadable: `find_files` has reported it
        return False


COMMAND = Command("index", str(__doc__), _add_options, _run, reads_files=True)
