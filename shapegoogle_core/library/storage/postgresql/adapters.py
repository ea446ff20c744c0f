# SPDX-License-Identifier: MIT
"""How names and codes travel between Python and PostgreSQL."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import Any

import numpy as np
import psycopg
from numpy.typing import NDArray
from psycopg.adapt import Buffer, Dumper, Loader
from psycopg.pq import Format
from psycopg.types.string import StrBinaryDumper, StrDumper, TextBinaryLoader, TextLoader

from shapegoogle_core.library.storage.postgresql.text import decode_name, encode_name

__all__ = ["Bits", "code_rows", "register_adapters"]

BIT_OID = 1560
VARBIT_OID = 1562
_LENGTH = struct.Struct(">i")
# Before and after the rows of a binary COPY.
_COPY_HEADER = 19
_COPY_TRAILER = 2


class Bits(bytes):
    """A code: bytes that are stored as a string of bits."""


class _BitsDumper(Dumper):
    oid = BIT_OID
    format = Format.BINARY

    def dump(self, obj: bytes) -> Buffer:
        return _LENGTH.pack(8 * len(obj)) + obj


class _BitsLoader(Loader):
    format = Format.BINARY

    def load(self, data: Buffer) -> bytes:
        return bytes(data)[_LENGTH.size :]


class _NameDumper(StrDumper):
    def dump(self, obj: str) -> Buffer | None:
        return super().dump(encode_name(obj))


class _NameBinaryDumper(StrBinaryDumper):
    def dump(self, obj: str) -> Buffer | None:
        return super().dump(encode_name(obj))


class _NameLoader(TextLoader):
    def load(self, data: Buffer) -> Any:
        return decode_name(super().load(data))  # type: ignore[arg-type]


class _NameBinaryLoader(TextBinaryLoader):
    def load(self, data: Buffer) -> Any:
        return decode_name(super().load(data))  # type: ignore[arg-type]


def register_adapters(connection: psycopg.Connection[Any]) -> None:
    """Let a connection take `Bits`, and names of any characters.

    Parameters
    ----------
    connection : psycopg.Connection
    """
    adapters = connection.adapters
    adapters.register_dumper(Bits, _BitsDumper)
    for dumper in (_NameDumper, _NameBinaryDumper):
        adapters.register_dumper(str, dumper)
    for loader in (_NameLoader, _NameBinaryLoader):
        adapters.register_loader("text", loader)
    for oid in (BIT_OID, VARBIT_OID):
        adapters.register_loader(oid, _BitsLoader)


def code_rows(
    portions: Iterator[Buffer], code_bytes: int
) -> tuple[NDArray[np.int64], NDArray[np.uint8]] | None:
    """Read rows of ids and codes from a binary COPY, in which all rows have the same length.

    Parameters
    ----------
    portions : iterator of bytes
        From ``COPY (SELECT bigint, bit(n) …) TO STDOUT (FORMAT BINARY)``.
    code_bytes : int

    Returns
    -------
    shape_ids, codes : (n,) array of int64, (n, code_bytes) array of uint8
        None if the rows have another length.
    """
    row = np.dtype(
        [
            ("fields", ">i2"),
            ("id_length", ">i4"),
            ("id", ">i8"),
            ("code_length", ">i4"),
            ("bits", ">i4"),
            ("code", np.uint8, (code_bytes,)),
        ]
    )
    content = b"".join(portions)[_COPY_HEADER:-_COPY_TRAILER]
    if len(content) % row.itemsize:
        return None
    rows = np.frombuffer(content, row)
    if np.any(rows["bits"] != 8 * code_bytes):
        return None
    return rows["id"].astype(np.int64), np.ascontiguousarray(rows["code"])
