# SPDX-License-Identifier: MIT
"""Which indexed files are gone, and which are only out of reach."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from shapegoogle_core.library.roots.paths import relative_to
from shapegoogle_core.library.storage.records import SourceRecord

__all__ = ["ForgetReport", "find_gone"]


@dataclass(frozen=True)
class ForgetReport:
    """Outcome of forgetting sources.

    Attributes
    ----------
    forgotten : tuple of str
        Paths and labels of the sources.
    shape_count : int
        Number of their shapes.
    kept : tuple of (str, int)
        Folders that are not there, or empty as where no drive is mounted, and the number of missing files
        below each: they are not forgotten, because they may come back.
    """

    forgotten: tuple[str, ...]
    shape_count: int
    kept: tuple[tuple[str, int], ...] = ()


@dataclass
class _Folders:
    """Folders that were looked at."""

    known: dict[Path, bool] = field(default_factory=dict)

    def with_entries(self, folder: Path) -> bool:
        """Whether a folder is there and holds anything."""
        if folder not in self.known:
            try:
                self.known[folder] = any(folder.iterdir())
            except OSError:
                self.known[folder] = False
        return self.known[folder]


def find_gone(
    sources: Iterable[SourceRecord], tops: Sequence[str]
) -> tuple[list[SourceRecord], dict[str, int]]:
    """Find the indexed files below some folders that no longer exist.

    A file is gone if the folder that it was in, or the nearest one above that is left, holds other entries.
    An empty folder may be where a drive is mounted, and a folder that is not there on a drive that is not
    connected.

    Parameters
    ----------
    sources : iterable of SourceRecord
    tops : sequence of str
        Absolute paths.

    Returns
    -------
    gone : list of SourceRecord
    kept : dict of str to int
        By folder, the number of files that are missing but may come back.
    """
    gone: list[SourceRecord] = []
    kept: dict[str, int] = {}
    folders = _Folders()
    for source in sources:
        if source.size is None or not _is_missing(source.path):
            continue
        top = next((top for top in tops if relative_to(source.path, top)), None)
        if top is None:
            continue
        folder = Path(source.path).parent
        while not folder.is_dir() and str(folder) != top and folder != folder.parent:
            folder = folder.parent
        if folders.with_entries(folder):
            gone.append(source)
        else:
            kept[str(folder)] = kept.get(str(folder), 0) + 1
    return gone, kept


def _is_missing(path: str) -> bool:
    """Return whether a file certainly does not exist; one that cannot be reached may exist."""
    try:
        Path(path).stat()
    except (FileNotFoundError, NotADirectoryError):
        return True
    except (OSError, ValueError):
        return False
    return False
