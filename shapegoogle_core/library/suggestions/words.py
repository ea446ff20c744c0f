# SPDX-License-Identifier: MIT
"""Words of the names that people give to shapes."""

from __future__ import annotations

import re
from pathlib import PurePath

__all__ = ["name_words"]

# Digits and punctuation separate runs of letters.
_LETTERS = re.compile(r"[^\W\d_]+")
# Words that say how a file was made and not what it shows.
_TECHNICAL = {
    *("copy", "export", "final", "geo", "geometry", "high", "lod", "low", "mesh", "model", "new", "obj"),
    *("object", "old", "poly", "polygon", "scan", "scene", "test", "tmp", "untitled", "version"),
}
_SHORTEST = 3


def name_words(name: str) -> list[str]:
    """List the words of a name that may say what a shape is.

    Parameters
    ----------
    name : str
        Of an object or a file.

    Returns
    -------
    words : list of str
        In lower case, each once, in their order; without numbers, words of one or two letters, file suffixes
        and technical words such as "mesh".

    Examples
    --------
    >>> name_words("OfficeChair_low.003"), name_words("pine-tree2.obj")
    (['office', 'chair'], ['pine', 'tree'])
    """
    path = PurePath(name)
    stem = path.stem if path.suffix[1:].isalnum() else name
    words = [word.lower() for run in _LETTERS.findall(stem) for word in _words_of_run(run)]
    return list(dict.fromkeys(word for word in words if len(word) >= _SHORTEST and word not in _TECHNICAL))


def _words_of_run(letters: str) -> list[str]:
    """Split at capitals: "OfficeChair" has two words, and so has "USBStick"."""
    words = [letters[:1]]
    for number, letter in enumerate(letters[1:], start=1):
        next_is_small = letters[number + 1 : number + 2].islower()
        if letter.isupper() and (not letters[number - 1].isupper() or next_is_small):
            words.append(letter)
        else:
            words[-1] += letter
    return words
