# SPDX-License-Identifier: MIT
"""Add the meshes of folders to a library; only new and changed files are read.

Files that cannot be read, take too long or crash their process are skipped and listed at the end.
They are tried again when they change, or with --retry.

--exclude  patterns as in a .gitignore, except that they only exclude: "*_draft.*" is compared with the name
           of each file and folder, "old/*.obj" and "/old" with the path below FOLDER, "old/" with folders
           only. * and ? stand for any characters but the slash, [a-z] for one of some, ** for any number of
           folders. What is in an excluded folder is excluded. Files that were indexed before stay in the
           library.
--shard    which part a file belongs to depends on its path below FOLDER, so machines agree without speaking
           to each other; they may run at the same time if the library is in a database
--log      lines with time and level: what was started, each file with its shapes and seconds, warnings,
           failures with the whole reason, unexpected errors with their traceback, and the summary

for example:
  shapegoogle index ~/models ~/scans --library shapes.sglib --jobs 4
  shapegoogle index ~/models --library shapes.sglib --prune --json
  shapegoogle index ~/models --library shapes.sglib --exclude "*_draft.*" --exclude old/ --dry-run
"""

from __future__ import annotations

import argparse
import traceback
from collections.abc import Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

from shapegoogle_core import __version__
from shapegoogle_core.api.arguments import as_path
from shapegoogle_core.cli.arguments import (
    add_flag,
    add_inputs,
    add_jobs,
    add_library,
    add_value,
    named_folder,
    number_from,
    positive_number,
    shard_from,
)
from shapegoogle_core.cli.command import DONE, INTERRUPTED, SOME_FAILED, UNUSABLE, Command
from shapegoogle_core.cli.events import Event
from shapegoogle_core.cli.index_report import names, report_plan, report_summary, summary_of, texts
from shapegoogle_core.cli.inputs import Failures, find_files, list_failures, say_skipped
from shapegoogle_core.cli.text import counted, say
from shapegoogle_core.errors import ShapeGoogleError
from shapegoogle_core.indexing.progress.events import IndexSummary
from shapegoogle_core.indexing.settings import IndexSettings
from shapegoogle_core.library.storage.address import Place, shown_place, without_passwords
from shapegoogle_core.mesh.io.other_formats import SkippedFormat

if TYPE_CHECKING:
    from shapegoogle_core.library.library import Library
    from shapegoogle_core.library.storage.records import Root

__all__ = ["COMMAND"]

INTERRUPTION = "everything stored so far is kept, run the same command again to continue"


def _add_options(parser: argparse.ArgumentParser) -> None:
    add_inputs(parser, least=0)
    root = (
        "index FOLDER as the root NAME, instead of one named after the folder; may be repeated. If the "
        "library has this root at a place that is not there on this computer, FOLDER is where it is here"
    )
    parser.add_argument(
        "--root", action="append", default=[], type=named_folder, metavar="NAME=FOLDER", help=root
    )
    add_library(parser, "library file, or postgresql:// address; created if it does not exist")
    add_jobs(parser)
    model = "model of a new library: a file written by `train`, or a shipped model: default, paper"
    add_value(parser, "--model", "FILE", model)
    seconds = (
        "seconds for reading one file (in Blender: without progress), and for describing one shape "
        "(%(default)g)"
    )
    add_value(parser, "--time-limit", "S", seconds, positive_number, IndexSettings.time_limit)
    megabytes = (
        "megabytes for reading one file, and for describing one shape (%(default)s); not enforced on macOS "
        "and Windows"
    )
    add_value(parser, "--memory-limit", "MB", megabytes, number_from(1), IndexSettings.memory_limit)
    add_flag(parser, "--retry", "try files again that failed before")
    add_flag(parser, "--reread", "read all files again, changed or not")
    add_flag(parser, "--prune", "remove files from the library that are gone from these folders")
    exclude = "leave out files and folders, see below; may be given more than once"
    parser.add_argument(
        "--exclude", action="append", default=[], type=_pattern, metavar="PATTERN", help=exclude
    )
    shard = "index only the I-th of N parts of the files, for N machines that index the same folders"
    add_value(parser, "--shard", "I/N", shard, shard_from)
    cluster = "index on the workers of this Dask scheduler; `local` starts --jobs workers on this machine"
    add_value(parser, "--cluster", "ADDRESS", cluster)
    trust = "allow a tcp:// scheduler on another machine, whose messages are not encrypted"
    add_flag(parser, "--trust-network", trust)
    add_flag(parser, "--dry-run", "only list what would be done; nothing is read, changed or created")
    add_value(parser, "--log", "FILE", "append each event to a file, one line each", as_path)
    add_flag(parser, "--json", "print one JSON object at the end")
    add_flag(parser, "--events", "print JSON objects, one per line, for each file and for the progress")


