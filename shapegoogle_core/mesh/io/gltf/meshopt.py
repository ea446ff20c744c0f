# SPDX-License-Identifier: MIT
"""Buffer views of a glTF that are compressed with meshopt, as the two extensions of that name describe them.

Bytes of consecutive elements are differences, packed in groups of 16; triangles name edges and vertices that
occurred recently. No package with this decoder runs on the Python and numpy of all Blenders; its output was
compared with the original decoder's (tests/core/mesh/io/test_gltf_compression.py).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.io.file import DamagedError, FormatError
from shapegoogle_core.mesh.io.gltf.container import Document
from shapegoogle_core.mesh.io.gltf.extensions import MESHOPT
from shapegoogle_core.mesh.io.gltf.json_object import JsonObject

__all__ = ["decompressed"]

_GROUP = 16  # elements whose differences have the same number of bits
_ZERO, _WHOLE = 0, 8
# Bits of a difference by version, or by control mode, and by the two bits in front of a group.
_BITS_OF_VERSION_0 = (_ZERO, 2, 4, _WHOLE)
_BITS_OF_CONTROL = ((_ZERO, 1, 2, 4), (1, 2, 4, _WHOLE))
_ALL_ZERO, _LITERAL = 2, 3  # control modes without groups

_Bytes = NDArray[np.uint8]


def _sentinel_counts(bits: int) -> bytes:
    """Table: how many differences in a byte have all bits set, and so follow as whole bytes."""
    sentinel = (1 << bits) - 1
    return bytes(
        sum((byte >> shift) & sentinel == sentinel for shift in range(0, 8, bits)) for byte in range(256)
    )


_SENTINELS = {bits: _sentinel_counts(bits) for bits in (1, 2, 4)}


def decompressed(document: Document, view: JsonObject) -> memoryview | None:
    """Decompress a buffer view.

    Parameters
    ----------
    document : Document
    view : JsonObject

    Returns
    -------
    data : memoryview or None
        None if it is not compressed.

    Raises
    ------
    FormatError
        If it is damaged.
    """
    extensions = view.object("extensions")
    name = next((name for name in MESHOPT if extensions.has(name)), None)
    if name is None:
        return None
    packed = extensions.object(name)
    data = bytes(document.bytes_of(packed))
    count, stride, mode = packed.whole("count"), packed.whole("byteStride"), packed.text("mode")
    if count > max(3 * document.file.max_faces, 10_000_000):
        raise DamagedError(f"claims {count:,} values in {packed.place}, a number out of range")
    try:
        if mode == "ATTRIBUTES" and 0 < stride <= 256 and stride % 4 == 0:
            return _filtered(_attributes(data, count, stride), packed.text("filter", "NONE"), packed)
        if mode in ("TRIANGLES", "INDICES") and stride in (2, 4):
            numbers = _triangles(data, count) if mode == "TRIANGLES" else _indices(data, count)
            return memoryview(np.array(numbers, np.uint32).astype(f"<u{stride}").tobytes())
    except (IndexError, ValueError) as error:
        raise DamagedError(f"has meshopt data in {packed.place} that cannot be decoded") from error
    raise DamagedError(
        f"has the mode {mode[:20]!r} with {stride} bytes in {packed.place}, which meshopt does not have"
    )


def _attributes(data: bytes, count: int, stride: int) -> _Bytes:
    """Decode a sequence of elements, (count, stride)."""
    version = data[0] - 0xA0
    if version not in (0, 1):
        raise ValueError("unknown version")
    tail = stride + stride // 4 if version else stride
    end = len(data) - max(tail, 24 if version else 32)
    differences = _differences(data, count, stride, version, end)
    first = np.frombuffer(data, np.uint8, stride, len(data) - tail)
    modes = data[len(data) - stride // 4 :] if version else bytes(stride // 4)
    elements = np.empty((count, stride), np.uint8)
    for channel, mode in enumerate(modes):
        columns = slice(4 * channel, 4 * channel + 4)
        elements[:, columns] = _summed(differences[:, columns], first[columns], mode)
    return elements


def _differences(data: bytes, count: int, stride: int, version: int, end: int) -> _Bytes:
    """Unpack the differences between elements, (count, stride)."""
    block = min(8192 // stride & ~15, 256)
    unpacked = np.zeros((-(-count // _GROUP) * _GROUP, stride), np.uint8)
    groups: dict[int, list[tuple[int, int, int]]] = {bits: [] for bits in (1, 2, 4, _WHOLE)}
    position = 1
    for start in range(0, count, block):
        group_count = -(-min(block, count - start) // _GROUP)
        controls = data[position : position + stride // 4] if version else b""
        position += len(controls)
        for column in range(stride):
            widths = _BITS_OF_VERSION_0
            if version:
                control = controls[column // 4] >> 2 * (column % 4) & 3
                if control == _ALL_ZERO:
                    continue
                if control == _LITERAL:
                    length = min(block, count - start)
                    unpacked[start : start + length, column] = np.frombuffer(data, np.uint8, length, position)
                    position += length
                    continue
                widths = _BITS_OF_CONTROL[control]
            header = data[position : position + -(-group_count // 4)]
            position += len(header)
            for group in range(group_count):
                bits = widths[header[group // 4] >> 2 * (group % 4) & 3]
                if bits == _ZERO:
                    continue
                groups[bits].append((position, start + _GROUP * group, column))
                packed = 2 * bits
                if bits != _WHOLE:
                    position += sum(data[position : position + packed].translate(_SENTINELS[bits]))
                position += packed
            if position > end:
                raise ValueError("ends early")
    if position != end:
        raise ValueError("has bytes that nothing names")
    stream = np.frombuffer(data, np.uint8)
    for bits, found in groups.items():
        if found:
            offsets, rows, columns = np.array(found).T
            values = _unpacked(stream, offsets, bits)
            unpacked[rows[:, None] + np.arange(_GROUP), columns[:, None]] = values
    return unpacked[:count]


def _unpacked(stream: _Bytes, offsets: NDArray[np.int64], bits: int) -> _Bytes:
    """Unpack groups that begin at some bytes, (g, 16)."""
    packed: _Bytes = stream[offsets[:, None] + np.arange(2 * bits)]
    if bits == _WHOLE:
        return packed
    sentinel = (1 << bits) - 1
    shifts = np.arange(0, 8, bits)
    if bits > 1:
        shifts = shifts[::-1]  # the first difference is in the highest bits
    values: _Bytes = ((packed[:, :, None] >> shifts) & sentinel).reshape(-1, _GROUP).astype(np.uint8)
    outside = values == sentinel
    rows = np.nonzero(outside)[0]
    values[outside] = stream[offsets[rows] + 2 * bits + (np.cumsum(outside, axis=1) - 1)[outside]]
    return values


def _summed(differences: _Bytes, first: _Bytes, mode: int) -> _Bytes:
    """Add up the differences of four bytes, from a first element on."""
    if mode in (0, 1):
        kind = np.dtype("<u1") if mode == 0 else np.dtype("<u2")
        steps = np.ascontiguousarray(differences).view(kind)
        one = kind.type(1)
        signed = (steps >> one) ^ (kind.type(0) - (steps & one))
        sums = np.cumsum(signed, axis=0, dtype=kind) + np.ascontiguousarray(first).view(kind)
        return np.ascontiguousarray(sums.astype(kind)).view(np.uint8)
    if mode & 15 != 2:
        raise ValueError("unknown channel mode")
    words = np.ascontiguousarray(differences).view("<u4")[:, 0]
    turn = mode >> 4  # to the left before they were packed
    if turn:
        words = (words >> np.uint32(turn)) | (words << np.uint32(32 - turn))
    words = np.bitwise_xor.accumulate(words) ^ np.ascontiguousarray(first).view("<u4")
    return np.ascontiguousarray(words.astype("<u4")).view(np.uint8).reshape(-1, 4)


def _filtered(elements: _Bytes, name: str, packed: JsonObject) -> memoryview:
    """Undo a filter."""
    if name == "NONE":
        return memoryview(elements.tobytes())
    if name == "EXPONENTIAL":
        words = elements.view("<i4")
        values: NDArray[Any] = np.ldexp((words << 8 >> 8).astype(np.float64), words >> 24).astype("<f4")
        return memoryview(values.tobytes())
    if name == "QUATERNION" and elements.shape[1] == 8:
        return memoryview(_quaternions(elements.view("<i2")).tobytes())
    raise FormatError(
        f"has the meshopt filter {name[:20]!r} in {packed.place}, which positions and places cannot have; "
        "export it again"
    )


def _quaternions(numbers: NDArray[np.int16]) -> NDArray[np.int16]:
    """Rotations of three components each; the largest one follows from their length."""
    one = (numbers[:, 3] | 3).astype(np.float64)
    small = numbers[:, :3] / one[:, None] / np.sqrt(2)
    largest = np.sqrt(np.maximum(1 - (small**2).sum(axis=1), 0))
    places = ((numbers[:, 3] & 3)[:, None] + np.arange(4)) % 4
    turned = np.empty((len(numbers), 4))
    np.put_along_axis(turned, places.astype(np.int64), np.column_stack([largest, small]), axis=1)
    return np.rint(turned * 32767).astype("<i2")


class _Numbers:
    """Whole numbers behind each other, seven bits a byte."""

    def __init__(self, data: bytes, position: int) -> None:
        self.data, self.position = data, position

    def byte(self) -> int:
        self.position += 1
        return self.data[self.position - 1]

    def next(self) -> int:
        value, shift = 0, 0
        while shift < 35:
            byte = self.byte()
            value |= (byte & 127) << shift
            if byte < 128:
                return value & 0xFFFFFFFF
            shift += 7
        raise ValueError("has a number that is too long")


def _indices(data: bytes, count: int) -> list[int]:
    """Decode a sequence of indices, each a step from one of two others."""
    if data[0] != 0xD1:
        raise ValueError("unknown version")
    numbers, last, found = _Numbers(data, 1), [0, 0], []
    for _ in range(count):
        value = numbers.next()
        step = ~(value >> 2) if value & 2 else value >> 2
        last[value & 1] = (last[value & 1] + step) & 0xFFFFFFFF
        found.append(last[value & 1])
    if numbers.position != len(data) - 4:
        raise ValueError("has bytes that nothing names")
    return found


def _triangles(data: bytes, count: int) -> list[int]:
    """Decode the corners of triangles, each code with an edge or vertices that occurred recently."""
    if data[0] != 0xE1 or count % 3:
        raise ValueError("unknown version")
    codes, table = data[1 : 1 + count // 3], data[-16:]
    numbers = _Numbers(data, 1 + count // 3)
    edges, vertices = [(0, 0)] * 16, [0] * 16  # the most recent one is last
    fresh, last, corners = 0, 0, list[int]()

    def step() -> int:
        nonlocal last
        value = numbers.next()
        last = (last + (~(value >> 1) if value & 1 else value >> 1)) & 0xFFFFFFFF
        return last

    def corner(kind: int) -> int:
        """0: a fresh vertex; 15: a step; otherwise a recent one."""
        nonlocal fresh
        if kind == 0:
            fresh += 1
            return fresh - 1
        return step() if kind == 15 else recent[-kind]

    for code in codes:
        edge, kind = code >> 4, code & 15
        recent = vertices
        if edge < 15:
            a, b = edges[-1 - edge]
            if kind in (13, 14):
                last = (last + (1 if kind == 14 else -1)) & 0xFFFFFFFF
                c = last
            elif 0 < kind < 13:
                c = vertices[-1 - kind]
            else:
                c = corner(kind)
            edges = [*edges[2:], (c, b), (a, c)]
            if kind == 0 or kind > 12:
                vertices = [*vertices[1:], c]
        else:
            pair = numbers.byte() if kind > 13 else table[kind]
            if kind > 13 and pair == 0:
                fresh = 0
            a = step() if kind == 15 else corner(0)
            b = corner(pair >> 4)
            c = corner(pair & 15)
            edges = [*edges[3:], (b, a), (c, b), (a, c)]
            added = [a, *([b] if pair >> 4 in (0, 15) else []), *([c] if pair & 15 in (0, 15) else [])]
            vertices = [*vertices[len(added) :], *added]
        corners += (a, b, c)
    if numbers.position != len(data) - 16:
        raise ValueError("has bytes that nothing names")
    return corners
