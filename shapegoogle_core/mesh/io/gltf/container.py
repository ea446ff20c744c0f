# SPDX-License-Identifier: MIT
"""The containers of glTF: JSON with buffers inside it, beside it, or behind it in one binary file."""

from __future__ import annotations

import base64
import binascii
import struct
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path, PurePosixPath
from urllib.parse import unquote, unquote_to_bytes

from shapegoogle_core.mesh.io.file import DamagedError, FormatError, MeshFile, read_content
from shapegoogle_core.mesh.io.gltf.extensions import check_extensions
from shapegoogle_core.mesh.io.gltf.json_object import JsonObject, parse_json
from shapegoogle_core.mesh.io.text import without_mark

__all__ = ["Document", "buffer_files", "open_glb", "open_gltf"]

_HEADER = struct.Struct("<4sII")
_CHUNK = struct.Struct("<II")
_JSON_CHUNK, _BINARY_CHUNK = 0x4E4F534A, 0x004E4942


@dataclass(frozen=True, eq=False)
class Document:
    """A glTF file: its JSON and its buffers.

    Parameters
    ----------
    root : JsonObject
    file : MeshFile
    binary : memoryview or None
        The binary chunk of a .glb.
    """

    root: JsonObject
    file: MeshFile
    binary: memoryview | None = None
    _buffers: dict[int, memoryview] = field(default_factory=dict)

    @cached_property
    def _lists(self) -> dict[str, list[JsonObject]]:
        kinds = ("scenes", "nodes", "meshes", "skins", "accessors", "bufferViews", "buffers")
        return {kind: self.root.objects(kind) for kind in kinds}

    def all(self, kind: str) -> list[JsonObject]:
        """Return a list of the file, such as its "nodes"."""
        return self._lists[kind]

    def item(self, kind: str, index: int, owner: JsonObject) -> JsonObject:
        """Return an item of a list; `DamagedError` if the object that names it names too large a number."""
        items = self._lists[kind]
        if index >= len(items):
            place = owner.place or "its JSON"
            raise DamagedError(f"names {kind}[{index}] in {place}, but has only {len(items):,} {kind}")
        return items[index]

    def buffer(self, index: int, owner: JsonObject) -> memoryview:
        """Return the bytes of a buffer.

        Parameters
        ----------
        index : int
        owner : JsonObject
            The object that names it, for errors.

        Returns
        -------
        data : memoryview

        Raises
        ------
        FormatError
            If it is not there, shorter than announced, or in a file elsewhere.
        """
        if index not in self._buffers:
            buffer = self.item("buffers", index, owner)
            length = buffer.whole("byteLength")
            data, name = self._load(buffer, index)
            if len(data) < length:
                raise DamagedError(f"needs {length:,} bytes of {name}, which has only {len(data):,}")
            self._buffers[index] = data[:length]
        return self._buffers[index]

    def bytes_of(self, view: JsonObject) -> memoryview:
        """Return the bytes of a buffer view, or of what else names a buffer, an offset and a length."""
        buffer = self.buffer(view.whole("buffer"), view)
        offset, length = view.whole("byteOffset", 0), view.whole("byteLength")
        if offset + length > len(buffer):
            raise DamagedError(
                f"has {view.place} that ends at byte {offset + length:,} of a buffer of {len(buffer):,} bytes"
            )
        return buffer[offset : offset + length]

    def _load(self, buffer: JsonObject, index: int) -> tuple[memoryview, str]:
        """Return the data of a buffer and a name for it."""
        if not buffer.has("uri"):
            if self.binary is None or index > 0:
                raise DamagedError(f"has no data for {buffer.place}: neither a 'uri' nor a binary chunk")
            return self.binary, "its binary chunk"
        uri = buffer.text("uri")
        if uri[:5].lower() == "data:":
            return memoryview(_embedded(uri, buffer.place)), buffer.place
        path = _neighbour(self.file.folder, uri)
        if path is None:
            raise FormatError(
                f"needs the file {uri[:200]!r}, which is not beside it or in a folder below it; "
                "copy both together"
            )
        try:
            return memoryview(read_content(path, self.file.max_faces)), f"the file {path.name!r}"
        except FormatError as error:
            raise FormatError(f"needs the file {path.name!r}, which {error}") from error


