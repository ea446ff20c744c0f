# SPDX-License-Identifier: MIT
"""Paths of sources: their roots, and the many spellings of one path.

A library may have been made on another computer, so a path is read by what it looks like, not by the system
that runs: with a drive or a share it is a path of Windows, where upper and lower case are the same.
"""

from __future__ import annotations

import ntpath
import os
import posixpath
import re
from collections.abc import Callable, Sequence
from pathlib import Path

__all__ = [
    "absolute_path",
    "containing_root",
    "is_windows",
    "joined",
    "path_key",
    "relative_to",
    "spellings",
    "top_folders",
]

_DRIVE_OR_SHARE = re.compile(r"^(?:[A-Za-z]:(?:[\\/]|$)|\\\\[^\\/])")
# The long form of Windows: \\?\C:\models and \\?\UNC\server\share.
_LONG_SHARE, _LONG = "\\\\?\\UNC\\", "\\\\?\\"


def is_windows(path: str) -> bool:
    r"""Whether a path has a drive or a share of Windows.

    Parameters
    ----------
    path : str

    Returns
    -------
    windows : bool

    Examples
    --------
    >>> from shapegoogle_core.library.roots.paths import is_windows
    >>> [is_windows(path) for path in (r"D:\models", r"\\nas\models", "/home/ana", "a.obj")]
    [True, True, False, False]
    """
    return _DRIVE_OR_SHARE.match(path) is not None


def absolute_path(path: str) -> str:
    """Return an absolute path without "..", "." and trailing separators; links are not followed.

    Parameters
    ----------
    path : str
        Relative to the working directory, unless it is absolute on its own system.

    Returns
    -------
    path : str
    """
    if is_windows(path):
        path = path.replace("/", "\\")
        if path.upper().startswith(_LONG_SHARE):
            path = "\\\\" + path[len(_LONG_SHARE) :]
        path = path.removeprefix(_LONG)
        if os.name != "nt":
            path = ntpath.normpath(path)
            return path.rstrip("\\") if path.startswith("\\\\") else path
    return os.path.abspath(path)  # noqa: PTH100 - `resolve` would follow links


def spellings(path: str, follow: Callable[[str], str] = os.path.realpath) -> list[str]:
    """List the absolute paths that a path may stand for, the likeliest first.

    Links in the folder are followed, so that a folder has one name however it is reached. A link to a file
    keeps its own name if it points to a hidden place, as in a store of contents by their hashes.

    Parameters
    ----------
    path : str
    follow : callable, optional
        Follows the links in a path; `os.path.realpath`, which a caller with many paths may cache.

    Returns
    -------
    paths : list of str
        Each once.
    """
    plain = absolute_path(path)
    if is_windows(plain) and os.name != "nt":
        return [plain]
    folder, name = os.path.split(plain)
    found = [str(Path(follow(folder), name)), plain]
    if Path(plain).is_symlink():
        target = os.path.realpath(plain)
        same_kind = Path(target).suffix.lower() == Path(plain).suffix.lower()
        if same_kind and _hidden(target) <= _hidden(found[0]):
            found.insert(0, target)
    if os.name == "nt" and path.startswith("/"):
        found.append(posixpath.normpath(path))  # of a library that was made on another system
    return list(dict.fromkeys(found))


def relative_to(path: str, folder: str) -> str | None:
    r"""Return the path below a folder, with "/" between its parts.

    Parameters
    ----------
    path, folder : str
        Absolute, see `absolute_path`.

    Returns
    -------
    relative : str or None
        Empty for the folder itself; None for a path that does not lie below it.

    Examples
    --------
    >>> from shapegoogle_core.library.roots.paths import relative_to
    >>> relative_to(r"C:\Models\chairs\oak.obj", r"c:\models")
    'chairs/oak.obj'
    >>> print(relative_to("/models2/oak.obj", "/models"))
    None
    """
    windows = is_windows(folder)
    if windows != is_windows(path):
        return None
    if not windows:  # of a hundred thousand paths this takes a tenth of the time
        top = folder.rstrip("/")
        if path.rstrip("/") == top:
            return ""
        return path[len(top) + 1 :] if path.startswith(f"{top}/") else None
    parts, tops = _parts(path, windows), _parts(folder, windows)
    if _folded(parts[: len(tops)]) != _folded(tops):
        return None
    return "/".join(parts[len(tops) :])


def joined(folder: str, relative: str) -> str:
    """Return the full path of a source below a root.

    Parameters
    ----------
    folder : str
        Path of the root.
    relative : str
        With "/" between its parts.

    Returns
    -------
    path : str
    """
    separator = "\\" if is_windows(folder) else "/"
    if separator == "\\":
        relative = relative.replace("/", "\\")
    if not relative:
        return folder
    return folder + relative if folder.endswith(separator) else folder + separator + relative


def path_key(folder: str, relative: str) -> str:
    """Return the key of a path below a root: equal for all spellings that mean the same file there.

    Parameters
    ----------
    folder : str
        Path of the root.
    relative : str

    Returns
    -------
    key : str
    """
    return relative.casefold() if is_windows(folder) else relative


def containing_root(path: str, roots: Sequence[str]) -> tuple[int, str] | None:
    """Find the root that a path lies below: the longest of them.

    Parameters
    ----------
    path : str
        Absolute, see `absolute_path`.
    roots : sequence of str
        Paths of the roots.

    Returns
    -------
    index, relative : int, str
        Position of the root and the path below it; None if it lies below none.
    """
    below = [
        (index, relative)
        for index, root in enumerate(roots)
        if (relative := relative_to(path, root)) is not None
    ]
    return min(below, key=lambda found: len(found[1]), default=None)


def top_folders(folders: Sequence[str]) -> list[str]:
    """Leave out the folders that lie below another one of them.

    Parameters
    ----------
    folders : sequence of str
        Absolute.

    Returns
    -------
    folders : list of str
        Each once, in alphabetical order.
    """
    tops: list[str] = []
    for folder in sorted(dict.fromkeys(folders), key=lambda folder: (len(folder), folder)):
        if containing_root(folder, tops) is None:
            tops.append(folder)
    return sorted(tops)


def _parts(path: str, windows: bool) -> list[str]:
    if windows:
        return path.replace("/", "\\").rstrip("\\").split("\\")
    return path.rstrip("/").split("/")


def _hidden(path: str) -> set[str]:
    return {part for part in _parts(path, is_windows(path)) if part.startswith(".")}


def _folded(parts: Sequence[str]) -> list[str]:
    return [part.casefold() for part in parts]
