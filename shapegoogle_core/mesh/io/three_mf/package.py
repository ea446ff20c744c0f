# SPDX-License-Identifier: MIT
"""The package of a 3MF: a zip whose relationships name the part that describes the plate."""

from __future__ import annotations

import io
import posixpath
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any
from xml.parsers import expat

from shapegoogle_core.mesh.io.file import DamagedError, FormatError, MeshFile, largest_content

__all__ = ["Package", "parse_xml"]

_RELATIONSHIPS = "_rels/.rels"
_START_PART = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
_USUAL_START_PART = "3D/3dmodel.model"

# XML of coordinates is packed about ten times; what is packed more is made to fill memory.
_BOMB_RATIO = 200
_BOMB_SIZE = 100_000_000

_CHUNK = 1 << 20

Handler = Callable[[str, dict[str, str]], None]


class Package:
    """The parts of a 3MF file.

    Parameters
    ----------
    file : MeshFile
    """

    def __init__(self, file: MeshFile) -> None:
        self._limit = largest_content(file.max_faces)
        try:
            self._zip = zipfile.ZipFile(io.BytesIO(file.data))
        except (zipfile.BadZipFile, ValueError, NotImplementedError, UnicodeDecodeError) as error:
            raise DamagedError("is not a zip that can be opened, as every 3MF file is") from error
        # Names of parts are compared without regard to case.
        self._parts = {_key(entry.filename): entry for entry in self._zip.infolist()}

    def start_part(self) -> str:
        """Return the path of the model that describes the plate; `FormatError` if there is none."""
        targets: list[str] = []

        def start(name: str, attributes: dict[str, str]) -> None:
            if name.endswith("}Relationship") and attributes.get("Type") == _START_PART:
                targets.append(attributes.get("Target", ""))

        if _key(_RELATIONSHIPS) in self._parts:
            parse_xml(self, _RELATIONSHIPS, start)
        found = [path for path in (*targets, _USUAL_START_PART) if _key(path) in self._parts]
        if not found:
            missing = f" (it names {targets[0][:100]!r})" if targets else ""
            raise FormatError(
                f"is a zip without a 3D model{missing}: it is not a 3MF file, or is damaged; export it again"
            )
        return _key(found[0])

    def has(self, path: str) -> bool:
        """Whether there is such a part."""
        return _key(path) in self._parts

    def resolve(self, path: str, part: str) -> str:
        """Return the path of a part that another part names; `DamagedError` if it is not there."""
        key = _key(posixpath.join("/" + posixpath.dirname(part), path))
        if key not in self._parts:
            raise DamagedError(f"names the part {path[:100]!r} in {part!r}, which it does not have")
        return key

    @contextmanager
    def open(self, path: str) -> Iterator[Any]:
        """Open a part for reading, with errors as `FormatError`."""
        entry = self._parts[_key(path)]
        too_packed = entry.file_size > max(_BOMB_SIZE, _BOMB_RATIO * entry.compress_size)
        if entry.file_size > self._limit or too_packed:
            raise FormatError(
                f"unpacks its part {path!r} to {entry.file_size:,} bytes, more than a mesh takes; "
                "simplify it first, or export it again"
            )
        if entry.flag_bits & 1:
            raise FormatError("is encrypted, which cannot be read; export it without a password")
        try:
            with self._zip.open(entry) as file:
                yield file
        except NotImplementedError as error:
            raise FormatError(
                f"has the part {path!r} packed in a way that cannot be read; export it again"
            ) from error
        except (zipfile.BadZipFile, zlib.error, EOFError, ValueError) as error:
            raise DamagedError(f"has the part {path!r}, which cannot be unpacked") from error


def parse_xml(
    package: Package,
    path: str,
    start: Handler,
    end: Callable[[str], None] | None = None,
    namespace: Callable[[str, str], None] | None = None,
) -> None:
    """Parse the XML of a part, without entities.

    Parameters
    ----------
    package : Package
    path : str
    start : callable
        Called with name and attributes of each element; a name with a namespace is "namespace}name".
    end : callable, optional
        Called with the name of each element that ends.
    namespace : callable, optional
        Called with the prefix and the name of each namespace, before its element.

    Raises
    ------
    FormatError
        If it is no XML, declares entities, or a handler raises ValueError, KeyError or IndexError.
    """

    def declared(*_arguments: object) -> None:
        # Entities could be anything, of any length; no 3MF has them.
        raise FormatError(
            f"has a document type in its part {path!r}, which 3MF does not allow; export it again"
        )

    parser = expat.ParserCreate(namespace_separator="}")
    parser.StartDoctypeDeclHandler = declared
    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.StartNamespaceDeclHandler = namespace
    with package.open(path) as file:
        try:
            while chunk := file.read(_CHUNK):
                parser.Parse(chunk, False)
            parser.Parse(b"", True)
        except expat.ExpatError as error:
            raise DamagedError(
                f"has no valid XML at line {error.lineno:,}, column {error.offset + 1:,} of its part {path!r}"
            ) from error
        except (ValueError, LookupError, OverflowError) as error:
            raise DamagedError(
                f"has an element or an encoding at line {parser.CurrentLineNumber:,} of its part {path!r} "
                "that does not follow the format"
            ) from error


def _key(path: str) -> str:
    return posixpath.normpath("/" + path.replace("\\", "/")).lstrip("/").lower()
