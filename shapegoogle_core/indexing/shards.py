# SPDX-License-Identifier: MIT
"""Shards: parts of the files, for machines that index the same folders without speaking to each other."""

from __future__ import annotations

import hashlib
import unicodedata
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

__all__ = ["Shard", "files_of_shard"]


@dataclass(frozen=True)
class Shard:
    """One of several parts of the files, chosen by their names.

    Attributes
    ----------
    number : int
        From 1 on.
    count : int
        Number of parts.

    Raises
    ------
    ValueError
        If the number is not one of the parts.

    Examples
    --------
    >>> from shapegoogle_core.indexing.shards import Shard
    >>> [shard.has("chairs/oak.obj") for shard in (Shard(1, 2), Shard(2, 2))].count(True)
    1
    """

    number: int
    count: int

    def __post_init__(self) -> None:
        if not 1 <= self.number <= self.count:
            raise ValueError(f"a shard is I/N with I from 1 to N, not {self.number}/{self.count}")

    def has(self, name: str) -> bool:
        """Decide whether a file belongs to this part, on every machine alike.

        Parameters
        ----------
        name : str
            Path below the folder that is indexed, with "/" between its parts.

        Returns
        -------
        belongs : bool
        """
        # macOS may list "é" as two characters where other systems have one.
        composed = unicodedata.normalize("NFC", name)
        digest = hashlib.sha256(composed.encode("utf-8", "surrogatepass")).digest()
        return int.from_bytes(digest[:8], "big") % self.count == self.number - 1


def files_of_shard(paths: Iterable[Path], folders: Sequence[Path], shard: Shard) -> list[Path]:
    """List the files that belong to a shard.

    Parameters
    ----------
    paths : iterable of Path
        Absolute.
    folders : sequence of Path
        Absolute; the folders that are indexed, which may have other paths on other machines. Files below none
        of them are chosen by their own names.
    shard : Shard

    Returns
    -------
    paths : list of Path
    """
    # The innermost folder, so that it does not matter in which order they are named.
    tops = sorted(folders, key=lambda folder: -len(folder.parts))
    chosen = []
    for path in paths:
        top = next((top for top in tops if path != top and path.is_relative_to(top)), path.parent)
        if shard.has(path.relative_to(top).as_posix()):
            chosen.append(path)
    return chosen