def open_gltf(file: MeshFile) -> Document:
    """Open a text glTF; `FormatError` if it is not one that can be read."""
    return _checked(Document(parse_json(without_mark(file.data)), file))


def open_glb(file: MeshFile) -> Document:
    """Open a binary glTF; `FormatError` if it is not one that can be read."""
    json_chunk, binary = None, None
    for kind, chunk in _chunks(memoryview(file.data)):
        if json_chunk is None:
            if kind != _JSON_CHUNK:
                raise DamagedError("does not have its JSON in its first chunk")
            json_chunk = bytes(chunk)
        elif kind == _BINARY_CHUNK and binary is None:
            binary = chunk
    if json_chunk is None:
        raise DamagedError("ends before its JSON")
    return _checked(Document(parse_json(without_mark(json_chunk)), file, binary))


def buffer_files(path: Path) -> list[Path]:
    """List the files in which a glTF stores its buffers; those that are not there are left out.

    Parameters
    ----------
    path : Path
        A .gltf or .glb.

    Returns
    -------
    paths : list of Path

    Raises
    ------
    FormatError
        If the file is damaged.
    OSError
        If it cannot be read.
    """
    with path.open("rb") as file:
        head = file.read(_HEADER.size + _CHUNK.size)
        if path.suffix.lower() == ".glb":
            length = _CHUNK.unpack_from(head, _HEADER.size)[0] if len(head) == 20 else 0
            text = file.read(min(length, path.stat().st_size))
        else:
            text = head + file.read()
    found = []
    for buffer in parse_json(without_mark(text)).objects("buffers"):
        uri = buffer.text("uri", "data:")
        if uri[:5].lower() != "data:" and (neighbour := _neighbour(path.parent, uri)):
            found.append(neighbour)
    return found


def _chunks(data: memoryview) -> Iterator[tuple[int, memoryview]]:
    """Kind and content of each chunk of a binary glTF."""
    magic, version, length = _HEADER.unpack(bytes(data[:12]).ljust(12, b"\0"))
    if magic != b"glTF":
        raise FormatError("does not begin like a binary glTF file (.glb); export it again")
    if version != 2:
        raise FormatError(f"is binary glTF {version}, which cannot be read; export it as glTF 2.0")
    if length > len(data) or len(data) < _HEADER.size:
        raise DamagedError(f"claims {length:,} bytes, but has {len(data):,}")
    position = _HEADER.size
    while position + _CHUNK.size <= length:
        size, kind = _CHUNK.unpack_from(data, position)
        position += _CHUNK.size
        if position + size > length:
            raise DamagedError(
                f"claims {size:,} bytes in a chunk, of which only {length - position:,} are there"
            )
        yield kind, data[position : position + size]
        position += size


def _checked(document: Document) -> Document:
    """Check version and extensions."""
    if not document.root.has("asset"):
        raise FormatError("has no 'asset' entry, so it is not a glTF file; export it again")
    version = str(document.root.object("asset").values.get("version", "2.0"))  # old programs write a number
    if version.partition(".")[0] != "2":
        raise FormatError(f"is glTF {version[:20]!r}, which cannot be read; export it as glTF 2.0")
    check_extensions(document.root.texts("extensionsRequired"))
    return document


def _embedded(uri: str, place: str) -> bytes:
    """Decode a data URI."""
    head, comma, content = uri.partition(",")
    if not comma:
        raise DamagedError(f"has a data URI without a comma in {place}")
    data = unquote_to_bytes(content)
    if not head.lower().rstrip().endswith(";base64"):
        return data
    data = b"".join(data.split())
    try:
        return base64.b64decode(data.rstrip(b"=") + b"=" * (-len(data.rstrip(b"=")) % 4), validate=True)
    except binascii.Error as error:
        raise DamagedError(f"has a data URI in {place} that is not base64") from error


def _neighbour(folder: Path, uri: str) -> Path | None:
    """Find a file that a glTF names, in its folder or below: nothing elsewhere is ever opened."""
    for name in (unquote(uri), uri, unquote(uri).replace("\\", "/")):
        relative = PurePosixPath(name)
        outside = relative.is_absolute() or ".." in relative.parts or Path(name).drive or "\0" in name
        with suppress(OSError):  # a name that is too long
            if name and not outside and (folder / name).is_file():
                return folder / name
    return None
