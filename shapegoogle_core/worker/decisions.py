# SPDX-License-Identifier: MIT
"""Requests about decisions: make, list and undo them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from shapegoogle_core.client import LibraryAddress
from shapegoogle_core.library.decisions.decision import Decision, DecisionKind
from shapegoogle_core.library.storage.address import Place
from shapegoogle_core.model import ShapeSignature
from shapegoogle_core.worker.requests import changing, open_library
from shapegoogle_core.worker.session import as_address

__all__ = ["Outside", "decide", "decisions", "undo"]


@dataclass(frozen=True, eq=False)
class Outside:
    """A shape that is not taken from the library: what was searched with.

    Attributes
    ----------
    signature : ShapeSignature
    name, source : str
        Of its object and its file.
    """

    signature: ShapeSignature
    name: str
    source: str


def decide(
    path: LibraryAddress | Place,
    kind: DecisionKind,
    shapes: Sequence[int | Outside],
    others: Sequence[int],
    author: str,
) -> list[Decision]:
    """Remember decisions, and list all of the library.

    Parameters
    ----------
    path : LibraryAddress, Path or str
        The library.
    kind : str
        See `Decision`.
    shapes : sequence of int or Outside
        For a pair, each of them is paired with each of the others; otherwise each gets a decision.
    others : sequence of int
        Empty if the kind is about one shape.
    author : str

    Returns
    -------
    decisions : list of Decision
        Oldest first; those made now are the last ones.

    Raises
    ------
    LibraryError
        If the library cannot be written, or a shape is not in it any more.
    """
    with changing(path) as library:
        for shape in shapes:
            for other in others or (None,):
                if isinstance(shape, Outside):
                    about = {"name": shape.name, "source": shape.source}
                    library.decide(kind, shape.signature, other, author=author, **about)
                elif shape != other:
                    library.decide(kind, shape, other, author=author)
        return library.decisions()


def decisions(path: LibraryAddress | Place) -> list[Decision]:
    """List what was decided about shapes of a library; see `Library.decisions`.

    Parameters
    ----------
    path : LibraryAddress, Path or str
        The library, which need not exist.

    Returns
    -------
    decisions : list of Decision
        Oldest first.

    Raises
    ------
    LibraryError
        If the library cannot be read.
    """
    address = as_address(path)
    is_there = not isinstance(address.place, Path) or address.place.is_file()
    return open_library(address).decisions() if is_there else []


def undo(path: LibraryAddress | Place, numbers: Sequence[int]) -> list[Decision]:
    """Take decisions back, and list those that are left.

    Parameters
    ----------
    path : LibraryAddress, Path or str
        The library.
    numbers : sequence of int
        Those that another program has taken back meanwhile are passed over.

    Returns
    -------
    decisions : list of Decision
        Oldest first.

    Raises
    ------
    LibraryError
        If the library cannot be written.
    """
    with changing(path) as library:
        known = {decision.number for decision in library.decisions()}
        for number in numbers:
            if number in known:
                library.undo(number)
        return library.decisions()
