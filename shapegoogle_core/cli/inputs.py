# SPDX-License-Identifier: MIT
"""Inputs of a command: finding the files, and listing those that failed."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from shapegoogle_core.cli.text import counted, say
from shapegoogle_core.mesh.io.other_formats import SkippedFormat, skipped_formats

__all__ = ["Failures", "find_files", "list_failures", "say_skipped", "skip"]

Failures = list[tuple[Path, str]]
"""Inputs that failed, each with the reason."""


def find_files(
    options: Namespace,
    failed: Failures,
    exclude: Sequence[str] = (),
    on_excluded: Callable[[Path], None] | None = None,
    skipped: list[SkippedFormat] | None = None,
) -> list[Path]:
    """Find the mesh files of a command's inputs.

    Parameters
    ----------
    options : argparse.Namespace
        With ``inputs`` and ``reader``.
    failed : list of (Path, str)
        Inputs that are missing or contain no mesh are appended here, and reported.
    exclude : sequence of str, optional
    on_excluded : callable, optional
        See `find_meshes`.
    skipped : list of SkippedFormat, optional
        Formats that are not read are appended here; by default they are reported.

    Returns
    -------
    paths : list of Path
        See `find_meshes`.
    """
    from shapegoogle_core.indexing import find_meshes, readable_suffixes

    other: list[Path] = []
    paths = find_meshes(
        options.inputs,
        lambda path, reason: skip(path, reason, failed),
        readable_suffixes(options.reader),
        exclude=exclude,
        on_excluded=on_excluded,
        on_skipped=other.append,
    )
    formats = skipped_formats(other)
    if skipped is None:
        say_skipped(formats)
    else:
        skipped.extend(formats)
    return paths


def say_skipped(formats: Iterable[SkippedFormat]) -> None:
    """Print what to do with files in formats that are not read.

    Parameters
    ----------
    formats : iterable of SkippedFormat
    """
    for skipped in formats:
        say(skipped.sentence())


def skip(path: Path, reason: str, failed: Failures) -> None:
    """Report an input that failed when it fails, and note it for the list at the end.

    Parameters
    ----------
    path : Path
    reason : str
        A sentence that names the input.
    failed : list of (Path, str)
    """
    say(f"skipped {path}: {reason}")
    failed.append((path, reason))


def list_failures(failed: Failures) -> None:
    """Print all inputs that failed to stderr.

    Parameters
    ----------
    failed : list of (Path, str)
    """
    if failed:
        say(f"{counted(len(failed), 'input')} failed:")
        for path, reason in failed:
            say(f"  {path}: {reason}")