def _run(options: argparse.Namespace) -> int:
    options.inputs += [folder for _, folder in options.root if folder not in options.inputs]
    if not options.inputs:
        say("usage: shapegoogle index FOLDER... --library FILE")
        say("shapegoogle index: error: name the folders or files to index, or a --root")
        return UNUSABLE
    if options.log is None:
        return _index(options)
    from shapegoogle_core.cli.run_log import RunLog
    from shapegoogle_core.indexing import readable_suffixes

    files = [place for place in (options.library, *options.inputs) if isinstance(place, Path)]
    log = RunLog(options.log, files, readable_suffixes(options.reader))
    send = options.send

    def send_and_log(event: Event) -> None:
        log(event)
        if send is not None:
            send(event)

    options.send = send_and_log
    log.started(__version__, [without_passwords(word) for word in options.arguments])
    try:
        code = _index(options)
    except KeyboardInterrupt:
        log.warn(f"interrupted: {INTERRUPTION}")
        raise
    except ShapeGoogleError:  # whoever catches it sends it
        raise
    except Exception:
        log.failed("ended by an unexpected error", traceback.format_exc())
        raise
    if code == INTERRUPTED:
        log.warn(f"interrupted: {INTERRUPTION}")
    return code


def _index(options: argparse.Namespace) -> int:
    from shapegoogle_core.cli.index_progress import IndexProgress
    from shapegoogle_core.indexing import index_files, plan_indexing
    from shapegoogle_core.indexing.cluster import check_address, index_on_cluster
    from shapegoogle_core.indexing.files import absolute
    from shapegoogle_core.indexing.shards import files_of_shard
    from shapegoogle_core.library.library import Library
    from shapegoogle_core.library.storage.opening import library_exists
    from shapegoogle_core.model import load_model

    failed: Failures = []
    excluded: list[Path] = []
    skipped: list[SkippedFormat] = []
    paths = find_files(options, failed, options.exclude, excluded.append, skipped)
    if options.cluster is not None:
        check_address(options.cluster, trusted=options.trust_network)
    if options.shard is not None:
        paths = files_of_shard(paths, [absolute(folder) for folder in options.inputs], options.shard)
    known = library_exists(options.library)
    settings = IndexSettings(
        options.jobs, options.time_limit, options.memory_limit, options.retry, options.reread
    )
    if options.dry_run:
        with Library.open(options.library, read_only=True) if known else nullcontext() as library:
            if library is not None:
                _map_known_roots(library, options)
            outcomes = plan_indexing(library, paths, settings, options.reader)
            gone = library.missing(_folders(options)) if library is not None and options.prune else []
            away = [] if library is None else _roots_away(library)
        report_plan(outcomes, failed, excluded, gone, options)
        say_skipped(skipped)
        if any(outcome.status == "added" for outcome in outcomes):
            _say_away(away, options.library)
        return SOME_FAILED if failed or any(outcome.status == "failed" for outcome in outcomes) else DONE
    if not paths and not (options.prune and known):
        # A misspelt folder must not create a library.
        shapes = _shape_count(options.library) if known else 0
        summary = IndexSummary(
            failed=texts(failed), excluded=names(excluded), skipped=tuple(skipped), library_shapes=shapes
        )
        report_summary(summary, options, printed=options.json or not failed)
        say_skipped(skipped)
        list_failures(failed)
        return SOME_FAILED if failed else DONE
    model = None if options.model is None else load_model(options.model)
    with Library.open(options.library, model) as library:
        _map_known_roots(library, options)
        folders = _folders(options)
        removed = library.remove_missing(folders) if options.prune else []
        gone = [] if options.prune else library.missing(folders)
        away = _roots_away(library)
        for name, folder in [*options.root, *(("", folder) for folder in options.inputs)]:
            if folder.is_dir() and any(path.is_relative_to(absolute(folder)) for path in paths):
                library.add_root(folder, name)
        progress = IndexProgress(len(paths), verbose=options.verbose, send=options.send)
        try:
            with progress:
                if options.cluster is not None:
                    report = index_on_cluster(
                        library,
                        options.library,
                        paths,
                        settings,
                        options.cluster,
                        progress=progress.outcome,
                        reader=options.reader,
                    )
                else:
                    report = index_files(
                        library,
                        paths,
                        settings,
                        reader=options.reader,
                        progress=progress.outcome,
                        status=progress.status,
                    )
        except KeyboardInterrupt:
            say(f"shapegoogle: interrupted after {progress.done} of {len(paths)} files; {INTERRUPTION}")
            return INTERRUPTED
        shapes = len(library)
        advice = library.reindexing_advice()
        kept = _excluded_sources(library, options) if excluded else 0
    failed += report.failed
    report_summary(summary_of(report, failed, removed, excluded, skipped, shapes), options)
    say_skipped(skipped)
    if advice:
        say(advice)
    if gone:
        say(f"{counted(len(gone), 'indexed file')} no longer there; remove with --prune")
    if kept:
        say(f"{counted(kept, 'excluded file')} indexed before, which stay in the library")
    if report.added:
        _say_away(away, options.library)
    list_failures(failed)
    return SOME_FAILED if failed else DONE


