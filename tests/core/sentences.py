# SPDX-License-Identifier: MIT
"""The rule for messages: one plain sentence that names the input, and nothing of Python."""

from __future__ import annotations

import re

__all__ = ["faults"]

# What Python, numpy, SQLite and the formats' libraries say, and no user understands.
_PYTHON = [
    r"\b(?!MeshError|LibraryError|ModelError|ShapeGoogleError)[A-Z]\w*(?:Error|Exception|Warning|Interrupt|Exit)\b",
    r"\bSQLITE_",
    r"\bErrno\b|\[Errno",
    r"Traceback|\bat 0x[0-9a-f]+|<[\w.]+ object|<class '",
    r"\bNoneType\b|'\w+' object (has|is|cannot)",
    r"\bdtype\b|\barray\(|\bndarray\b|\bnumpy\b|np\.\w+\(",
    r"\bb'|\bb\"",
    r"\\x[0-9a-f]{2}",
    r"codec can't|invalid literal|could not convert|invalid load key|unpack requires|not enough values",
    r"out of bounds for|list index|index \d+ is out|string indices|subscriptable|unhashable|not iterable",
    r"cannot reshape|broadcast|inhomogeneous|setting an array element|negative dimensions",
    r"Expecting (value|property|',')|Extra data:|line \d+ column \d+|\(char \d+\)",
    r"unexpected keyword|positional argument|takes \d+|missing \d+ required",
    r"Bad magic number|Bad CRC|not a zip file|decompressing data|mismatched tag|not well-formed",
    r"database disk image|no such (table|column)|constraint failed|malformed",
    r"\bunexpected (?=[A-Z])",
]
_PATTERNS = [re.compile(pattern) for pattern in _PYTHON]


def faults(message: str, name: str | None = None) -> list[str]:
    """List what is wrong with a message for users.

    Parameters
    ----------
    message : str
    name : str, optional
        Of the input, which the message must have.

    Returns
    -------
    faults : list of str
        Empty for a message that follows the rule.
    """
    found = [
        f"has {match.group()!r}" for pattern in _PATTERNS for match in [pattern.search(message)] if match
    ]
    if "\n" in message or "\r" in message:
        found.append("has several lines")
    if len(message) > 600:
        found.append(f"has {len(message)} characters")
    if name is not None and name not in message:
        found.append(f"does not name {name!r}")
    # What to do follows a semicolon, a colon or a parenthesis, and is said in the imperative.
    if not re.search(r"[;:(] ?(?:or )?[a-z`'\"][\w`'-]* ", message):
        found.append("does not say what to do")
    return [f"{fault}: {message}" for fault in found]
