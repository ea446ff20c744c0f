# SPDX-License-Identifier: MIT
"""What a file must pass before trimesh parses it, and the spelling in which trimesh reads it right.

Seen with trimesh 5.2. Other geometry than the file's, without a word: texts that end too early or hold what
is no number; STL whose name holds the word vertex. Refused though sound: binary PLY with polygons of several
sizes, which Blender writes, and texts outside UTF-8 without another package. OBJ is read in `obj.py`.
"""

from __future__ import annotations

import re
import struct
from array import array
from itertools import islice, takewhile
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["Checked", "FormatError", "check_face_count", "check_off", "check_ply", "check_stl"]


class FormatError(Exception):
    """A file is not what its format asks for; the message completes the sentence "<file>: …"."""


class Checked(NamedTuple):
    """A file's content for trimesh, and how many triangles have to come out of it."""

    data: bytes
    faces: int | None


def check_face_count(count: int, max_faces: int) -> None:
    """Raise `FormatError` if there are more faces than wanted."""
    if count > max_faces:
        raise FormatError(
            f"has {count:,} faces or more, above the limit of {max_faces:,}; "
            "simplify it first, or raise max_faces"
        )


def check_off(data: bytes, max_faces: int) -> Checked:
    """Compare the counts of an OFF text with its lines."""
    text = re.sub(rb"[^\x00-\x7f]", b"?", re.sub(rb"#.*", b"", data)).strip()
    # Some files of the Princeton and ModelNet collections have "OFF3514 3546 0" in one line.
    keyword = re.match(rb"(?:ST)?C?N?OFF\s*(?:(\d+)[ \t]+(\d+)(?!\S))?.*", text)
    if keyword is None:
        raise FormatError(
            "does not begin with the word OFF: it is empty, or no plain OFF file; export it again"
        )
    if keyword[1] is None:
        raise FormatError("has no counts of vertices and faces after the word OFF; export it again")
    vertex_count, face_count = int(keyword[1]), int(keyword[2])
    if 2 * (vertex_count + face_count) > len(data):
        raise FormatError(
            f"claims {vertex_count:,} vertices and {face_count:,} faces, more than a file of "
            f"{len(data):,} bytes can hold; it is damaged or was cut short"
        )
    check_face_count(face_count, max_faces)
    rows = _rows(text[keyword.end() :], vertex_count + face_count)
    triangle_count = sum(max(int(row.split(None, 1)[0]) - 2, 0) for row in rows[vertex_count:])
    check_face_count(triangle_count, max_faces)
    head = b"OFF\n%d %d 0\n" % (vertex_count, face_count)
    return Checked(head + b"\n".join(rows), triangle_count)


def _rows(text: bytes, count: int) -> list[bytes]:
    """Return the first lines that are not blank."""
    rows = [line for line in text.splitlines() if line.strip()]
    if len(rows) < count:
        raise FormatError(
            f"ends after {len(rows):,} of the {count:,} lines that it announces; it was cut short: "
            "copy or export it again"
        )
    return rows[:count]


def check_stl(data: bytes, max_faces: int) -> Checked:
    """Compare the length of a binary STL with its count; count the facets of a text, and take names away."""
    count = int.from_bytes(data[80:84], "little")
    if len(data) == 84 + 50 * count:
        check_face_count(count, max_faces)
        return Checked(data, count)
    if data.lstrip()[:5].lower() == b"solid":
        text = re.sub(rb"[^\x00-\x7f]", b"?", data.lower())
        text = re.sub(rb"^\s*(end ?)?solid\b.*", rb"\1solid", text, flags=re.MULTILINE)
        text = text.replace(b"end solid", b"endsolid")
        if text.split()[-1] != b"endsolid":
            raise FormatError("ends before the word endsolid: it was cut short; copy or export it again")
        facet_count = text.count(b"endfacet")
        check_face_count(facet_count, max_faces)
        triangles = re.findall(rb"(?:\bvertex(?:[ \t]+[-+.\w]+){3}[ \t\r]*\n\s*){3}end", text)
        if not 3 * len(triangles) == 3 * facet_count == text.count(b"vertex"):
            raise FormatError(
                f"has {facet_count:,} facets, of which {len(triangles):,} are triangles; it is damaged or "
                "was cut short: copy or export it again"
            )
        return Checked(text, facet_count)
    if len(data) < 84:
        raise FormatError(f"has only {len(data)} bytes, which is no STL file; copy or export it again")
    raise FormatError(
        f"claims {count:,} triangles, which take {84 + 50 * count:,} bytes, but has {len(data):,}; it is no "
        "STL file, damaged or cut short: copy or export it again"
    )