def _shape_count(library: Place) -> int:
    from shapegoogle_core.library.library import Library

    with Library.open(library, read_only=True) as opened:
        return len(opened)


def _excluded_sources(library: Library, options: argparse.Namespace) -> int:
    """Count the files of the library that are excluded now."""
    from shapegoogle_core.indexing import Exclusion

    exclusion = Exclusion(options.exclude)
    tops = {spelling for entry in options.inputs for spelling in (entry.absolute(), entry.resolve())}
    sources = [Path(source) for source in library.sources()]
    return sum(
        any(
            source.is_relative_to(top) and exclusion.excludes(source.relative_to(top).as_posix())
            for top in tops
        )
        for source in sources
    )


def _map_known_roots(library: Library, options: argparse.Namespace) -> None:
    """Let named roots that are not where the library says, as on another computer, be where they are here."""
    known = {root.name: root for root in library.roots()}
    for name, folder in options.root:
        if name in known and not Path(known[name].path).is_dir():
            library.map_root(name, folder)


def _roots_away(library: Library) -> list[Root]:
    return [root for root in library.roots() if not Path(root.path).is_dir()]


def _say_away(roots: Sequence[Root], library: Place) -> None:
    """Say what to do if the new files are in a folder that was moved: they would be there twice."""
    for root in roots:
        say(
            f"the folder '{root.path}' of the root {root.name!r} is not there; if it was moved, run "
            f"`shapegoogle move '{root.path}' NEW --library {shown_place(library)}`"
        )


def _folders(options: argparse.Namespace) -> list[Path]:
    """Folders whose missing files count as gone: an empty one may be where a drive is mounted."""
    return [entry for entry in options.inputs if _has_entries(entry)]


def _has_entries(folder: Path) -> bool:
    try:
        return any(folder.iterdir())
    except OSError:  # not a folder, missing or unreadable: `find_files` has reported it
        return False


def _pattern(text: str) -> str:
    from shapegoogle_core.indexing.exclusion import Exclusion

    try:
        Exclusion([text])
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from error
    return text


COMMAND = Command("index", str(__doc__), _add_options, _run, reads_files=True)
