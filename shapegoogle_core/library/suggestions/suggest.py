# SPDX-License-Identifier: MIT
"""Votes of the nearest relatives of a shape for tags, catalogs, folders and name words."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import PurePath
from typing import Literal, TypeAlias

from shapegoogle_core.library.storage.records import ShapeRecord
from shapegoogle_core.library.suggestions.words import name_words

__all__ = ["RELATIVES", "Suggestion", "SuggestionKind", "suggestions_from"]

SuggestionKind: TypeAlias = Literal["tag", "catalog", "folder", "word"]
"""A tag or catalog of relatives, the name of the folder that their files lie in, or a word of their names."""

RELATIVES = 8
"""Number of nearest relatives that vote by default."""

# Distance that is added to all: below it, which of two relatives is nearer says nothing.
_SOFT = 0.05
# Weight of a doubter who votes for nothing, so that a few far relatives give no certainty.
_DOUBT = 0.5


@dataclass(frozen=True)
class Suggestion:
    """A tag, folder or word that relatives of a shape have.

    Attributes
    ----------
    kind : {"tag", "catalog", "folder", "word"}
        A tag or asset catalog of relatives, the name of the folder that their files lie in, or a word of
        their names.
    text : str
        As it is in the library.
    confidence : float
        Share of the relatives' votes, from 0 to 1; nearer relatives have more weight.
    relatives : tuple of str
        Names of the relatives that have it, nearest first.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> sg.Suggestion("word", "chair", 0.8, ("Chair 1", "Armchair"))
    Suggestion(kind='word', text='chair', confidence=0.8, relatives=('Chair 1', 'Armchair'))
    """

    kind: SuggestionKind
    text: str
    confidence: float
    relatives: tuple[str, ...]

    def to_json(self) -> dict[str, object]:
        """Convert to the object that ``shapegoogle suggest --json`` prints.

        Returns
        -------
        record : dict
            ``kind``, ``text``, ``confidence``, ``relatives``.
        """
        return {
            "kind": self.kind,
            "text": self.text,
            "confidence": round(self.confidence, 3),
            "relatives": list(self.relatives),
        }


def suggestions_from(relatives: Sequence[ShapeRecord], distances: Sequence[float]) -> list[Suggestion]:
    """Let the nearest relatives of a shape vote.

    Parameters
    ----------
    relatives : sequence of n ShapeRecord
        Nearest first.
    distances : sequence of n float
        From the shape.

    Returns
    -------
    suggestions : list of Suggestion
        The most confident first.
    """
    votes: defaultdict[tuple[SuggestionKind, str], float] = defaultdict(float)
    names: defaultdict[tuple[SuggestionKind, str], list[str]] = defaultdict(list)
    total = 0.0
    for record, distance in zip(relatives, distances, strict=True):
        weight = (distances[0] + _SOFT) / (distance + _SOFT)
        total += weight
        for choice in _choices(record):
            votes[choice] += weight
            names[choice].append(record.object_name or record.name)
    found = [
        Suggestion(kind, text, votes[kind, text] / (total + _DOUBT), tuple(names[kind, text]))
        for kind, text in votes
    ]
    return sorted(found, key=lambda one: (-one.confidence, one.kind, one.text))


def _choices(record: ShapeRecord) -> set[tuple[SuggestionKind, str]]:
    """List everything a relative votes for."""
    choices: set[tuple[SuggestionKind, str]] = {("tag", tag) for tag in record.tags}
    if record.origin.catalog:
        choices.add(("catalog", record.origin.catalog))
    folder = PurePath(record.source).parent.name
    if folder:
        choices.add(("folder", folder))
    words = name_words(record.object_name or record.name)
    # The file's name too: an object is often just a "Cube".
    words += name_words(PurePath(record.source).name) if record.object_name else []
    return choices | {("word", word) for word in words}
