# SPDX-License-Identifier: MIT
"""What the readers share: their error, lines of text, polygons to triangles."""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "FormatError",
    "Geometry",
    "Polygons",
    "check_face_count",
    "fan_triangles",
    "file_size",
    "lines_of",
    "points_of",
]

# Vertices (n, 3) and triangles (m, 3); indices are not checked yet.
Geometry = tuple[NDArray[np.float64], NDArray[np.int64]]

# No line of a mesh file is longer; a binary file without line ends is not read into memory as one line.
LONGEST_LINE = 1 << 20


class FormatError(Exception):
    """A file is not what its format asks for; the message completes the sentence "<file>: …"."""


def check_face_count(count: int, max_faces: int) -> None:
    """Raise `FormatError` if there are more faces than wanted."""
    if count > max_faces:
        raise FormatError(
            f"has {count:,} faces or more, above the limit of {max_faces:,}; "
            "simplify it first, or raise max_faces"
        )


def lines_of(file: BinaryIO, comment: bytes = b"#") -> Iterator[tuple[int, list[bytes]]]:
    """Yield number and words of each line that has any, without comments.

    Parameters
    ----------
    file : binary file
        Read from where it stands, a line at a time.
    comment : bytes, optional
        What begins a comment; empty: there are none.

    Yields
    ------
    number : int
        Counted from 1 where the file stood.
    words : list of bytes
    """
    number = 0
    while line := file.readline(LONGEST_LINE):
        number += 1
        if len(line) == LONGEST_LINE:
            raise FormatError(
                f"has a line {number} of more than {LONGEST_LINE:,} bytes: it is no text; export it again"
            )
        if comment:
            line = line.partition(comment)[0]
        words = line.split()
        if words:
            yield number, words


def points_of(coordinates: array[float]) -> NDArray[np.float64]:
    """Turn a flat list x, y, z, x, … into points, shape (n, 3)."""
    return np.frombuffer(coordinates, np.float64).reshape(-1, 3) if coordinates else np.empty((0, 3))


class Polygons:
    """Polygons as they come from a text file, kept small in memory.

    Parameters
    ----------
    max_faces : int
        More triangles than this raise `FormatError`.
    """

    def __init__(self, max_faces: int) -> None:
        self.max_faces = max_faces
        self.triangle_count = 0
        self._corners = array("q")
        self._sizes = array("q")

    def append(self, corners: Iterable[int]) -> None:
        """Add one polygon; fewer than three corners are a point or a line and leave no triangle."""
        before = len(self._corners)
        self._corners.extend(corners)
        size = len(self._corners) - before
        self._sizes.append(size)
        self.triangle_count += max(size - 2, 0)
        if self.triangle_count > self.max_faces:
            check_face_count(self.triangle_count, self.max_faces)

    def triangles(self) -> NDArray[np.int64]:
        """Return all polygons as triangles, shape (m, 3), each polygon a fan round its first corner."""
        return fan_triangles(
            np.frombuffer(self._corners, np.int64) if self._corners else np.empty(0, np.int64),
            np.frombuffer(self._sizes, np.int64) if self._sizes else np.empty(0, np.int64),
        )


def fan_triangles(corners: NDArray[np.int64], sizes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Split polygons into fans of triangles.

    Parameters
    ----------
    corners : (sum of sizes,) array
        The polygons' corners, one polygon after the other.
    sizes : (p,) array
        How many corners each polygon has.

    Returns
    -------
    triangles : (sum of max(sizes − 2, 0), 3) array
    """
    starts = np.cumsum(sizes) - sizes
    counts = np.maximum(sizes - 2, 0)
    first = np.repeat(starts, counts)
    step = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.stack([corners[first], corners[first + step + 1], corners[first + step + 2]], axis=1)


def file_size(path: Path) -> int:
    """Size in bytes."""
    return path.stat().st_size
