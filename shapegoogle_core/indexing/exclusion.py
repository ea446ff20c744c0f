# SPDX-License-Identifier: MIT
"""Patterns of files and folders to leave out, as in a .gitignore."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterable

from shapegoogle_core.api.arguments import check_type

__all__ = ["Exclusion"]

# Where names of files do not depend on case, patterns do not either.
_FLAGS = re.IGNORECASE if sys.platform in ("win32", "darwin") else re.NOFLAG


class Exclusion:
    """Patterns of files and folders to leave out.

    A pattern without a slash, other than one at its end, is compared with the name of each file and folder.
    One with a slash is compared with the path below the searched folder. ``*`` stands for any characters but
    the slash, ``?`` for one, ``[a-z]`` for one of some, ``**`` for any number of folders. With a slash at its
    end, a pattern is that of folders only. What is below a folder that is left out is left out too.

    Parameters
    ----------
    patterns : iterable of str

    Raises
    ------
    ValueError
        If a pattern is empty, or begins with an exclamation mark.

    Examples
    --------
    >>> from shapegoogle_core.indexing.exclusion import Exclusion
    >>> exclusion = Exclusion(["*_draft.*", "old/"])
    >>> exclusion.excludes("chairs/old/stool.obj"), exclusion.excludes("chairs/stool.obj")
    (True, False)
    """

    def __init__(self, patterns: Iterable[str]) -> None:
        self._rules = [_rule(pattern) for pattern in patterns]

    def __bool__(self) -> bool:
        """Whether there are any patterns."""
        return bool(self._rules)

    def matches(self, path: str, *, folder: bool = False) -> bool:
        """Whether a file or folder is named by a pattern.

        Parameters
        ----------
        path : str
            Below the searched folder, with slashes.
        folder : bool, optional
            Whether it is a folder.

        Returns
        -------
        matches : bool
        """
        return any(rule.fullmatch(path) for rule, folders in self._rules if folder or not folders)

    def excludes(self, path: str) -> bool:
        """Whether a file is left out, by itself or with one of its folders.

        Parameters
        ----------
        path : str
            Below the searched folder, with slashes.

        Returns
        -------
        excludes : bool
        """
        folders = path.split("/")[:-1]
        above = ("/".join(folders[: end + 1]) for end in range(len(folders)))
        return self.matches(path) or any(self.matches(folder, folder=True) for folder in above)


def _rule(pattern: str) -> tuple[re.Pattern[str], bool]:
    """Translate a pattern; returns whether it is that of folders only, too."""
    check_type("a pattern to exclude", pattern, str, "a text")
    text = pattern.replace(os.sep, "/") if os.sep == "\\" else pattern
    body = text.rstrip("/").removeprefix("/")
    if not body:
        raise ValueError(f"a pattern to exclude must name something, not {pattern!r}")
    if body.startswith("!"):
        raise ValueError(
            f"a pattern to exclude must not begin with '!', as {pattern!r} does; it only excludes"
        )
    anchored = "/" in text.rstrip("/")
    parts = body.split("/")
    expression = "" if anchored else "(?:.*/)?"
    for number, part in enumerate(parts):
        last = number == len(parts) - 1
        if part == "**":
            # At the end it is everything below a folder, not the folder itself.
            expression += ".+" if last else "(?:.*/)?"
        else:
            expression += _translate(part) + ("" if last else "/")
    return re.compile(expression, _FLAGS | re.DOTALL), text.endswith("/")


def _translate(part: str) -> str:
    """Translate one name of a pattern."""
    expression, position = "", 0
    while position < len(part):
        character = part[position]
        position += 1
        if character == "*":
            expression += "[^/]*"
        elif character == "?":
            expression += "[^/]"
        elif (
            character == "["
            and (end := part.find("]", position + 1 + (part[position : position + 1] in "!^"))) > 0
        ):
            chosen = part[position:end].replace("\\", "\\\\").replace("[", "\\[")
            negated = chosen[0] in "!^"
            expression += f"(?!/)[{'^' if negated else ''}{chosen[negated:]}]"
            position = end + 1
        elif character == "\\" and position < len(part):
            expression += re.escape(part[position])
            position += 1
        else:
            expression += re.escape(character)
    return expression