_Order = Literal["<", ">"]  # little, big endian


class _Property(NamedTuple):
    name: str
    type: str  # numpy's name, which PLY knows too
    count_type: str = ""  # of a list's length; empty: a single value


class _Element(NamedTuple):
    name: str
    length: int
    properties: list[_Property]

    def header(self) -> str:
        """Lines of the header in which only positions and corners have a name that trimesh knows."""
        lines = [f"element {self.name} {self.length}\n"]
        for index, (name, kind, count_type) in enumerate(self.properties):
            known = name == "vertex_indices" if count_type else name in ("x", "y", "z")
            prefix = f"list {count_type} " if count_type else ""
            lines.append(f"property {prefix}{kind} {name if known else f'p{index}'}\n")
        return "".join(lines)


_NUMPY_NAMES = {"char": "int8", "short": "int16", "int": "int32", "float": "float32", "double": "float64"}
_NUMPY_NAMES |= {"uchar": "uint8", "ushort": "uint16", "uint": "uint32"}
_NUMPY_NAMES |= {name: name for name in (*_NUMPY_NAMES.values(), "int64", "uint64")}


def check_ply(data: bytes, max_faces: int) -> Checked:
    """Compare a PLY file with its header; keep positions and corners, and make mixed polygons triangles."""
    kind, elements, position = _ply_header(data)
    for element in elements:
        if element.name == "face":
            check_face_count(element.length, max_faces)
        if not 0 <= element.length <= len(data) - position:
            raise FormatError(
                f"claims {element.length:,} times the element {element.name!r}, but only "
                f"{len(data) - position:,} bytes are left; it is damaged or was cut short"
            )
    if kind == "ascii":
        elements, body, triangle_count = _ply_text(data[position:], elements)
    else:
        elements, body, triangle_count = _ply_binary(data, elements, position, ">" if "big" in kind else "<")
    check_face_count(triangle_count, max_faces)
    header = f"ply\nformat {kind} 1.0\n{''.join(map(_Element.header, elements))}end_header\n"
    return Checked(header.encode() + body, triangle_count)


def _ply_header(data: bytes) -> tuple[str, list[_Element], int]:
    """Return the format, the elements that are not empty, and where the data begin."""
    if not re.match(rb"ply\s", data):
        raise FormatError("does not begin with the word ply: it is empty, or no PLY file; export it again")
    end = re.compile(rb"^end_header[ \t\r]*$\n?", re.MULTILINE).search(data, 0, 1 << 20)
    if end is None:
        raise FormatError("has a PLY header without end: it was cut short; copy or export it again")
    kind, elements = "", list[_Element]()
    for line in data[: end.start()].decode("latin-1").splitlines()[1:]:
        try:
            match line.split():
                case ["format", ("ascii" | "binary_little_endian" | "binary_big_endian") as kind, *_]:
                    pass
                case ["element", name, count]:
                    elements.append(_Element(name, int(count), []))
                case ["property", "list", count_type, item_type, name]:
                    name = "vertex_indices" if name == "vertex_index" else name
                    types = _NUMPY_NAMES[item_type], _NUMPY_NAMES[count_type]
                    elements[-1].properties.append(_Property(name, *types))
                case ["property", value_type, name]:
                    elements[-1].properties.append(_Property(name, _NUMPY_NAMES[value_type]))
                case [] | ["comment" | "obj_info", *_]:
                    pass
                case _:
                    raise ValueError("unknown")
        except (ValueError, KeyError, IndexError) as error:
            raise FormatError(
                f"has a damaged line {line[:60]!r} in its PLY header ({error}); export it again"
            ) from error
    if not kind:
        raise FormatError("has a PLY header without a format; it is damaged: export it again")
    for element in elements:
        if element.name == "face" and "vertex_indices" not in (each.name for each in element.properties):
            raise FormatError("has faces without 'vertex_indices'; export it again")
    return kind, [element for element in elements if element.length], end.end()


def _ply_text(text: bytes, elements: list[_Element]) -> tuple[list[_Element], bytes, int]:
    """Return elements and lines for trimesh, and how many triangles the faces make."""
    rows = iter(_rows(text, sum(element.length for element in elements)))
    kept, lines, triangle_count = list[_Element](), list[bytes](), 0
    for element in elements:
        of_element = list(islice(rows, element.length))
        if element.name in ("vertex", "face"):
            kept.append(element)
            lines += of_element
        if element.name == "face":
            before = list(takewhile(lambda each: each.name != "vertex_indices", element.properties))
            for words in map(bytes.split, of_element):
                at = 0
                for each in before:
                    at += 1 + int(words[at]) if each.count_type else 1
                triangle_count += max(int(words[at]) - 2, 0)
    return kept, b"\n".join(lines), triangle_count


