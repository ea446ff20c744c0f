# SPDX-License-Identifier: MIT
"""Plans for moving sources: a folder lies elsewhere now, and the library follows it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.roots.arranging import free_name
from shapegoogle_core.library.roots.paths import (
    containing_root,
    is_windows,
    joined,
    path_key,
    relative_to,
    spellings,
)
from shapegoogle_core.library.storage.records import Rearrangement, Root, SourceKey, SourceRecord

__all__ = ["MoveReport", "plan_move"]

# Number of names in an error message.
_SHOWN = 3


@dataclass(frozen=True)
class MoveReport:
    """Outcome of moving sources.

    Attributes
    ----------
    sources : tuple of (str, str)
        Former and new path of each source.
    missing : tuple of str
        New paths at which there is no file.
    merged : tuple of str
        Former paths of sources that gave way to a source at their new path, because that has the same content
        or because only its file still exists.
    roots : tuple of (str, str, str)
        Name, former and new path of each root that lies elsewhere; the former path of a new one is empty.
    changes : Rearrangement
        What the library has to do.
    """

    sources: tuple[tuple[str, str], ...]
    missing: tuple[str, ...]
    merged: tuple[str, ...]
    roots: tuple[tuple[str, str, str], ...]
    changes: Rearrangement = field(repr=False)

    @property
    def found(self) -> int:
        """Number of files that are at their new path."""
        return len(self.sources) - len(self.missing)


@dataclass(frozen=True)
class _Place:
    """A source with its place after the move."""

    source: SourceRecord
    path: str
    key: SourceKey
    moves: bool


def plan_move(
    old: str, new: str, roots: Sequence[Root], sources: Sequence[SourceRecord], exists: Callable[[str], bool]
) -> MoveReport:
    """Plan to move all sources below a folder.

    Parameters
    ----------
    old : str
        The folder as it was, in any spelling; it need not exist.
    new : str
        Absolute path of the folder that it is now.
    roots : sequence of Root
    sources : sequence of SourceRecord
        All of the library.
    exists : callable
        Whether there is a file at a path.

    Returns
    -------
    report : MoveReport

    Raises
    ------
    LibraryError
        If no source lies below `old`; if no file of them is below `new`; or if two different files would
        become one source.
    """
    old = _known_spelling(old, roots, sources)
    if relative_to(old, new) == "":
        raise LibraryError(
            "'{old}' and '{new}' are the same folder; name the one that it was and the new one",
            old=old,
            new=new,
        )
    after = _roots_after(old, new, roots, sources)
    places = [_place(source, old, new, after) for source in sources]
    kept, merged = _without_conflicts(places, after, exists)
    moving = [place for place in places if place.moves]
    missing = tuple(
        place.path for place in moving if place.source.size is not None and not exists(place.path)
    )
    files = [place for place in moving if place.source.size is not None]
    if files and len(missing) == len(files):
        raise LibraryError(
            "none of the {count:,} files below '{old}' is in '{new}'; name the folder that has the same "
            "files and folders in it",
            count=len(files),
            old=old,
            new=new,
        )
    before = {root.name: root.path for root in roots}
    flavour = {name for name, path in before.items() if is_windows(path) != is_windows(after.get(name, path))}
    used = {place.key.root for place in kept}
    removed = {place.source.key for place in places} - {place.source.key for place in kept}
    return MoveReport(
        sources=tuple((place.source.path, place.path) for place in moving),
        missing=missing,
        merged=tuple(place.source.path for place in merged),
        roots=tuple(
            (name, before.get(name, ""), path) for name, path in after.items() if before.get(name) != path
        ),
        changes=Rearrangement(
            roots=tuple((name, path) for name, path in after.items() if before.get(name) != path),
            moved=tuple(
                (place.source.key, place.key)
                for place in kept
                if place.source.key != place.key or place.key.root in flavour
            ),
            removed=tuple(sorted(removed)),
            # A root in the place of another one, or one whose sources all lie below another one now.
            removed_roots=tuple(
                root.name
                for root in roots
                if root.name not in after or (root.source_count and root.name not in used)
            ),
        ),
    )


def _known_spelling(old: str, roots: Sequence[Root], sources: Sequence[SourceRecord]) -> str:
    """Return the spelling of a folder that sources or roots lie below."""
    for spelling in spellings(old):
        folders = any(relative_to(root.path, spelling) is not None for root in roots)
        if folders or any(relative_to(source.path, spelling) for source in sources):
            return spelling
    listed = ", ".join(f"'{root.path}'" for root in roots)
    known = f"the library knows {listed}" if listed else "the library has no roots"
    raise LibraryError(f"no indexed file lies below '{old}'; {known}")


def _roots_after(
    old: str, new: str, roots: Sequence[Root], sources: Sequence[SourceRecord]
) -> dict[str, str]:
    """Paths of the roots after the move, by name; of two that would be one folder, only that of the place."""
    moving = {root.name: relative_to(root.path, old) for root in roots}
    after = {root.name: root.path for root in roots if moving[root.name] is None}
    for name, relative in moving.items():
        if relative is not None:
            path = joined(new, relative)
            if all(relative_to(path, other) != "" for other in after.values()):
                after[name] = path
    inside = any(
        source.root and moving[source.root] is None and relative_to(source.path, old) for source in sources
    )
    if inside and containing_root(new, list(after.values())) is None:
        after[free_name(new, roots)] = new
    return after


def _place(source: SourceRecord, old: str, new: str, after: dict[str, str]) -> _Place:
    relative = relative_to(source.path, old)
    path = joined(new, relative) if relative else source.path
    if not source.root:
        return _Place(source, path, SourceKey("", path), bool(relative))
    found = containing_root(path, list(after.values()))
    if found is None:  # through a link that leads out of its root
        return _Place(source, path, source.key, bool(relative))
    return _Place(source, path, SourceKey(list(after)[found[0]], found[1]), bool(relative))


def _without_conflicts(
    places: Sequence[_Place], after: dict[str, str], exists: Callable[[str], bool]
) -> tuple[list[_Place], list[_Place]]:
    """Choose one of the sources that would have the same place; return these and the others."""
    by_place: defaultdict[tuple[str, str], list[_Place]] = defaultdict(list)
    for place in places:
        root, path = place.key
        by_place[root, path_key(after[root], path) if root in after else path].append(place)
    kept: list[_Place] = []
    given_way: list[_Place] = []
    different: list[_Place] = []
    for rivals in by_place.values():
        # The source that is there describes the file that is there; otherwise the one with more shapes.
        first, *others = sorted(rivals, key=_preference)
        kept.append(first)
        for other in others:
            same = first.source.sha256 is not None and first.source.sha256 == other.source.sha256
            outdated = not first.moves and exists(first.path) and not exists(other.source.path)
            (given_way if same or outdated else different).append(other)
    if different:
        names = ", ".join(f"'{place.source.path}'" for place in different[:_SHOWN])
        more = f" and {len(different) - _SHOWN:,} more" if len(different) > _SHOWN else ""
        raise LibraryError(
            f"{names}{more} would take the place of another source with another content, "
            f"'{different[0].path}'; forget one of the two first (`shapegoogle forget`)"
        )
    return kept, given_way


def _preference(place: _Place) -> tuple[bool, bool, int, str]:
    return place.source.error is not None, place.moves, -place.source.shape_count, place.source.path
