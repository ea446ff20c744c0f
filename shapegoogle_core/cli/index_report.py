# SPDX-License-Identifier: MIT
"""What `shapegoogle index` prints at the end: the summary of a run, or of a dry run."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path

from shapegoogle_core.api.text import one_line
from shapegoogle_core.cli.events import summary_to_json
from shapegoogle_core.cli.inputs import Failures, list_failures
from shapegoogle_core.cli.text import counted, put
from shapegoogle_core.indexing.progress.events import FileOutcome, IndexReport, IndexSummary
from shapegoogle_core.mesh.io.other_formats import SkippedFormat

__all__ = ["names", "report_plan", "report_summary", "summary_of", "texts"]


def summary_of(
    report: IndexReport,
    failed: Failures,
    removed: list[str],
    excluded: list[Path],
    skipped: Sequence[SkippedFormat],
    shapes: int,
) -> IndexSummary:
    """Sum up a run.

    Parameters
    ----------
    report : IndexReport
    failed : list of (Path, str)
        All inputs that failed, also before the run.
    removed : list of str
        Files that were removed from the library.
    excluded : list of Path
    skipped : sequence of SkippedFormat
    shapes : int
        Number of shapes in the library.

    Returns
    -------
    summary : IndexSummary
    """
    return IndexSummary(
        added=report.added,
        updated=report.updated,
        unchanged=report.unchanged,
        added_shapes=report.shapes - report.updated_shapes - report.partial_shapes,
        updated_shapes=report.updated_shapes,
        partial_shapes=report.partial_shapes,
        failed=texts(failed),
        warnings=texts(report.warnings),
        removed=tuple(removed),
        excluded=names(excluded),
        skipped=tuple(skipped),
        left_out=report.left_out,
        library_shapes=shapes,
        seconds=report.seconds,
    )


def texts(entries: list[tuple[Path, str]]) -> tuple[tuple[str, str], ...]:
    """Turn paths with sentences into texts.

    Parameters
    ----------
    entries : list of (Path, str)

    Returns
    -------
    entries : tuple of (str, str)
    """
    return tuple((str(path), sentence) for path, sentence in entries)


def names(paths: list[Path]) -> tuple[str, ...]:
    """Turn paths into texts.

    Parameters
    ----------
    paths : list of Path

    Returns
    -------
    names : tuple of str
    """
    return tuple(map(str, paths))


def report_summary(summary: IndexSummary, options: argparse.Namespace, *, printed: bool = True) -> None:
    """Send the result of a run, and print it.

    Parameters
    ----------
    summary : IndexSummary
    options : argparse.Namespace
    printed : bool, optional
    """
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


# What a dry run says of files, by what a run would report of them.
_TO_DO = {"added": "add", "updated": "update", "removed": "remove", "excluded": "leave out"}


def report_plan(
    outcomes: Sequence[FileOutcome],
    failed: Failures,
    excluded: list[Path],
    gone: Sequence[str],
    options: argparse.Namespace,
) -> None:
    """Print what a run would do.

    Parameters
    ----------
    outcomes : sequence of FileOutcome
        From `plan_indexing`.
    failed : list of (Path, str)
        Inputs that failed; files that would fail are appended.
    excluded : list of Path
    gone : sequence of str
        Files that would be removed from the library.
    options : argparse.Namespace
    """
    groups: dict[str, list[str]] = {status: [] for status in ("added", "updated", "unchanged")}
    for outcome in outcomes:
        if options.send is not None:
            options.send(outcome)
        if outcome.status == "failed":
            failed.append((outcome.path, outcome.reason))
        else:
            groups[outcome.status].append(str(outcome.path))
    groups |= {"removed": list(gone), "excluded": list(names(excluded))}
    if options.json:
        failures = [{"source": source, "error": reason} for source, reason in texts(failed)]
        put(json.dumps({"dry_run": True, **groups, "failed": failures}))
    else:
        for status, verb in _TO_DO.items():
            for path in groups[status]:
                put(f"{verb:<9}  {one_line(path)}")
        parts = [
            f"{counted(len(paths), 'file')} {f'to {_TO_DO[status]}' if status in _TO_DO else status}"
            for status, paths in groups.items()
            if paths
        ]
        if failed:
            parts.append(f"{counted(len(failed), 'input')} skipped")
        put(f"dry run, nothing was changed: {', '.join(parts) or 'no files found'}")
    list_failures(failed)
