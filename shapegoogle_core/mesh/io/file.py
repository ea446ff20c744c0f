# SPDX-License-Identifier: MIT
"""The input of every reader, its error, and the limits that a file is held to."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

__all__ = [
    "DamagedError",
    "FormatError",
    "MeshFile",
    "check_face_count",
    "check_point_count",
    "largest_content",
    "read_content",
]


# A file is read as a whole. The longest spelling, a text STL, takes about 300 bytes a face; textures in a
# glTF come on top.
_BYTES_PER_FACE = 400
_OTHER_BYTES = 500_000_000


class FormatError(Exception):
    """A file does not follow its format; the message completes the sentence "<file> …"."""


class DamagedError(FormatError):
    """A file is damaged; the message says only where, and not what to do."""

    def __str__(self) -> str:
        return f"{super().__str__()}; it is damaged or was cut short: copy or export it again"


@dataclass(frozen=True)
class MeshFile:
    """A mesh file in memory, its folder and its limits.

    Parameters
    ----------
    data : bytes
        Content of the file.
    folder : Path
        Folder of the file; a glTF may name other files there.
    max_faces : int
        Largest number of triangles, or of points without faces.
    """

    data: bytes
    folder: Path
    max_faces: int


def check_face_count(count: int, max_faces: int) -> None:
    """Raise `FormatError` if there are more than `max_faces` faces."""
    if count > max_faces:
        raise FormatError(
            f"has {count:,} faces or more, above the limit of {max_faces:,}; "
            "simplify it first, or raise max_faces"
        )


def check_point_count(count: int, most: int) -> None:
    """Raise `FormatError` if there are more than `most` points."""
    if count > most:
        raise FormatError(
            f"has {count:,} points, above the limit of {most:,}; thin it first, or raise max_faces"
        )


def largest_content(max_faces: int) -> int:
    """Return the largest number of bytes that a file with `max_faces` faces may have."""
    return _OTHER_BYTES + _BYTES_PER_FACE * max_faces


def read_content(path: Path, max_faces: int) -> bytes:
    """Read a file; raise `FormatError` if it is empty or larger than `max_faces` faces can be."""
    size = path.stat().st_size
    if size == 0:
        raise FormatError("is empty (0 bytes); copy or export it again")
    if size > largest_content(max_faces):
        raise FormatError(
            f"has {size:,} bytes, more than a mesh with the limit of {max_faces:,} faces takes; "
            "simplify it first, or raise max_faces"
        )
    return path.read_bytes()
