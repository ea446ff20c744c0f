# SPDX-License-Identifier: MIT
"""What a reader says of a file besides its shapes: objects that are no shapes, and files that it links."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

from shapegoogle_core.api.text import counted

__all__ = ["NO_NOTES", "FileNotes", "LeftOut", "left_out_sentence", "total_left_out", "with_number"]


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
    >>> from shapegoogle_core.indexing.reading.notes import LeftOut, left_out_sentence
    >>> left_out_sentence([LeftOut("mesh without faces", 5), LeftOut("light", 7)])
    '12 objects skipped: 7 lights, 5 meshes without faces'
    """
    total = total_left_out(notes)
    if not total:
        return ""
    kinds = ", ".join(with_number(note) for note in total)
    return f"{counted(sum(note.count for note in total), 'object')} skipped: {kinds}"


def with_number(note: LeftOut) -> str:
    """Name a kind of object with its number.

    Parameters
    ----------
    note : LeftOut

    Returns
    -------
    text : str

    Examples
    --------
    >>> from shapegoogle_core.indexing.reading.notes import LeftOut, with_number
    >>> with_number(LeftOut("empty", 2)), with_number(LeftOut("object of a missing file", 3))
    ('2 empties', '3 objects of a missing file')
    """
    if note.count == 1:
        return f"1 {note.kind}"
    # Of "mesh without faces" and "object of a missing file" the first word is the noun.
    joint = next((word for word in (" without ", " of ") if word in note.kind), " without ")
    noun, joint, rest = note.kind.partition(joint)
    if noun.endswith("sh"):
        noun = f"{noun}es"
    elif noun.endswith("ty"):
        noun = f"{noun[:-1]}ies"
    else:
        noun = f"{noun}s"
    return f"{note.count:,} {noun}{joint}{rest}"
