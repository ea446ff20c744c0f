# SPDX-License-Identifier: MIT
"""Text formats: one decoder for all of them, and their lines, each with its number for errors."""

from __future__ import annotations

import codecs
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

from shapegoogle_core.mesh.io.file import DamagedError

__all__ = ["Lines", "filled_lines", "lines_of", "plain_text", "quoted", "unexpected", "without_mark"]

_UTF_16 = {codecs.BOM_UTF16_LE: "utf-16-le", codecs.BOM_UTF16_BE: "utf-16-be"}
# Characters of the beginning that show whether a text without a mark has two bytes each.
_BEGINNING = 256
_FEWEST_CHARACTERS = 8
# How C libraries of Windows and others write what is not a number, or not finite.
_NOT_A_NUMBER = re.compile(rb"[-+]?\d\.#(?:QNAN|SNAN|IND|NAN)\w*", re.IGNORECASE)
_INFINITE = re.compile(rb"([-+]?)\d\.#INF\w*", re.IGNORECASE)
_NAN_OF_A_KIND = re.compile(rb"\bnan\([\w]*\)", re.IGNORECASE)


def without_mark(data: bytes) -> bytes:
    """Remove a byte order mark, and decode UTF-16; line ends stay, since binary data may follow a header."""
    if encoding := _UTF_16.get(data[:2]):
        return data[2:].decode(encoding, "replace").encode()
    if encoding := _unmarked_encoding(data):
        return data.decode(encoding, "replace").encode()
    return data.removeprefix(codecs.BOM_UTF8)


def _unmarked_encoding(data: bytes) -> str | None:
    """Return the encoding of UTF-16 without a mark: every other byte of its ASCII characters is zero."""
    even, odd = data[: 2 * _BEGINNING : 2], data[1 : 2 * _BEGINNING : 2]
    if len(odd) < _FEWEST_CHARACTERS:
        return None
    if not any(odd) and all(even):
        return "utf-16-le"
    return "utf-16-be" if not any(even) and all(odd) else None


def plain_text(data: bytes) -> bytes:
    r"""Decode a text file of any common encoding.

    Parameters
    ----------
    data : bytes
        ASCII, any extension of it to eight bits, UTF-8, or UTF-16.

    Returns
    -------
    text : bytes
        An extension of ASCII without a byte order mark; lines end with ``\n``, and every spelling of what is
        not a number is "nan".
    """
    # A search for one byte costs next to nothing; one for several bytes or a regular expression does.
    text = without_mark(data).removesuffix(b"\x1a")  # the end of a file of DOS
    if b"\r" in text:
        text = text.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    if b"\xef" in text:  # perhaps a mark where files were joined
        text = text.replace(b"\n" + codecs.BOM_UTF8, b"\n")
    if b"#" in text and b".#" in text:
        text = _INFINITE.sub(rb"\1inf", _NOT_A_NUMBER.sub(b"nan", text))
    return _NAN_OF_A_KIND.sub(b"nan", text) if b"(" in text else text


@dataclass(frozen=True)
class Lines:
    """Some lines of a text file, and where they are in it.

    Parameters
    ----------
    content : list of bytes
    find_numbers : callable
        Returns the number of each line in the file, counted from 1. Only called for an error.
    """

    content: list[bytes]
    find_numbers: Callable[[], Sequence[int]]

    def __len__(self) -> int:
        return len(self.content)

    @cached_property
    def numbers(self) -> Sequence[int]:
        """Number of each line in the file, counted from 1."""
        return self.find_numbers()

    def part(self, start: int, stop: int | None = None) -> Lines:
        """Take the lines from one place to another."""
        return Lines(self.content[start:stop], lambda: self.numbers[start:stop])

    def chosen(self, places: Sequence[int]) -> Lines:
        """Take the lines at some places."""
        return Lines(
            [self.content[place] for place in places], lambda: [self.numbers[place] for place in places]
        )

    def with_content(self, content: list[bytes]) -> Lines:
        """Replace the content of each line."""
        return Lines(content, lambda: self.numbers)

    def first(self, count: int) -> Lines:
        """Take the first lines; raise `DamagedError` if there are fewer."""
        if len(self) < count:
            raise DamagedError(f"ends after {len(self):,} of the {count:,} lines that it announces")
        return self if len(self) == count else self.part(0, count)

    def unexpected(self, place: int, expected: str) -> DamagedError:
        """Make the error for a line that has something else than expected."""
        return unexpected(self.content[place], self.numbers[place], expected)


def filled_lines(text: bytes, first_number: int = 1) -> Lines:
    r"""Take the lines of a text that are not blank.

    Parameters
    ----------
    text : bytes
        With ``\n`` as line end.
    first_number : int, optional
        Number of its first line in the file.

    Returns
    -------
    lines : Lines
    """
    every = text.split(b"\n")
    lines = [line for line in every if line and not line.isspace()]
    return Lines(lines, lambda: _numbers(every, first_number))


def lines_of(count: int) -> str:
    """Write a number of lines, such as "1 line" or "2,000 lines"."""
    return f"{count:,} line{'' if count == 1 else 's'}"


def _numbers(every: Iterable[bytes], first_number: int) -> list[int]:
    return [number for number, line in enumerate(every, first_number) if line and not line.isspace()]


def unexpected(line: bytes, number: int, expected: str) -> DamagedError:
    """Make the error for a line that has something else than expected.

    Parameters
    ----------
    line : bytes
    number : int
        Counted from 1.
    expected : str
        Such as "a vertex".

    Returns
    -------
    error : DamagedError
    """
    return DamagedError(f"has {quoted(line)} in line {number:,}, where {expected} is expected")


def quoted(text: bytes | str) -> str:
    r"""Quote a piece of a file for a message: at most 60 characters, question marks for unprintable ones.

    Parameters
    ----------
    text : bytes or str
        Bytes are in UTF-8, or any encoding of one byte for each character.

    Returns
    -------
    quoted : str
        Between single quotation marks.

    Examples
    --------
    >>> from shapegoogle_core.mesh.io.text import quoted
    >>> quoted(b"v 1.0 \x00\x1f 3.0 ")
    "'v 1.0 ?? 3.0'"
    """
    decoded = text if isinstance(text, str) else _decoded(text)
    shown = "".join(character if character.isprintable() else "?" for character in decoded.strip()[:60])
    return f"'{shown}'"


def _decoded(text: bytes) -> str:
    try:
        return text.decode()
    except UnicodeDecodeError:
        return text.decode("latin-1")
