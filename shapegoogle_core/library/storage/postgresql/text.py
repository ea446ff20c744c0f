# SPDX-License-Identifier: MIT
"""Names in a database: PostgreSQL stores valid Unicode only, but names of files may be anything.

Half surrogates (bytes of a name that is not valid UTF-8) and the null character become characters of the last
private-use plane, and come back as they were.
"""

from __future__ import annotations

import re

__all__ = ["decode_name", "encode_name"]

# The null character, then U+D800 to U+DFFF, each on one character of the plane.
_FIRST = 0x10D7FF
_ESCAPE = "\U0010fffd"
_STORED = f"{chr(_FIRST)}-{chr(_FIRST + 0x800)}"
_UNSTORABLE = re.compile(f"[\0\ud800-\udfff{_STORED}{_ESCAPE}]")
_ENCODED = re.compile(f"{_ESCAPE}(.)|[{_STORED}]", re.DOTALL)


def encode_name(name: str) -> str:
    r"""Make a name that can be stored.

    Parameters
    ----------
    name : str
        Of any characters.

    Returns
    -------
    stored : str
        The name itself, unless it has characters that PostgreSQL refuses.

    Examples
    --------
    >>> from shapegoogle_core.library.storage.postgresql.text import decode_name, encode_name
    >>> encode_name("chair.obj")
    'chair.obj'
    >>> decode_name(encode_name("half \udcdf")) == "half \udcdf"
    True
    """
    return name if name.isascii() and "\0" not in name else _UNSTORABLE.sub(_stored, name)


def decode_name(stored: str) -> str:
    """Return the name that `encode_name` made a stored one of.

    Parameters
    ----------
    stored : str

    Returns
    -------
    name : str
    """
    return stored if stored.isascii() else _ENCODED.sub(_original, stored)


def _stored(match: re.Match[str]) -> str:
    code = ord(match[0])
    if code == 0:
        return chr(_FIRST)
    if 0xD800 <= code <= 0xDFFF:
        return chr(_FIRST + 1 + code - 0xD800)
    return _ESCAPE + match[0]


def _original(match: re.Match[str]) -> str:
    if match[1]:
        return match[1]
    code = ord(match[0]) - _FIRST
    return chr(0xD800 + code - 1) if code else "\0"
