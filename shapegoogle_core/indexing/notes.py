# SPDX-License-Identifier: MIT
"""What a reader says of a file besides its shapes: objects that are no shapes, and files that it links."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

from shapegoogle_core.api.text import counted

__all__ = ["NO_NOTES", "FileNotes", "LeftOut", "left_out_sentence", "total_left_out"]


@dataclass(frozen=True)
class LeftOut:
    """Objects of one kind that are no shapes.

    Attributes
    ----------
    kind : str
        In the singular, such as "light" or "mesh without faces".
    count : int
    """

    kind: str
    count: int


@dataclass(frozen=True)
class FileNotes:
    """Notes on a file.

    Attributes
    ----------
    left_out : tuple of LeftOut
    linked : tuple of str
        Paths of the files that it shows objects of.
    """

    left_out: tuple[LeftOut, ...] = ()
    linked: tuple[str, ...] = ()


NO_NOTES = FileNotes()
"""On a file of which there is nothing to say."""


def total_left_out(notes: Iterable[LeftOut]) -> tuple[LeftOut, ...]:
    """Add up what was left out.

    Parameters
    ----------
    notes : iterable of LeftOut

    Returns
    -------
    total : tuple of LeftOut
        One for each kind, the most frequent first.
    """
    counts: Counter[str] = Counter()
    for note in notes:
        counts[note.kind] += note.count
    listed = sorted(counts.items(), key=lambda pair: (-pair[1], pair[0]))
    return tuple(LeftOut(kind, count) for kind, count in listed)


def left_out_sentence(notes: Iterable[LeftOut]) -> str:
    """Describe for people what was left out.

    Parameters
    ----------
    notes : iterable of LeftOut

    Returns
    -------
    sentence : str
        Empty if nothing was.

    Examples
    --------
    >>> from shapegoogle_core.indexing.notes import LeftOut, left_out_sentence
    >>> left_out_sentence([LeftOut("mesh without faces", 5), LeftOut("light", 7)])
    '12 objects skipped: 7 lights, 5 meshes without faces'
    """
    total = total_left_out(notes)
    if not total:
        return ""
    kinds = ", ".join(_with_number(note) for note in total)
    return f"{counted(sum(note.count for note in total), 'object')} skipped: {kinds}"


def _with_number(note: LeftOut) -> str:
    if note.count == 1:
        return f"1 {note.kind}"
    noun, without, rest = note.kind.partition(" without ")
    if noun.endswith("sh"):
        noun = f"{noun}es"
    elif noun.endswith("ty"):
        noun = f"{noun[:-1]}ies"
    else:
        noun = f"{noun}s"
    return f"{note.count:,} {noun}{without}{rest}"
