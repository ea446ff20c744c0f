# SPDX-License-Identifier: MIT
"""Plans for changes of roots, which a store then carries out in one transaction."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.roots.keys import key_below
from shapegoogle_core.library.roots.paths import containing_root, is_windows
from shapegoogle_core.library.storage.records import Rearrangement, Root, SourceKey, SourceRecord

__all__ = ["free_name", "with_root"]


def with_root(
    path: str, name: str, roots: Sequence[Root], sources: Callable[[], Sequence[SourceRecord]]
) -> Rearrangement | None:
    """Plan to make a folder a root.

    Parameters
    ----------
    path : str
        Absolute, links followed.
    name : str
        Empty for a name after the folder, which then becomes no root if it lies below one.
    roots : sequence of Root
        Of the library.
    sources : callable
        Returns all sources of the library; not called if the root is there.

    Returns
    -------
    changes : Rearrangement or None
        None if the root is there.

    Raises
    ------
    LibraryError
        If the name belongs to another folder, or the folder has another name.
    """
    found = containing_root(path, [root.path for root in roots])
    if found is not None:
        known = roots[found[0]]
        if not name or (name == known.name and not found[1]):
            return None
        if not found[1]:
            raise LibraryError(f"'{path}' is the root {known.name!r} of the library; use this name")
    if other := next((root for root in roots if root.name == name), None):
        raise LibraryError(
            f"the root {name!r} of the library is '{other.path}'; if the folder was moved, run "
            f"`shapegoogle move` with '{other.path}' and '{path}', otherwise choose another name"
        )
    name = name or free_name(path, roots)
    renamed = [*roots, Root(name, path)]
    moved: list[tuple[SourceKey, SourceKey]] = []
    for source in sources():
        # Only indexed files have a size; other labels need not be paths.
        if source.root or source.size is not None:
            # A link inside another root may lead into the new one.
            key = key_below(source.path, renamed)
            if key is not None and key.root == name:
                moved.append((source.key, key))
    return Rearrangement(roots=((name, path),), moved=tuple(moved))


def free_name(path: str, roots: Sequence[Root]) -> str:
    """Name a root after its folder.

    Parameters
    ----------
    path : str
        Of the folder.
    roots : sequence of Root
        Whose names are taken.

    Returns
    -------
    name : str
        With a number if the name of the folder is taken.
    """
    separators = "/\\" if is_windows(path) else "/"
    own = path.rstrip(separators)
    for separator in separators:
        own = own.rpartition(separator)[2]
    own = own or path
    taken = {root.name for root in roots}
    name, number = own, 1
    while name in taken:
        number += 1
        name = f"{own} {number}"
    return name
