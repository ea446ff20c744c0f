# SPDX-License-Identifier: GPL-3.0-or-later
"""Progress and result of indexing and training in words, in the language of the interface.

The core describes the same events in English, for its command line.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..translation import countable, counted, marked, tr

if TYPE_CHECKING:
    from collections.abc import Sequence

    from shapegoogle_core.cli.events import StepProgress
    from shapegoogle_core.indexing import IndexingProgress, IndexSummary
    from shapegoogle_core.indexing.reading.notes import LeftOut

__all__ = ["progress_text", "step_text", "summary_text"]

# Kinds of objects that are no shapes, as `reading` names them; others are shown in English.
LEFT_OUT = {
    "light": countable("{count:,} light", "{count:,} lights"),
    "camera": countable("{count:,} camera", "{count:,} cameras"),
    "armature": countable("{count:,} armature", "{count:,} armatures"),
    "empty": countable("{count:,} empty", "{count:,} empties"),
    "lattice": countable("{count:,} lattice", "{count:,} lattices"),
    "speaker": countable("{count:,} speaker", "{count:,} speakers"),
    "volume": countable("{count:,} volume", "{count:,} volumes"),
    "light probe": countable("{count:,} light probe", "{count:,} light probes"),
    "grease pencil": countable("{count:,} grease pencil", "{count:,} grease pencils"),
    "hair object": countable("{count:,} hair object", "{count:,} hair objects"),
    "mesh without faces": countable("{count:,} mesh without faces", "{count:,} meshes without faces"),
    "empty mesh": countable("{count:,} empty mesh", "{count:,} empty meshes"),
    "empty point cloud": countable("{count:,} empty point cloud", "{count:,} empty point clouds"),
    "empty curve": countable("{count:,} empty curve", "{count:,} empty curves"),
    "empty text": countable("{count:,} empty text", "{count:,} empty texts"),
    "empty surface": countable("{count:,} empty surface", "{count:,} empty surfaces"),
    "metaball element": countable("{count:,} metaball element", "{count:,} metaball elements"),
    "empty collection": countable("{count:,} empty collection", "{count:,} empty collections"),
    "oversized whole": countable("{count:,} oversized whole", "{count:,} oversized wholes"),
    "hidden object": countable("{count:,} hidden object", "{count:,} hidden objects"),
    "further instance": countable("{count:,} further instance", "{count:,} further instances"),
    "object of a missing file": countable(
        "{count:,} object of a missing file", "{count:,} objects of missing files"
    ),
}
# Steps of training, as the core names them.
STEPS = {
    "reading": marked("Reading"),
    "describing shapes": marked("Describing shapes"),
}


def progress_text(progress: IndexingProgress, *, brief: bool = False) -> str:
    """Describe the progress of indexing.

    Parameters
    ----------
    progress : IndexingProgress
    brief : bool, optional
        Without the shapes, if there are files to count.

    Returns
    -------
    text : str
        Such as "351 of 352 files, 412 of about 2,350 shapes, 6 min left".
    """
    parts = []
    if not progress.scene:
        parts.append(
            counted(
                "{done:,} of {count:,} file",
                "{done:,} of {count:,} files",
                progress.files_total,
                done=progress.files_done,
            )
        )
    if progress.read_share is not None:
        parts.append(tr("{share:.0%} of a large file read").format(share=progress.read_share))
    left = progress.shapes_waiting + progress.shapes_expected
    done, shapes = progress.shapes_done, progress.shapes_done + left
    if brief and not progress.scene:
        pass
    elif progress.seconds_left is None:
        # A file that has not been read may contain one shape or thousands.
        parts.append(_shapes(done))
    elif progress.shapes_expected:
        parts.append(
            counted(
                "{done:,} of about {count:,} shape", "{done:,} of about {count:,} shapes", shapes, done=done
            )
        )
    elif shapes:
        parts.append(
            counted("{done:,} of {count:,} shape", "{done:,} of {count:,} shapes", shapes, done=done)
        )
    if progress.seconds_left is None:
        if not brief or progress.read_share is None:
            parts.append(tr("estimating the time left"))
    elif progress.files_done == progress.files_total and not left:
        parts.append(tr("done"))
    else:
        parts.append(_time_left(progress.seconds_left))
    return ", ".join(parts)


def summary_text(summary: IndexSummary) -> str:
    """Describe what indexing has done.

    Parameters
    ----------
    summary : IndexSummary

    Returns
    -------
    text : str
        Such as "130 shapes added from 12 files, 3 files unchanged; 3 objects skipped: 3 lights".
    """
    text = ", ".join(_counts(summary)) or tr("no files found")
    return f"{text}; {_left_out(summary.left_out)}" if summary.left_out else text


def step_text(step: StepProgress) -> str:
    """Describe the progress of training.

    Parameters
    ----------
    step : StepProgress

    Returns
    -------
    text : str
        Such as "Reading: 3 of 12".
    """
    name = tr(STEPS.get(step.step, step.step))
    if step.total is None:
        return f"{name}: {step.done:,}"
    return tr("{step}: {done:,} of {count:,}").format(step=name, done=step.done, count=step.total)


def _counts(summary: IndexSummary) -> list[str]:
    failed = len(summary.failed)
    if summary.scene:
        parts = [
            counted("{count:,} shape of this scene", "{count:,} shapes of this scene", summary.added_shapes)
        ]
        if failed:
            parts.append(counted("{count:,} object failed", "{count:,} objects failed", failed))
        return parts
    parts = []
    if summary.added:
        parts.append(
            tr("{shapes} added from {files}").format(
                shapes=_shapes(summary.added_shapes), files=_files(summary.added)
            )
        )
    if summary.updated:
        parts.append(
            tr("{shapes} updated from {files}").format(
                shapes=_shapes(summary.updated_shapes), files=_files(summary.updated)
            )
        )
    if summary.unchanged:
        parts.append(counted("{count:,} file unchanged", "{count:,} files unchanged", summary.unchanged))
    if summary.removed:
        parts.append(counted("{count:,} file removed", "{count:,} files removed", len(summary.removed)))
    if failed and summary.partial_shapes:
        parts.append(
            counted(
                "{count:,} input failed ({shapes} stored)",
                "{count:,} inputs failed ({shapes} stored)",
                failed,
                shapes=_shapes(summary.partial_shapes),
            )
        )
    elif failed:
        parts.append(counted("{count:,} input failed", "{count:,} inputs failed", failed))
    if summary.excluded:
        parts.append(
            counted(
                "{count:,} file or folder excluded",
                "{count:,} files and folders excluded",
                len(summary.excluded),
            )
        )
    if summary.skipped:
        parts.append(
            counted(
                "{count:,} file not read ({formats})",
                "{count:,} files not read ({formats})",
                sum(each.files for each in summary.skipped),
                formats=", ".join(each.format for each in summary.skipped),
            )
        )
    if summary.warnings:
        parts.append(counted("{count:,} warning", "{count:,} warnings", len(summary.warnings)))
    return parts


def _left_out(notes: Sequence[LeftOut]) -> str:
    from shapegoogle_core.indexing.reading.notes import with_number

    kinds = [
        counted(*LEFT_OUT[note.kind], note.count) if note.kind in LEFT_OUT else with_number(note)
        for note in notes
    ]
    return counted(
        "{count:,} object skipped: {kinds}",
        "{count:,} objects skipped: {kinds}",
        sum(note.count for note in notes),
        kinds=", ".join(kinds),
    )


def _files(count: int) -> str:
    return counted("{count:,} file", "{count:,} files", count)


def _shapes(count: int) -> str:
    return counted("{count:,} shape", "{count:,} shapes", count)


def _time_left(seconds: float) -> str:
    if seconds < 59.5:
        return tr("{seconds} s left").format(seconds=max(round(seconds), 1))
    if seconds < 3570:
        return tr("{minutes} min left").format(minutes=round(seconds / 60))
    return tr("{hours:.1f} h left").format(hours=seconds / 3600)
