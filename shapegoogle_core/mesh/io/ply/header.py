# SPDX-License-Identifier: MIT
"""The header of a PLY file: which elements follow, and the properties of each."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from shapegoogle_core.mesh.io.file import DamagedError, FormatError
from shapegoogle_core.mesh.io.text import plain_text, quoted, unexpected

__all__ = ["Element", "Header", "Property", "Type", "read_header"]

_TYPES = {"char": "i1", "short": "i2", "int": "i4", "float": "f4", "double": "f8"}
_TYPES |= {"uchar": "u1", "ushort": "u2", "uint": "u4"}
_TYPES |= {np.dtype(kind).name: kind for kind in (*_TYPES.values(), "i8", "u8")}
_ORDERS = {"ascii": "=", "binary_little_endian": "<", "binary_big_endian": ">"}
_END = re.compile(rb"(?<=[\r\n])[ \t]*end_header[ \t]*(?:\r\n|\n|\r|\Z)")
_LONGEST = 1 << 20

_COORDINATES = ("x", "y", "z")
_WITH_CORNERS = ("face", "tristrips")
_CORNERS = ("vertex_indices", "vertex_index")

Type = np.dtype[Any]


@dataclass(frozen=True)
class Property:
    """A property of an element.

    Attributes
    ----------
    name : str
    type : dtype
    count_type : dtype or None
        Type of the length of a list; None for a single value.
    """

    name: str
    type: Type
    count_type: Type | None


@dataclass(frozen=True)
class Element:
    """A table of a PLY file.

    Attributes
    ----------
    name : str
    length : int
        Number of rows.
    properties : list of Property
    """

    name: str
    length: int
    properties: list[Property] = field(default_factory=list)

    def wanted(self) -> list[int]:
        """Return the places of the properties that are read: coordinates, or the list of corners."""
        if self.name == "vertex":
            return [self._place((axis,)) for axis in _COORDINATES]
        return [self._place(_CORNERS)] if self.name in _WITH_CORNERS else []

    def _place(self, names: Sequence[str]) -> int:
        places = [place for place, each in enumerate(self.properties) if each.name in names]
        if not places and len(names) > 1:  # one list of whole numbers can only be the corners
            places = [
                place
                for place, each in enumerate(self.properties)
                if each.count_type is not None and each.type.kind in "iu"
            ]
        if len(places) != 1:
            has = "with several properties that may be" if places else "without"
            raise FormatError(f"has the element {quoted(self.name)} {has} {names[0]!r}; export it again")
        if (self.properties[places[0]].count_type is None) != (len(names) == 1):
            wanted = "a single value" if len(names) == 1 else "a list"
            raise FormatError(f"has {names[0]!r} of {quoted(self.name)} not as {wanted}; export it again")
        return places[0]


@dataclass(frozen=True)
class Header:
    """The header of a PLY file.

    Attributes
    ----------
    is_text : bool
    elements : list of Element
    start : int
        First byte behind the header.
    line_count : int
        Including the line end_header.
    """

    is_text: bool
    elements: list[Element]
    start: int
    line_count: int


def read_header(data: bytes) -> Header:
    """Read the header of a PLY file.

    Parameters
    ----------
    data : bytes
        The file without byte order mark.

    Returns
    -------
    header : Header

    Raises
    ------
    FormatError
        If a line of it is damaged, or what is needed is missing.
    """
    if not re.match(rb"ply\s", data):
        raise FormatError("does not begin with the word ply: it is empty, or not a PLY file; export it again")
    end = _END.search(data, 0, _LONGEST)
    if end is None:
        raise DamagedError("has a PLY header without the line end_header")
    lines = plain_text(data[: end.start()]).split(b"\n")
    words = [line.decode("latin-1").split() for line in lines]
    formats = [number for number, line in enumerate(words) if line[:1] == ["format"]]
    if not formats:
        raise DamagedError("has a PLY header without a line 'format'")
    orders = [_ORDERS.get((*words[number], "")[1]) for number in formats]
    order = orders[0]
    for number, other in zip(formats, orders, strict=True):
        if other is None or other != order:
            raise unexpected(lines[number], number + 1, f"one format of {', '.join(_ORDERS)}")
    assert order is not None
    elements = list[Element]()
    for number, line in enumerate(words[1:], 2):
        expected = _take(line, order, elements)
        if expected is not None:
            raise unexpected(lines[number - 1], number, expected)
    for element in elements:
        if element.length:
            element.wanted()
    return Header(order == "=", elements, end.end(), len(lines))


def _take(line: Sequence[str], order: str, elements: list[Element]) -> str | None:
    """Take a line of the header; return what is expected if it is damaged."""
    match line:
        case ["element", name, count] if count.isdecimal():
            elements.append(Element(name.lower(), int(count)))
        case ["element", *_]:
            return "an element with its name and number of rows"
        case ["property", *_] if not elements:
            return "an element before its properties"
        case ["property", "list", count_type, item_type, name]:
            kind, count_kind = _TYPES.get(item_type.lower()), _TYPES.get(count_type.lower())
            if kind is None or count_kind is None or count_kind[0] == "f":
                return "a list with the types of its length, which is whole, and of its values"
            elements[-1].properties.append(
                Property(name.lower(), np.dtype(order + kind), np.dtype(order + count_kind))
            )
        case ["property", value_type, name] if value_type.lower() in _TYPES:
            kind = _TYPES[value_type.lower()]
            elements[-1].properties.append(Property(name.lower(), np.dtype(order + kind), None))
        case ["property", *_]:
            return f"a property with its name and one of the types {', '.join(_TYPES)}"
    # All other lines are comments, whatever their keyword.
    return None