def _ply_binary(
    data: bytes, elements: list[_Element], position: int, order: _Order
) -> tuple[list[_Element], bytes, int]:
    """Return elements and bytes for trimesh, and how many triangles the faces make."""
    kept, body, triangle_count = list[_Element](), b"", 0
    for element in elements:
        if {"vertex", "face"} <= {each.name for each in kept}:
            break
        begin = position
        if element.name == "face":
            starts, sizes, position = _ply_lists(data, begin, element, order)
            triangle_count = int(np.maximum(sizes - 2, 0).sum())
        elif any(each.count_type for each in element.properties):
            raise FormatError(
                f"has lists in the element {element.name!r}, which cannot be read; export it again"
            )
        else:
            position += element.length * sum(np.dtype(each.type).itemsize for each in element.properties)
        if position > len(data):
            raise _ply_cut_short(element)
        rows = data[begin:position]
        if element.name == "face":
            list_count = sum(bool(each.count_type) for each in element.properties)
            if list_count > 1 or sizes[0] not in (3, 4) or (sizes != sizes[0]).any():
                # trimesh takes the lengths in the first row for all rows.
                element, rows = _ply_triangles(data, starts, sizes, element, order)
        if element.name in ("vertex", "face"):
            kept.append(element)
            body += rows
    return kept, body, triangle_count


def _ply_cut_short(element: _Element) -> FormatError:
    return FormatError(
        f"ends before its {element.length:,} times the element {element.name!r} are complete; it was cut "
        "short: copy or export it again"
    )


def _ply_lists(
    data: bytes, position: int, element: _Element, order: _Order
) -> tuple[NDArray[np.int64], NDArray[np.int64], int]:
    """Where the corners of each face begin, how many they are, and where the faces end."""
    steps, gap = [], 0
    for each in element.properties:
        width = np.dtype(each.type).itemsize
        if each.count_type:
            length = _dtype(each.count_type, order)
            steps.append((gap, struct.Struct(order + length.char), width, each.name == "vertex_indices"))
            gap = 0
        else:
            gap += width
    if len(steps) == 1:  # rows of one length, as in most files, need no loop
        before, count, width, _ = steps[0]
        first = int.from_bytes(data[position + before :][: count.size], "little" if order == "<" else "big")
        row = before + count.size + first * width + gap
        if position + element.length * row <= len(data):
            rows = np.frombuffer(data, np.uint8, element.length * row, position).reshape(-1, row)
            size_bytes = rows[:, before : before + count.size]
            if (size_bytes == size_bytes[0]).all():
                begins = position + before + count.size + row * np.arange(element.length)
                return begins, np.full(element.length, first), position + element.length * row
    starts, sizes = array("q"), array("q")
    for _ in range(element.length):
        for before, count, width, wanted in steps:
            position += before + count.size
            if position > len(data):
                raise _ply_cut_short(element)
            (size,) = count.unpack_from(data, position - count.size)
            if size < 0:
                raise FormatError(f"has a face with a list of {size} values; it is damaged")
            if wanted:
                starts.append(position)
                sizes.append(size)
            position += size * width
        position += gap
    return np.array(starts), np.array(sizes), position


def _dtype(name: str, order: _Order) -> np.dtype[np.generic]:
    return np.dtype(name).newbyteorder(order)


def _ply_triangles(
    data: bytes,
    starts: NDArray[np.int64],
    sizes: NDArray[np.int64],
    element: _Element,
    order: _Order,
) -> tuple[_Element, bytes]:
    """Return faces of any sizes as fans of triangles."""
    (corners,) = (each for each in element.properties if each.name == "vertex_indices")
    corner = _dtype(corners.type, order)
    triangles = [np.empty((0, 3), corner)]
    for size in np.unique(sizes[sizes > 2]):
        begins = starts[sizes == size, None]
        polygons = np.frombuffer(data, np.uint8)[begins + np.arange(size * corner.itemsize)].view(corner)
        fan = np.stack([np.zeros(size - 2, int), np.arange(1, size - 1), np.arange(2, size)], axis=1)
        triangles.append(polygons[:, fan].reshape(-1, 3))
    rows = np.empty(sum(map(len, triangles)), [("size", "u1"), ("corners", corner, 3)])
    rows["size"], rows["corners"] = 3, np.concatenate(triangles)
    return _Element("face", len(rows), [corners._replace(count_type="uint8")]), rows.tobytes()
